"""Results to NPY (as a stream) and NPZ (gathered, written at the end)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal
from .._npy import header_bytes
from ._errors import ResultFileError
from ._extras import for_numpy
from ._records import (
    SCENE_COLUMNS,
    STATUS_NAMES,
    ResultChunk,
    ResultLayout,
    scene_columns,
)
from ._writer import ResultWriter

_NUMBERS = {"int": np.int64, "float": np.float64, "bool": np.bool_}


def record_dtype(
    layout: ResultLayout, id_dtype: np.dtype[Any], texts: Mapping[str, np.dtype[Any]]
) -> np.dtype[Any]:
    """Return the structured type of one result row; `texts` are types of columns passed on."""
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
            *(
                (name, texts[name] if kind == "text" else _NUMBERS[kind])
                for name, kind in layout.extras
            ),
        ]
    )


def records(layout: ResultLayout, chunk: ResultChunk, refuse: Refusal) -> NDArray[Any]:
    """Return the chunk as a structured array."""
    extras = {each.name: for_numpy(each, chunk.extras[each.name], refuse) for each in layout.extras}
    types = {name: column.dtype for name, column in extras.items()}
    out = np.empty(len(chunk), dtype=record_dtype(layout, chunk.ids.dtype, types))
    for name, column in extras.items():
        out[name] = column
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
    is known. Texts have no common width until all are known, so rows with text ids, or with
    texts that are passed on, are gathered.
    """

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        super().__init__(path, layout, force=force)
        self._count = 0
        self._gathered: list[ResultChunk] = []
        self._refuse = partial(ResultFileError, path)
        self._gathers = layout.text_ids or any(extra.kind == "text" for extra in layout.extras)
        if not self._gathers:
            self._dtype = record_dtype(layout, np.dtype(np.int64), {})
            self._header(0)

    def _header(self, count: int) -> None:
        self._file.stream.write(header_bytes(self._dtype, count))

    def _write(self, chunk: ResultChunk) -> None:
        if self._gathers:
            self._gathered.append(chunk)
        else:
            # The bytes as they lie, without a copy.
            rows = records(self.layout, chunk, self._refuse)
            self._file.stream.write(rows.view(np.uint8).data)
        self._count += len(chunk)

    def _finish(self) -> None:
        if self._gathers:
            rows = records(self.layout, ResultChunk.joined(self._gathered), self._refuse)
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
        refuse = partial(ResultFileError, self.path)
        for extra in self.layout.extras:
            scene[extra.name] = for_numpy(extra, joined.extras[extra.name], refuse)
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
            extra_columns=np.array([extra.name for extra in self.layout.extras], dtype=np.str_),
            metadata=np.array(json.dumps(self.layout.metadata, sort_keys=True)),
        )
