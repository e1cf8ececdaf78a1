"""Results to files, chunk by chunk, and back; the kind of a file follows from its suffix."""

from __future__ import annotations

from pathlib import Path

from ._errors import ResultFileError
from ._records import ResultChunk, ResultLayout
from ._writer import ResultWriter

RESULT_SUFFIXES = (".csv", ".npy", ".npz", ".parquet")
"""Kinds of result files."""


def check_result_path(path: Path | str) -> Path:
    """Return the path if its suffix names a kind of result file.

    Raises
    ------
    ResultFileError
        For any other suffix.

    Examples
    --------
    >>> from agrik_fast.io import check_result_path
    >>> check_result_path("joints.parquet").suffix
    '.parquet'
    """
    path = Path(path)
    if path.suffix.lower() not in RESULT_SUFFIXES:
        kinds = ", ".join(RESULT_SUFFIXES)
        raise ResultFileError(path, f"unknown suffix '{path.suffix}', expected one of {kinds}")
    return path


def open_results(path: Path | str, layout: ResultLayout, *, force: bool = False) -> ResultWriter:
    """Start a result file; the kind follows from the suffix.

    Every kind holds, in this order: ``id``, the joint values by name and unit, ``status``,
    ``success``, ``position_error_m``, ``orientation_error_rad``, ``iterations``, ``restarts``;
    with a scene also ``clearance_m``, ``body`` and ``object``, which is nearest to what.

    * ``.csv``: a header line; status by name, success as true or false, floats that read
      back to the same bits.
    * ``.parquet``: the same columns; how they were made is in the schema's metadata.
    * ``.npy``: a structured array with these fields; status as the code of `Status`.
    * ``.npz``: arrays ``id``, ``q`` (n, dof), ``joint_columns``, ``status`` (codes),
      ``status_names``, ``success``, ``position_error_m``, ``orientation_error_rad``,
      ``iterations``, ``restarts``, ``metadata`` (JSON).

    Columns that are passed on from the targets (`ResultLayout.extras`) stand behind these; NPZ
    names them in ``extra_columns``.

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

    Examples
    --------
    >>> from agrik_fast.io import ResultChunk, ResultLayout, open_results, read_results
    >>> one = np.ones(1, dtype=int)
    >>> q, none = np.full((1, 1), 0.5), np.zeros(1)
    >>> chunk = ResultChunk(one, q, 0 * one, one > 0, none, none, one, one)
    >>> with open_results("results.csv", ResultLayout(("q1_rad",))) as results:
    ...     results.write(chunk)
    >>> read_results("results.csv")[1].q
    array([[0.5]])
    """
    path = check_result_path(path)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        from ._csv_results import CsvWriter

        return CsvWriter(path, layout, force=force)
    if suffix == ".parquet":
        from ._parquet_results import ParquetWriter

        return ParquetWriter(path, layout, force=force)
    from ._numpy_results import NpyWriter, NpzWriter

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

    Examples
    --------
    >>> from agrik_fast.io import read_results
    >>> from agrik_fast.jobs import SolveRequest, solve_file
    >>> from pathlib import Path
    >>> np.save("points.npy", [[0.4, 0.2, 0.3]])
    >>> paths = Path("points.npy"), Path("joints.csv")
    >>> _ = solve_file(SolveRequest("ur5", *paths))
    >>> layout, results = read_results("joints.csv")
    >>> layout.joint_columns[0], results.success.tolist()
    ('shoulder_pan_rad', [True])
    """
    from ._read_back import read

    return read(check_result_path(path))
