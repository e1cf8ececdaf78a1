"""Results to files, chunk by chunk; the file appears when it is complete."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .atomic import AtomicFile
from .errors import ResultFileError, os_reason

RESULT_SUFFIXES = (".csv", ".npy", ".npz", ".parquet")
STATUS_NAMES = ("converged", "out_of_reach", "not_found", "bad_input")


@dataclass(frozen=True)
class ResultLayout:
    """What every row of a result file holds besides the fixed columns.

    Attributes
    ----------
    joint_columns : tuple of str
        One per joint, the name with its unit: ``theta_rad``, ``s10_m``.
    text_ids : bool
        True if the row ids are text.
    metadata : dict of str
        How the results were made (robot, task, solver, seed, ...); kept in NPZ and Parquet.
    """

    joint_columns: tuple[str, ...]
    text_ids: bool = False
    metadata: dict[str, str] = field(default_factory=dict)

    @staticmethod
    def joint_names(names: Sequence[str], types: Sequence[str]) -> tuple[str, ...]:
        """Return column names of joints: ``_m`` for prismatic ones, ``_rad`` for the others."""
        return tuple(
            f"{name}_{'m' if kind == 'prismatic' else 'rad'}"
            for name, kind in zip(names, types, strict=True)
        )


@dataclass(frozen=True)
class ResultChunk:
    """Consecutive results.

    Attributes
    ----------
    ids : ndarray, shape (n,)
        Row ids as read, int64 or text.
    q : ndarray, shape (n, dof), rad or m
        Joint values; of an unsolved row the best found.
    status : ndarray, shape (n,)
        Codes of `agrik_fast.Status`.
    success : ndarray of bool, shape (n,)
    position_error : ndarray, shape (n,), m
    orientation_error : ndarray, shape (n,), rad
    iterations, restarts : ndarray, shape (n,)
    """

    ids: NDArray[Any]
    q: NDArray[np.float64]
    status: NDArray[np.integer[Any]]
    success: NDArray[np.bool_]
    position_error: NDArray[np.float64]
    orientation_error: NDArray[np.float64]
    iterations: NDArray[np.integer[Any]]
    restarts: NDArray[np.integer[Any]]

    def __len__(self) -> int:
        return len(self.status)


class ResultWriter(abc.ABC):
    """Writes chunks in order; `close` puts the file in place, leaving on an error does not.

    Use it as a context manager: a ``with`` block left by an exception, Ctrl-C included,
    removes what was written and leaves the destination as it was.
    """

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        self.path = path
        self.layout = layout
        self._file = AtomicFile(path, force=force)

    def write(self, chunk: ResultChunk) -> None:
        """Append a chunk.

        Raises
        ------
        ResultFileError
            If the disk refuses.
        """
        try:
            self._write(chunk)
        except OSError as error:
            raise ResultFileError(self.path, f"cannot be written: {os_reason(error)}") from error

    def close(self) -> None:
        """Finish the file and move it to its name."""
        try:
            self._finish()
        except OSError as error:
            self.discard()
            raise ResultFileError(self.path, f"cannot be written: {os_reason(error)}") from error
        self._file.commit()

    def discard(self) -> None:
        """Give up: nothing appears at the destination."""
        self._file.discard()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self.discard()
            return
        try:
            self.close()
        except BaseException:
            self.discard()
            raise

    @abc.abstractmethod
    def _write(self, chunk: ResultChunk) -> None: ...

    @abc.abstractmethod
    def _finish(self) -> None: ...


def check_result_path(path: Path | str) -> Path:
    """Return the path if its suffix names a kind of result file.

    Raises
    ------
    ResultFileError
        For any other suffix.
    """
    path = Path(path)
    if path.suffix.lower() not in RESULT_SUFFIXES:
        kinds = ", ".join(RESULT_SUFFIXES)
        raise ResultFileError(path, f"unknown suffix '{path.suffix}', expected one of {kinds}")
    return path


def open_results(path: Path | str, layout: ResultLayout, *, force: bool = False) -> ResultWriter:
    """Start a result file; the kind follows from the suffix.

    Every kind holds, in this order: ``id``, the joint values by name and unit, ``status``,
    ``success``, ``position_error_m``, ``orientation_error_rad``, ``iterations``, ``restarts``.

    * ``.csv``: a header line; status by name, success as true or false, floats that read
      back to the same bits.
    * ``.parquet``: the same columns; how they were made is in the schema's metadata.
    * ``.npy``: a structured array with these fields; status as the code of `Status`.
    * ``.npz``: arrays ``id``, ``q`` (n, dof), ``joint_columns``, ``status`` (codes),
      ``status_names``, ``success``, ``position_error_m``, ``orientation_error_rad``,
      ``iterations``, ``restarts``, ``metadata`` (JSON).

    Parameters
    ----------
    path : path-like
    layout : ResultLayout
    force : bool
        Replace an existing file.

    Raises
    ------
    ResultFileError
        For an unknown suffix, an existing file without `force`, a folder that cannot be
        written.
    """
    path = check_result_path(path)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        from .csv_results import CsvWriter

        return CsvWriter(path, layout, force=force)
    if suffix == ".parquet":
        from .parquet_results import ParquetWriter

        return ParquetWriter(path, layout, force=force)
    from .numpy_results import NpyWriter, NpzWriter

    kind = NpyWriter if suffix == ".npy" else NpzWriter
    return kind(path, layout, force=force)


def read_results(path: Path | str) -> tuple[ResultLayout, ResultChunk]:
    """Read a result file back, whole.

    Parameters
    ----------
    path : path-like
        A file that `open_results` made.

    Returns
    -------
    layout : ResultLayout
    results : ResultChunk

    Raises
    ------
    ResultFileError
        If the file is missing or no result file.
    """
    from . import read_back

    return read_back.read(check_result_path(path))
