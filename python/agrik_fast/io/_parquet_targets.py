"""Targets from Parquet, read as a stream of record batches."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from .._files import reading
from ._arrow import TargetTable
from ._errors import TargetFileError
from ._extras import ArrowExtras
from ._parquet import WHAT, check_parquet_sizes, open_parquet
from ._reader import DEFAULT_CHUNK, TargetReader, rows_within
from ._records import TargetChunk
from ._row_faults import RowFaults


class ParquetReader(TargetReader):
    """A Parquet file with the CSV's columns; nulls count as not finite."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._refuse = partial(TargetFileError, path)
        with open_parquet(path, self._refuse) as file, reading(self._refuse, WHAT):
            self.count = int(file.metadata.num_rows)
            self._table = TargetTable(file.schema_arrow, self._refuse)
            check_parquet_sizes(file, path.stat().st_size, self._refuse)
            self._extras = ArrowExtras(
                file.schema_arrow,
                self._table.ignored,
                lambda name: _may_have_nulls(file.metadata, name),
                self._refuse,
            )
        if self.count <= 0:
            raise TargetFileError(path, "no targets in the file")
        self.is_pose = self._table.is_pose
        self.ignored = self._table.ignored
        self.extras = self._extras.columns
        self.has_text_ids = self._table.has_text_ids

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        first = 0
        with contextlib.closing(open_parquet(self.path, self._refuse)) as file:
            with reading(self._refuse, WHAT):
                names = [*self._table.names, *(extra.name for extra in self.extras)]
                batches = file.iter_batches(batch_size=size, columns=names)
            while True:
                with reading(self._refuse, f"is damaged after row {first}"):
                    batch = next(batches, None)
                if batch is None:
                    break
                try:
                    yield from self._batch(first, batch)
                except TargetFileError:
                    self._tell_rows()
                    raise
                first += batch.num_rows
        if first != self.count:
            raise self._refuse(f"claims {self.count} rows, has {first}")

    def _tell_rows(self) -> None:
        """Raise what is wrong with rows, of the whole file, if anything is."""
        faults, first = RowFaults(), 0
        # Damage is told by what was raised before.
        with (
            contextlib.suppress(TargetFileError),
            contextlib.closing(open_parquet(self.path, self._refuse)) as file,
            reading(self._refuse, WHAT),
        ):
            for batch in file.iter_batches(DEFAULT_CHUNK, columns=list(self._table.names)):
                faults.add_rows(self._table.row_faults(first, batch))
                first += batch.num_rows
        if faults:
            raise self._refuse(str(faults))

    def _batch(self, first: int, batch: Any) -> Iterator[TargetChunk]:
        """Yield a batch, in pieces where its ids are long."""
        step = rows_within(max(batch.num_rows, 1), self._table.row_bytes(first, batch))
        for at in range(0, batch.num_rows, step):
            part = batch.slice(at, step)
            with reading(self._refuse, f"is damaged after row {first + at}"):
                chunk = self._table.chunk(first + at, part)
                extras = self._extras.of(part)
            yield replace(chunk, extras=extras)


def _may_have_nulls(metadata: Any, name: str) -> bool:
    """Return whether a column of a Parquet file has nulls, or does not say that it has none."""
    for group in range(metadata.num_row_groups):
        row_group = metadata.row_group(group)
        found = [
            row_group.column(k)
            for k in range(row_group.num_columns)
            if row_group.column(k).path_in_schema == name
        ]
        for column in found:
            said = column.statistics
            if said is None or not said.has_null_count or said.null_count:
                return True
    return False
