"""Targets from files and results to files, in chunks: CSV, NPZ, NPY and Parquet."""

from ._arrow import ResultTable, TargetTable, check_number_columns, number_columns
from ._errors import DataFileError, ResultFileError, TargetFileError
from ._extras import Extra, Extras, arrow_type, part_of
from ._parquet import check_parquet_sizes, import_pyarrow, open_parquet, parquet_writer
from ._reader import TargetReader
from ._records import ResultChunk, ResultLayout, SceneColumns, TargetChunk
from ._results import check_result_path, open_results, read_results
from ._targets import read_targets
from ._writer import ResultWriter

__all__ = [
    "DataFileError",
    "Extra",
    "Extras",
    "ResultChunk",
    "ResultFileError",
    "ResultLayout",
    "ResultTable",
    "ResultWriter",
    "SceneColumns",
    "TargetChunk",
    "TargetFileError",
    "TargetReader",
    "TargetTable",
    "arrow_type",
    "check_number_columns",
    "check_parquet_sizes",
    "check_result_path",
    "import_pyarrow",
    "number_columns",
    "open_parquet",
    "open_results",
    "parquet_writer",
    "part_of",
    "read_results",
    "read_targets",
]
