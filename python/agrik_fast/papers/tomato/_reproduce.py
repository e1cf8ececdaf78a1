"""All files of the tomato paper."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from . import _drawings, _figures
from ._links import write_links
from ._lost import write_lost
from ._published import PUBLISHED
from ._tables import monte_carlo, write_figure8, write_table1
from ._torques import write_torques
from ._vision import write_vision


def reproduce(directory: Path, *, report: Callable[[str], None] | None = None) -> list[Path]:
    """Write table 1, figures 2 to 10, torques, latency, and where the methods fail.

    Parameters
    ----------
    directory : path
        Folder, made if need be; files of the same names are replaced.
    report : callable, optional
        Told what is being worked on.

    Returns
    -------
    list of Path
        The files.
    """
    say = report or (lambda line: None)
    directory.mkdir(parents=True, exist_ok=True)
    say("table 1")
    files = write_table1(directory)
    say("figure 8")
    draws = {method: monte_carlo(method) for method in PUBLISHED}
    files.append(write_figure8(directory, draws))
    files += write_torques(directory)
    say("torque by the number of links")
    files += write_links(directory)
    say("targets that are lost")
    files += write_lost(directory)
    say("figures")
    for draw in (
        _drawings.figure2,
        _drawings.figure3,
        _drawings.figure4,
        _drawings.figure5,
        _drawings.figure6,
    ):
        files += draw(directory)
    files += _figures.figure8(directory, draws)
    files += _figures.arm(directory)
    say("camera")
    files += write_vision(directory)
    return files
