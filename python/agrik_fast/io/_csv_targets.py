"""Targets from CSV, read as a stream."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._files import shown
from ._columns import ColumnError, match_columns
from ._csv_rows import CsvRows, open_text
from ._errors import TargetFileError
from ._ids import check_text
from ._reader import CHUNK_BYTES, DEFAULT_CHUNK, TargetReader
from ._records import TargetChunk

# Bytes that a number takes while it is a text, and its place in a list.
_FIELD_BYTES = 64


class CsvReader(TargetReader):
    """A CSV file of targets with a header line; see `read_targets` for the columns."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.count = None
        self._refuse = partial(TargetFileError, path)
        with open_text(path) as stream:
            rows = iter(CsvRows(path, stream, self._refuse))
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

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        with open_text(self.path) as stream:
            rows = iter(CsvRows(self.path, stream, self._refuse))
            next(rows)
            block = _Block(0)
            for line, fields, _ in rows:
                self._add(block, line, fields)
                if len(block.lines) >= size or block.size() >= CHUNK_BYTES:
                    yield self._chunk(block)
                    block = _Block(block.first + len(block.lines))
            if block.lines:
                yield self._chunk(block)

    def _add(self, block: _Block, line: int, fields: list[str]) -> None:
        row = block.first + len(block.lines) + 1
        if len(fields) != self._width:
            raise self._refuse(
                f"row {row} (line {line}): {len(fields)} fields, "
                f"expected {self._width} as in the header"
            )
        block.lines.append(line)
        block.numbers.append([fields[i] for i in self._picked])
        block.letters += sum(len(fields[i]) for i in self._picked)
        if self._id_at is not None:
            place = f"row {row} (line {line}), column 'id'"
            row_id = check_text(fields[self._id_at].strip(), place, self._refuse)
            block.ids.append(row_id)
            block.widest = max(block.widest, len(row_id))

    def _chunk(self, block: _Block) -> TargetChunk:
        first, count = block.first, len(block.lines)
        ids: NDArray[np.int64] | NDArray[np.str_]
        if self._id_at is None:
            ids = np.arange(first + 1, first + count + 1, dtype=np.int64)
        else:
            ids = np.array(block.ids, dtype=np.str_)
        return TargetChunk(first, self._columns.targets(self._numbers(block)), ids)

    def _numbers(self, block: _Block) -> NDArray[np.float64]:
        try:
            return np.array([[float(x) for x in row] for row in block.numbers], dtype=np.float64)
        except ValueError:
            # Only the failing chunk is looked at again, to name the field.
            row, line, column, text = self._bad_field(block)
            raise self._refuse(
                f"row {row} (line {line}), column '{column}': expected a number, got {shown(text)}"
            ) from None

    def _bad_field(self, block: _Block) -> tuple[int, int, str, str]:
        for k, row in enumerate(block.numbers):
            for name, text in zip(self._columns.numeric, row, strict=True):
                try:
                    float(text)
                except ValueError:
                    return block.first + k + 1, block.lines[k], name, text.strip()
        raise AssertionError("a block that failed to parse has a bad field")


class _Block:
    """The fields in use of some rows."""

    def __init__(self, first: int) -> None:
        self.first = first
        self.lines: list[int] = []
        self.numbers: list[list[str]] = []
        self.ids: list[str] = []
        self.letters = 0
        self.widest = 0

    def size(self) -> int:
        """Return about how many bytes the rows take, ids as wide as the widest."""
        numbers = _FIELD_BYTES * sum(map(len, self.numbers[:1])) + 4 * self.widest
        return len(self.lines) * numbers + self.letters
