"""Reads the rows that `Robot.from_dh` takes: an array or a list of dictionaries."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array, real_number, text
from ..errors import ArgumentError, UnknownNameError

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
CONVENTIONS = ("standard", "modified")
_KEYS = ("a", "alpha", "alpha_deg", "d", "theta", "theta_deg")


class DhRow(NamedTuple):
    """One Denavit-Hartenberg row of a robot, as shown to users.

    Attributes
    ----------
    name : str
        Name of the joint.
    type : str
        "revolute", "continuous", "prismatic" or "fixed".
    a, d : float
        Link length and link offset, m.
    alpha, theta : float
        Link twist and joint angle, rad. The joint's value is added to `theta`
        (revolute, continuous) or to `d` (prismatic).
    lower, upper : float
        Limits, rad or m; infinite for continuous joints.

    Examples
    --------
    >>> ik.Robot.load("puma560").dh[1]._fields
    ('name', 'type', 'a', 'alpha', 'd', 'theta', 'lower', 'upper')
    """

    name: str
    type: str
    a: float
    alpha: float
    d: float
    theta: float
    lower: float
    upper: float


class DhTable(NamedTuple):
    """What `_native.Chain.from_dh` takes, one entry per row."""

    rows: FloatArray
    types: list[str]
    names: list[str]
    lower: FloatArray
    upper: FloatArray

    def listing(self) -> tuple[DhRow, ...]:
        """Return the rows one by one."""
        return tuple(
            DhRow(name, kind, a, alpha, d, theta, lower, upper)
            for name, kind, (a, alpha, d, theta), lower, upper in zip(
                self.names,
                self.types,
                self.rows.tolist(),
                self.lower.tolist(),
                self.upper.tolist(),
                strict=True,
            )
        )


def read_table(
    rows: ArrayLike | Sequence[Mapping[str, float]],
    limits: ArrayLike | None,
    joint_types: Sequence[str] | None,
    joint_names: Sequence[str] | None,
) -> DhTable:
    """Check the arguments of `Robot.from_dh` that have one entry per row."""
    table = _rows_array(rows)
    count = len(table)
    if joint_types is None:
        types = ["continuous" if limits is None else "revolute"] * count
    else:
        types = _strings("joint_types", joint_types, count)
        for kind in types:
            if kind not in JOINT_TYPES:
                raise UnknownNameError("joint type", kind, JOINT_TYPES)
    if joint_names is None:
        names = [f"q{index}" for index in range(1, count + 1)]
    else:
        names = _strings("joint_names", joint_names, count)
    return DhTable(table, types, names, *_limits(limits, types))


def _rows_array(rows: ArrayLike | Sequence[Mapping[str, float]]) -> FloatArray:
    if isinstance(rows, (list, tuple)) and any(isinstance(row, Mapping) for row in rows):
        table = np.array([_dict_row(i, row) for i, row in enumerate(rows)])
    else:
        table = float_array("rows", rows)  # type: ignore[arg-type]
    if table.ndim != 2 or table.shape[1] != 4 or len(table) == 0:
        expected = "shape (n, 4), columns a, alpha, d, theta, with n >= 1"
        raise ArgumentError("rows", f"shape {table.shape}", expected)
    if not np.isfinite(table).all():
        bad = int(np.argwhere(~np.isfinite(table))[0, 0])
        raise ArgumentError(f"rows[{bad}]", str(table[bad].tolist()), "finite numbers")
    return table


def _dict_row(index: int, row: object) -> list[float]:
    place = f"rows[{index}]"
    if not isinstance(row, Mapping):
        raise ArgumentError(place, repr(row), "a dictionary, as the other rows")
    for key in row:
        if key not in _KEYS:
            raise UnknownNameError(f"{place} key", str(key), _KEYS)
    return [
        _entry(place, row, "a"),
        _entry(place, row, "alpha", angle=True),
        _entry(place, row, "d"),
        _entry(place, row, "theta", angle=True, default=0.0),
    ]


def _entry(
    place: str,
    row: Mapping[str, float],
    key: str,
    *,
    angle: bool = False,
    default: float | None = None,
) -> float:
    degrees = f"{key}_deg"
    if angle and degrees in row:
        if key in row:
            raise ArgumentError(place, f"{key!r} and {degrees!r}", "one of the two")
        return math.radians(real_number(f"{place}[{degrees!r}]", row[degrees], -math.inf))
    if key in row:
        return real_number(f"{place}[{key!r}]", row[key], -math.inf)
    if default is None:
        wanted = f"{key!r} or {degrees!r}" if angle else repr(key)
        raise ArgumentError(place, f"keys {sorted(row)}", f"a key {wanted}")
    return default


def _strings(argument: str, values: object, count: int) -> list[str]:
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise ArgumentError(argument, repr(values), "a sequence of strings")
    if not all(isinstance(value, str) for value in values):
        raise ArgumentError(argument, repr(values), "a sequence of strings")
    for value in values:
        text(argument, value)
    if len(values) != count:
        raise ArgumentError(argument, f"{len(values)} entries", f"{count}, one per row")
    return list(values)


def _limits(limits: ArrayLike | None, types: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    count = len(types)
    bounded = np.array([kind in ("revolute", "prismatic") for kind in types])
    if limits is None:
        if bounded.any():
            index = int(np.argmax(bounded))
            received = f"None, but row {index} is {types[index]}"
            raise ArgumentError("limits", received, f"shape ({count}, 2)")
        return np.full(count, -np.inf), np.full(count, np.inf)
    table = float_array("limits", limits)
    if table.shape != (count, 2):
        raise ArgumentError("limits", f"shape {table.shape}", f"shape ({count}, 2)")
    for index in np.flatnonzero(bounded).tolist():
        lower, upper = table[index].tolist()
        if math.isnan(lower) or math.isnan(upper):
            received = f"[{lower:g}, {upper:g}] for a {types[index]} joint"
            raise ArgumentError(f"limits[{index}]", received, "numbers, infinite for no limit")
        if lower > upper:
            received = f"lower {lower:g} > upper {upper:g}"
            raise ArgumentError(f"limits[{index}]", received, "lower <= upper")
    return np.where(bounded, table[:, 0], -np.inf), np.where(bounded, table[:, 1], np.inf)
