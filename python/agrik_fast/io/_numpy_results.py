"""Results to NPY (as a stream) and NPZ (gathered, written at the end)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .._npy import header_bytes
from ._records import (
    SCENE_COLUMNS,
    STATUS_NAMES,
    ResultChunk,
    ResultLayout,
    scene_columns,
)
from ._writer import ResultWriter


def record_dtype(layout: ResultLayout, id_dtype: np.dtype[Any]) -> np.dtype[Any]:
    """Return the structured type of one result row."""
    kinds = (np.float64, *2 * (f"<U{layout.name_letters}",))
    return np.dtype(
        [
            ("id", id_dtype),
            *((name, np.float64) for name in layout.joint_columns),
            ("status", np.int8),
            ("success", np.bool_),
            ("position_error_m", np.float64),
            ("orientation_error_rad", np.float64),
            ("iterations", np.int32),
            ("restarts", np.int32),
            *(zip(SCENE_COLUMNS, kinds, strict=True) if layout.name_letters else ()),
        ]
    )


def records(layout: ResultLayout, chunk: ResultChunk) -> NDArray[Any]:
    """Return the chunk as a structured array."""
    out = np.empty(len(chunk), dtype=record_dtype(layout, chunk.ids.dtype))
    out["id"] = chunk.ids
    for k, name in enumerate(layout.joint_columns):
        out[name] = chunk.q[:, k]
    out["status"] = chunk.status
    out["success"] = chunk.success
    out["position_error_m"] = chunk.position_error
    out["orientation_error_rad"] = chunk.orientation_error
    out["iterations"] = chunk.iterations
    out["restarts"] = chunk.restarts
    for name, column in zip(SCENE_COLUMNS, scene_columns(layout, chunk) or (), strict=False):
        out[name] = column
    return out


class NpyWriter(ResultWriter):
    """A structured array, row by row on the disk.

    The header is written for no rows first and again, at the same length, when their number
    is known. Text ids have no common width until all are known, so such rows are gathered.
    """

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        super().__init__(path, layout, force=force)
        self._count = 0
        self._gathered: list[NDArray[Any]] = []
        self._dtype = record_dtype(layout, np.dtype(np.int64))
        if not layout.text_ids:
            self._header(0)

    def _header(self, count: int) -> None:
        self._file.stream.write(header_bytes(self._dtype, count))

    def _write(self, chunk: ResultChunk) -> None:
        rows = records(self.layout, chunk)
        if self.layout.text_ids:
            self._gathered.append(rows)
        else:
            # The bytes as they lie, without a copy.
            self._file.stream.write(rows.view(np.uint8).data)
        self._count += len(chunk)

    def _finish(self) -> None:
        if self.layout.text_ids:
            rows = np.concatenate(self._gathered)
            self._file.stream.write(header_bytes(rows.dtype, len(rows)))
            self._file.stream.write(rows.view(np.uint8).data)
            return
        self._file.stream.seek(0)
        self._header(self._count)
        self._file.stream.seek(0, 2)


class NpzWriter(ResultWriter):
    """Plain arrays in a compressed archive."""

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        super().__init__(path, layout, force=force)
        self._gathered: list[ResultChunk] = []

    def _write(self, chunk: ResultChunk) -> None:
        self._gathered.append(chunk)

    def _finish(self) -> None:
        joined = ResultChunk.joined(self._gathered)
        columns = scene_columns(self.layout, joined) or ()
        scene: dict[str, Any] = dict(zip(SCENE_COLUMNS, columns, strict=False))
        np.savez_compressed(
            cast(Any, self._file.stream),
            id=joined.ids,
            q=joined.q,
            joint_columns=np.array(self.layout.joint_columns),
            status=joined.status.astype(np.int8),
            status_names=np.array(STATUS_NAMES),
            success=joined.success,
            position_error_m=joined.position_error,
            orientation_error_rad=joined.orientation_error,
            iterations=joined.iterations,
            restarts=joined.restarts,
            **scene,
            metadata=np.array(json.dumps(self.layout.metadata, sort_keys=True)),
        )
