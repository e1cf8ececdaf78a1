"""All files of the cucumber paper."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ... import harvest
from ...collision import Scene, greenhouse
from .._output import write_csv, write_text
from . import _figures
from ._published import FIELD
from ._tables import (
    ROBOT,
    ablation,
    crop_shares,
    field_cycle,
    search_runs,
    sensitivity_rows,
    write_tables,
)


def reproduce(directory: Path, *, report: Callable[[str], None] | None = None) -> list[Path]:
    """Write the paper's tables and figures, and what it leaves open.

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
    scene, thin = harvest.example_scene(), harvest.example_scene("cucumber_thin")
    programme = harvest.Programme(ROBOT, thin, "C1")
    say("searches")
    runs, seconds = search_runs(programme)
    say("tables")
    files = write_tables(directory, scene, programme, runs, seconds)
    say("settings of the genetic algorithm")
    head = ["setting", "median J", "best J", "worst J", "runs of 20 within 1 mm"]
    files.append(write_csv(directory / "ablation.csv", head, ablation(programme)))
    say("crops")
    rows = crop_shares()
    head = ["leaves removed a plant", "from, m", "to, m", "fruits", "share harvestable"]
    files.append(write_csv(directory / "crop_shares.csv", head, rows))
    say("harvest cycles")
    files.append(_cycle(directory / "cycle.csv"))
    say("errors")
    head = ["target", "D, mm", "TCP rms, mm", "drawn, mm", "P nearest body", "P union bound"]
    head += ["P drawn", "D for 99 %, mm"]
    files.append(write_csv(directory / "sensitivity.csv", head, sensitivity_rows(scene)))
    say("figures")
    two_step = harvest.plan(
        ROBOT, thin, "C1", settings=harvest.Settings(refine=True), distance="tree"
    )["C1"]
    costs = np.atleast_1d(programme.terms(two_step.q).cost)
    files += _figures.robot(directory)
    files += _figures.vertical(directory)
    files += _figures.crop(directory, thin)
    files += _figures.genetic(directory, thin, runs["GA"])
    files += _figures.scans(directory, scene)
    files += _figures.compared(directory, thin, two_step, runs, costs)
    files += _figures.thinned(directory, scene)
    files += _figures.boxes(directory)
    files += _figures.convergence(directory, runs, seconds)
    files += _figures.shares(directory, rows)
    files += _figures.sensitivity(directory, scene)
    files.append(_notes(directory / "report.md"))
    return files


def _crop(number: int) -> Scene:
    return greenhouse(seed=200 + number, plants=4, leaves=4, fruits=2, clear_band=(0.65, 1.3))


def _cycle(path: Path) -> Path:
    ours = field_cycle(_crop)
    head = ["quantity", "simulated", "paper", "note"]
    rows = [
        ["success, share", ours["success"], FIELD.success, "vision error 10 mm, assumed"],
        ["successful cycle, s", ours["cycle"], FIELD.cycle, "the paper's own times, assumed"],
        ["per harvested cucumber, s", ours["per_cucumber"], FIELD.per_cucumber, ""],
        ["attempts a harvested cucumber", ours["attempts"], "", "at most three a fruit"],
    ]
    return write_csv(path, head, rows)


def _notes(path: Path) -> Path:
    return write_text(
        path,
        [
            "# What is assumed",
            "",
            "Tables and figures of the cucumber paper, computed anew.",
            "Lengths and limits of table 1 are a sister arm's or assumed: the paper's are lost.",
            "Crops are made up; gripper and machine are assumed.",
        ],
    )
