"""Result files read back, whole, from every kind."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal, listing, reading, shown
from .._npy import Archive, read_array
from ._csv_rows import CsvRows
from ._errors import ResultFileError
from ._ids import check_text, check_width, checked
from ._parquet import WHAT, check_parquet_sizes, open_parquet
from ._records import (
    FIXED_COLUMNS,
    METADATA_PREFIX,
    STATUS_NAMES,
    ResultChunk,
    ResultLayout,
)

Columns = dict[str, NDArray[Any]]
_NO_RESULT = "is not a result file"
# Lines of a CSV file that are texts at a time.
_BLOCK = 65_536
_TYPES: Mapping[str, Any] = {
    "status": np.int8,
    "success": np.bool_,
    "iterations": np.int32,
    "restarts": np.int32,
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
    return tuple(name for name in names if name != "id" and name not in FIXED_COLUMNS)


def _assemble(
    names: Sequence[str], columns: Columns, metadata: dict[str, str], refuse: Refusal
) -> tuple[ResultLayout, ResultChunk]:
    joints = _joints(names, refuse)
    count = len(columns["id"])
    for name in names:
        column = columns[name]
        if column.shape != (count,):
            raise refuse(f"'{name}' of shape {column.shape}, expected ({count},)")
        wanted = "b" if name == "success" else "fiu"
        if name != "id" and column.dtype.kind not in wanted:
            expected = "true or false" if name == "success" else "numbers"
            raise refuse(f"'{name}' holds {shown(column.dtype)}, expected {expected}")
    check_width(columns["id"].dtype, "'id'", refuse)
    for name, most in (("status", len(STATUS_NAMES) - 1), ("success", 1)):
        codes = np.ascontiguousarray(columns[name])
        codes = codes.view(np.uint8) if name == "success" else codes
        if not (wrong := (codes < 0) | (codes > most)).any():
            continue
        row = int(np.argmax(wrong))
        raise refuse(f"row {row + 1}, '{name}': expected a code from 0 to {most}, got {codes[row]}")
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
    )
    return ResultLayout(joints, columns["id"].dtype.kind == "U", metadata), chunk


Read = tuple[Sequence[str], Columns, dict[str, str]]


def _csv(path: Path, refuse: Refusal) -> Read:
    with reading(refuse, _NO_RESULT):
        stream = path.open(encoding="utf-8", newline="")
    with stream:
        rows = iter(CsvRows(path, stream, refuse))
        header = next(rows, None)
        if header is None:
            raise refuse(f"{_NO_RESULT}: the file is empty")
        names = header[1]
        _joints(names, refuse)
        blocks = list(_csv_blocks(names, rows, refuse))
    empty = [{name: _column(name, []) for name in names}]
    joined = {name: np.concatenate([block[name] for block in blocks or empty]) for name in names}
    return names, joined, {}


def _csv_blocks(
    names: Sequence[str], rows: Iterator[tuple[int, list[str], int]], refuse: Refusal
) -> Iterator[Columns]:
    block: list[list[str]] = []
    id_at = names.index("id")
    for line, fields, _ in rows:
        if len(fields) != len(names):
            raise refuse(f"line {line}: {len(fields)} fields, expected {len(names)}")
        check_text(fields[id_at], f"line {line}, 'id'", refuse)
        block.append(fields)
        if len(block) == _BLOCK:
            yield _csv_columns(names, block, line, refuse)
            block = []
    if block:
        yield _csv_columns(names, block, line, refuse)


def _csv_columns(
    names: Sequence[str], block: list[list[str]], line: int, refuse: Refusal
) -> Columns:
    columns: Columns = {}
    for name, texts in zip(names, zip(*block, strict=True), strict=True):
        try:
            columns[name] = _column(name, texts)
        except (ValueError, OverflowError) as error:
            first = line - len(block) + 1
            raise refuse(f"lines {first} to {line}, '{name}': {shown(str(error))}") from None
    return columns


def _column(name: str, texts: Sequence[str]) -> NDArray[Any]:
    if name == "id":
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
        columns = {name: archive.array(name) for name in ("id", *FIXED_COLUMNS)}
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
    return ["id", *names, *FIXED_COLUMNS], columns, metadata


def _parquet(path: Path, refuse: Refusal) -> Read:
    with open_parquet(path, refuse) as file, reading(refuse, WHAT):
        names = list(file.schema_arrow.names)
        _joints(names, refuse)
        check_parquet_sizes(file, path.stat().st_size, refuse)
        table = file.read()
        columns: Columns = {}
        for name in names:
            column = table.column(name)
            if name == "status":
                columns[name] = _column(name, column.to_pylist())
            elif name == "id":
                columns[name] = _parquet_ids(column, refuse)
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
