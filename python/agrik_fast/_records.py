"""What the records of answers can do beside holding arrays: rows, tables, pickles.

The compiled classes hand their methods on to here, with themselves as the first argument. A
record's fields are arrays whose first dimensions are those of the targets.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from . import _native, _tables
from ._checks import shown
from .errors import ArgumentError
from .plots import outcomes
from .result import Status

if TYPE_CHECKING:
    from ._native import Branches, IkResult, TargetSolver

    Record: TypeAlias = IkResult | Branches

__all__ = [
    "html_table",
    "iterate",
    "last_answer",
    "length",
    "made",
    "plot",
    "reduce",
    "rows",
    "take",
    "text",
    "text_of_solver",
    "to_arrow",
    "to_dict",
    "to_pandas",
    "truth",
]

_FIELDS = {
    "IkResult": (
        "q",
        "status",
        "success",
        "position_error",
        "orientation_error",
        "iterations",
        "restarts",
        "warnings",
        "clearance",
        "nearest_pair",
    ),
    "Branches": (
        "q",
        "valid",
        "reached",
        "singular",
        "status",
        "warnings",
        "free_joint",
        "value",
        "branch",
        "orientation_error",
        "position_error",
    ),
}
_LAST = (
    "q",
    "status",
    "success",
    "position_error",
    "orientation_error",
    "iterations",
    "restarts",
)
_UNITS = {"position_error": "position error (m)", "orientation_error": "orientation error (rad)"}


def to_dict(record: Record) -> dict[str, Any]:
    """Return the record's arrays by their names."""
    found = {name: getattr(record, name) for name in _FIELDS[type(record).__name__]}
    return {name: array for name, array in found.items() if array is not None}


def reduce(record: Record) -> tuple[Any, ...]:
    """Return how to make the record again."""
    return made, (type(record).__name__, to_dict(record))


def made(kind: str, fields: dict[str, Any], like: IkResult | None = None) -> Record:
    """Return the record of a kind that holds some arrays; what pickles call.

    With `like`, it is of the same question.
    """
    arrays = {name: np.asarray(value) for name, value in fields.items()}
    if kind == "Branches":
        return _native.branches(**arrays)
    arrays.pop("success", None)  # the statuses say it
    return _native.ik_result(**arrays, like=like)


def rows(record: Record) -> tuple[int, ...]:
    """Return the targets' shape."""
    return record.status.shape


def length(record: Record) -> int:
    """Return how many rows the record has along its first dimension."""
    shape = rows(record)
    if not shape:
        kind = type(record).__name__
        hint = "; its branches are q[valid]" if kind == "Branches" else ""
        raise TypeError(f"the answer to a single target has no length{hint}")
    return shape[0]


def take(record: Record, key: Any) -> Record:
    """Return the record of some of the targets, chosen as in a NumPy array of them."""
    shape = rows(record)
    if not shape:
        raise TypeError("the answer to a single target has no rows")
    # Places say what a key picks, whatever it is made of.
    places = np.arange(np.prod(shape, dtype=int)).reshape(shape)[key]
    picked = {}
    for name, array in to_dict(record).items():
        flat = array.reshape(-1, *array.shape[len(shape) :])
        picked[name] = flat[places]
    like = record if isinstance(record, _native.IkResult) else None
    return made(type(record).__name__, picked, like)


def iterate(record: Record) -> Iterator[Record]:
    """Go through the rows along the first dimension."""
    return (take(record, row) for row in range(length(record)))


def truth(record: IkResult) -> bool:
    """Return whether a single target was reached."""
    if record.success.size != 1:
        raise ValueError(
            f"the truth value of answers to {record.success.size} targets is ambiguous: use "
            "result.success.all() or result.success.any()"
        )
    return bool(record.success.reshape(-1)[0])


def _columns(record: Record) -> dict[str, Any]:
    """Return one column a number, one row a target (of branches: a branch)."""
    names = [status.name.lower() for status in Status]
    columns: dict[str, Any] = {}
    leading = record.q.shape[:-1]
    if len(leading) > 1 or type(record).__name__ == "Branches":
        for axis, index in enumerate(np.indices(leading)):
            last = axis == len(leading) - 1 and type(record).__name__ == "Branches"
            name = "branch" if last else "target" if len(leading) <= 2 else f"target_{axis}"
            columns[name] = index.reshape(-1)
    for name, array in to_dict(record).items():
        if name in ("q", "nearest_pair"):
            flat = array.reshape(-1, array.shape[-1])
            heads = ("body", "object") if name == "nearest_pair" else None
            columns |= {heads[k] if heads else f"q_{k}": flat[:, k] for k in range(flat.shape[1])}
            continue
        wide = np.broadcast_to(
            array.reshape(array.shape + (1,) * (len(leading) - array.ndim)), leading
        )
        flat = wide.reshape(-1)
        columns[name] = [names[code] for code in flat.tolist()] if name == "status" else flat
    return columns


def to_arrow(record: Record) -> Any:
    """Return the record as a `pyarrow.Table`."""
    return _tables.arrow_table(_columns(record))


def to_pandas(record: Record) -> Any:
    """Return the record as a `pandas.DataFrame`."""
    return _tables.pandas_frame(_columns(record))


def plot(record: IkResult, arm: Any) -> Any:
    """Return a picture of what became of targets, or of an arm's postures."""
    if arm is None:
        return outcomes(record.status, record.position_error, record.iterations)
    if not callable(getattr(arm, "plot", None)):
        raise ArgumentError("arm", shown(arm), "a Robot")
    return arm.plot(record.q)


def text(record: IkResult, head: str) -> str:
    """Return what a record says of itself: a head, and of a single target its numbers."""
    if rows(record):
        return f"IkResult({head})"
    with np.printoptions(precision=6, suppress=True, linewidth=200, threshold=12):
        q = np.array2string(record.q, separator=", ")
    errors = f"position_error={float(record.position_error):.3g}"
    if record.orientation_error:
        errors += f", orientation_error={float(record.orientation_error):.3g}"
    return f"IkResult({head}, q={q}, {errors})"


def html_table(record: Record) -> str:
    """Return the first rows as a table for notebooks."""
    return _tables.html_table(_columns(record), repr(record), _UNITS)


def last_answer(solver: TargetSolver) -> IkResult:
    """Return the last answer of a solver for one target at a time, as a record of its own."""
    fields = {name: getattr(solver, name) for name in _LAST}
    fields |= {"status": np.uint8(fields["status"]), "warnings": np.uint8(0)}
    fields |= {name: np.uint32(fields[name]) for name in ("iterations", "restarts")}
    return cast("IkResult", made("IkResult", fields))


def text_of_solver(solver: TargetSolver, head: str) -> str:
    """Return what a solver says of itself: whose it is, and its last answer."""
    # A call leaves a finite error, or the status of a bad target.
    if solver.status == Status.NOT_FOUND and np.isinf(solver.position_error):
        return f"TargetSolver({head}nothing asked yet)"
    return f"TargetSolver({head}{solver.result!r})"
