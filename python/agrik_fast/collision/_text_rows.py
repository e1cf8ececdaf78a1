"""Rows of numbers in lines of text, as clouds of points have them."""

from __future__ import annotations

import numpy as np

from .._checks import FloatArray
from .._files import Refusal, shown


def numbers_of_lines(
    body: bytes, count: int, columns: int, refuse: Refusal, *, skip: int = 0, what: str
) -> FloatArray:
    """Return rows of numbers.

    Parameters
    ----------
    body : bytes
        Lines of numbers with blanks between them; blank lines do not count.
    count, columns : int
        Rows that are claimed, and numbers in each.
    refuse : callable
        Makes the file's error from what is wrong.
    skip : int
        Lines to pass over.
    what : str
        What the rows are.

    Returns
    -------
    ndarray, shape (count, columns)
    """
    # A line of n numbers has 2 n letters at least: the claim is held against that first.
    if count * max(1, columns) * 2 > len(body) + 2:
        most = len(body) // max(1, 2 * columns)
        raise refuse(f"ends early: at most {most} of the {count} {what} that it claims")
    lines = [line for line in body.split(b"\n") if line.strip()][skip : skip + count]
    if len(lines) < count:
        raise refuse(f"ends early: {len(lines)} of the {count} {what} that it claims")
    try:
        # float() of bytes takes underscores, NumPy's reading does not tell lines apart.
        rows = np.array([line.split() for line in lines], dtype="S").astype(np.float64)
        if rows.shape == (count, columns) or count == 0:
            return rows.reshape(count, columns)
    except ValueError:
        pass
    for number, line in enumerate(lines, start=1):
        if not _is_row(line, columns):
            last = ", and the file ends with it" if number == count else ""
            got = shown(line.decode("latin1").strip())
            raise refuse(f"{what} row {number}: expected {columns} numbers, got {got}{last}")
    raise refuse(f"{what}: expected {columns} numbers a line")


def _is_row(line: bytes, columns: int) -> bool:
    try:
        return len([float(x) for x in line.split()]) == columns
    except ValueError:
        return False
