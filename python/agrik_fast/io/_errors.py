"""Errors of target and result files; each carries the file and the reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import AgrikError


class DataFileError(AgrikError, ValueError):
    """A target or result file cannot be used.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    reason : str
        What is wrong, with row and column where they are known; of several rows a line each.

    Examples
    --------
    >>> from agrik_fast.io import DataFileError, read_targets
    >>> try:
    ...     read_targets("nowhere.csv")
    ... except DataFileError as error:
    ...     print(error.path.name)
    nowhere.csv
    """

    def __init__(self, path: Path | str, reason: str) -> None:
        self.path = Path(path)
        self.reason = reason
        super().__init__(f"{self.path}: {reason}")

    def __reduce__(self) -> tuple[Any, ...]:
        # The default rebuilds from the message alone, which is not what __init__ takes.
        return type(self), (self.path, self.reason)


class TargetFileError(DataFileError):
    """A target file is missing, malformed or of an unknown kind.

    Examples
    --------
    >>> from agrik_fast.io import TargetFileError, read_targets
    >>> np.save("wrong.npy", np.zeros((5, 2)))
    >>> try:
    ...     read_targets("wrong.npy")
    ... except TargetFileError as error:
    ...     print(error.path.name)
    wrong.npy
    """


class ResultFileError(DataFileError):
    """A result file exists already, cannot be written or is of an unknown kind.

    Examples
    --------
    >>> from agrik_fast.io import ResultFileError, check_result_path
    >>> try:
    ...     check_result_path("joints.xls")
    ... except ResultFileError as error:
    ...     print(error.path.name)
    joints.xls
    """
