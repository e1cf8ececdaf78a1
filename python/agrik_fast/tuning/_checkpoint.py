"""What a search keeps on the disk, so that a run that was killed can go on."""

from __future__ import annotations

import hashlib
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._atomic import write_bytes
from .._checks import FloatArray
from .._files import Refusal, reading, shown
from .._native import Tuner
from .._npy import Archive
from ..errors import AgrikError, ArgumentError, GainFileError

PERIOD_S = 2.0
"""Seconds from one writing to the next."""

_NAMES = ("identity", "counts", "cost", "state", "gains", "checksum")


class Bounds(NamedTuple):
    """What the progress of a search may be, for each number of ended legs."""

    evaluations: Sequence[tuple[int, int]]
    """Fewest and most gain sets judged when so many legs have ended."""
    goals: int
    """Validation goals."""
    shapes: Mapping[str, tuple[int, ...]]
    """Shapes of the gains."""


@dataclass
class Progress:
    """What is known of the searches that have ended."""

    identity: dict[str, Any]
    leg: int = 0
    evaluations: int = 0
    cost: float = float("inf")
    """Of the best, on the validation goals."""
    solved: int = 0
    """Validation goals that the best reaches."""
    gains: dict[str, Any] = field(default_factory=dict)
    """The best, as a tuner gives it."""

    def end_leg(self, tuner: Tuner, gains: dict[str, Any], score: tuple[float, int, int]) -> None:
        self.leg += 1
        self.evaluations += tuner.evaluations
        cost, solved, _ = score
        if cost < self.cost or not self.gains:
            self.cost, self.solved, self.gains = cost, solved, gains


def prepare(path: Path, progress: Progress, bounds: Bounds, resume: bool) -> FloatArray | None:
    """Take up the stored progress; returns the state of the run that had not ended.

    Raises
    ------
    GainFileError
        There is a checkpoint and `resume` is False, or none and it is True; it is another
        run's, damaged, or holds what no run writes.
    """
    refuse = partial(GainFileError, str(path))
    if not resume:
        if path.exists():
            raise refuse("is the checkpoint of a run that did not end; resume it or remove it")
        return None
    if not path.exists():
        raise refuse("no such checkpoint to resume")
    stored = _stored(path, refuse)
    _check_identity(stored, progress.identity, refuse)
    counts = _array(stored, "counts", (3,), "i", refuse)
    leg, evaluations, solved = (int(count) for count in counts)
    cost = float(_array(stored, "cost", (), "f", refuse))
    if not 0 <= leg < len(bounds.evaluations):
        most = len(bounds.evaluations) - 1
        raise refuse(f"'counts': {leg} ended searches, expected 0 to {most}")
    gains = _gains(stored, bounds, refuse, ended=leg > 0)
    low, high = bounds.evaluations[leg]
    if not low <= evaluations <= high:
        raise refuse(f"'counts': {evaluations} gain sets judged, expected {low} to {high}")
    if not 0 <= solved <= (bounds.goals if leg else 0):
        raise refuse(f"'counts': {solved} of {bounds.goals if leg else 0} goals reached")
    if not (0.0 <= cost < math.inf if leg else cost == math.inf):
        expected = "a finite number >= 0" if leg else "infinity before a search has ended"
        raise refuse(f"'cost': {cost!r}, expected {expected}")
    state = stored["state"]
    if state.ndim != 1 or state.dtype != np.float64:
        raise refuse(f"'state' of shape {state.shape}, {state.dtype}, expected (n,), float64")
    if _text(stored, "checksum", refuse) != _checksum(stored):
        raise refuse("its checksum belongs to other content: it was changed or is damaged")
    progress.leg, progress.evaluations = leg, evaluations
    progress.cost, progress.solved, progress.gains = cost, solved, gains
    # Between two searches there is none.
    return state if len(state) else None


def _stored(path: Path, refuse: Refusal) -> dict[str, NDArray[Any]]:
    def damaged(reason: str) -> AgrikError:
        return refuse(f"is no whole checkpoint: {reason}")

    with Archive(path, damaged) as archive:
        return {name: archive.array(name) for name in _NAMES}


def _text(stored: Mapping[str, NDArray[Any]], name: str, refuse: Refusal) -> str:
    value = stored[name]
    if value.shape != () or value.dtype.kind != "U":
        raise refuse(f"'{name}' of shape {value.shape}, {shown(value.dtype)}, expected a text")
    with reading(refuse, f"'{name}' is no text"):
        return str(value)


def _array(
    stored: Mapping[str, NDArray[Any]],
    name: str,
    shape: tuple[int, ...],
    kind: str,
    refuse: Refusal,
) -> NDArray[Any]:
    value = stored[name]
    if value.shape != shape or value.dtype.kind != kind:
        words = {"i": "integers", "f": "floats"}[kind]
        found = f"shape {value.shape}, {shown(value.dtype)}"
        raise refuse(f"'{name}' of {found}, expected {shape}, {words}")
    return value


def _table(stored: Mapping[str, NDArray[Any]], name: str, refuse: Refusal) -> dict[str, Any]:
    text = _text(stored, name, refuse)
    with reading(refuse, f"'{name}' is no JSON"):
        table = json.loads(text)
    if not isinstance(table, dict):
        raise refuse(f"'{name}' holds {shown(table)}, expected a table")
    return table


def _check_identity(
    stored: Mapping[str, NDArray[Any]], wanted: dict[str, Any], refuse: Refusal
) -> None:
    other = _table(stored, "identity", refuse)
    # As it reads back: tuples have become lists.
    wanted = json.loads(json.dumps(wanted))
    for key in [*wanted, *(key for key in other if key not in wanted)]:
        if key not in other or key not in wanted or other[key] != wanted[key]:
            found, mine = (shown(table.get(key)) for table in (other, wanted))
            raise refuse(f"belongs to another run: {key} {found}, not {mine}")


def _gains(
    stored: Mapping[str, NDArray[Any]], bounds: Bounds, refuse: Refusal, *, ended: bool
) -> dict[str, Any]:
    found = _table(stored, "gains", refuse)
    shapes = bounds.shapes if ended else {}
    if set(found) != set(shapes):
        names = ", ".join(shapes) or "none"
        raise refuse(f"'gains': {shown(list(found))}, expected {names}")
    gains = {}
    for name, shape in shapes.items():
        with reading(refuse, f"'gains': {name} is no matrix"):
            value = np.array(found[name], dtype=np.float64)
        if value.shape != shape or not np.isfinite(value).all():
            raise refuse(f"'gains': {name} of shape {value.shape}, expected {shape}, finite")
        gains[name] = value
    return gains


def restore(path: Path, tuner: Tuner, state: FloatArray) -> None:
    try:
        tuner.restore(state)
    except ArgumentError as error:
        raise GainFileError(str(path), str(error)) from None


def save(path: Path, progress: Progress, state: FloatArray) -> None:
    """Write the progress and the state of the search underway, empty between two searches.

    Raises
    ------
    GainFileError
        The file cannot be written; the one before is still there.
    """
    gains = {name: np.asarray(value).tolist() for name, value in progress.gains.items()}
    content = {
        "identity": np.array(json.dumps(progress.identity)),
        "counts": np.array([progress.leg, progress.evaluations, progress.solved], dtype=np.int64),
        "cost": np.array(progress.cost),
        "state": state,
        "gains": np.array(json.dumps(gains)),
    }
    content["checksum"] = np.array(_checksum(content))
    stream = io.BytesIO()
    np.savez(stream, **content)  # type: ignore[arg-type]
    write_bytes(path, stream.getvalue(), partial(GainFileError, str(path)), force=True)


def _checksum(content: Mapping[str, NDArray[Any]]) -> str:
    """Return a checksum of everything but itself: no run reads what another hand has written."""
    digest = hashlib.sha256()
    for name in _NAMES[:-1]:
        value = np.ascontiguousarray(content[name])
        digest.update(f"{name} {value.shape} {value.dtype.kind}".encode())
        digest.update(value.tobytes())
    return digest.hexdigest()
