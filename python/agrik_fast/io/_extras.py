"""Columns that mean nothing to a solver and are passed on from targets to results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal
from ._ids import ID_LETTERS
from ._parquet import import_pyarrow

Extras: TypeAlias = Mapping[str, NDArray[Any]]
"""Columns by name, one entry a row: int64, float64, bool, or objects that are texts."""
Kind: TypeAlias = Literal["int", "float", "bool", "text"]

_TYPES: dict[Kind, Any] = {"int": np.int64, "float": np.float64, "bool": np.bool_, "text": object}


class Extra(NamedTuple):
    """A column that is passed on."""

    name: str
    kind: Kind


def kind_of(dtype: np.dtype[Any]) -> Kind | None:
    """Return what a NumPy type is passed on as; None for what is not."""
    if dtype.kind == "b":
        return "bool"
    if dtype.kind == "U":
        return "text"
    if dtype.kind in "iu":
        # Not all of uint64 is int64.
        return None if dtype == np.uint64 else "int"
    return "float" if dtype.kind == "f" and dtype.itemsize <= 8 else None


def column_of(kind: Kind, values: Any) -> NDArray[Any]:
    """Return values of a kind as a column."""
    array = np.asarray(values)
    if kind == "text" and array.dtype != object:
        array = np.array(array.tolist(), dtype=object)
    return array.astype(_TYPES[kind], copy=False)


def part_of(extras: Extras, rows: Any) -> dict[str, NDArray[Any]]:
    """Return some rows of the columns."""
    return {name: column[rows] for name, column in extras.items()}


def joined(parts: Sequence[Extras]) -> dict[str, NDArray[Any]]:
    """Return the columns of parts that follow one another."""
    if not parts:
        return {}
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def for_numpy(extra: Extra, column: NDArray[Any], refuse: Refusal) -> NDArray[Any]:
    """Return a column as NumPy files hold it: texts as wide as the longest.

    Raises
    ------
    AgrikError
        By `refuse`: a text that is too long for that.
    """
    if extra.kind != "text":
        return column
    longest = max(map(len, column.tolist()), default=0)
    if longest > ID_LETTERS:
        raise refuse(
            f"column '{extra.name}' holds text of {longest} letters, expected at most "
            f"{ID_LETTERS}: .csv and .parquet hold any"
        )
    return column.astype(np.str_) if len(column) else np.empty(0, dtype="<U1")


class ArrowExtras:
    """The columns of an Arrow schema that can be passed on.

    Parameters
    ----------
    schema : pyarrow.Schema
    names : tuple of str
        Those that are wanted.
    has_nulls : callable
        Says of a column whether it has, or may have, nulls.
    refuse : callable
        Makes the error where pyarrow is missing.
    """

    def __init__(
        self, schema: Any, names: Sequence[str], has_nulls: Callable[[str], bool], refuse: Refusal
    ) -> None:
        self._pyarrow = import_pyarrow(refuse)
        kinds = ((name, self._kind(schema.field(name).type, has_nulls(name))) for name in names)
        self.columns = tuple(Extra(name, kind) for name, kind in kinds if kind is not None)

    def _kind(self, kind: Any, nulls: bool) -> Kind | None:
        types = self._pyarrow.types
        if types.is_dictionary(kind):
            kind = kind.value_type
        if types.is_floating(kind):
            return "float"
        if types.is_integer(kind) and not types.is_uint64(kind):
            # NaN stands for a null, which whole numbers have not.
            return "float" if nulls else "int"
        if types.is_boolean(kind):
            return "text" if nulls else "bool"
        if types.is_nested(kind) or types.is_binary(kind) or types.is_large_binary(kind):
            return None
        return "text"

    def of(self, batch: Any) -> dict[str, NDArray[Any]]:
        """Return the columns of a record batch."""
        found = {}
        for name, kind in self.columns:
            column = batch.column(batch.schema.get_field_index(name))
            if self._pyarrow.types.is_dictionary(column.type):
                column = column.dictionary_decode()
            if kind == "text":
                texts = column.cast(self._pyarrow.string()).fill_null("")
                found[name] = column_of("text", np.array(texts.to_pylist(), dtype=object))
            elif kind == "float":
                double = column.cast(self._pyarrow.float64(), safe=False)
                found[name] = double.to_numpy(zero_copy_only=False)
            else:
                found[name] = column_of(kind, column.to_numpy(zero_copy_only=False))
        return found


def arrow_type(pyarrow: Any, kind: Kind) -> Any:
    """Return the Arrow type of a kind."""
    makers = {
        "int": pyarrow.int64,
        "float": pyarrow.float64,
        "bool": pyarrow.bool_,
        "text": pyarrow.string,
    }
    return makers[kind]()
