"""Targets from CSV, read as a stream."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ._columns import ColumnError, match_columns
from ._csv_rows import Block, CsvRows
from ._errors import TargetFileError
from ._extras import Extra, column_of
from ._ids import check_texts
from ._reader import CHUNK_BYTES, DEFAULT_CHUNK, TargetReader
from ._records import TargetChunk


class CsvReader(TargetReader):
    """A CSV file of targets with a header line; see `read_targets` for the columns."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.count = None
        self._refuse = partial(TargetFileError, path)
        rows = CsvRows(path, self._refuse)
        names = rows.header
        if not names:
            raise TargetFileError(path, "the file is empty")
        try:
            self._columns = match_columns(names)
        except ColumnError as error:
            raise TargetFileError(path, str(error)) from error
        self._numeric = [names.index(name) for name in self._columns.numeric]
        self._texts = [] if self._columns.row_id is None else [names.index("id")]
        # What a column holds is known when the last row is read: it is passed on as it is written.
        self.extras = tuple(Extra(name, "text") for name in self._columns.ignored if name)
        self._more = [names.index(extra.name) for extra in self.extras]
        if not rows.any_row(self._numeric, [*self._texts, *self._more]):
            raise TargetFileError(path, "no targets after the header")
        self.is_pose = self._columns.orientation is not None
        self.has_text_ids = bool(self._texts)
        self.ignored = self._columns.ignored

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        rows = CsvRows(self.path, self._refuse)
        first = 0
        while True:
            block = rows.block(size, CHUNK_BYTES, self._numeric, [*self._texts, *self._more])
            count = len(block[2])
            if not count:
                return
            targets = self._columns.targets(block[0])
            texts = block[1][len(self._texts) :]
            extras = {
                extra.name: column_of("text", np.array(column, dtype=object))
                for extra, column in zip(self.extras, texts, strict=True)
            }
            yield TargetChunk(first, targets, self._ids(first, block), extras)
            first += count

    def _ids(self, first: int, block: Block) -> NDArray[np.int64] | NDArray[np.str_]:
        _, texts, lines = block
        if not self._texts:
            return np.arange(first + 1, first + len(lines) + 1, dtype=np.int64)
        check_texts(texts[0], lambda at: f"row {first + at + 1} (line {lines[at]})", self._refuse)
        return np.array(texts[0], dtype=np.str_)
