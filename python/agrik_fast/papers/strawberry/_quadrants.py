"""Execution times by quadrant: "the third and fourth are higher than the ones closer"."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arms import StrawberryArm
from ._experiments import METHODS, Experiment
from ._published import Column


class Quadrant(NamedTuple):
    """Mean execution time in a quadrant of the plant's circle.

    Attributes
    ----------
    quadrant : int
        1 to 4: x and y below the middle, x above, both above, y above.
    column : str
        ncos, ssas or as.
    distance : float, m
        Mean distance of its targets from the tool point at home.
    seconds : float
        Mean time, s.
    """

    quadrant: int
    column: Column
    distance: float
    seconds: float


def quadrant_times(runs: Sequence[Experiment]) -> list[Quadrant]:
    """Return mean times by quadrant and method."""
    arm = StrawberryArm()
    home = arm.fk(arm.reset_pose)
    rows = []
    for quadrant in (1, 2, 3, 4):
        for column in METHODS:
            own = [run for run in runs if (run.quadrant, run.column) == (quadrant, column)]
            away = float(np.mean([np.linalg.norm(run.target - home) for run in own]))
            seconds = float(np.mean([run.seconds for run in own]))
            rows.append(Quadrant(quadrant, column, away, seconds))
    return rows


def quadrant_report(rows: Sequence[Quadrant]) -> list[str]:
    """Return the times by quadrant in Markdown, with a verdict."""
    lines = [
        "# Times by quadrant",
        "",
        "| quadrant | distance from home, m | NCOS, s | SSAS, s | AS, s |",
        "|---|---|---|---|---|",
    ]
    means = {}
    for quadrant in (1, 2, 3, 4):
        own = [row for row in rows if row.quadrant == quadrant]
        means[quadrant] = float(np.mean([row.seconds for row in own]))
        times = " | ".join(f"{row.seconds:.2f}" for row in own)
        lines.append(f"| {quadrant} | {own[0].distance:.3f} | {times} |")
    first, last = means[1] + means[2], means[3] + means[4]
    slower = "holds" if min(means[3], means[4]) > max(means[1], means[2]) else "holds in the mean"
    verdict = slower if last > first else "does not hold"
    order = " < ".join(str(quadrant) for quadrant in sorted(means, key=lambda q: means[q]))
    return [
        *lines,
        "",
        f'"The third and fourth quadrants are higher" {verdict}: {last / 2:.2f} s for '
        f"{first / 2:.2f} s in the first and second; the order of the quadrants is {order}.",
    ]
