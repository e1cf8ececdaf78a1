"""Gains for further robots, as the paper's conclusions ask for: tuned against untuned."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from ...robot import Robot
from ...solvers import Feedback, StaticGain
from ...tuning.goals import joint_uniform
from ._tables import GOALS, plain

OTHERS = ("tomato", "puma560", "ur5", "redundant7")
START = "zero"
"""Where attempts start; of three of these robots it is the middle of the limits too."""


class RobotRow(NamedTuple):
    """A robot's goals of 1,000 at 1 mm in one attempt from zero.

    Attributes
    ----------
    robot : str
        Name.
    untuned : int
        Goals reached by half a pseudo-inverse of the middle posture.
    tuned : int
        Goals reached by the gains that come with the library.
    untuned_iterations, tuned_iterations : float
        Mean iterations of the goals reached.
    untuned_restarts, tuned_restarts : int
        Goals reached with twenty restarts.
    """

    robot: str
    untuned: int
    tuned: int
    untuned_iterations: float
    tuned_iterations: float
    untuned_restarts: int
    tuned_restarts: int


def gains_of(name: str) -> str:
    """Return the name of the bundled gains of a robot."""
    return f"{name}_static_cma"


def tuned_robots() -> list[RobotRow]:
    """Return the table of `OTHERS`."""
    rows = []
    for name in OTHERS:
        arm = Robot.load(name)
        goals = joint_uniform(arm, GOALS, 1)
        found: list[tuple[int, float, int]] = []
        for gains in (StaticGain(start=START), StaticGain.load(gains_of(name), as_tuned=True)):
            solver: Feedback = gains
            ended = arm.ik(goals, solver=plain(solver, START), position_tolerance=1e-3)
            again = replace(gains, start="sampled", max_restarts=20, max_iterations=400)
            helped = arm.ik(goals, solver=again, position_tolerance=1e-3)
            good = ended.success
            mean = round(float(ended.iterations[good].mean()), 1)
            found.append((int(good.sum()), mean, int(helped.success.sum())))
        (plain_count, plain_mean, plain_more), (count, mean, more) = found
        rows.append(RobotRow(name, plain_count, count, plain_mean, mean, plain_more, more))
    return rows
