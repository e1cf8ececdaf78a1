"""Results to CSV."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from .._native import csv_lines
from ._records import STATUS_NAMES, ResultChunk, ResultLayout, scene_columns
from ._writer import ResultWriter


class CsvWriter(ResultWriter):
    """One line a row; the shortest text of a number that reads back to the same bits."""

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        super().__init__(path, layout, force=force)
        head = io.StringIO()
        csv.writer(head, lineterminator="\n").writerow(layout.columns)
        self._file.stream.write(head.getvalue().encode())

    def _write(self, chunk: ResultChunk) -> None:
        ids = chunk.ids.tolist() if chunk.ids.dtype.kind == "U" else chunk.ids.astype(np.int64)
        columns = [
            ids,
            *(np.ascontiguousarray(column) for column in chunk.q.T),
            [STATUS_NAMES[code] for code in chunk.status.tolist()],
            chunk.success,
            chunk.position_error,
            chunk.orientation_error,
            chunk.iterations.astype(np.int64),
            chunk.restarts.astype(np.int64),
        ]
        scene = scene_columns(self.layout, chunk)
        if scene is not None:
            clearance, body, thing = scene
            columns += [clearance, body.tolist(), thing.tolist()]
        for name, kind in self.layout.extras:
            column = chunk.extras[name]
            columns.append(column.tolist() if kind == "text" else np.ascontiguousarray(column))
        self._file.stream.write(csv_lines(columns))

    def _finish(self) -> None:
        pass
