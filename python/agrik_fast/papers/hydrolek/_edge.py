"""Where goals are lost (section 6.1): at the edge of the workspace or inside it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...robot import Robot
from ...solvers import (
    ClosedPseudoInverse,
    DampedLeastSquares,
    Feedback,
    IkPid,
    JacobianSolver,
    StateSpace,
    Transpose,
)
from ...tuning.goals import joint_uniform
from ._tables import GOALS, plain
from ._workspace import Edge

EDGE_SEEDS = (1, 11, 12)
"""Seeds of the goal sets J."""


def edge_solvers() -> dict[str, JacobianSolver | Feedback]:
    """Return the methods whose lost goals are looked at."""
    return {
        "pseudo-inverse": ClosedPseudoInverse(),
        "transpose": Transpose(),
        "damped, 200 mm": DampedLeastSquares(damping=0.2),
        "IK-PID, Kp 0.02": IkPid.load("hydrolek_pid_published_kp", as_tuned=True),
        "IK-PID, tuned": IkPid.load("hydrolek_pid_published_tuned", as_tuned=True),
        "state space, optimised": StateSpace.load("hydrolek_full90_pso", as_tuned=True),
    }


class Lost(NamedTuple):
    """Goals that a method loses, over the three sets J from the zero start.

    Attributes
    ----------
    method : str
        In words.
    goals : int
        Goals tried.
    lost : int
        Goals lost at 1 mm.
    lost_at_edge : int
        How many of these in a cube of the workspace that has an empty neighbour.
    edge_share : float
        Share of all goals in such cubes.
    """

    method: str
    goals: int
    lost: int
    lost_at_edge: int
    edge_share: float


def lost_goals(robot: Robot) -> tuple[list[Lost], FloatArray, dict[str, NDArray[np.bool_]]]:
    """Return the table, the goals of the first set, and which of them each method loses."""
    edge = Edge(robot)
    sets = [joint_uniform(robot, GOALS, seed) for seed in EDGE_SEEDS]
    goals = np.concatenate(sets)
    at_edge = edge.holds(goals)
    rows, first = [], {}
    for name, solver in edge_solvers().items():
        ended = robot.ik(goals, solver=plain(solver, "zero"), position_tolerance=1e-3)
        lost = ~ended.success
        rows.append(
            Lost(
                name,
                len(goals),
                int(lost.sum()),
                int((lost & at_edge).sum()),
                float(at_edge.mean()),
            )
        )
        first[name] = lost[:GOALS]
    return rows, sets[0], first
