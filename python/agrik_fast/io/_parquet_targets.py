"""Targets from Parquet, read as a stream of record batches."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import reading
from ._columns import ColumnError, match_columns
from ._errors import TargetFileError
from ._ids import check_text, checked
from ._parquet import WHAT, check_sizes, import_pyarrow, open_file
from ._reader import CHUNK_BYTES, DEFAULT_CHUNK, TargetReader, rows_within
from ._records import TargetChunk

# Whole numbers up to here are float64 numbers too.
_EXACT = 2**53


class ParquetReader(TargetReader):
    """A Parquet file with the CSV's columns; nulls count as not finite."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._refuse = partial(TargetFileError, path)
        self._pyarrow = import_pyarrow(self._refuse)
        with open_file(path, self._refuse) as file, reading(self._refuse, WHAT):
            kinds = dict(zip(file.schema_arrow.names, file.schema_arrow.types, strict=True))
            names = list(file.schema_arrow.names)
            self.count = int(file.metadata.num_rows)
            try:
                self._columns = match_columns(names)
            except ColumnError as error:
                raise TargetFileError(path, str(error)) from error
            self._names = [*self._columns.numeric, *(["id"] if self._columns.row_id else [])]
            check_sizes(file, path, self._refuse)
        types = self._pyarrow.types
        for name in self._columns.numeric:
            kind = kinds[name]
            if not (types.is_floating(kind) or types.is_integer(kind)):
                raise TargetFileError(path, f"column '{name}' holds {kind}, expected numbers")
        if self.count <= 0:
            raise TargetFileError(path, "no targets in the file")
        self.is_pose = self._columns.orientation is not None
        self.ignored = self._columns.ignored
        if self._columns.row_id is not None:
            kind = kinds["id"]
            if types.is_dictionary(kind):
                kind = kind.value_type
            self.has_text_ids = bool(types.is_string(kind) or types.is_large_string(kind))
            if not (self.has_text_ids or types.is_integer(kind)):
                raise TargetFileError(path, f"column 'id' holds {kind}, expected integers or text")

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        first = 0
        with contextlib.closing(open_file(self.path, self._refuse)) as file:
            with reading(self._refuse, WHAT):
                batches = file.iter_batches(batch_size=size, columns=self._names)
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
        step = rows_within(max(batch.num_rows, 1), self._row_bytes(first, batch))
        for at in range(0, batch.num_rows, step):
            part = batch.slice(at, step)
            with reading(self._refuse, f"is damaged after row {first + at}"):
                chunk = self._chunk(first + at, part)
            yield chunk

    def _row_bytes(self, first: int, batch: Any) -> int:
        """Return about how many bytes a row takes; long ids are refused."""
        if not self.has_text_ids:
            return 0
        letters = 0
        with reading(self._refuse, f"is damaged after row {first}"):
            column = batch.column(batch.schema.get_field_index("id"))
            # A text is looked at before a chunk's ids are made as wide as the longest.
            texts = getattr(column, "dictionary", column)
            longest = self._pyarrow.compute.max(self._pyarrow.compute.binary_length(texts))
            if (longest.as_py() or 0) > CHUNK_BYTES // DEFAULT_CHUNK:
                for k, text in enumerate(texts.to_pylist()):
                    if text is not None:
                        row = self._row_of(column, texts, k)
                        check_text(text, f"row {first + row + 1}, column 'id'", self._refuse)
                        letters = max(letters, len(text))
        return 4 * letters

    def _row_of(self, column: Any, texts: Any, k: int) -> int:
        if texts is column:
            return k
        found = self._pyarrow.compute.index(column.indices, k).as_py()
        return max(int(found), 0)

    def _chunk(self, first: int, batch: Any) -> TargetChunk:
        double = self._pyarrow.float64()
        values = np.empty((batch.num_rows, len(self._columns.numeric)))
        for k, name in enumerate(self._columns.numeric):
            column = batch.column(batch.schema.get_field_index(name))
            if self._pyarrow.types.is_integer(column.type):
                self._check_exact(first, name, column)
            values[:, k] = column.cast(double).to_numpy(zero_copy_only=False)
        return TargetChunk(first, self._columns.targets(values), self._ids(first, batch))

    def _check_exact(self, first: int, name: str, column: Any) -> None:
        whole = column.fill_null(0).to_numpy(zero_copy_only=False)
        beyond = (whole > _EXACT) | (whole < -_EXACT if whole.dtype.kind == "i" else False)
        if beyond.any():
            at = int(np.argmax(beyond))
            raise self._refuse(
                f"row {first + at + 1}, column '{name}': expected a number that float64 "
                f"holds, at most 2**53, got {whole[at]}"
            )

    def _ids(self, first: int, batch: Any) -> NDArray[Any]:
        if self._columns.row_id is None:
            return np.arange(first + 1, first + batch.num_rows + 1, dtype=np.int64)
        column = batch.column(batch.schema.get_field_index("id"))
        if column.null_count:
            row = first + int(np.argmax(column.is_null().to_numpy(zero_copy_only=False))) + 1
            raise self._refuse(f"row {row}, column 'id': is empty")
        if self.has_text_ids:
            return np.array(column.to_pylist(), dtype=np.str_)
        if self._pyarrow.types.is_dictionary(column.type):
            column = column.dictionary_decode()
        whole = np.asarray(column.to_numpy(zero_copy_only=False))
        return checked(whole, first, self._refuse)
