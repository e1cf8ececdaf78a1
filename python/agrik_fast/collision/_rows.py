"""What rows of numbers in a scene may hold, and which one of many holds something else."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._bodies import LARGEST
from .._checks import FloatArray


@dataclass(frozen=True)
class RowKind:
    """One kind of solid that is a row of numbers.

    Attributes
    ----------
    name : str
        Its key in files.
    columns : int
    meaning : str
        What the columns are.
    radius : bool
        True if the last column is a radius, 0 or more.
    lengths : slice
        Columns that are lengths.
    """

    name: str
    columns: int
    meaning: str
    radius: bool
    lengths: slice


SPHERE = RowKind("spheres", 4, "x, y, z, radius", True, slice(0, 4))
POINT = RowKind("points", 3, "x, y, z", False, slice(0, 3))
CAPSULE = RowKind("capsules", 7, "the ends a and b, and the radius", True, slice(0, 7))
HALFSPACE = RowKind("halfspaces", 4, "an outward normal and d", False, slice(3, 4))

_Fault = tuple[int, str, str]


def faulty(kind: RowKind, rows: FloatArray) -> NDArray[np.int64]:
    """Return the indices of rows that hold what they may not."""
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(rows) <= LARGEST).all(axis=1)
        if kind.radius:
            bad |= rows[:, -1] < 0.0
        if kind is HALFSPACE:
            bad |= ~rows[:, :3].any(axis=1)
    return np.flatnonzero(bad)


def told(kind: RowKind, row: FloatArray) -> tuple[str, str]:
    """Return what came and what was expected, of a row that holds what it may not."""
    if not np.isfinite(row).all():
        return str(row.tolist()), f"finite numbers: {kind.meaning}"
    if kind.radius and row[-1] < 0.0:
        return f"radius {row[-1]:g}", "a radius >= 0"
    if kind is HALFSPACE and not row[:3].any():
        return "a normal of no length", f"{kind.meaning}"
    return str(row.tolist()), f"numbers up to {LARGEST:g} m"


def first_fault(kind: RowKind, rows: FloatArray) -> _Fault | None:
    """Return the first row that holds what it may not, what came and what was expected."""
    bad = faulty(kind, rows)
    if not len(bad):
        return None
    row = int(bad[0])
    return row, *told(kind, rows[row])
