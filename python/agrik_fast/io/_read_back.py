"""Result files read back, whole, from every kind."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal, listing, reading, shown
from .._npy import Archive, read_array
from ._csv_rows import CsvRows
from ._errors import ResultFileError
from ._extras import Extra, column_of, kind_of
from ._ids import check_text, check_texts, check_width, checked
from ._parquet import WHAT, check_parquet_sizes, open_parquet
from ._reader import CHUNK_BYTES
from ._records import (
    FIXED_COLUMNS,
    METADATA_PREFIX,
    SCENE_COLUMNS,
    STATUS_NAMES,
    ResultChunk,
    ResultLayout,
    SceneColumns,
)
from ._row_faults import RowFaults

Columns = dict[str, NDArray[Any]]
_NO_RESULT = "is not a result file"
# Lines of a CSV file that are read at a time.
_BLOCK = 65_536
_TYPES: Mapping[str, Any] = {
    "status": np.int8,
    "success": np.bool_,
    "iterations": np.int32,
    "restarts": np.int32,
}


# Columns of texts, and the texts that may stand in them.
_WORDS: Mapping[str, Sequence[str]] = {
    "id": (),
    "status": STATUS_NAMES,
    "success": ("false", "true"),
}


def read(path: Path) -> tuple[ResultLayout, ResultChunk]:
    """Layout and results of a file; see `agrik_fast.io.read_results`."""
    readers = {".csv": _csv, ".npy": _npy, ".npz": _npz, ".parquet": _parquet}
    refuse = partial(ResultFileError, path)
    names, columns, metadata = readers[path.suffix.lower()](path, refuse)
    with reading(refuse, _NO_RESULT):
        return _assemble(names, columns, metadata, refuse)


def _joints(names: Sequence[str], refuse: Refusal) -> tuple[str, ...]:
    """Return the joints' columns of a header, which names every other column as well."""
    missing = [name for name in ("id", *FIXED_COLUMNS) if name not in names]
    if missing:
        raise refuse(f"{_NO_RESULT}: missing '{missing[0]}'; found {listing(names) or 'nothing'}")
    if len(set(names)) < len(names):
        raise refuse(f"{_NO_RESULT}: a column appears twice")
    # Joints stand before the first fixed column; what was passed on stands behind the last.
    return tuple(name for name in names[: names.index(FIXED_COLUMNS[0])] if name != "id")


def _passed_on(names: Sequence[str]) -> list[str]:
    """Return the columns of a header that were passed on from the targets."""
    known = (*FIXED_COLUMNS, *_scene_names(names))
    return [name for name in names[names.index(FIXED_COLUMNS[0]) :] if name not in known]


def _scene_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return the columns on a scene, if a header has all of them."""
    return SCENE_COLUMNS if set(SCENE_COLUMNS) <= set(names) else ()


def _assemble(
    names: Sequence[str], columns: Columns, metadata: dict[str, str], refuse: Refusal
) -> tuple[ResultLayout, ResultChunk]:
    joints = _joints(names, refuse)
    count = len(columns["id"])
    extras = {}
    for name in _passed_on(names):
        column = columns[name]
        kind = "text" if column.dtype == object else kind_of(column.dtype)
        if column.shape != (count,) or kind is None:
            raise refuse(f"'{name}' of shape {column.shape} holds {shown(column.dtype)}")
        extras[Extra(name, kind)] = column_of(kind, column)
    for name in names:
        if name in {extra.name for extra in extras}:
            continue
        column = columns[name]
        if column.shape != (count,):
            raise refuse(f"'{name}' of shape {column.shape}, expected ({count},)")
        texts = _scene_names(names)[1:]
        wanted = "b" if name == "success" else "U" if name in texts else "fiu"
        if name != "id" and column.dtype.kind not in wanted:
            expected = {"b": "true or false", "U": "text"}.get(wanted, "numbers")
            raise refuse(f"'{name}' holds {shown(column.dtype)}, expected {expected}")
    check_width(columns["id"].dtype, "'id'", refuse)
    for name, most in (("status", len(STATUS_NAMES) - 1), ("success", 1)):
        codes = np.ascontiguousarray(columns[name])
        codes = codes.view(np.uint8) if name == "success" else codes
        if not (wrong := (codes < 0) | (codes > most)).any():
            continue
        row = int(np.argmax(wrong))
        raise refuse(f"row {row + 1}, '{name}': expected a code from 0 to {most}, got {codes[row]}")
    scene, letters = None, 0
    if _scene_names(names):
        for name in SCENE_COLUMNS[1:]:
            check_width(columns[name].dtype, f"'{name}'", refuse)
        clearance, body, thing = (columns[name] for name in SCENE_COLUMNS)
        scene = SceneColumns(clearance.astype(np.float64), body, thing)
        letters = max(1, *(column.dtype.itemsize // 4 for column in (body, thing)))
    q = [columns[name].astype(np.float64) for name in joints]
    chunk = ResultChunk(
        ids=checked(columns["id"], 0, refuse),
        q=np.column_stack(q) if q else np.empty((count, 0)),
        status=columns["status"],
        success=columns["success"],
        position_error=columns["position_error_m"],
        orientation_error=columns["orientation_error_rad"],
        iterations=columns["iterations"],
        restarts=columns["restarts"],
        scene=scene,
        extras={extra.name: column for extra, column in extras.items()},
    )
    text_ids = columns["id"].dtype.kind == "U"
    return ResultLayout(joints, text_ids, metadata, letters, tuple(extras)), chunk


Read = tuple[Sequence[str], Columns, dict[str, str]]


def _csv(path: Path, refuse: Refusal) -> Read:
    rows = CsvRows(path, refuse)
    names = list(rows.header)
    if not names:
        raise refuse(f"{_NO_RESULT}: the file is empty")
    _joints(names, refuse)
    passed_on = _passed_on(names)
    worded = [*_WORDS, *_scene_names(names)[1:], *passed_on]
    words = [names.index(name) for name in worded]
    numeric = [at for at in range(len(names)) if at not in words]
    blocks = []
    while True:
        numbers, texts, lines = rows.block(_BLOCK, CHUNK_BYTES, numeric, words)
        columns: Columns = {names[at]: numbers[:, k] for k, at in enumerate(numeric)}
        for name, column in zip(worded, texts, strict=True):
            columns[name] = (
                np.array(column, dtype=object)
                if name in passed_on
                else _words(name, column, lines, refuse)
            )
        blocks.append(columns)
        if not lines:
            break
    joined = {name: np.concatenate([block[name] for block in blocks]) for name in names}
    for name, kind in _TYPES.items():
        joined[name] = joined[name].astype(kind)
    return names, joined, {}


def _words(name: str, texts: list[str], lines: list[int], refuse: Refusal) -> NDArray[Any]:
    if name == "id":
        check_texts(texts, lambda at: f"line {lines[at]}", refuse)
    elif name in _WORDS:
        faults = RowFaults()
        for text, line in zip(texts, lines, strict=True):
            if text not in _WORDS[name]:
                faults.add(f"line {line}, '{name}': expected one of {', '.join(_WORDS[name])}")
        if faults:
            raise refuse(str(faults))
    return _column(name, texts)


def _column(name: str, texts: Sequence[str]) -> NDArray[Any]:
    if name == "id" or name in SCENE_COLUMNS[1:]:
        return np.array(texts, dtype=np.str_)
    if name == "status":
        return np.array([STATUS_NAMES.index(word) for word in texts], dtype=np.int8)
    if name == "success":
        return np.array([("false", "true").index(word) for word in texts], dtype=np.bool_)
    return np.array(texts).astype(_TYPES.get(name, np.float64))


def _npy(path: Path, refuse: Refusal) -> Read:
    rows = read_array(path, refuse, _NO_RESULT)
    names = rows.dtype.names or ()
    _joints(names, refuse)
    return names, {name: rows[name] for name in names}, {}


def _npz(path: Path, refuse: Refusal) -> Read:
    with Archive(path, refuse) as archive:
        scene = _scene_names(archive.names)
        columns = {name: archive.array(name) for name in ("id", *FIXED_COLUMNS, *scene)}
        more: list[str] = []
        if "extra_columns" in archive.names:
            more = [str(name) for name in archive.array("extra_columns").tolist()]
            columns |= {name: archive.array(name) for name in more}
        joints = archive.array("joint_columns")
        q = archive.array("q")
        text = archive.array("metadata")
    if joints.dtype.kind != "U" or q.ndim != 2 or joints.shape != q.shape[1:]:
        raise refuse(f"'q' of shape {q.shape} for 'joint_columns' of shape {joints.shape}")
    with reading(refuse, "'metadata' is damaged"):
        metadata = json.loads(str(text))
        if not isinstance(metadata, dict):
            raise ValueError("expected a table")
    with reading(refuse, "'joint_columns' is damaged"):
        names = [str(name) for name in joints.tolist()]
    columns.update({name: q[:, k] for k, name in enumerate(names)})
    return ["id", *names, *FIXED_COLUMNS, *scene, *more], columns, metadata


def _parquet(path: Path, refuse: Refusal) -> Read:
    with open_parquet(path, refuse) as file, reading(refuse, WHAT):
        names = list(file.schema_arrow.names)
        _joints(names, refuse)
        check_parquet_sizes(file, path.stat().st_size, refuse)
        table = file.read()
        columns: Columns = {}
        for name in names:
            column = table.column(name)
            if name == "status" or name in _scene_names(names)[1:]:
                columns[name] = _column(name, column.to_pylist())
            elif name == "id":
                columns[name] = _parquet_ids(column, refuse)
            elif name in _passed_on(names) and column.type == "string":
                columns[name] = np.array(column.to_pylist(), dtype=object)
            else:
                columns[name] = column.to_numpy()
        metadata = {
            key.decode().removeprefix(METADATA_PREFIX): value.decode()
            for key, value in (table.schema.metadata or {}).items()
            if key.decode().startswith(METADATA_PREFIX)
        }
    return names, columns, metadata


def _parquet_ids(column: Any, refuse: Refusal) -> NDArray[Any]:
    import pyarrow

    if pyarrow.types.is_dictionary(column.type):
        for chunk in column.chunks:
            for text in chunk.dictionary.to_pylist():
                if isinstance(text, str):
                    check_text(text, "'id'", refuse)
    return np.array(column.to_pylist())
