"""The command ``agrik-fast tune``: a progress bar, a checkpoint, a gain file."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TextIO

import typer

from .._atomic import AtomicFile
from ..errors import ArgumentError, GainFileError
from ..jobs import RobotChoice
from ..solvers.gain_file import GainFile, text, write
from ..tuning import Report, Tuning, trials, tune
from ._exits import say, telling, write_line
from ._tables import aligned
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
        line = f"{report.evaluations} of {report.wanted} gain sets, cost {report.cost:.4f}"
        # The first generation tells how far the run is, not yet how fast it goes.
        if done:
            line += f", {max(left, 0.0):.0f} s left"
        write_line(self._stream, line + (f"; {report.unsaved}" if report.unsaved else ""))


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
            unsaved = " (checkpoint not written)" if report.unsaved else ""
            bar.start(f"gain sets, cost {report.cost:.4f}{unsaved}", report.wanted)
            bar.advance(report.evaluations - shown)
            shown = report.evaluations

        yield show


def tune_to_file(
    robot: RobotChoice, tuning: Tuning, output: Path, *, force: bool, resume: bool
) -> GainFile:
    """Tune and write the gain file; returns its content.

    Raises
    ------
    AgrikError
        Bad arguments, files that cannot be written or resumed. A search that has ended is then
        in its checkpoint, or on standard output where that cannot be written either.
    """
    if output.suffix not in (".toml", ".json"):
        raise ArgumentError("output", str(output), "a name that ends in .toml or .json")
    if not output.parent.is_dir():
        raise ArgumentError("output", str(output), "a name in a folder that exists")
    # Before the search, not hours later.
    AtomicFile(output, partial(GainFileError, str(output)), force=force).discard()
    checkpoint = checkpoint_of(output)
    arm = robot.load()
    for note in arm.notes:
        say(f"{arm.name}: {note}")

    def store(content: GainFile) -> None:
        try:
            write(output, content, force=force)
        except GainFileError as error:
            if checkpoint.exists():
                raise GainFileError(error.file, f"{error.reason}; {what_is_kept(output)}") from None
            with telling():
                typer.echo(text(output, content))
            reason = f"{error.reason}; its text is on standard output"
            raise GainFileError(error.file, reason) from None

    with reporting(sys.stderr) as report:
        return tune(arm, tuning, checkpoint=checkpoint, resume=resume, report=report, store=store)


def comparison(content: GainFile, robot: RobotChoice, tuning: Tuning) -> list[str]:
    """Return lines that set tuned gains beside the default and the published ones.

    All are tried with the same start, steps and tolerance on the goals kept apart.
    """
    rows = [["gains", "solved", "of", "mean steps"]]
    for name, table in trials(content, robot.load(), tuning).items():
        mean = "-" if table.mean_iterations is None else f"{table.mean_iterations:.1f}"
        rows.append([name, str(table.solved), str(table.goals), mean])
    return aligned(rows)


def checkpoint_of(output: Path) -> Path:
    """Return the name of the checkpoint of a gain file."""
    return output.with_name(f"{output.name}.checkpoint.npz")


def what_is_kept(output: Path) -> str:
    """Return what is left of a search that was cut off, in words."""
    checkpoint = checkpoint_of(output)
    if checkpoint.exists():
        return f"the search is kept in {checkpoint} (--resume goes on with it)"
    return "nothing was written"
