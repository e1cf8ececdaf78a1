"""Faults of a file's rows: the first of them are told, a line each, the others are counted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numpy.typing import NDArray

from .._files import Refusal

__all__ = ["FaultyRows", "RowFaults", "refuse_rows"]

FaultyRows = tuple[NDArray[Any], Callable[[int], str]]
"""Numbers of rows with one kind of fault, ascending, and what is wrong with one of them."""

# Faults that are told.
_TOLD = 20


class RowFaults:
    """What is wrong with rows, in the order of the file."""

    def __init__(self) -> None:
        self._told: list[str] = []
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, text: str) -> None:
        """Add the fault of a row."""
        self._count += 1
        if len(self._told) < _TOLD:
            self._told.append(text)

    def add_rows(self, faults: Sequence[FaultyRows]) -> None:
        """Add faults of rows that follow those added so far, one entry a kind of fault."""
        self._count += sum(len(rows) for rows, _ in faults)
        # Words are made for those that are told alone.
        left = _TOLD - len(self._told)
        first = [(int(row), word) for rows, word in faults for row in rows[:left]]
        first.sort(key=lambda each: each[0])
        self._told += [word(row) for row, word in first[:left]]

    def __str__(self) -> str:
        """Return the only fault as it is, or a line on their number and one on each."""
        if self._count == 1:
            return self._told[0]
        more = self._count - len(self._told)
        ending = [f"and {more} more"] if more else []
        return "\n  ".join([f"{self._count} rows are faulty", *self._told, *ending])


def refuse_rows(found: Sequence[FaultyRows], refuse: Refusal) -> None:
    """Raise what `refuse` makes of faulty rows, if there are any."""
    faults = RowFaults()
    faults.add_rows(found)
    if faults:
        raise refuse(str(faults))
