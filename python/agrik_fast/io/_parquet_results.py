"""Results to Parquet, one row group a chunk."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np

from ._errors import ResultFileError
from ._records import (
    METADATA_PREFIX,
    SCENE_COLUMNS,
    STATUS_NAMES,
    ResultChunk,
    ResultLayout,
    scene_columns,
)
from ._writer import ResultWriter


class ParquetWriter(ResultWriter):
    """The CSV's columns with types; the status as a dictionary of the names."""

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError as error:
            raise ResultFileError(
                path, "Parquet files need pyarrow: pip install 'agrik-fast[parquet]'"
            ) from error
        super().__init__(path, layout, force=force)
        self._pyarrow: Any = pyarrow
        metadata = {METADATA_PREFIX + key: value for key, value in layout.metadata.items()}
        text = pyarrow.string()
        scene = zip(SCENE_COLUMNS, (pyarrow.float64(), text, text), strict=True)
        self._schema: Any = pyarrow.schema(
            [
                ("id", pyarrow.string() if layout.text_ids else pyarrow.int64()),
                *((name, pyarrow.float64()) for name in layout.joint_columns),
                ("status", pyarrow.dictionary(pyarrow.int8(), pyarrow.string())),
                ("success", pyarrow.bool_()),
                ("position_error_m", pyarrow.float64()),
                ("orientation_error_rad", pyarrow.float64()),
                ("iterations", pyarrow.int32()),
                ("restarts", pyarrow.int32()),
                *(((name, kind) for name, kind in scene) if layout.name_letters else ()),
            ],
            metadata=metadata,
        )
        self._writer: Any = parquet.ParquetWriter(
            # A dictionary pays for the few names, not for numbers that never repeat.
            self._file.stream,
            self._schema,
            use_dictionary=["status", *(SCENE_COLUMNS[1:] if layout.name_letters else ())],
        )

    def _write(self, chunk: ResultChunk) -> None:
        array = self._pyarrow.array
        status = self._pyarrow.DictionaryArray.from_arrays(
            array(chunk.status.astype(np.int8)), array(list(STATUS_NAMES))
        )
        columns = [
            array(chunk.ids.tolist() if self.layout.text_ids else chunk.ids),
            *(array(np.ascontiguousarray(chunk.q[:, k])) for k in range(chunk.q.shape[1])),
            status,
            array(chunk.success),
            array(chunk.position_error),
            array(chunk.orientation_error),
            array(chunk.iterations.astype(np.int32)),
            array(chunk.restarts.astype(np.int32)),
            *(array(column.tolist()) for column in scene_columns(self.layout, chunk) or ()),
        ]
        self._writer.write_table(self._pyarrow.Table.from_arrays(columns, schema=self._schema))

    def _finish(self) -> None:
        self._writer.close()

    def discard(self) -> None:
        """Give up: nothing appears at the destination."""
        # Closing writes a footer, which the disk may refuse as well.
        with contextlib.suppress(OSError):
            self._writer.close()
        super().discard()
