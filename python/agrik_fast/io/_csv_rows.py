"""Rows of a CSV file, each of bounded length; errors name the file and its line."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import _native
from .._files import Refusal, os_reason
from ._row_faults import RowFaults

ROW_BYTES = 1 << 20
"""Longest row, the lines inside quotes included."""

# Faults of a single row, after which the next one can be read; a row without an end is none.
_OF_ONE_ROW = re.compile(r"row \d+ |line \d+: is not UTF-8 text")
# Rows that are read at a time where only their faults are wanted.
_BLOCK = 65_536
_BLOCK_BYTES = 32 << 20

Block = tuple[NDArray[np.float64], list[list[str]], list[int]]
"""Numbers, shape (n, k), texts by column, and the line of each row."""


class CsvRows:
    """The rows of a file that are neither blank nor comments, after its header.

    Parameters
    ----------
    path : path
    refuse : callable
        Makes the file's error.

    Attributes
    ----------
    header : tuple of str
        Names of the columns; empty where the file holds no row at all.
    """

    def __init__(self, path: Path, refuse: Refusal) -> None:
        self._refuse = refuse
        with self._naming():
            self._rows = _native.CsvRows(path, ROW_BYTES)
        self.header = tuple(self._rows.header)

    def any_row(self, numeric: Sequence[int], texts: Sequence[int]) -> bool:
        """Go to the next row and return whether there is one; faults as of `block`."""
        with self._naming((numeric, texts)):
            return bool(self._rows.block(1, 1, [], [])[2])

    def block(
        self, size: int, size_bytes: int, numeric: Sequence[int], texts: Sequence[int]
    ) -> Block:
        """Return up to `size` rows, fewer where they take more than `size_bytes`.

        Raises
        ------
        AgrikError
            By `refuse`: rows with another number of fields, a field that is no number, or
            bytes that are no text; with row, line and column. The file is read to its end then,
            to tell of all such rows.
        """
        with self._naming((numeric, texts)):
            return self._rows.block(size, size_bytes, list(numeric), list(texts))

    @contextlib.contextmanager
    def _naming(self, columns: tuple[Sequence[int], Sequence[int]] | None = None) -> Iterator[None]:
        """Name the file in errors, and with `columns` all faulty rows from here on."""
        try:
            yield
        except OSError as error:
            raise self._refuse(f"cannot be read: {os_reason(error)}") from error
        except ValueError as error:
            faults = RowFaults()
            faults.add(str(error))
            if columns is not None and _OF_ONE_ROW.match(str(error)):
                self._read_on(faults, *map(list, columns))
            raise self._refuse(str(faults)) from None

    def _read_on(self, faults: RowFaults, numeric: list[int], texts: list[int]) -> None:
        """Add the faults of the rows that are left."""
        while True:
            try:
                if not self._rows.block(_BLOCK, _BLOCK_BYTES, numeric, texts)[2]:
                    return
            except OSError:
                return  # what is known by now is told
            except ValueError as error:
                faults.add(str(error))
                if not _OF_ONE_ROW.match(str(error)):
                    return
