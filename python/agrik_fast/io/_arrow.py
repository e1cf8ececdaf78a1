"""Targets and results as Arrow tables, whatever file or store they are in."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal, listing, reading
from ._columns import ColumnError, match_columns
from ._extras import ArrowExtras, arrow_type
from ._ids import ID_LETTERS, checked, too_long
from ._parquet import import_pyarrow
from ._reader import CHUNK_BYTES, DEFAULT_CHUNK
from ._records import (
    METADATA_PREFIX,
    SCENE_COLUMNS,
    STATUS_NAMES,
    ResultChunk,
    ResultLayout,
    TargetChunk,
    scene_columns,
)
from ._row_faults import FaultyRows, refuse_rows

# Whole numbers up to here are float64 numbers too.
_EXACT = 2**53


class TargetTable:
    """Which columns of an Arrow schema hold targets, and how a batch of them reads.

    Parameters
    ----------
    schema : pyarrow.Schema
    refuse : callable
        Makes the error of the table's place from what is wrong.

    Attributes
    ----------
    names : tuple of str
        Columns in use.
    is_pose, has_text_ids : bool
        As of `TargetReader`.
    ignored : tuple of str
    extras : tuple of str
        Those of the ignored columns that can be passed on to results.

    Raises
    ------
    AgrikError
        By `refuse`: the columns do not describe targets.

    Examples
    --------
    >>> from agrik_fast.io import TargetTable
    >>> import pyarrow
    >>> batch = pyarrow.RecordBatch.from_pydict({"x_m": [0.4], "y_m": [0.2], "z_m": [0.3]})
    >>> TargetTable(batch.schema, lambda reason: ValueError(reason)).is_pose
    False
    """

    def __init__(self, schema: Any, refuse: Refusal) -> None:
        self._refuse = refuse
        self._pyarrow = import_pyarrow(refuse)
        kinds = dict(zip(schema.names, schema.types, strict=True))
        try:
            self._columns = match_columns(schema.names)
        except ColumnError as error:
            raise refuse(str(error)) from error
        self.numeric = self._columns.numeric
        check_number_columns(schema, self.numeric, refuse)
        self.is_pose = self._columns.orientation is not None
        self.ignored = self._columns.ignored
        found = ArrowExtras(schema, self.ignored, lambda name: False, refuse).columns
        self.extras = tuple(extra.name for extra in found)
        self.has_ids = self._columns.row_id is not None
        self.names = (*self.numeric, *(["id"] if self.has_ids else []))
        self.has_text_ids = False
        if self.has_ids:
            types, kind = self._pyarrow.types, kinds["id"]
            if types.is_dictionary(kind):
                kind = kind.value_type
            self.has_text_ids = bool(types.is_string(kind) or types.is_large_string(kind))
            if not (self.has_text_ids or types.is_integer(kind)):
                raise refuse(f"column 'id' holds {kind}, expected integers or text")

    def chunk(self, first: int, batch: Any) -> TargetChunk:
        """Return a record batch as targets; `first` is the index of its first row.

        Examples
        --------
        >>> from agrik_fast.io import TargetTable
        >>> import pyarrow
        >>> batch = pyarrow.RecordBatch.from_pydict({"x_m": [0.4], "y_m": [0.2], "z_m": [0.3]})
        >>> table = TargetTable(batch.schema, lambda reason: ValueError(reason))
        >>> table.chunk(0, batch).targets
        array([[0.4, 0.2, 0.3]])
        """
        refuse_rows(self._inexact_and_empty(first, batch), self._refuse)
        values = number_columns(first, batch, self.numeric, self._refuse)
        return TargetChunk(first, self._columns.targets(values), self._ids(first, batch))

    def row_faults(self, first: int, batch: Any) -> list[FaultyRows]:
        """Return what is wrong with the rows of a batch: numbers, ids that are empty or long.

        Examples
        --------
        >>> from agrik_fast.io import TargetTable
        >>> import pyarrow
        >>> columns = {"x_m": [0, 2**60], "y_m": [0.2, 0.1], "z_m": [0.3, 0.3]}
        >>> batch = pyarrow.RecordBatch.from_pydict(columns)
        >>> table = TargetTable(batch.schema, lambda reason: ValueError(reason))
        >>> [rows.tolist() for rows, word in table.row_faults(0, batch)]
        [[2]]
        """
        return [*self._inexact_and_empty(first, batch), *self._long(first, batch)]

    def _inexact_and_empty(self, first: int, batch: Any) -> list[FaultyRows]:
        found = _inexact(first, batch, self.numeric, self._pyarrow)
        if self.has_ids:
            column = batch.column(batch.schema.get_field_index("id"))
            if column.null_count:
                rows = np.flatnonzero(column.is_null().to_numpy(zero_copy_only=False))
                found.append((first + 1 + rows, lambda row: f"row {row}, column 'id': is empty"))
        return found

    def _long(self, first: int, batch: Any) -> list[FaultyRows]:
        if not self.has_text_ids:
            return []
        letters = self._letters(batch)

        def word(row: int) -> str:
            return too_long(f"row {row}, column 'id'", int(letters[row - first - 1]))

        return [(first + 1 + np.flatnonzero(letters > ID_LETTERS), word)]

    def _letters(self, batch: Any) -> NDArray[Any]:
        """Return how many letters the id of each row has."""
        column = batch.column(batch.schema.get_field_index("id"))
        # The rows of a dictionary may be many and long; they are not unpacked.
        lengths = self._pyarrow.compute.utf8_length(getattr(column, "dictionary", column))
        if hasattr(column, "dictionary"):
            lengths = lengths.take(column.indices)
        return np.asarray(lengths.fill_null(0).to_numpy(zero_copy_only=False))

    def row_bytes(self, first: int, batch: Any) -> int:
        """Return about how many bytes a row takes; long ids are refused."""
        if not self.has_text_ids:
            return 0
        letters = 0
        with reading(self._refuse, f"is damaged after row {first}"):
            column = batch.column(batch.schema.get_field_index("id"))
            # A text is looked at before a chunk's ids are made as wide as the longest.
            texts = getattr(column, "dictionary", column)
            longest = self._pyarrow.compute.max(self._pyarrow.compute.binary_length(texts))
            if (longest.as_py() or 0) > CHUNK_BYTES // DEFAULT_CHUNK:
                refuse_rows(self._long(first, batch), self._refuse)
                letters = int(np.max(self._letters(batch), initial=0))
        return 4 * letters

    def _ids(self, first: int, batch: Any) -> NDArray[Any]:
        if not self.has_ids:
            return np.arange(first + 1, first + batch.num_rows + 1, dtype=np.int64)
        column = batch.column(batch.schema.get_field_index("id"))
        if self.has_text_ids:
            return np.array(column.to_pylist(), dtype=np.str_)
        if self._pyarrow.types.is_dictionary(column.type):
            column = column.dictionary_decode()
        whole = np.asarray(column.to_numpy(zero_copy_only=False))
        return checked(whole, first, self._refuse)


def check_number_columns(schema: Any, names: tuple[str, ...], refuse: Refusal) -> None:
    """Refuse a schema that lacks one of these columns, or has it with other than numbers.

    Parameters
    ----------
    schema : pyarrow.Schema
    names : tuple of str
    refuse : callable
        Makes the error from what is wrong.
    """
    types = import_pyarrow(refuse).types
    for name in names:
        if name not in schema.names:
            found = listing(schema.names) or "nothing"
            raise refuse(f"missing column '{name}'; found {found}")
        kind = schema.field(name).type
        if not (types.is_floating(kind) or types.is_integer(kind)):
            raise refuse(f"column '{name}' holds {kind}, expected numbers")


def number_columns(
    first: int, batch: Any, names: tuple[str, ...], refuse: Refusal
) -> NDArray[np.float64]:
    """Return columns of a record batch as float64, shape (n, len(names)); nulls are NaN.

    Parameters
    ----------
    first : int
        Index of the batch's first row, for messages.
    batch : pyarrow.RecordBatch
    names : tuple of str
    refuse : callable
        Makes the error from what is wrong.
    """
    pyarrow = import_pyarrow(refuse)
    double = pyarrow.float64()
    refuse_rows(_inexact(first, batch, names, pyarrow), refuse)
    values = np.empty((batch.num_rows, len(names)))
    for k, name in enumerate(names):
        column = batch.column(batch.schema.get_field_index(name))
        values[:, k] = column.cast(double).to_numpy(zero_copy_only=False)
    return values


def _inexact(first: int, batch: Any, names: tuple[str, ...], pyarrow: Any) -> list[FaultyRows]:
    """Return the rows whose whole numbers float64 does not hold."""
    found: list[FaultyRows] = []
    for name in names:
        column = batch.column(batch.schema.get_field_index(name))
        if not pyarrow.types.is_integer(column.type):
            continue
        whole = column.fill_null(0).to_numpy(zero_copy_only=False)
        beyond = (whole > _EXACT) | (whole < -_EXACT if whole.dtype.kind == "i" else False)
        if beyond.any():

            def word(row: int, name: str = name, whole: Any = whole) -> str:
                return (
                    f"row {row}, column '{name}': expected a number that float64 "
                    f"holds, at most 2**53, got {whole[row - first - 1]}"
                )

            found.append((first + 1 + np.flatnonzero(beyond), word))
    return found


class ResultTable:
    """Results as Arrow tables: the CSV's columns with types, the status as a dictionary.

    Parameters
    ----------
    layout : ResultLayout
    refuse : callable
        Makes the error where pyarrow is missing.

    Attributes
    ----------
    schema : pyarrow.Schema
        With the layout's metadata, its keys behind a prefix.

    Examples
    --------
    >>> from agrik_fast.io import ResultLayout, ResultTable
    >>> table = ResultTable(ResultLayout(("q1_rad",)), lambda reason: ValueError(reason))
    >>> table.schema.names[:3]
    ['id', 'q1_rad', 'status']
    """

    def __init__(self, layout: ResultLayout, refuse: Refusal) -> None:
        pyarrow = import_pyarrow(refuse)
        self._pyarrow: Any = pyarrow
        self._layout = layout
        metadata = {METADATA_PREFIX + key: value for key, value in layout.metadata.items()}
        # Few names, many rows.
        words = pyarrow.dictionary(pyarrow.int32(), pyarrow.string())
        scene = (pyarrow.float64(), words, words)
        self.schema: Any = pyarrow.schema(
            [
                ("id", pyarrow.string() if layout.text_ids else pyarrow.int64()),
                *((name, pyarrow.float64()) for name in layout.joint_columns),
                ("status", pyarrow.dictionary(pyarrow.int8(), pyarrow.string())),
                ("success", pyarrow.bool_()),
                ("position_error_m", pyarrow.float64()),
                ("orientation_error_rad", pyarrow.float64()),
                ("iterations", pyarrow.int32()),
                ("restarts", pyarrow.int32()),
                *(zip(SCENE_COLUMNS, scene, strict=True) if layout.name_letters else ()),
                *((name, arrow_type(pyarrow, kind)) for name, kind in layout.extras),
            ],
            metadata=metadata,
        )

    def table(self, chunk: ResultChunk) -> Any:
        """Return a chunk as a `pyarrow.Table`.

        Examples
        --------
        >>> from agrik_fast.io import ResultChunk, ResultLayout, ResultTable
        >>> one = np.ones(1, dtype=int)
        >>> q, none = np.full((1, 1), 0.5), np.zeros(1)
        >>> chunk = ResultChunk(one, q, 0 * one, one > 0, none, none, one, one)
        >>> table = ResultTable(ResultLayout(("q1_rad",)), lambda reason: ValueError(reason))
        >>> table.table(chunk).num_rows
        1
        """
        array = self._pyarrow.array
        status = self._pyarrow.DictionaryArray.from_arrays(
            array(chunk.status.astype(np.int8)), array(list(STATUS_NAMES))
        )
        columns = [
            array(chunk.ids.tolist() if self._layout.text_ids else chunk.ids),
            *(array(np.ascontiguousarray(chunk.q[:, k])) for k in range(chunk.q.shape[1])),
            status,
            array(chunk.success),
            array(chunk.position_error),
            array(chunk.orientation_error),
            array(chunk.iterations.astype(np.int32)),
            array(chunk.restarts.astype(np.int32)),
        ]
        scene = scene_columns(self._layout, chunk)
        if scene is not None:
            clearance, *names = scene
            columns += [array(clearance), *(array(n.tolist()).dictionary_encode() for n in names)]
        columns += [
            array(chunk.extras[name], type=arrow_type(self._pyarrow, kind))
            for name, kind in self._layout.extras
        ]
        return self._pyarrow.Table.from_arrays(columns, schema=self.schema)
