"""Targets from files and results to files, in chunks: CSV, NPZ, NPY and Parquet."""

from .errors import DataFileError, ResultFileError, TargetFileError
from .results import ResultChunk, ResultLayout, ResultWriter, open_results, read_results
from .targets import TargetChunk, TargetReader, read_targets

__all__ = [
    "DataFileError",
    "ResultChunk",
    "ResultFileError",
    "ResultLayout",
    "ResultWriter",
    "TargetChunk",
    "TargetFileError",
    "TargetReader",
    "open_results",
    "read_results",
    "read_targets",
]
