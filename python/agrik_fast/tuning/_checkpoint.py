"""What a search keeps on the disk, so that a run that was killed can go on."""

from __future__ import annotations

import json
import os
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .._checks import FloatArray
from .._native import Tuner
from ..errors import ArgumentError, GainFileError

PERIOD_S = 2.0
"""Seconds from one writing to the next."""


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


def prepare(path: Path, progress: Progress, resume: bool) -> FloatArray | None:
    """Take up the stored progress; returns the state of the run that had not ended."""
    if not resume:
        if path.exists():
            message = "is the checkpoint of a run that did not end; resume it or remove it"
            raise GainFileError(str(path), message)
        return None
    if not path.exists():
        raise GainFileError(str(path), "no such checkpoint to resume")
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            other = json.loads(str(stored["identity"]))
            state: FloatArray = stored["state"]
            leg, evaluations, solved = (int(x) for x in stored["counts"])
            cost = float(stored["cost"])
            found = json.loads(str(stored["gains"]))
            gains = {name: np.array(value) for name, value in found.items()}
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise GainFileError(str(path), f"is no whole checkpoint: {error}") from None
    wanted = json.loads(json.dumps(progress.identity))
    for key, value in wanted.items():
        if other.get(key) != value:
            message = f"belongs to another run: {key} {other.get(key)!r}, not {value!r}"
            raise GainFileError(str(path), message)
    progress.leg, progress.evaluations = leg, evaluations
    progress.cost, progress.solved, progress.gains = cost, solved, gains
    return state


def restore(path: Path, tuner: Tuner, state: FloatArray) -> None:
    try:
        tuner.restore(state)
    except ArgumentError as error:
        raise GainFileError(str(path), str(error)) from None


def save(path: Path, progress: Progress, state: FloatArray) -> None:
    gains = {name: np.asarray(value).tolist() for name, value in progress.gains.items()}
    temporary = path.with_name(f".{path.name}.{os.getpid()}.partial")
    with temporary.open("wb") as stream:
        np.savez(
            stream,
            identity=np.array(json.dumps(progress.identity)),
            counts=np.array([progress.leg, progress.evaluations, progress.solved]),
            cost=np.array(progress.cost),
            state=state,
            gains=np.array(json.dumps(gains)),
        )
    temporary.replace(path)
