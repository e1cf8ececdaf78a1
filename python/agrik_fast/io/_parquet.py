"""Parquet files, opened without belief in what they claim."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from .._files import Refusal, reading
from .._npy import BOMB_BYTES, BOMB_RATIO

WHAT = "is not a Parquet file"
BUFFER_BYTES = 1 << 20


def import_pyarrow(refuse: Refusal) -> Any:
    """Return the pyarrow module, or a one-line error that says how to get it."""
    try:
        import pyarrow
        import pyarrow.compute
    except ImportError as error:
        reason = "Parquet files need pyarrow: pip install 'agrik-fast[parquet]'"
        raise refuse(reason) from error
    return pyarrow


def open_parquet(source: Path | BinaryIO, refuse: Refusal) -> Any:
    """Return the open file, a `pyarrow.parquet.ParquetFile`, of a path or a stream."""
    import_pyarrow(refuse)
    from pyarrow import parquet

    # Columns are read piece by piece; otherwise whole row groups would be held, and a row
    # group may be the whole file.
    make = partial(parquet.ParquetFile, source, buffer_size=BUFFER_BYTES, pre_buffer=False)
    with reading(refuse, WHAT):
        file = make()
        names = file.schema_arrow.names
        if "id" in names and _is_text(file.schema_arrow.field("id").type):
            file.close()
            # Of texts that repeat, a batch holds each once.
            file = make(read_dictionary=["id"])
        return file


def _is_text(kind: Any) -> bool:
    from pyarrow import types

    return bool(types.is_string(kind) or types.is_large_string(kind))


def parquet_writer(stream: Any, schema: Any) -> Any:
    """Return a `pyarrow.parquet.ParquetWriter` to a stream; of a table it makes a row group."""
    import pyarrow
    from pyarrow import parquet

    # A dictionary pays for the few status names, not for numbers that never repeat.
    words = [field.name for field in schema if pyarrow.types.is_dictionary(field.type)]
    return parquet.ParquetWriter(stream, schema, use_dictionary=words)


def check_parquet_sizes(file: Any, packed: int, refuse: Refusal) -> None:
    """Refuse a file of `packed` bytes that claims to unpack to far more than its size."""
    with reading(refuse, WHAT):
        # The sizes of single columns are not asked for: damaged ones end the process, as an
        # exception of the library that nobody catches.
        groups = (file.metadata.row_group(k) for k in range(file.metadata.num_row_groups))
        unpacked = sum(group.total_byte_size for group in groups)
    if unpacked > max(BOMB_BYTES, BOMB_RATIO * packed):
        raise refuse(
            f"{packed} bytes claim to unpack to {unpacked}, more than {BOMB_RATIO} times as many"
        )
