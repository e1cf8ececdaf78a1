"""Row ids: integers or text of a length that rows can bear."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal
from ._row_faults import RowFaults, refuse_rows

ID_LETTERS = 1000
"""Longest id. All ids of a chunk are as wide as its longest."""
_LARGEST = 2**63 - 1
_LAST = 0x10FFFF
_SURROGATES = (0xD800, 0xDFFF)


def check_width(dtype: np.dtype[Any], place: str, refuse: Refusal) -> None:
    """Refuse what is neither integers nor text of at most `ID_LETTERS` letters."""
    if dtype.kind not in "iuU":
        raise refuse(f"{place} holds {dtype}, expected integers or text")
    if dtype.kind == "U" and dtype.itemsize > 4 * ID_LETTERS:
        letters = dtype.itemsize // 4
        raise refuse(f"{place} holds text of {letters} letters, expected at most {ID_LETTERS}")


def check_text(text: str, place: str, refuse: Refusal) -> str:
    """Return an id that is text, if it is not too long."""
    if len(text) > ID_LETTERS:
        raise refuse(too_long(place, len(text)))
    return text


def check_texts(texts: Sequence[str], row: Callable[[int], str], refuse: Refusal) -> None:
    """Refuse ids that are too long; `row` names the row of the one at a place."""
    faults = RowFaults()
    for at, text in enumerate(texts):
        if len(text) > ID_LETTERS:
            faults.add(too_long(f"{row(at)}, column 'id'", len(text)))
    if faults:
        raise refuse(str(faults))


def too_long(place: str, letters: int) -> str:
    """Return what is wrong with an id of so many letters."""
    return f"{place}: {letters} letters, expected at most {ID_LETTERS}"


def checked(ids: NDArray[Any], first: int, refuse: Refusal) -> NDArray[Any]:
    """Return ids as int64 or text; `first` is the index of the first one in the file.

    Raises
    ------
    AgrikError
        By `refuse`: an integer beyond int64, or numbers in the place of letters.
    """
    if ids.dtype.kind in "iu":
        if ids.dtype.kind == "u":
            _refuse_rows(ids > _LARGEST, first, "is beyond 2**63 - 1", refuse)
        return ids.astype(np.int64)
    if ids.dtype.itemsize:
        codes = np.ascontiguousarray(ids).view(np.uint32).reshape(len(ids), -1)
        low, high = _SURROGATES
        wrong = (codes > _LAST) | ((codes >= low) & (codes <= high))
        _refuse_rows(wrong.any(axis=1), first, "is no text", refuse)
    return ids


def _refuse_rows(wrong: Any, first: int, message: str, refuse: Refusal) -> None:
    rows = first + 1 + np.flatnonzero(wrong)
    refuse_rows([(rows, lambda row: f"row {row}, 'id': {message}")], refuse)
