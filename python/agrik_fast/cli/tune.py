"""The command ``agrik-fast tune``: a progress line, a checkpoint, a gain file."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from ..errors import ArgumentError, GainFileError
from ..gain_file import GainFile, write
from ..robot import Robot
from ..tune import Report, Tuning, tune

__all__ = ["tune_to_file"]

_PERIOD_S = 2.0


class _Line:
    """Says every few seconds how far a search has come; on a terminal, in one line."""

    def __init__(self) -> None:
        self._begin = time.monotonic()
        self._next = self._begin
        self._first = 0
        self._terminal = sys.stderr.isatty()

    def __call__(self, report: Report) -> None:
        now = time.monotonic()
        if now < self._next and report.evaluations < report.wanted:
            return
        if self._next == self._begin:
            self._first = report.evaluations
        self._next = now + (0.2 if self._terminal else _PERIOD_S)
        done = report.evaluations - self._first
        left = (report.wanted - report.evaluations) * (now - self._begin) / max(done, 1)
        text = (
            f"{report.evaluations} of {report.wanted} gain sets, cost {report.cost:.4f}, "
            f"{max(left, 0.0):.0f} s left"
        )
        if self._terminal:
            end = "\n" if report.evaluations >= report.wanted else ""
            print(f"\r{text:<70}", end=end, file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)


def tune_to_file(
    robot: str, tuning: Tuning, output: Path, *, force: bool, resume: bool
) -> GainFile:
    """Tune and write the gain file; returns its content."""
    if output.suffix not in (".toml", ".json"):
        raise ArgumentError("output", str(output), "a name that ends in .toml or .json")
    if output.exists() and not force:
        raise GainFileError(str(output), "exists already (use --force to replace it)")
    if not output.parent.is_dir():
        raise ArgumentError("output", str(output), "a name in a folder that exists")
    checkpoint = output.with_name(f"{output.name}.checkpoint.npz")
    content = tune(Robot.load(robot), tuning, checkpoint=checkpoint, resume=resume, report=_Line())
    write(output, content)
    return content
