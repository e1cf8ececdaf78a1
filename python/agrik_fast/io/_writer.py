"""What every writer of results does: the file appears when it is complete."""

from __future__ import annotations

import abc
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

from .._atomic import AtomicFile
from .._files import os_reason
from ._errors import ResultFileError
from ._records import ResultChunk, ResultLayout


class ResultWriter(abc.ABC):
    """Writes chunks in order; `close` puts the file in place, leaving on an error does not.

    Use it as a context manager: a ``with`` block left by an exception, Ctrl-C included,
    removes what was written and leaves the destination as it was.

    Examples
    --------
    >>> from agrik_fast.io import ResultLayout, open_results
    >>> with open_results("empty.csv", ResultLayout(("q1_rad",))) as results:
    ...     print(type(results).__name__)
    CsvWriter
    """

    def __init__(self, path: Path, layout: ResultLayout, *, force: bool) -> None:
        self.path = path
        self.layout = layout
        self._file = AtomicFile(path, partial(ResultFileError, path), force=force)

    def write(self, chunk: ResultChunk) -> None:
        """Append a chunk.

        Raises
        ------
        ResultFileError
            If the disk refuses.

        Examples
        --------
        >>> from agrik_fast.io import ResultChunk, ResultLayout, open_results, read_results
        >>> one = np.ones(1, dtype=int)
        >>> q, none = np.full((1, 1), 0.5), np.zeros(1)
        >>> chunk = ResultChunk(one, q, 0 * one, one > 0, none, none, one, one)
        >>> with open_results("two.csv", ResultLayout(("q1_rad",))) as results:
        ...     results.write(chunk)
        ...     results.write(chunk)
        >>> len(read_results("two.csv")[1].ids)
        2
        """
        try:
            self._write(chunk)
        except OSError as error:
            raise ResultFileError(self.path, f"cannot be written: {os_reason(error)}") from error

    def close(self) -> None:
        """Finish the file and move it to its name.

        Examples
        --------
        >>> from agrik_fast.io import ResultLayout, open_results
        >>> from pathlib import Path
        >>> results = open_results("closed.csv", ResultLayout(("q1_rad",)))
        >>> results.close()
        >>> Path("closed.csv").exists()
        True
        """
        try:
            self._finish()
        except OSError as error:
            self.discard()
            raise ResultFileError(self.path, f"cannot be written: {os_reason(error)}") from error
        self._file.commit()

    def discard(self) -> None:
        """Give up: nothing appears at the destination.

        Examples
        --------
        >>> from agrik_fast.io import ResultLayout, open_results
        >>> from pathlib import Path
        >>> results = open_results("discarded.csv", ResultLayout(("q1_rad",)))
        >>> results.discard()
        >>> Path("discarded.csv").exists()
        False
        """
        self._file.discard()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self.discard()
            return
        try:
            self.close()
        except BaseException:
            self.discard()
            raise

    @abc.abstractmethod
    def _write(self, chunk: ResultChunk) -> None: ...

    @abc.abstractmethod
    def _finish(self) -> None: ...
