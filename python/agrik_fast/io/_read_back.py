"""Result files read back, whole, from every kind."""

from __future__ import annotations

import csv
import json
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import ResultFileError, os_reason
from ._records import (
    FIXED_COLUMNS,
    METADATA_PREFIX,
    STATUS_NAMES,
    ResultChunk,
    ResultLayout,
)

Columns = dict[str, NDArray[Any]]


def read(path: Path) -> tuple[ResultLayout, ResultChunk]:
    """Layout and results of a file; see `agrik_fast.io.read_results`."""
    readers = {".csv": _csv, ".npy": _npy, ".npz": _npz, ".parquet": _parquet}
    try:
        return readers[path.suffix.lower()](path)
    except OSError as error:
        raise ResultFileError(path, f"cannot be read: {os_reason(error)}") from error
    except (ValueError, KeyError, EOFError, StopIteration, zipfile.BadZipFile) as error:
        if isinstance(error, ResultFileError):
            raise
        raise ResultFileError(path, "is not a result file") from error


def _assemble(
    names: Sequence[str], columns: Columns, metadata: dict[str, str]
) -> tuple[ResultLayout, ResultChunk]:
    joints = tuple(name for name in names if name != "id" and name not in FIXED_COLUMNS)
    chunk = ResultChunk(
        ids=columns["id"],
        q=np.column_stack([columns[name] for name in joints]).astype(np.float64),
        status=columns["status"],
        success=columns["success"],
        position_error=columns["position_error_m"],
        orientation_error=columns["orientation_error_rad"],
        iterations=columns["iterations"],
        restarts=columns["restarts"],
    )
    return ResultLayout(joints, columns["id"].dtype.kind == "U", metadata), chunk


def _csv(path: Path) -> tuple[ResultLayout, ResultChunk]:
    with path.open(encoding="utf-8", newline="") as stream:
        lines = csv.reader(stream)
        names = next(lines)
        texts = list(zip(*lines, strict=True)) or [() for _ in names]
    columns: Columns = {}
    for name, text in zip(names, texts, strict=True):
        if name == "id":
            columns[name] = np.array(text, dtype=np.str_)
        elif name == "status":
            columns[name] = np.array([STATUS_NAMES.index(word) for word in text], dtype=np.int8)
        elif name == "success":
            columns[name] = np.array(text, dtype=np.str_) == "true"
        elif name in ("iterations", "restarts"):
            columns[name] = np.array(text).astype(np.int32)
        else:
            columns[name] = np.array(text).astype(np.float64)
    return _assemble(names, columns, {})


def _npy(path: Path) -> tuple[ResultLayout, ResultChunk]:
    rows = np.load(path, allow_pickle=False)
    names = rows.dtype.names or ()
    return _assemble(names, {name: rows[name] for name in names}, {})


def _npz(path: Path) -> tuple[ResultLayout, ResultChunk]:
    with np.load(path, allow_pickle=False) as archive:
        columns = {name: archive[name] for name in ("id", *FIXED_COLUMNS)}
        joints = [str(name) for name in archive["joint_columns"]]
        q = archive["q"]
        metadata = json.loads(str(archive["metadata"]))
    columns.update({name: q[:, k] for k, name in enumerate(joints)})
    return _assemble(["id", *joints, *FIXED_COLUMNS], columns, metadata)


def _parquet(path: Path) -> tuple[ResultLayout, ResultChunk]:
    from pyarrow import parquet

    table = parquet.read_table(path)
    columns: Columns = {}
    for name in table.column_names:
        if name == "status":
            words = table.column(name).to_pylist()
            columns[name] = np.array([STATUS_NAMES.index(word) for word in words], dtype=np.int8)
        elif name == "id":
            columns[name] = np.array(table.column(name).to_pylist())
        else:
            columns[name] = table.column(name).to_numpy()
    metadata = {
        key.decode().removeprefix(METADATA_PREFIX): value.decode()
        for key, value in (table.schema.metadata or {}).items()
        if key.decode().startswith(METADATA_PREFIX)
    }
    return _assemble(table.column_names, columns, metadata)
