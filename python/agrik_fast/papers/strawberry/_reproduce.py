"""All files of the strawberry paper."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..._checks import word
from ...arms import StrawberryArm
from . import _figures, _mechanism
from ._published import FIGURE_TARGET, Column
from ._write import write_tables

EXPERIMENTS = ("model", "firmware")
"""How the 24 experiments can be done."""


def reproduce(
    directory: Path,
    *,
    report: Callable[[str], None] | None = None,
    experiments: str = "model",
) -> list[Path]:
    """Write tables 3 and 4, figures 1 to 6, the 24 experiments, P1 and the NCOS's starts.

    Parameters
    ----------
    directory : path
        Folder, made if need be; files of the same names are replaced.
    report : callable, optional
        Told what is being worked on.
    experiments : {"model", "firmware"}
        The 24 experiments by the model of their times alone, or also on the board's program in
        a simulator.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    UnknownNameError
        `experiments` is another word.
    SimulatorError
        The simulator is not built and cannot be.
    """
    word("experiments", experiments, EXPERIMENTS)
    say = report or (lambda line: None)
    directory.mkdir(parents=True, exist_ok=True)
    arm = StrawberryArm()
    say("tables and experiments")
    files = write_tables(directory, arm)
    say("figures")
    files += _mechanism.figure1(directory)
    files += _figures.figure2(directory)
    files += _mechanism.figure3(directory)
    poses: dict[str, Column] = {
        "figure4": "as",
        "figure5": "ssas",
        "figure6": "ncos",
        "exact": "exact",
    }
    for name, method in poses.items():
        files += _figures.pose(directory, name, FIGURE_TARGET, method, arm)
    files += _figures.table4(directory, arm)
    if experiments == "firmware":
        from . import _firmware

        files += _firmware.write(directory, _firmware.outcomes(say))
    return files
