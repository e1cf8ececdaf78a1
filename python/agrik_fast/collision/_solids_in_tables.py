"""The solids of an object in a scene file, in metres, with every fault of their numbers.

They are worked out from the raw tables, and skip whatever has the wrong type: the check of
single keys in `_tables` tells that itself.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from .._bodies import Box
from .._checks import FloatArray
from .._files import shown
from ..errors import ArgumentError, Fault
from ._objects import SceneObject
from ._rows import CAPSULE, HALFSPACE, POINT, SPHERE, RowKind, faulty, told

# Faults of one list of rows that are told one by one.
_ROW_FAULTS = 20


def numbers_in(values: Any, scale: float) -> FloatArray:
    """Return numbers of a file in metres; a division rounds once, a factor would twice."""
    array = np.asarray(values, dtype=np.float64)
    return array / scale if scale != 1.0 else array


def tables(value: Any) -> list[tuple[int, Mapping[str, Any]]]:
    """Return the tables of a list with their indices."""
    if not isinstance(value, list):
        return []
    return [(i, row) for i, row in enumerate(value) if isinstance(row, dict)]


def object_of(
    place: str, table: Mapping[str, Any], scale: float, faults: list[Fault]
) -> SceneObject | None:
    """Return an object; None where something is wrong with it, which joins `faults`.

    Parameters
    ----------
    place : str
        Where the table is in its file.
    table : mapping
        The raw table.
    scale : float
        Units of the file in a metre.
    faults : list of Fault
    """
    before = len(faults)
    spheres = _rows(place, table, SPHERE, scale, faults)
    points = _rows(place, table, POINT, scale, faults)
    radii = _radii(place, table, len(points), scale, faults)
    capsules = _rows(place, table, CAPSULE, scale, faults)
    halfspaces = _rows(place, table, HALFSPACE, scale, faults)
    boxes = [
        box
        for number, one in tables(table.get("boxes"))
        if (box := _box(f"{place}, boxes row {number + 1}", one, scale, faults)) is not None
    ]
    hulls = [
        hull
        for number, one in tables(table.get("hulls"))
        if (hull := _hull(f"{place}, hulls row {number + 1}", one, scale, faults)) is not None
    ]
    name, kind, removable = (table.get(key) for key in ("name", "kind", "removable"))
    if len(faults) > before or not isinstance(name, str) or not name:
        return None
    if len(points):
        spheres = np.concatenate([spheres, np.column_stack([points, radii])])
    try:
        return SceneObject(
            name,
            kind if isinstance(kind, str) else "",
            removable is True,
            spheres=spheres,
            capsules=capsules,
            boxes=np.array(boxes),
            halfspaces=halfspaces,
            hulls=tuple(hulls),
        )
    except ArgumentError as error:
        faults.append(Fault(place, f"{error.argument}: expected {error.expected}, "
                                   f"got {error.received}"))  # fmt: skip
        return None


def _rows(
    place: str, table: Mapping[str, Any], kind: RowKind, scale: float, faults: list[Fault]
) -> FloatArray:
    """Return the rows of one kind in metres; what is wrong with them joins `faults`."""
    values = table.get(kind.name)
    nothing = np.zeros((0, kind.columns))
    if not isinstance(values, list) or not values:
        return nothing
    sound = list(range(len(values)))
    array = _as_rows(values, kind.columns)
    if array is None:
        sound = [k for k, row in enumerate(values) if _as_rows([row], kind.columns) is not None]
        odd = sorted(set(range(len(values))) - set(sound))
        expected = f"{kind.columns} numbers: {kind.meaning}"
        each = ((k, f"expected {expected}, got {shown(values[k])}") for k in odd)
        faults += _first_ones(f"{place}, {kind.name}", each, len(odd))
        array = _as_rows([values[k] for k in sound], kind.columns) if sound else None
    if array is None:
        return nothing
    array = array.copy()
    array[:, kind.lengths] = numbers_in(array[:, kind.lengths], scale)
    bad = faulty(kind, array).tolist()
    each = ((sound[row], _words(kind, values[sound[row]])) for row in bad)
    faults += _first_ones(f"{place}, {kind.name}", each, len(bad))
    return nothing if bad or len(array) < len(values) else array


def _first_ones(place: str, each: Iterable[tuple[int, str]], count: int) -> Iterator[Fault]:
    """Faults of rows, no more of them than a reader needs."""
    for row, message in itertools.islice(each, _ROW_FAULTS):
        yield Fault(f"{place} row {row + 1}", message)
    if count > _ROW_FAULTS:
        yield Fault(place, f"{count - _ROW_FAULTS} more such rows")


def _words(kind: RowKind, row: Any) -> str:
    received, expected = told(kind, np.asarray(_flat(row), dtype=np.float64))
    return f"expected {expected}, got {received}"


def _flat(row: Any) -> Any:
    """Return [a, b, radius] or [n, d] as a row of numbers."""
    if isinstance(row, list) and any(isinstance(part, list) for part in row):
        return [x for part in row for x in (part if isinstance(part, list) else [part])]
    return row


def _is_row(row: Any, columns: int) -> bool:
    return (
        isinstance(row, list)
        and len(row) == columns
        and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in row)
    )


def _as_rows(values: Sequence[Any], columns: int) -> FloatArray | None:
    """Return rows of numbers as an array; None where one is no such row."""
    if any(isinstance(row, list) and row and isinstance(row[0], list) for row in values):
        values = [_flat(row) for row in values]
    if not all(_is_row(row, columns) for row in values):
        return None
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError:
        return None


def _radii(
    place: str, table: Mapping[str, Any], count: int, scale: float, faults: list[Fault]
) -> FloatArray:
    radius = table.get("radius")
    given = isinstance(table.get("points"), list) and bool(table["points"])
    if radius is None:
        if given:
            faults.append(Fault(f"{place}, radius", "missing: points need one"))
        return np.zeros(count)
    if not given:
        faults.append(Fault(f"{place}, radius", "belongs to points, of which there are none"))
    if not isinstance(radius, list):
        # A wrong type or a negative number has been told already.
        number = isinstance(radius, (int, float)) and not isinstance(radius, bool)
        return np.full(count, float(numbers_in(radius, scale)) if number else 0.0)
    if not _is_row(radius, len(radius)):
        faults.append(Fault(f"{place}, radius", "expected a number, or one a point"))
    elif len(radius) != len(table.get("points") or ()):
        there = len(table.get("points") or ())
        faults.append(Fault(f"{place}, radius", f"expected {there} numbers, got {len(radius)}"))
    else:
        values = np.array(radius, dtype=np.float64)
        bad = np.flatnonzero(~(np.isfinite(values) & (values >= 0.0))).tolist()
        each = ((k, f"expected a number >= 0, got {values[k]:g}") for k in bad)
        faults += _first_ones(f"{place}, radius", each, len(bad))
        if not bad and len(values) == count:
            return numbers_in(values, scale)
    return np.zeros(count)


def _box(
    place: str, table: Mapping[str, Any], scale: float, faults: list[Fault]
) -> list[float] | None:
    """Return a box as a row; None where a single key of it has been told already."""
    centre, half, turn = table.get("centre"), table.get("half"), table.get("R")
    radius = table.get("radius", 0.0)
    if not (_is_row(centre, 3) and _is_row(half, 3) and _is_row([radius], 1)):
        return None
    if turn is not None and not (
        isinstance(turn, list) and len(turn) == 3 and all(_is_row(row, 3) for row in turn)
    ):
        return None
    rows: list[list[float]] = np.eye(3).tolist() if turn is None else turn
    try:
        middle, halves = numbers_in(centre, scale), numbers_in(half, scale)
        Box(middle, halves, rows, float(numbers_in(radius, scale)))  # type: ignore[arg-type]
    except ArgumentError as error:
        key = {"rotation": "R"}.get(error.argument, error.argument)
        if np.isfinite(np.asarray([centre, half], dtype=np.float64)).all() or key == "R":
            message = f"expected {error.expected}, got {error.received}"
            faults.append(Fault(f"{place}, {key}", message))
        return None
    parts = (middle, halves, np.array(rows, dtype=np.float64), numbers_in(radius, scale))
    flat: list[float] = np.concatenate([part.ravel() for part in parts]).tolist()
    return flat


def _hull(
    place: str, table: Mapping[str, Any], scale: float, faults: list[Fault]
) -> tuple[FloatArray, float] | None:
    corner = RowKind("vertices", 3, "x, y, z", False, slice(0, 3))
    if table.get("vertices") == []:
        faults.append(Fault(f"{place}, vertices", "expected at least one point, got none"))
    points = _rows(place, table, corner, scale, faults)
    radius = table.get("radius", 0.0)
    if not len(points) or not _is_row([radius], 1):
        return None
    return points, float(numbers_in(radius, scale))
