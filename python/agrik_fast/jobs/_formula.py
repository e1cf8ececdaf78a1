"""Rows that are made where they are needed, from a file of some lines: grids and random rows.

Nothing but additions, products and square roots of IEEE 754 is used, so that the rows have the
same bits on every machine.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from .._checks import FloatArray
from .._files import Refusal, decode, parse_toml, read_bytes, shown
from .._splitmix import uniform
from ..io import import_pyarrow
from ._job import Job, JobError, canonical
from ._sources import FOLDER_FILES, PARTITION_ROWS, Partition

_MOST = 2**63 - 1
_ROTATION = ("qx", "qy", "qz", "qw")
_TABLE_ROWS = 100_000
# Powers of a quarter turn beyond this one are below the last digit.
_TERMS = 20


@dataclass(frozen=True)
class Axis:
    """An axis of a grid: its columns and their values, evenly spaced or listed."""

    columns: tuple[str, ...]
    count: int
    low: float = 0.0
    high: float = 0.0
    values: tuple[tuple[float, ...], ...] = ()

    def at(self, index: Any) -> FloatArray:
        """Return the values at positions on the axis, shape (n, columns)."""
        if self.values:
            return np.asarray(np.array(self.values, dtype=np.float64)[index])
        steps = max(self.count - 1, 1)
        # Both ends are exact.
        share = index.astype(np.float64) / steps
        place = np.where(index == steps, self.high, self.low + (self.high - self.low) * share)
        return np.asarray(place, dtype=np.float64)[:, None]


@dataclass(frozen=True)
class Draw:
    """Random columns: one between two ends, or the four of a rotation."""

    columns: tuple[str, ...]
    low: float = 0.0
    high: float = 1.0

    @property
    def numbers(self) -> int:
        """Random numbers that a row takes."""
        return 3 if len(self.columns) == len(_ROTATION) else 1

    def of(self, u: FloatArray) -> FloatArray:
        """Return the columns from random numbers of shape (n, numbers)."""
        if len(self.columns) == 1:
            return self.low + (self.high - self.low) * u
        # Shoemake, "Uniform random rotations", Graphics Gems III, 1992.
        inner, outer = np.sqrt(1.0 - u[:, 0]), np.sqrt(u[:, 0])
        (sin1, cos1), (sin2, cos2) = _circle(u[:, 1]), _circle(u[:, 2])
        return np.stack([inner * sin1, inner * cos1, outer * sin2, outer * cos2], axis=1)


def _circle(u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sine and cosine of shares of a turn, by series within a quarter of it."""
    quarter = np.floor(4.0 * u)
    t = (4.0 * u - quarter) * (math.pi / 2.0)
    square = t * t
    sine, cosine = np.ones_like(t), np.ones_like(t)
    for k in range(_TERMS, 0, -2):
        sine = 1.0 - square / (k * (k + 1)) * sine
        cosine = 1.0 - square / ((k - 1) * k) * cosine
    sine = t * sine
    turn = quarter.astype(np.int64) % 4
    return (
        np.choose(turn, [sine, cosine, -sine, -cosine]),
        np.choose(turn, [cosine, -sine, -cosine, sine]),
    )


@dataclass(frozen=True)
class Formula:
    """What a file of a formula says: a grid of axes, random columns, or both.

    Attributes
    ----------
    axes : tuple of Axis
        The last one turns fastest.
    draws : tuple of Draw
    rows, seed, partition_rows : int
    """

    axes: tuple[Axis, ...]
    draws: tuple[Draw, ...]
    rows: int
    seed: int
    partition_rows: int

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns, the axes' first."""
        parts: tuple[Axis | Draw, ...] = (*self.axes, *self.draws)
        return tuple(name for part in parts for name in part.columns)

    def values(self, first: int, count: int) -> FloatArray:
        """Return rows, shape (count, columns)."""
        index = np.arange(first, first + count, dtype=np.int64)
        parts = []
        for axis in reversed(self.axes):
            index, at = np.divmod(index, axis.count)
            parts.append(axis.at(at))
        parts.reverse()
        width = sum(draw.numbers for draw in self.draws)
        u = uniform(self.seed, first * width, count * width).reshape(count, width)
        used = 0
        for draw in self.draws:
            parts.append(draw.of(u[:, used : used + draw.numbers]))
            used += draw.numbers
        return np.hstack(parts)


@dataclass(frozen=True)
class FormulaRows:
    """Some rows of a formula."""

    formula: Formula
    first: int
    rows: int

    def batches(self, columns: tuple[str, ...], size: int) -> Iterator[Any]:
        """Yield the rows."""
        pyarrow = import_pyarrow(partial(JobError, "formula"))
        names = self.formula.columns
        for at in range(0, self.rows, size):
            count = min(size, self.rows - at)
            values = self.formula.values(self.first + at, count)
            arrays = [np.ascontiguousarray(values[:, names.index(name)]) for name in columns]
            yield pyarrow.RecordBatch.from_arrays(list(map(pyarrow.array, arrays)), list(columns))


class FormulaSource:
    """The rows of a formula's file, made in the process that works on them.

    Parameters
    ----------
    place : str or path
        A TOML file; the page of clusters describes it.

    Raises
    ------
    JobError
        The file has faults; names table and key.

    Examples
    --------
    >>> from agrik_fast.jobs import FormulaSource
    >>> from pathlib import Path
    >>> lines = ["rows = 100", "seed = 1", "rows_per_partition = 50"]
    >>> for name in ("x_m", "y_m", "z_m"):
    ...     lines += ["[[random]]", f'column = "{name}"', "from = 0.2", "to = 0.4"]
    >>> _ = Path("points.toml").write_text(chr(10).join(lines))
    >>> source = FormulaSource("points.toml")
    >>> source.count, source.rows
    (2, 100)
    """

    def __init__(self, place: str | PathLike[str]) -> None:
        self.place = fspath(place)
        self.formula = _read(Path(place))
        self.rows = self.formula.rows
        self.count = -(-self.rows // self.formula.partition_rows)
        pyarrow = import_pyarrow(partial(JobError, self.place))
        self.schema = pyarrow.schema([(name, pyarrow.float64()) for name in self.formula.columns])
        words = canonical([repr(self.formula)])
        self._hash = hashlib.sha256(words.encode()).hexdigest()

    def partition(self, number: int) -> Partition:
        """Return a partition by its number."""
        size = self.formula.partition_rows
        first = number * size
        rows = min(size, self.rows - first)
        name = f"part-{number:09d}"
        if self.count > FOLDER_FILES:
            name = f"p{number // FOLDER_FILES:04d}/{name}"
        data = FormulaRows(self.formula, first, rows)
        return Partition(number, name, first, rows, {"formula": self._hash}, data)

    def summary(self) -> dict[str, Any]:
        """Return how many partitions and rows there are, and a hash of the formula."""
        return {"partitions": self.count, "rows": self.rows, "formula": self._hash}

    def check(self, job: Job) -> tuple[str, ...]:
        """Return the columns that a job reads."""
        return job.columns(self.schema, partial(JobError, self.place))


def _read(path: Path) -> Formula:
    refuse = partial(JobError, str(path))
    table = parse_toml(decode(read_bytes(path, refuse), refuse), refuse)
    known = ("rows", "seed", "rows_per_partition", "axis", "random")
    for key in table:
        if key not in known:
            raise refuse(f"unknown key {shown(key)}, expected one of {', '.join(known)}")
    axes = tuple(
        _axis(entry, partial(_at, refuse, "axis", k))
        for k, entry in enumerate(_tables(table, "axis", refuse), start=1)
    )
    draws = tuple(
        _draw(entry, partial(_at, refuse, "random", k))
        for k, entry in enumerate(_tables(table, "random", refuse), start=1)
    )
    if not axes and not draws:
        raise refuse("neither [[axis]] nor [[random]], expected one of them")
    columns = Formula(axes, draws, 0, 0, 1).columns
    doubled = sorted({name for name in columns if columns.count(name) > 1})
    if doubled:
        raise refuse(f"column {shown(doubled[0])} is made twice")
    if axes:
        if "rows" in table:
            raise refuse("'rows' beside [[axis]]: a grid has the product of its counts")
        rows = math.prod(axis.count for axis in axes)
        if rows > _MOST:
            raise refuse(f"a grid of {rows} rows, expected at most 2**63 - 1")
    else:
        rows = _whole(table, "rows", None, 1, _MOST, refuse)
    seed = _whole(table, "seed", 0, 0, 2**63 - 1, refuse)
    if "seed" in table and not draws:
        raise refuse("'seed' without [[random]]: nothing is drawn")
    size = _whole(table, "rows_per_partition", PARTITION_ROWS, 1, 2**40, refuse)
    return Formula(axes, draws, rows, seed, size)


def _at(refuse: Refusal, kind: str, number: int, reason: str) -> Exception:
    return refuse(f"[[{kind}]] {number}: {reason}")


def _tables(table: Mapping[str, Any], key: str, refuse: Refusal) -> list[Mapping[str, Any]]:
    found = table.get(key, [])
    if not isinstance(found, list) or not all(isinstance(entry, dict) for entry in found):
        raise refuse(f"'{key}' holds {shown(found)}, expected tables [[{key}]]")
    return found


def _axis(entry: Mapping[str, Any], refuse: Any) -> Axis:
    if "values" in entry:
        _check_keys(entry, ("column", "columns", "values"), refuse)
        columns = _columns(entry, refuse)
        values = entry["values"]
        if not isinstance(values, list) or not 1 <= len(values) <= _TABLE_ROWS:
            raise refuse(f"'values' holds {shown(values)}, expected a list of 1 to {_TABLE_ROWS}")
        rows = tuple(
            tuple(_number(x, "values", refuse) for x in (row if isinstance(row, list) else [row]))
            for row in values
        )
        for row in rows:
            if len(row) != len(columns):
                raise refuse(f"'values': {shown(list(row))}, expected {len(columns)} numbers")
        return Axis(columns, len(rows), values=rows)
    _check_keys(entry, ("column", "from", "to", "count"), refuse)
    columns = _columns(entry, refuse)
    count = _whole(entry, "count", None, 2, _MOST, refuse)
    return Axis(columns, count, *_ends(entry, refuse))


def _draw(entry: Mapping[str, Any], refuse: Any) -> Draw:
    if "rotation" in entry:
        _check_keys(entry, ("rotation",), refuse)
        if entry["rotation"] is not True:
            raise refuse(f"'rotation' holds {shown(entry['rotation'])}, expected true")
        return Draw(_ROTATION)
    _check_keys(entry, ("column", "from", "to"), refuse)
    return Draw(_columns(entry, refuse), *_ends(entry, refuse))


def _check_keys(entry: Mapping[str, Any], known: tuple[str, ...], refuse: Any) -> None:
    for key in entry:
        if key not in known:
            raise refuse(f"unknown key {shown(key)}, expected {', '.join(known)}")


def _columns(entry: Mapping[str, Any], refuse: Any) -> tuple[str, ...]:
    if ("column" in entry) == ("columns" in entry):
        raise refuse("expected 'column' or 'columns'")
    found = entry.get("columns", [entry.get("column")])
    good = isinstance(found, list) and found and all(isinstance(x, str) and x for x in found)
    if not good:
        raise refuse(f"columns are {shown(found)}, expected names")
    return tuple(found)


def _ends(entry: Mapping[str, Any], refuse: Any) -> tuple[float, float]:
    for key in ("from", "to"):
        if key not in entry:
            raise refuse(f"missing key '{key}'")
    low, high = (_number(entry[key], key, refuse) for key in ("from", "to"))
    if not low < high:
        raise refuse(f"'from' {low!r} and 'to' {high!r}, expected the smaller one first")
    return low, high


def _number(value: Any, key: str, refuse: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise refuse(f"'{key}' holds {shown(value)}, expected a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise refuse(f"'{key}' holds {shown(value)}, expected a finite number")
    return number


def _whole(
    table: Mapping[str, Any], key: str, default: int | None, low: int, high: int, refuse: Any
) -> int:
    if key not in table and default is not None:
        return default
    if key not in table:
        raise refuse(f"missing key '{key}'")
    value = table[key]
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise refuse(f"'{key}' holds {shown(value)}, expected a whole number, {low} to {high}")
    return value
