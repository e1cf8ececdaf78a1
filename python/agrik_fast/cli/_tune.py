"""The command ``agrik-fast tune``: a progress bar, a checkpoint, a gain file."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from ..errors import ArgumentError, GainFileError
from ..robot import Robot
from ..solvers.gain_file import GainFile, write
from ..tuning import Report, Tuning, tune
from .progress import PLAIN_INTERVAL_S, Bar

__all__ = ["tune_to_file"]


class _Lines:
    """Says every few seconds how far a search has come: fit for logs."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._begin = time.monotonic()
        self._next = self._begin
        self._first = 0

    def __call__(self, report: Report) -> None:
        now = time.monotonic()
        if now < self._next and report.evaluations < report.wanted:
            return
        if self._next == self._begin:
            self._first = report.evaluations
        self._next = now + PLAIN_INTERVAL_S
        done = report.evaluations - self._first
        left = (report.wanted - report.evaluations) * (now - self._begin) / max(done, 1)
        text = f"{report.evaluations} of {report.wanted} gain sets, cost {report.cost:.4f}"
        # The first generation tells how far the run is, not yet how fast it goes.
        if done:
            text += f", {max(left, 0.0):.0f} s left"
        print(text, file=self._stream, flush=True)


@contextmanager
def reporting(stream: TextIO) -> Iterator[Callable[[Report], None]]:
    """Give what shows reports: a bar if the stream is a terminal, plain lines otherwise."""
    if not stream.isatty():
        yield _Lines(stream)
        return
    shown = 0
    with Bar(stream) as bar:

        def show(report: Report) -> None:
            nonlocal shown
            # A generation is judged as a whole, so the last one may bring more than was asked.
            bar.start(f"gain sets, cost {report.cost:.4f}", report.wanted)
            bar.advance(report.evaluations - shown)
            shown = report.evaluations

        yield show


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
    arm = Robot.load(robot)
    with reporting(sys.stderr) as report:
        content = tune(arm, tuning, checkpoint=checkpoint, resume=resume, report=report)
    write(output, content)
    return content
