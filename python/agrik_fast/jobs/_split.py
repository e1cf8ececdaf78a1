"""A file of targets of any kind, cut into Parquet files that partitions are made of."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .._atomic import AtomicFile
from .._checks import whole_number
from .._files import os_reason
from ..io import (
    TargetChunk,
    TargetReader,
    arrow_type,
    import_pyarrow,
    parquet_writer,
    read_targets,
)
from ..rotations import quat_of
from ._job import JobError
from ._partition import BATCH_ROWS
from ._sources import FOLDER_FILES, PARTITION_ROWS


def split_file(
    targets: Path | str,
    folder: Path | str,
    rows: int = PARTITION_ROWS,
    *,
    force: bool = False,
    report: Callable[[int], None] | None = None,
) -> list[Path]:
    """Cut a target file of any kind into Parquet files.

    Written are ``id`` (the file's own, or row numbers from 1), ``x_m``, ``y_m``, ``z_m`` and, of
    poses, ``qx``, ``qy``, ``qz``, ``qw``. Row for row the targets are those of the file but for
    the last digits of orientations that it has as matrices or angles. Other columns follow behind
    as they are.

    Parameters
    ----------
    targets : path-like
        CSV, NPY, NPZ or Parquet, see `agrik_fast.io.read_targets`.
    folder : path-like
        Where the files ``part-000000.parquet``, ... go.
    rows : int
        Rows of each.
    force : bool
        Replace files.
    report : callable, optional
        Hears how many rows are done.

    Returns
    -------
    list of Path

    Raises
    ------
    AgrikError
        The file cannot be read, the folder cannot be written or holds files of these names.

    Examples
    --------
    >>> from agrik_fast.jobs import split_file
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> [path.name for path in split_file("points.npy", "parts", rows=4)]
    ['part-000000.parquet', 'part-000001.parquet', 'part-000002.parquet']
    """
    whole_number("rows", rows, 1)
    reader = read_targets(targets)
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise JobError(str(folder), f"cannot be written: {os_reason(error)}") from error
    files: list[Path] = []
    file: _SplitFile | None = None
    done = 0
    try:
        for chunk in reader.chunks(min(rows, BATCH_ROWS)):
            at = 0
            while at < len(chunk):
                if file is None:
                    name = f"part-{len(files):06d}.parquet"
                    if len(files) >= FOLDER_FILES:
                        name = f"p{len(files) // FOLDER_FILES:04d}/{name}"
                    files.append(folder / name)
                    file = _SplitFile(files[-1], reader, force)
                count = min(rows - file.rows, len(chunk) - at)
                file.write(chunk, slice(at, at + count))
                at += count
                if file.rows == rows:
                    file.close()
                    file = None
            done += len(chunk)
            if report is not None:
                report(done)
        if file is not None:
            file.close()
            file = None
    finally:
        if file is not None:
            file.discard()
    return files


class _SplitFile:
    def __init__(self, path: Path, reader: TargetReader, force: bool) -> None:
        self._refuse = partial(JobError, str(path))
        pyarrow = import_pyarrow(self._refuse)
        self._pyarrow: Any = pyarrow
        self._text_ids = reader.has_text_ids
        numbers = ["x_m", "y_m", "z_m", *(["qx", "qy", "qz", "qw"] if reader.is_pose else [])]
        kind = pyarrow.string() if self._text_ids else pyarrow.int64()
        own = [("id", kind), *((name, pyarrow.float64()) for name in numbers)]
        names = {name for name, _ in own}
        self._extras = [extra for extra in reader.extras if extra.name not in names]
        self._schema = pyarrow.schema(
            own + [(extra.name, arrow_type(pyarrow, extra.kind)) for extra in self._extras]
        )
        path.parent.mkdir(exist_ok=True)
        self._file = AtomicFile(path, self._refuse, force=force)
        self._writer = parquet_writer(self._file.stream, self._schema)
        self.rows = 0

    def write(self, chunk: TargetChunk, part: slice) -> None:
        targets = chunk.targets[part]
        values = targets
        if targets.ndim == 3:
            good = np.isfinite(targets).all(axis=(1, 2))
            turn = np.full((len(targets), 4), np.nan)
            turn[good] = quat_of(targets[good])
            values = np.hstack([targets[:, :3, 3], turn])
        ids = chunk.ids[part]
        columns = [ids.tolist() if self._text_ids else ids, *values.T.copy()]
        columns += [chunk.extras[extra.name][part] for extra in self._extras]
        kinds = zip(columns, self._schema.types, strict=True)
        arrays = [self._pyarrow.array(column, type=kind) for column, kind in kinds]
        try:
            self._writer.write_table(self._pyarrow.Table.from_arrays(arrays, schema=self._schema))
        except OSError as error:
            raise self._refuse(f"cannot be written: {os_reason(error)}") from error
        self.rows += len(targets)

    def close(self) -> None:
        try:
            self._writer.close()
        except OSError as error:
            self.discard()
            raise self._refuse(f"cannot be written: {os_reason(error)}") from error
        self._file.commit()

    def discard(self) -> None:
        self._file.discard()
