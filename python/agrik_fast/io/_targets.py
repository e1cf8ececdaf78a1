"""Targets as an iterator of chunks, whatever the file's kind.

Units: metres and radians after reading; a file may use others where its column or key names
say so. A row that is not finite passes through, so that it becomes status ``bad_input`` and
its neighbours are solved; a matrix or quaternion that is no rotation is made NaN for the same
end. Text in a number's place is an error that names row and column.
"""

from __future__ import annotations

import abc
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import TargetFileError, os_reason

TARGET_SUFFIXES = (".csv", ".npy", ".npz", ".parquet")
DEFAULT_CHUNK = 65_536


@dataclass(frozen=True)
class TargetChunk:
    """Consecutive targets of a file.

    Attributes
    ----------
    first : int
        Index of the chunk's first target in the file, from 0.
    targets : ndarray, shape (n, 3) in m, or (n, 4, 4)
        Tool points or tool poses in the robot's base frame.
    ids : ndarray, shape (n,)
        Row ids of the file, as int64 or text; row numbers from 1 where the file has none.
    """

    first: int
    targets: NDArray[np.float64]
    ids: NDArray[Any]

    def __len__(self) -> int:
        return len(self.targets)


class TargetReader(abc.ABC):
    """An open target file.

    Attributes
    ----------
    path : Path
    is_pose : bool
        True if every target has an orientation.
    count : int or None
        Number of targets, None where only reading on would tell (CSV).
    has_text_ids : bool
        True if the row ids are text.
    ignored : tuple of str
        Columns or keys that were found and not used.
    """

    path: Path
    is_pose: bool
    count: int | None
    has_text_ids: bool = False
    ignored: tuple[str, ...] = ()

    @abc.abstractmethod
    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time.

        Raises
        ------
        TargetFileError
            At the chunk that holds the fault, naming its row and column.
        """

    def read_all(self) -> TargetChunk:
        """All targets as one chunk."""
        parts = list(self.chunks())
        return TargetChunk(
            0,
            np.concatenate([part.targets for part in parts]),
            np.concatenate([part.ids for part in parts]),
        )


def read_targets(path: Path | str) -> TargetReader:
    """Open a target file; the kind follows from the suffix.

    * ``.csv``: a header line with ``x_m,y_m,z_m`` (or ``_cm``, ``_mm``); optionally one
      orientation: ``qx,qy,qz,qw`` (scalar last), ``zyz_alpha_rad,zyz_beta_rad,zyz_gamma_rad``
      (Rz Ry Rz) or ``roll_rad,pitch_rad,yaw_rad`` (URDF's fixed axes), angles also ``_deg``;
      optionally ``id``. Columns in any order; lines that start with ``#`` are skipped.
    * ``.parquet``: the same columns.
    * ``.npy``: (n, 3) points in m, or (n, 4, 4) poses in m.
    * ``.npz``: ``T`` (n, 4, 4) in m; or ``position_m`` (or ``position_cm``, ``position_mm``)
      (n, 3) with at most one of ``quaternion_xyzw`` (n, 4), ``zyz_rad``, ``zyz_deg``,
      ``rpy_rad``, ``rpy_deg`` (n, 3); optionally ``id`` (n,).

    Parameters
    ----------
    path : path-like

    Returns
    -------
    TargetReader

    Raises
    ------
    TargetFileError
        If the file is missing, unreadable, empty, of an unknown kind, or its columns do not
        describe targets.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in TARGET_SUFFIXES:
        kinds = ", ".join(TARGET_SUFFIXES)
        raise TargetFileError(path, f"unknown suffix '{path.suffix}', expected one of {kinds}")
    if path.is_dir():
        raise TargetFileError(path, "is a folder, expected a file")
    try:
        empty = path.stat().st_size == 0
    except OSError as error:
        raise TargetFileError(path, f"cannot be read: {os_reason(error)}") from error
    if empty:
        raise TargetFileError(path, "the file is empty")
    try:
        return _open(path, suffix)
    except OSError as error:
        raise TargetFileError(path, f"cannot be read: {os_reason(error)}") from error


def _open(path: Path, suffix: str) -> TargetReader:
    if suffix == ".csv":
        from .csv_targets import CsvReader

        return CsvReader(path)
    if suffix == ".parquet":
        from .parquet_targets import ParquetReader

        return ParquetReader(path)
    from .numpy_targets import NpyReader, open_npz

    return NpyReader(path) if suffix == ".npy" else open_npz(path)
