"""Targets from files and results to files, in chunks: CSV, NPZ, NPY and Parquet."""

from ._errors import DataFileError, ResultFileError, TargetFileError
from ._reader import TargetReader
from ._records import ResultChunk, ResultLayout, SceneColumns, TargetChunk
from ._results import check_result_path, open_results, read_results
from ._targets import read_targets
from ._writer import ResultWriter

__all__ = [
    "DataFileError",
    "ResultChunk",
    "ResultFileError",
    "ResultLayout",
    "ResultWriter",
    "SceneColumns",
    "TargetChunk",
    "TargetFileError",
    "TargetReader",
    "check_result_path",
    "open_results",
    "read_results",
    "read_targets",
]
