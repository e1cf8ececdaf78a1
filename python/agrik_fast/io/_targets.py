"""Targets as an iterator of chunks, whatever the file's kind.

Units: metres and radians after reading; a file may use others where its column or key names
say so. A row that is not finite passes through, so that it becomes status ``bad_input`` and
its neighbours are solved; a matrix or quaternion that is no rotation is made NaN for the same
end. Text in a number's place is an error that names row and column.
"""

from __future__ import annotations

from pathlib import Path

from .._files import os_reason
from ._errors import TargetFileError
from ._reader import TargetReader

TARGET_SUFFIXES = (".csv", ".npy", ".npz", ".parquet")
"""Kinds of target files."""


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
      ``rpy_rad``, ``rpy_deg`` (n, 3); optionally ``id`` (n,). Entries are stored or deflated.

    Other columns, and keys of as many rows, are read as well, to be passed on to results (of
    Parquet and NPZ not those of lists and bytes).

    Refused are ids of more than 1000 letters, CSV rows of more than 1 MiB, and arrays and
    columns that unpack to more than 64 MiB and 500 times their size in the file.

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

    Examples
    --------
    >>> from agrik_fast.io import read_targets
    >>> np.save("points.npy", [[0.4, 0.2, 0.3], [0.3, 0.1, 0.4]])
    >>> reader = read_targets("points.npy")
    >>> reader.is_pose, reader.count
    (False, 2)
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in TARGET_SUFFIXES:
        kinds = ", ".join(TARGET_SUFFIXES)
        raise TargetFileError(path, f"unknown suffix '{path.suffix}', expected one of {kinds}")
    if path.is_dir():
        raise TargetFileError(path, "is a folder, expected a file")
    if path.exists() and not path.is_file():
        # It is opened more than once, which a pipe cannot be.
        raise TargetFileError(path, "is no regular file")
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
        from ._csv_targets import CsvReader

        return CsvReader(path)
    if suffix == ".parquet":
        from ._parquet_targets import ParquetReader

        return ParquetReader(path)
    from ._numpy_targets import NpyReader, NpzReader

    return NpyReader(path) if suffix == ".npy" else NpzReader(path)
