"""Errors of target and result files; each carries the file and a one-line reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import AgrikError


class DataFileError(AgrikError, ValueError):
    """A target or result file cannot be used.

    Attributes
    ----------
    path : Path
        The file.
    reason : str
        What is wrong, with row and column where they are known.
    """

    def __init__(self, path: Path | str, reason: str) -> None:
        self.path = Path(path)
        self.reason = reason
        super().__init__(f"{self.path}: {reason}")

    def __reduce__(self) -> tuple[Any, ...]:
        # The default rebuilds from the message alone, which is not what __init__ takes.
        return type(self), (self.path, self.reason)


class TargetFileError(DataFileError):
    """A target file is missing, malformed or of an unknown kind."""


class ResultFileError(DataFileError):
    """A result file exists already, cannot be written or is of an unknown kind."""
