"""Results to CSV."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from ._records import STATUS_NAMES, ResultChunk, ResultLayout, scene_columns
from ._writer import ResultWriter


class CsvWriter(ResultWriter):
    """One line a row; Python's shortest float text, which reads back to the same bits."""

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        super().__init__(path, layout, force=force)
        self._text = io.TextIOWrapper(
            self._file.stream, encoding="utf-8", newline="", write_through=False
        )
        self._lines = csv.writer(self._text, lineterminator="\n")
        self._lines.writerow(layout.columns)

    def _write(self, chunk: ResultChunk) -> None:
        scene = scene_columns(self.layout, chunk)
        self._lines.writerows(
            (row_id, *q, STATUS_NAMES[status], "true" if success else "false", *rest)
            for row_id, q, status, success, *rest in zip(
                chunk.ids.tolist(),
                chunk.q.tolist(),
                chunk.status.tolist(),
                chunk.success.tolist(),
                chunk.position_error.tolist(),
                chunk.orientation_error.tolist(),
                chunk.iterations.tolist(),
                chunk.restarts.tolist(),
                *(() if scene is None else (column.tolist() for column in scene)),
                strict=True,
            )
        )

    def _finish(self) -> None:
        self._text.flush()
        self._text.detach()
