"""The claim that the method scales to arms with more degrees of freedom."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...plots import PAGE_WIDTH, figure, styled
from ...robot import Robot
from ...solvers import DifferentialEvolution, LevenbergMarquardt, Solver
from .._output import save, write_csv
from ._tables import TOLERANCE, arm

DEGREES_OF_FREEDOM = (7, 10, 14, 20)
GENERATIONS = (200, 400, 800, 1600)
REACH_M = 1.266
"""Sum of the link offsets of every arm, m: that of Table I."""


class Scaled(NamedTuple):
    """How the published recipe does on an arm with so many joints.

    Attributes
    ----------
    dof : int
        Joints.
    generations : int
        Generations; 0 for the step solver.
    success : float
        Share of targets within 0.1 mm and 1e-3 rad.
    median_cost : float
        Median cost at the end, mm + 100 rad; NaN for the step solver.
    """

    dof: int
    generations: int
    success: float
    median_cost: float


def alternating_arm(dof: int) -> Robot:
    """Return an arm of revolute joints with twists of -90 and +90 degrees in turn.

    As Table I: every other joint has an offset, the last twist is 0. The offsets are equal and
    sum up to 1.266 m; limits are +-170 and +-120 degrees in turn.
    """
    offset = REACH_M / ((dof + 1) // 2)
    rows, limits = [], []
    for k in range(dof):
        twist = 0.0 if k == dof - 1 else (-np.pi / 2 if k % 2 == 0 else np.pi / 2)
        rows.append((0.0, twist, offset if k % 2 == 0 else 0.0, 0.0))
        limit = np.radians(170 if k % 2 == 0 else 120)
        limits.append((-limit, limit))
    return Robot.from_dh(rows, limits=limits, name=f"alternating{dof}")


def scalability(count: int = 200) -> list[Scaled]:
    """Return the recipe's success by degrees of freedom and generations.

    Parameters
    ----------
    count : int, default 200
        Random reachable poses an arm; one run each.
    """
    from ._tables import cost

    recipe = DifferentialEvolution.paper()
    rows = []
    for dof in DEGREES_OF_FREEDOM:
        robot = arm() if dof == 7 else alternating_arm(dof)
        poses = robot.fk(robot.random_q(count, seed=21))
        solvers: list[tuple[int, Solver]] = [
            (generations, dataclasses.replace(recipe, generations=generations))
            for generations in GENERATIONS
        ]
        for generations, solver in [*solvers, (0, LevenbergMarquardt())]:
            ended = robot.ik(poses, solver=solver, **TOLERANCE)
            found = [cost(robot, q, pose) for q, pose in zip(ended.q, poses, strict=True)]
            median = float(np.median(found)) if generations else float("nan")
            rows.append(Scaled(dof, generations, float(ended.success.mean()), median))
    return rows


def verdict(rows: list[Scaled]) -> str:
    """Return what the table says of the claim."""
    share = {(row.dof, row.generations): 100 * row.success for row in rows}
    most = GENERATIONS[-1]
    at = ", ".join(f"{share[dof, GENERATIONS[0]]:.0f} %" for dof in DEGREES_OF_FREEDOM)
    late = ", ".join(f"{share[dof, most]:.0f} %" for dof in DEGREES_OF_FREEDOM)
    names = ", ".join(map(str, DEGREES_OF_FREEDOM))
    return (
        f"With the published {GENERATIONS[0]} generations {names} degrees of freedom give {at}; "
        f"with {most} generations {late}."
    )


@styled
def write_scalability(folder: Path, rows: list[Scaled]) -> list[Path]:
    """Write and draw the table; return the files."""
    drawing = figure(PAGE_WIDTH, 3.0)
    axes = drawing.subplots()
    for dof, mark in zip(DEGREES_OF_FREEDOM, "os^D", strict=True):
        own = [row for row in rows if row.dof == dof and row.generations]
        axes.semilogx(
            [row.generations for row in own],
            [100 * row.success for row in own],
            f"{mark}-",
            ms=4,
            label=f"{dof} joints",
        )
    axes.set_xticks(GENERATIONS, [str(x) for x in GENERATIONS])
    axes.minorticks_off()
    axes.set_xlabel("generations")
    axes.set_ylabel("targets reached [%]")
    axes.set_ylim(-3, 103)
    axes.legend()
    lines = [
        (
            row.dof,
            row.generations or "step solver",
            f"{100 * row.success:.1f}",
            "" if np.isnan(row.median_cost) else f"{row.median_cost:.2e}",
        )
        for row in rows
    ]
    header = ["dof", "generations", "success_percent", "median_cost"]
    return [
        write_csv(folder / "scalability.csv", header, lines),
        *save(drawing, folder, "scalability"),
    ]
