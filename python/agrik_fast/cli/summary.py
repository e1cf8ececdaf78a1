"""The table of finished batches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TextIO

import numpy as np

from ..jobs import Summary
from ..result import Status
from ._tables import aligned

# Statuses that have a column in any case; the others have one where some row has them.
_ALWAYS = (Status.CONVERGED, Status.OUT_OF_REACH, Status.NOT_FOUND, Status.BAD_INPUT)
_TEXT_COLUMNS = 2


def _title(status: Status) -> str:
    return "solved" if status is Status.CONVERGED else status.name.lower().replace("_", " ")


def table(summaries: Sequence[Summary]) -> list[list[str]]:
    """Return the headings and one row per batch, with a column for each status that occurs."""
    statuses = [
        status
        for status in Status
        if status in _ALWAYS or any(summary.counts[status] for summary in summaries)
    ]
    titles = [_title(status) for status in statuses]
    errors = ["median m", "worst m", "median rad", "worst rad"]
    headings = ["robot", "task", "rows", *titles, *errors, "time s", "solves/s"]
    return [headings, *(_cells(summary, statuses) for summary in summaries)]


def _cells(summary: Summary, statuses: Sequence[Status]) -> list[str]:
    return [
        summary.label,
        summary.task,
        str(summary.rows),
        *(str(summary.counts[status]) for status in statuses),
        *(
            _scientific(value)
            for value in (*summary.position_error(), *summary.orientation_error())
        ),
        f"{summary.total_s:.2f}",
        "-" if np.isnan(summary.rate) else f"{summary.rate:.0f}",
    ]


def _scientific(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.1e}"


def print_summaries(summaries: Sequence[Summary], stream: TextIO) -> None:
    """Print one table row per batch: with rules on a terminal, aligned text elsewhere.

    A terminal shows a single batch downwards, and several as sentences if the table is
    wider than the window.

    Examples
    --------
    >>> import io
    >>> from agrik_fast.cli import summary
    >>> from agrik_fast.jobs import Summary
    >>> stream = io.StringIO()
    >>> summary.print_summaries([Summary("ur5", "pose", True)], stream)
    >>> "ur5" in stream.getvalue()
    True
    """
    lines = table(summaries)
    if stream.isatty():
        _print_rich(*lines, stream=stream)
    else:
        _print_plain(lines, stream)


def _print_rich(headings: Sequence[str], *rows: Sequence[str], stream: TextIO) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(file=stream)
    if len(rows) == 1:
        column = Table("result", rows[0][0])
        for heading, cell in zip(headings[1:], rows[0][1:], strict=True):
            column.add_row(heading, cell)
        console.print(column)
        return
    ruled = Table()
    for k, heading in enumerate(headings):
        ruled.add_column(heading, justify="left" if k < _TEXT_COLUMNS else "right")
    for row in rows:
        ruled.add_row(*row)
    # Measured in a wide window, for a narrow one would cut the answer down to its own width.
    wide = console.options.update(max_width=1_000)
    if console.measure(ruled, options=wide).maximum <= console.width:
        console.print(ruled)
    else:
        for row in rows:
            print(_sentences(headings, row), file=stream)


def _sentences(headings: Sequence[str], row: Sequence[str]) -> str:
    """Return a batch's numbers in two lines that fit 80 characters."""
    cell = dict(zip(headings, row, strict=True))
    titles = headings[headings.index("rows") + 1 : headings.index("median m")]
    counts = ", ".join(f"{cell[name]} {name}" for name in titles)
    errors = f"error median {cell['median m']} m, worst {cell['worst m']} m"
    if cell["median rad"] != "-":
        errors += f", {cell['median rad']} rad, {cell['worst rad']} rad"
    return (
        f"{cell['robot']}, {cell['task']}: {cell['rows']} rows, {counts}\n"
        f"  {errors}; {cell['time s']} s"
    )


def _print_plain(lines: Sequence[Sequence[str]], stream: TextIO) -> None:
    for line in aligned(lines, _TEXT_COLUMNS):
        print(line, file=stream)
