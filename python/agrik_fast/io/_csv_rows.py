"""Rows of a CSV file, each of bounded length, with the number of its line."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from .._files import Refusal, brief

ROW_LETTERS = 1 << 20
"""Longest row, the lines inside quotes included."""


class _Lines:
    """The lines of a stream, as long as a row does not grow too long."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.letters = 0
        """Handed out since the last row ended."""

    def __iter__(self) -> _Lines:
        return self

    def __next__(self) -> str:
        line = self._stream.readline(ROW_LETTERS + 1)
        self.letters += len(line)
        if self.letters > ROW_LETTERS:
            raise csv.Error(f"a row of more than {ROW_LETTERS} letters")
        if not line:
            raise StopIteration
        return line


class CsvRows:
    """The rows of a file that are neither blank nor comments.

    Yields
    ------
    line : int
        Number of the row's last line, from 1.
    fields : list of str
    letters : int
        Length of the row.
    """

    def __init__(self, path: Path, stream: TextIO, refuse: Refusal) -> None:
        self._path = path
        self._stream = stream
        self._refuse = refuse

    def __iter__(self) -> Iterator[tuple[int, list[str], int]]:
        lines = _Lines(self._stream)
        reader = csv.reader(lines)
        before = 0
        try:
            for fields in reader:
                before, letters, lines.letters = reader.line_num, lines.letters, 0
                if not fields or (len(fields) == 1 and not fields[0].strip()):
                    continue
                if fields[0].lstrip().startswith("#"):
                    continue
                yield before, fields, letters
        except UnicodeDecodeError:
            raise self._refuse(f"line {self._undecodable()}: is not UTF-8 text") from None
        except csv.Error as error:
            # Of a quote that never ends, the line that it is on.
            raise self._refuse(f"line {before + 1}: {brief(error)}") from error

    def _undecodable(self) -> int:
        line, text = 1, b""
        with self._path.open("rb") as stream:
            while text := stream.readline(ROW_LETTERS):
                try:
                    text.decode("utf-8")
                except UnicodeDecodeError:
                    return line
                line += 1
        return line


def open_text(path: Path) -> TextIO:
    """Open a CSV file."""
    # utf-8-sig: spreadsheet programs put a byte-order mark before the first column's name.
    return path.open(encoding="utf-8-sig", newline="")
