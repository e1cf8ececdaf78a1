"""Tables of pixels that a person made: numbers in named columns, and a name for every row."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from .._checks import FloatArray
from ._errors import VisionFileError

__all__ = ["read_numbers"]


def read_numbers(
    file: Path, columns: tuple[str, ...], label: str, *, labelled: bool = False
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the numbers of a CSV file's columns, and its labels; none without such a column.

    Parameters
    ----------
    file : path
        Its name; lines that begin with # are passed over.
    columns : tuple of str
        Those that hold numbers.
    label : str
        The column of labels.
    labelled : bool, default False
        Whether every row needs a label.

    Raises
    ------
    VisionFileError
        It cannot be read; names row and column.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise VisionFileError(str(file), error.strerror or str(error)) from None
    except UnicodeDecodeError:
        raise VisionFileError(str(file), "no text in UTF-8") from None
    reader = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    try:
        header = [each.strip() for each in reader.fieldnames or ()]
        missing = [name for name in (*columns, *[label][: int(labelled)]) if name not in header]
        if missing:
            raise VisionFileError(str(file), f"no column {', '.join(missing)}")
        reader.fieldnames = header
        rows, labels = [], []
        for number, row in enumerate(reader, 1):
            rows.append([_number(file, number, name, row[name]) for name in columns])
            if label in header:
                labels.append((row[label] or "").strip())
            if labelled and not labels[-1]:
                raise VisionFileError(str(file), f"row {number}, column {label}: empty")
    except csv.Error as error:
        raise VisionFileError(str(file), f"line {reader.line_num}: {error}") from None
    return np.array(rows, dtype=float).reshape(-1, len(columns)), tuple(labels)


def _number(file: Path, row: int, column: str, given: str | None) -> float:
    try:
        value = float(given or "")
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise VisionFileError(str(file), f"row {row}, column {column}: {given!r} is no number")
    return value
