"""Which named columns of a table hold the target's position, orientation and row id."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .. import _rotations
from .._files import listing, shown
from .._warnings import warn
from ..errors import TargetWarning

Array = NDArray[np.float64]
Orientation = Literal["quaternion", "zyz", "rpy"]

UNITS_PER_METRE = {"m": 1.0, "cm": 100.0, "mm": 1000.0}
RADIANS_PER_UNIT = {"rad": 1.0, "deg": math.pi / 180.0}
_TURN = 2.0 * math.pi
QUATERNION = ("qx", "qy", "qz", "qw")
ANGLES: dict[Orientation, tuple[str, str, str]] = {
    "zyz": ("zyz_alpha", "zyz_beta", "zyz_gamma"),
    "rpy": ("roll", "pitch", "yaw"),
}
EXPECTED = (
    "expected x_m,y_m,z_m (or _cm, _mm), optionally with qx,qy,qz,qw or "
    "zyz_alpha_rad,zyz_beta_rad,zyz_gamma_rad or roll_rad,pitch_rad,yaw_rad (or _deg), and id"
)


class ColumnError(ValueError):
    """The header does not describe targets; the reader adds the file's name."""


@dataclass(frozen=True)
class TargetColumns:
    """Names of the columns in use and their units.

    Attributes
    ----------
    position : tuple of str
        The three position columns.
    units_per_metre : float
        1, 100 or 1000; divided by, since a product with 0.001 would round twice.
    orientation : str or None
        "quaternion", "zyz", "rpy", or None for a file of points.
    orientation_columns : tuple of str
    orientation_scale : float
        Radians per unit of the angle columns; 1 for a quaternion.
    row_id : str or None
        The column with the row ids.
    ignored : tuple of str
        Columns that mean nothing here.
    """

    position: tuple[str, str, str]
    units_per_metre: float
    orientation: Orientation | None = None
    orientation_columns: tuple[str, ...] = ()
    orientation_scale: float = 1.0
    row_id: str | None = None
    ignored: tuple[str, ...] = ()

    @property
    def numeric(self) -> tuple[str, ...]:
        """The columns to be read as numbers, position first."""
        return self.position + self.orientation_columns

    def targets(self, values: Array) -> Array:
        """Targets in m and rad from the numeric columns.

        Parameters
        ----------
        values : ndarray, shape (n, len(numeric))
            Rows in the file's own units.

        Returns
        -------
        ndarray, shape (n, 3) in m, or (n, 4, 4) if there is an orientation
            NaN orientation where a quaternion is not of length one.
        """
        position = values[:, :3] / self.units_per_metre
        if self.orientation is None:
            return position
        return _rotations.transforms(position, self._rotation(values[:, 3:]))

    def _rotation(self, values: Array) -> Array:
        if self.orientation == "quaternion":
            return _rotations.from_quaternion(values)
        if self.orientation_scale == 1.0 and (np.abs(values) > _TURN).any():
            names = ", ".join(repr(name) for name in self.orientation_columns)
            warn(
                f"{names}: more than a turn in rad: was it meant in degrees, as in "
                f"{self.orientation_columns[0].removesuffix('_rad') + '_deg'!r}?",
                TargetWarning,
            )
        angles = values * self.orientation_scale
        if self.orientation == "zyz":
            return _rotations.from_zyz(angles)
        return _rotations.from_rpy(angles)


def match_columns(names: Sequence[str]) -> TargetColumns:
    """Find position, orientation and id among the column names.

    Parameters
    ----------
    names : sequence of str
        The header, in any order.

    Raises
    ------
    ColumnError
        For missing, doubled, unit-less, mixed-unit or competing columns.
    """
    doubled = [name for name, count in Counter(names).items() if count > 1]
    if doubled:
        raise ColumnError(f"column {shown(doubled[0])} appears twice")
    if len(names) == 1 and ";" in names[0]:
        raise ColumnError("columns are separated by ';', expected ','")
    position, position_unit = _group(names, ("x", "y", "z"), UNITS_PER_METRE, "position")
    if position is None:
        found = listing(names) or "nothing"
        raise ColumnError(f"missing column 'x_m'; {EXPECTED}; found {found}")
    orientation, columns, scale = _orientation(names)
    row_id = "id" if "id" in names else None
    used = {*position, *columns, row_id}
    return TargetColumns(
        position=(position[0], position[1], position[2]),
        units_per_metre=UNITS_PER_METRE[position_unit],
        orientation=orientation,
        orientation_columns=columns,
        orientation_scale=scale,
        row_id=row_id,
        ignored=tuple(name for name in names if name not in used),
    )


def _orientation(names: Sequence[str]) -> tuple[Orientation | None, tuple[str, ...], float]:
    found: list[tuple[Orientation, tuple[str, ...], float]] = []
    if any(name in names for name in QUATERNION):
        missing = [name for name in QUATERNION if name not in names]
        if missing:
            raise ColumnError(f"missing column '{missing[0]}' of the quaternion qx,qy,qz,qw")
        found.append(("quaternion", QUATERNION, 1.0))
    for kind, stems in ANGLES.items():
        columns, unit = _group(names, stems, RADIANS_PER_UNIT, f"{kind} orientation")
        if columns is not None:
            found.append((kind, columns, RADIANS_PER_UNIT[unit]))
    if len(found) > 1:
        kinds = " and ".join(kind for kind, _, _ in found)
        raise ColumnError(f"two orientations ({kinds}), expected at most one")
    return found[0] if found else (None, (), 1.0)


def _group(
    names: Sequence[str], stems: tuple[str, str, str], units: dict[str, float], what: str
) -> tuple[tuple[str, ...] | None, str]:
    """Return the columns stem_unit of a group and their unit; (None, "") if none is there."""
    for stem in stems:
        if stem in names:
            choices = " or ".join(f"'{stem}_{unit}'" for unit in units)
            raise ColumnError(f"column '{stem}' names no unit, expected {choices}")
    found = {stem: [unit for unit in units if f"{stem}_{unit}" in names] for stem in stems}
    present = [unit for stem in stems for unit in found[stem]]
    if not present:
        return None, ""
    if len(set(present)) > 1:
        given = ", ".join(f"{stem}_{unit}" for stem in stems for unit in found[stem])
        raise ColumnError(f"mixed units in the {what} columns ({given}), expected one unit")
    unit = present[0]
    for stem in stems:
        if not found[stem]:
            raise ColumnError(f"missing column '{stem}_{unit}'")
    return tuple(f"{stem}_{unit}" for stem in stems), unit
