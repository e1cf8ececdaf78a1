"""Columns as tables of Arrow, of pandas and of notebooks; what can be shown as such a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ._checks import FloatArray
from .errors import MissingExtraError

__all__ = ["Postures", "Tabular", "arrow_table", "html_table", "joint_columns", "pandas_frame"]

# Rows of a table in a notebook.
_SHOWN = 10


def arrow_table(columns: Mapping[str, Any]) -> Any:
    """Return columns as a `pyarrow.Table`."""
    try:
        import pyarrow
    except ImportError:
        raise MissingExtraError("to_arrow", "parquet") from None
    columns = dict(columns)
    if "status" in columns:  # few names, many rows
        columns["status"] = pyarrow.array(columns["status"]).dictionary_encode()
    return pyarrow.table(columns)


def pandas_frame(columns: Mapping[str, Any]) -> Any:
    """Return columns as a `pandas.DataFrame`."""
    try:
        import pandas
    except ImportError:
        raise MissingExtraError("to_pandas", "pandas") from None
    return pandas.DataFrame(columns)


def html_table(
    columns: Mapping[str, Any], caption: str, heads: Mapping[str, str] | None = None
) -> str:
    """Return the first rows as a table for notebooks.

    Parameters
    ----------
    columns : mapping of str to sequence
    caption : str
    heads : mapping of str to str, optional
        What columns are called, where that is not their name.
    """
    from html import escape

    def cell(value: Any) -> str:
        return f"{value:.6g}" if isinstance(value, float) else escape(str(value))

    heads = {} if heads is None else heads
    count = len(next(iter(columns.values())))
    head = "".join(f"<th>{escape(heads.get(name, name))}</th>" for name in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{cell(values[row])}</td>" for values in columns.values()) + "</tr>"
        for row in range(min(count, _SHOWN))
    )
    more = f"<caption>{escape(caption)}</caption>"
    left = f"<tr><td>and {count - _SHOWN} more</td></tr>" if count > _SHOWN else ""
    return f"<table>{more}<thead><tr>{head}</tr></thead><tbody>{body}{left}</tbody></table>"


def joint_columns(name: str, values: FloatArray) -> dict[str, FloatArray]:
    """Return an array of shape (n, joints) as a column a joint: ``q_0``, ``q_1``, ..."""
    return {f"{name}_{k}": values[:, k] for k in range(values.shape[1])}


class Tabular:
    """Something that is a table of columns."""

    __slots__ = ()

    def _columns(self) -> dict[str, Any]:
        """Return the columns, all as long as each other."""
        raise NotImplementedError

    def to_arrow(self) -> Any:
        """Return a `pyarrow.Table`.

        Raises
        ------
        MissingExtraError
            pyarrow is not installed (extra ``parquet``).

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> arm.joint_path([arm.home, arm.home + 0.3]).to_arrow().num_rows
        2
        """
        return arrow_table(self._columns())

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame`.

        Raises
        ------
        MissingExtraError
            pandas is not installed (extra ``pandas``).

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> len(arm.joint_path([arm.home, arm.home + 0.3]).to_pandas())
        2
        """
        return pandas_frame(self._columns())

    def _repr_html_(self) -> str:
        return html_table(self._columns(), repr(self))


class Postures(Tabular):
    """Postures in a row: they are its rows, and what indexing and iteration give."""

    __slots__ = ()

    @property
    def _rows(self) -> FloatArray:
        """The joint values, shape (n, dof), rad or m."""
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, key: Any) -> FloatArray:
        return np.asarray(self._rows[key])

    def __iter__(self) -> Iterator[FloatArray]:
        return iter(self._rows)
