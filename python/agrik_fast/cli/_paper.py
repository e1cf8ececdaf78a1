"""``agrik-fast paper``: the tables and figures of a paper, written to a folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .. import papers
from ..errors import ArgumentError, UnknownNameError

ALL = "all"
"""What stands for every paper on the command line."""


def check(name: str, directory: Path, *, force: bool, experiments: str | None = None) -> None:
    """Refuse what cannot be done, before minutes of work.

    Raises
    ------
    UnknownNameError
        No such paper.
    ArgumentError
        The folder holds files and `force` is False, or `experiments` for all papers.
    """
    if name not in (*papers.PAPERS, ALL):
        raise UnknownNameError("paper", name, (*papers.PAPERS, ALL))
    if directory.exists() and not directory.is_dir():
        raise ArgumentError("output", f"the file {directory}", "a folder")
    if directory.is_dir() and any(directory.iterdir()) and not force:
        raise ArgumentError(
            "output", f"{directory}, which holds files", "an empty or new folder (or --force)"
        )
    if name == ALL and experiments is not None:
        raise ArgumentError("experiments", "it for all papers", "it for strawberry alone")


def reproduce(
    name: str,
    directory: Path,
    report: Callable[[str], None],
    *,
    experiments: str | None = None,
    done: Callable[[str], None] | None = None,
) -> list[Path]:
    """Write the files of a paper, or of all, into a folder and return their paths.

    Raises
    ------
    ArgumentError
        `experiments` for another paper.
    AgrikError
        Matplotlib is missing.
    """
    if name == ALL:
        return papers.reproduce_all(directory, report, done=done)
    return papers.reproduce(name, directory, report, experiments=experiments)
