"""The numbers of a finished batch and their table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TextIO

import numpy as np

from ..io import ResultChunk
from ..result import Status
from .spread import Spread


@dataclass
class Summary:
    """Counts and errors of a batch, gathered chunk by chunk.

    Attributes
    ----------
    label : str
        The robot's name.
    task : str
    with_orientation : bool
        True if the task has an orientation error.
    counts : dict of Status to int
    total_s, solve_s : float
        Seconds in all, and in the solver alone.
    """

    label: str
    task: str
    with_orientation: bool
    counts: dict[Status, int] = field(default_factory=lambda: dict.fromkeys(Status, 0))
    total_s: float = 0.0
    solve_s: float = 0.0
    _position: Spread = field(default_factory=Spread, repr=False)
    _orientation: Spread = field(default_factory=Spread, repr=False)

    def add(self, chunk: ResultChunk) -> None:
        """Count a chunk; errors are those of solved rows only."""
        for status in Status:
            self.counts[status] += int(np.count_nonzero(chunk.status == status))
        self._position.add(chunk.position_error[chunk.success])
        if self.with_orientation:
            self._orientation.add(chunk.orientation_error[chunk.success])

    @property
    def rows(self) -> int:
        """Number of rows."""
        return sum(self.counts.values())

    @property
    def solved(self) -> int:
        """Number of rows within tolerance and limits."""
        return self.counts[Status.CONVERGED]

    @property
    def rate(self) -> float:
        """Rows per second of solver time."""
        return self.rows / self.solve_s if self.solve_s > 0.0 else float("nan")

    def position_error(self) -> tuple[float, float]:
        """Return median (to 1 %) and worst position error of the solved rows, m; NaN if none."""
        return self._position.median(), self._position.largest()

    def orientation_error(self) -> tuple[float, float]:
        """Return median (to 1 %) and worst angle of the solved rows, rad; NaN if none."""
        return self._orientation.median(), self._orientation.largest()

    def cells(self) -> list[str]:
        """Return the texts under `HEADINGS`."""
        position, orientation = self.position_error(), self.orientation_error()
        return [
            self.label,
            self.task,
            str(self.rows),
            str(self.solved),
            str(self.counts[Status.OUT_OF_REACH]),
            str(self.counts[Status.NOT_FOUND]),
            str(self.counts[Status.BAD_INPUT]),
            *(_scientific(value) for value in (*position, *orientation)),
            f"{self.total_s:.2f}",
            "-" if np.isnan(self.rate) else f"{self.rate:.0f}",
        ]


HEADINGS = (
    "robot",
    "task",
    "rows",
    "solved",
    "out of reach",
    "not found",
    "bad input",
    "median m",
    "worst m",
    "median rad",
    "worst rad",
    "time s",
    "solves/s",
)
_TEXT_COLUMNS = 2


def _scientific(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.1e}"


def print_summaries(summaries: Sequence[Summary], stream: TextIO) -> None:
    """Print one table row per batch: with rules on a terminal, aligned text elsewhere.

    A terminal shows a single batch downwards, and several as sentences if the table is
    wider than the window.
    """
    rows = [summary.cells() for summary in summaries]
    if stream.isatty():
        _print_rich(rows, stream)
    else:
        _print_plain([list(HEADINGS), *rows], stream)


def _print_rich(rows: Sequence[Sequence[str]], stream: TextIO) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(file=stream)
    if len(rows) == 1:
        table = Table("result", rows[0][0])
        for heading, cell in zip(HEADINGS[1:], rows[0][1:], strict=True):
            table.add_row(heading, cell)
        console.print(table)
        return
    table = Table()
    for k, heading in enumerate(HEADINGS):
        table.add_column(heading, justify="left" if k < _TEXT_COLUMNS else "right")
    for row in rows:
        table.add_row(*row)
    # Measured in a wide window, for a narrow one would cut the answer down to its own width.
    wide = console.options.update(max_width=1_000)
    if console.measure(table, options=wide).maximum <= console.width:
        console.print(table)
    else:
        for row in rows:
            print(_sentences(row), file=stream)


def _sentences(row: Sequence[str]) -> str:
    """Return a batch's numbers in two lines that fit 80 characters."""
    cell = dict(zip(HEADINGS, row, strict=True))
    counts = ", ".join(f"{cell[name]} {name}" for name in HEADINGS[3:7])
    errors = f"error median {cell['median m']} m, worst {cell['worst m']} m"
    if cell["median rad"] != "-":
        errors += f", {cell['median rad']} rad, {cell['worst rad']} rad"
    return (
        f"{cell['robot']}, {cell['task']}: {cell['rows']} rows, {counts}\n"
        f"  {errors}; {cell['time s']} s"
    )


def _print_plain(lines: Sequence[Sequence[str]], stream: TextIO) -> None:
    widths = [max(len(line[k]) for line in lines) for k in range(len(HEADINGS))]
    for line in lines:
        padded = [
            cell.ljust(width) if k < _TEXT_COLUMNS else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        ]
        print("  ".join(padded).rstrip(), file=stream)
