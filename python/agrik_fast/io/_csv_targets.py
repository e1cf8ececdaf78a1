"""Targets from CSV, read as a stream."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from ._columns import ColumnError, match_columns
from ._errors import TargetFileError
from ._reader import DEFAULT_CHUNK, TargetReader
from ._records import TargetChunk


class CsvReader(TargetReader):
    """A CSV file of targets with a header line; see `read_targets` for the columns."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.count = None
        with self._open() as stream:
            rows = self._rows(stream)
            header = next(rows, None)
            if header is None:
                raise TargetFileError(path, "the file is empty")
            names = [name.strip() for name in header[1]]
            if next(rows, None) is None:
                raise TargetFileError(path, "no targets after the header")
        try:
            self._columns = match_columns(names)
        except ColumnError as error:
            raise TargetFileError(path, str(error)) from error
        self._width = len(names)
        self._picked = [names.index(name) for name in self._columns.numeric]
        self._id_at = None if self._columns.row_id is None else names.index("id")
        self.is_pose = self._columns.orientation is not None
        self.has_text_ids = self._id_at is not None
        self.ignored = self._columns.ignored

    def _open(self) -> TextIO:
        # utf-8-sig: spreadsheet programs put a byte-order mark before the first column's name.
        return self.path.open(encoding="utf-8-sig", newline="")

    def _rows(self, stream: TextIO) -> Iterator[tuple[int, list[str]]]:
        """Line number and fields of every row, the header first; blanks and comments skipped."""
        reader = csv.reader(stream)
        try:
            for fields in reader:
                if not fields or (len(fields) == 1 and not fields[0].strip()):
                    continue
                if fields[0].lstrip().startswith("#"):
                    continue
                yield reader.line_num, fields
        except UnicodeDecodeError as error:
            raise TargetFileError(self.path, "is not UTF-8 text") from error
        except csv.Error as error:
            raise TargetFileError(self.path, f"line {reader.line_num}: {error}") from error

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        with self._open() as stream:
            rows = self._rows(stream)
            next(rows)
            first = 0
            while block := list(islice(rows, size)):
                yield self._chunk(first, block)
                first += len(block)

    def _chunk(self, first: int, block: list[tuple[int, list[str]]]) -> TargetChunk:
        for k, (line, fields) in enumerate(block):
            if len(fields) != self._width:
                raise TargetFileError(
                    self.path,
                    f"row {first + k + 1} (line {line}): {len(fields)} fields, "
                    f"expected {self._width} as in the header",
                )
        targets = self._columns.targets(self._numbers(first, block))
        if self._id_at is None:
            ids: NDArray[np.int64] | NDArray[np.str_] = np.arange(
                first + 1, first + len(block) + 1, dtype=np.int64
            )
        else:
            at = self._id_at
            ids = np.array([fields[at].strip() for _, fields in block], dtype=np.str_)
        return TargetChunk(first, targets, ids)

    def _numbers(self, first: int, block: list[tuple[int, list[str]]]) -> NDArray[np.float64]:
        picked = self._picked
        try:
            return np.array(
                [[float(fields[i]) for i in picked] for _, fields in block], dtype=np.float64
            )
        except ValueError:
            # Only the failing chunk is looked at again, to name the field.
            row, line, column, text = self._bad_field(block)
            raise TargetFileError(
                self.path,
                f"row {first + row + 1} (line {line}), column '{column}': "
                f"expected a number, got '{text}'",
            ) from None

    def _bad_field(self, block: list[tuple[int, list[str]]]) -> tuple[int, int, str, str]:
        for k, (line, fields) in enumerate(block):
            for name, i in zip(self._columns.numeric, self._picked, strict=True):
                try:
                    float(fields[i])
                except ValueError:
                    return k, line, name, fields[i].strip()
        raise AssertionError("a block that failed to parse has a bad field")
