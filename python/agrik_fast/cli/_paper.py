"""``agrik-fast paper``: the tables and figures of a paper, written to a folder."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path

from ..errors import ArgumentError, UnknownNameError
from ..papers import PAPERS


def reproduce(
    name: str, directory: Path, report: Callable[[str], None], *, force: bool
) -> list[Path]:
    """Write the files of a paper into a folder and return their paths.

    Raises
    ------
    UnknownNameError
        No such paper.
    ArgumentError
        The folder holds files and `force` is False.
    AgrikError
        Matplotlib is missing.
    """
    if name not in PAPERS:
        raise UnknownNameError("paper", name, PAPERS)
    if directory.exists() and not directory.is_dir():
        raise ArgumentError("output", f"the file {directory}", "a folder")
    if directory.is_dir() and any(directory.iterdir()) and not force:
        raise ArgumentError(
            "output", f"{directory}, which holds files", "an empty or new folder (or --force)"
        )
    # Whether figures can be drawn shows before minutes of computing, not after.
    from ..papers._output import figure

    figure(1.0, 1.0)
    module = importlib.import_module(f"..papers.{name}", __package__)
    files: list[Path] = module.reproduce(directory, report=report)
    return files
