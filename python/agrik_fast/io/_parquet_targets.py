"""Targets from Parquet, read as a stream of record batches."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._columns import ColumnError, match_columns
from ._errors import TargetFileError
from ._reader import DEFAULT_CHUNK, TargetReader
from ._records import TargetChunk

BUFFER_BYTES = 1 << 20


class ParquetReader(TargetReader):
    """A Parquet file with the CSV's columns; nulls count as not finite."""

    def __init__(self, path: Path) -> None:
        pyarrow = import_pyarrow(path)
        from pyarrow import parquet

        self.path = path
        self._pyarrow = pyarrow
        self._parquet = parquet
        with self._open() as file:
            schema = file.schema_arrow
            self.count = int(file.metadata.num_rows)
        try:
            self._columns = match_columns(list(schema.names))
        except ColumnError as error:
            raise TargetFileError(path, str(error)) from error
        types = pyarrow.types
        for name in self._columns.numeric:
            kind = schema.field(name).type
            if not (types.is_floating(kind) or types.is_integer(kind)):
                raise TargetFileError(path, f"column '{name}' holds {kind}, expected numbers")
        if self.count == 0:
            raise TargetFileError(path, "no targets in the file")
        self.is_pose = self._columns.orientation is not None
        self.ignored = self._columns.ignored
        if self._columns.row_id is not None:
            kind = schema.field("id").type
            self.has_text_ids = bool(types.is_string(kind) or types.is_large_string(kind))
            if not (self.has_text_ids or types.is_integer(kind)):
                raise TargetFileError(path, f"column 'id' holds {kind}, expected integers or text")

    def _open(self) -> Any:
        try:
            # Columns are read piece by piece; otherwise whole row groups would be held, and
            # a row group may be the whole file.
            return self._parquet.ParquetFile(self.path, buffer_size=BUFFER_BYTES, pre_buffer=False)
        except self._pyarrow.ArrowInvalid as error:
            raise TargetFileError(self.path, "is not a Parquet file") from error

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        columns = [*self._columns.numeric, *(["id"] if self._columns.row_id else [])]
        first = 0
        with self._open() as file:
            for batch in file.iter_batches(batch_size=size, columns=columns):
                if batch.num_rows:
                    yield self._chunk(first, batch)
                    first += batch.num_rows

    def _chunk(self, first: int, batch: Any) -> TargetChunk:
        double = self._pyarrow.float64()
        values = np.empty((batch.num_rows, len(self._columns.numeric)))
        for k, name in enumerate(self._columns.numeric):
            column = batch.column(name).cast(double)
            values[:, k] = column.to_numpy(zero_copy_only=False)
        return TargetChunk(first, self._columns.targets(values), self._ids(first, batch))

    def _ids(self, first: int, batch: Any) -> NDArray[Any]:
        if self._columns.row_id is None:
            return np.arange(first + 1, first + batch.num_rows + 1, dtype=np.int64)
        column = batch.column("id")
        if column.null_count:
            row = first + int(np.argmax(column.is_null().to_numpy(zero_copy_only=False))) + 1
            raise TargetFileError(self.path, f"row {row}, column 'id': is empty")
        if self.has_text_ids:
            return np.array(column.to_pylist(), dtype=np.str_)
        whole = column.cast(self._pyarrow.int64())
        return np.asarray(whole.to_numpy(zero_copy_only=False), dtype=np.int64)


def import_pyarrow(path: Path) -> Any:
    """Return the pyarrow module, or a one-line error that says how to get it."""
    try:
        import pyarrow
    except ImportError as error:
        raise TargetFileError(
            path, "Parquet files need pyarrow: pip install 'agrik-fast[parquet]'"
        ) from error
    return pyarrow
