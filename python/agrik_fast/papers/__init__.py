"""Tables and figures of the papers that the bundled robots come from, one package a paper.

Each has what the paper prints (published), what we compute (tables), drawings (figures) and
a function ``reproduce(directory, report=...)`` that writes the files (tables as CSV, figures as
PNG and SVG, ``report.md`` on what matches) and returns their paths; ``agrik-fast paper NAME -o
DIR`` calls it, and with ``all`` for every paper. Figures need the extra ``papers``.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable
from pathlib import Path

__all__ = ["PAPERS", "reproduce", "reproduce_all"]

PAPERS = ("strawberry", "tomato", "hydrolek", "redundant7", "cucumber")
"""Names of the papers, each a package here."""


def reproduce(
    name: str,
    directory: Path,
    report: Callable[[str], None],
    *,
    experiments: str | None = None,
) -> list[Path]:
    """Write the tables and figures of a paper into a folder.

    Parameters
    ----------
    name : str
        One of `PAPERS`.
    directory : path
        Folder, made if need be; files of the same names are replaced.
    report : callable
        Told what is being worked on.
    experiments : {"model", "firmware"}, optional
        Strawberry alone: the 24 experiments by the model of their times, which is the default,
        or also on the board's program in a simulator.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    UnknownNameError
        No such paper.
    ArgumentError
        `experiments` for a paper that has none.
    AgrikError
        Matplotlib is missing.

    Examples
    --------
    >>> import pathlib
    >>> from agrik_fast import papers
    >>> files = papers.reproduce("fruit", pathlib.Path("out"), print)
    Traceback (most recent call last):
        ...
    agrik_fast.errors.UnknownNameError: unknown paper 'fruit'. Known: ...
    """
    from ..errors import ArgumentError, UnknownNameError

    if name not in PAPERS:
        raise UnknownNameError("paper", name, PAPERS)
    if experiments is not None and name != "strawberry":
        raise ArgumentError("experiments", f"{experiments!r} for {name}", "it for strawberry alone")
    # Whether figures can be drawn shows before minutes of computing, not after.
    from ..plots import figure, styled

    figure(1.0, 1.0)
    module = importlib.import_module(f".{name}", __name__)
    more = {} if experiments is None else {"experiments": experiments}
    files: list[Path] = styled(module.reproduce)(directory, report=report, **more)
    return files


def reproduce_all(
    directory: Path,
    report: Callable[[str], None],
    *,
    done: Callable[[str], None] | None = None,
) -> list[Path]:
    """Write the tables and figures of all papers, and one page that shows them.

    Parameters
    ----------
    directory : path
        Folder, made if need be; each paper gets one of its own in it.
    report : callable
        Told what is being worked on.
    done : callable, optional
        Told the name of each paper when it is there.

    Returns
    -------
    list of Path
        The files, ``index.html`` last.

    Raises
    ------
    AgrikError
        A library of the extra ``papers`` is missing, a file cannot be written.

    Examples
    --------
    >>> import inspect
    >>> from agrik_fast import papers
    >>> list(inspect.signature(papers.reproduce_all).parameters)
    ['directory', 'report', 'done']
    """
    from ._index import write_index

    files: list[Path] = []
    for name in PAPERS:
        files += reproduce(name, directory / name, functools.partial(_named, report, name))
        if done is not None:
            done(name)
    files.append(write_index(directory, PAPERS))
    return files


def _named(report: Callable[[str], None], name: str, line: str) -> None:
    report(f"{name}: {line}")
