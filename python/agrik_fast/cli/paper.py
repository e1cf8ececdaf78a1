"""``agrik-fast paper``: the tables and figures of a paper, written to a folder."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from ..errors import UnknownNameError
from ..papers import PAPERS


def reproduce(name: str, directory: Path, report: Callable[[str], None]) -> list[Path]:
    """Write the files of a paper; return their paths."""
    if name not in PAPERS:
        raise UnknownNameError("paper", name, PAPERS)
    module = import_module(f"agrik_fast.papers.{name}")
    files: list[Path] = module.reproduce(directory, report=report)
    return files
