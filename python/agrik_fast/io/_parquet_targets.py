"""Targets from Parquet, read as a stream of record batches."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from .._files import reading
from ._arrow import TargetTable
from ._errors import TargetFileError
from ._parquet import WHAT, check_parquet_sizes, open_parquet
from ._reader import DEFAULT_CHUNK, TargetReader, rows_within
from ._records import TargetChunk


class ParquetReader(TargetReader):
    """A Parquet file with the CSV's columns; nulls count as not finite."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._refuse = partial(TargetFileError, path)
        with open_parquet(path, self._refuse) as file, reading(self._refuse, WHAT):
            self.count = int(file.metadata.num_rows)
            self._table = TargetTable(file.schema_arrow, self._refuse)
            check_parquet_sizes(file, path.stat().st_size, self._refuse)
        if self.count <= 0:
            raise TargetFileError(path, "no targets in the file")
        self.is_pose = self._table.is_pose
        self.ignored = self._table.ignored
        self.has_text_ids = self._table.has_text_ids

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        first = 0
        with contextlib.closing(open_parquet(self.path, self._refuse)) as file:
            with reading(self._refuse, WHAT):
                batches = file.iter_batches(batch_size=size, columns=list(self._table.names))
            while True:
                with reading(self._refuse, f"is damaged after row {first}"):
                    batch = next(batches, None)
                if batch is None:
                    break
                yield from self._batch(first, batch)
                first += batch.num_rows
        if first != self.count:
            raise self._refuse(f"claims {self.count} rows, has {first}")

    def _batch(self, first: int, batch: Any) -> Iterator[TargetChunk]:
        """Yield a batch, in pieces where its ids are long."""
        step = rows_within(max(batch.num_rows, 1), self._table.row_bytes(first, batch))
        for at in range(0, batch.num_rows, step):
            part = batch.slice(at, step)
            with reading(self._refuse, f"is damaged after row {first + at}"):
                chunk = self._table.chunk(first + at, part)
            yield chunk
