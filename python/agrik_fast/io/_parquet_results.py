"""Results to Parquet, one row group a chunk."""

from __future__ import annotations

import contextlib
from functools import partial
from pathlib import Path
from typing import Any

from ._arrow import ResultTable
from ._errors import ResultFileError
from ._parquet import parquet_writer
from ._records import ResultChunk, ResultLayout
from ._writer import ResultWriter


class ParquetWriter(ResultWriter):
    """The CSV's columns with types; the status as a dictionary of the names."""

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        self._table = ResultTable(layout, partial(ResultFileError, path))
        super().__init__(path, layout, force=force)
        self._writer: Any = parquet_writer(self._file.stream, self._table.schema)

    def _write(self, chunk: ResultChunk) -> None:
        self._writer.write_table(self._table.table(chunk))

    def _finish(self) -> None:
        self._writer.close()

    def discard(self) -> None:
        """Give up: nothing appears at the destination."""
        # Closing writes a footer, which the disk may refuse as well.
        with contextlib.suppress(OSError):
            self._writer.close()
        super().discard()
