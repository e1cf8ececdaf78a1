"""Rows of a CSV file, each of bounded length; errors name the file and its line."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import _native
from .._files import Refusal, os_reason

ROW_BYTES = 1 << 20
"""Longest row, the lines inside quotes included."""

Block = tuple[NDArray[np.float64], list[list[str]], list[int]]
"""Numbers, shape (n, k), texts by column, and the line of each row."""


class CsvRows:
    """The rows of a file that are neither blank nor comments, after its header.

    Parameters
    ----------
    path : Path
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

    def block(
        self, size: int, size_bytes: int, numeric: Sequence[int], texts: Sequence[int]
    ) -> Block:
        """Return up to `size` rows, fewer where they take more than `size_bytes`.

        Raises
        ------
        AgrikError
            By `refuse`: a row with another number of fields, a field that is no number, or
            bytes that are no text; with row, line and column.
        """
        with self._naming():
            return self._rows.block(size, size_bytes, list(numeric), list(texts))

    @contextlib.contextmanager
    def _naming(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise self._refuse(f"cannot be read: {os_reason(error)}") from error
        except ValueError as error:
            raise self._refuse(str(error)) from None
