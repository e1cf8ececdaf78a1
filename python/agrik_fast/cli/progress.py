"""How a batch shows that it moves: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Self, TextIO

from ..jobs import Progress, Silent
from ._exits import write_line

PLAIN_INTERVAL_S = 2.0


class Plain(Silent):
    """One line at the start and one every few seconds: fit for logs."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._done = 0
        self._of = ""
        self._next = 0.0

    def start(self, label: str, total: int | None) -> None:
        """Print the label and the number of rows."""
        self._of = "" if total is None else f" of {total}"
        self.note(label if total is None else f"{label}: {total} rows")
        self._next = time.monotonic() + PLAIN_INTERVAL_S

    def note(self, text: str) -> None:
        """Print a line."""
        write_line(self._stream, text)

    def advance(self, rows: int) -> None:
        """Print the count if the last line is a while ago."""
        self._done += rows
        now = time.monotonic()
        if now >= self._next:
            self.note(f"{self._done}{self._of} rows done")
            self._next = now + PLAIN_INTERVAL_S


class Bar:
    """A rich progress bar."""

    def __init__(self, stream: TextIO) -> None:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=Console(file=stream),
        )
        self._task = self._bar.add_task("", total=None, start=False)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def start(self, label: str, total: int | None) -> None:
        """Start the clock of the bar."""
        self._bar.update(self._task, description=label, total=total)
        self._bar.start_task(self._task)

    def note(self, text: str) -> None:
        """Print a line above the bar."""
        self._bar.console.print(text, markup=False, highlight=False)

    def advance(self, rows: int) -> None:
        """Move the bar."""
        self._bar.advance(self._task, rows)


def for_stream(stream: TextIO) -> Progress:
    """Return a bar if the stream is a terminal, plain lines otherwise.

    Examples
    --------
    >>> import io
    >>> from agrik_fast.cli import progress
    >>> stream = io.StringIO()
    >>> with progress.for_stream(stream) as bar:
    ...     bar.start("ur5", 10)
    ...     bar.advance(10)
    """
    return Bar(stream) if stream.isatty() else Plain(stream)
