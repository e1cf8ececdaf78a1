"""Convergence and stability of the state space, which the paper leaves to later articles.

With e the error and x the state, about a posture that reaches its goal and has no joint at a
limit, ``e <- e - J C x`` and ``x <- A x + B e`` to first order. The goal is a stable fixed
point if the spectral radius of this system is below one; for a static gain K that is the
radius of ``I - J K``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...result import Status
from ...robot import Robot
from ...solvers import StateSpace, StaticGain
from ...tuning.goals import joint_uniform, joint_uniform_q
from ._tables import GOALS, plain, static_gain

SETS = {
    "trial (published)": "hydrolek_trial_published",
    "90 numbers (PSO)": "hydrolek_full90_pso",
    "24 numbers (PSO)": "hydrolek_diag24_pso",
    "15 numbers (CMA-ES)": "hydrolek_k15_cma",
}
"""Gain sets that are looked at."""

POSTURES = 5000
AT_LIMIT = 1e-9
"""A joint so near to a limit, rad, is at it."""


class Stability(NamedTuple):
    """What is known of a gain set.

    Attributes
    ----------
    name : str
        In words.
    radius_of_a : float
        Spectral radius of A: the state dies out below one.
    rank : int
        Rank of the gain that the system settles to; 3 leaves e = 0 as the only fixed point
        away from the limits.
    stable_share : float
        Share of random postures where goals are stable fixed points.
    radius_median : float
        Median of the spectral radius over these postures.
    reached : int
        Goals of 1,000 reached at 1 mm from zero.
    reached_unstable : int
        How many of these in a posture without joints at limits whose radius is not below one.
    stalled_at_limit : int
        Goals lost at a fixed point with a joint at a limit.
    stalled_free : int
        Goals lost at a fixed point without one.
    moving : int
        Goals lost that still move after 1,000 steps.
    """

    name: str
    radius_of_a: float
    rank: int
    stable_share: float
    radius_median: float
    reached: int
    reached_unstable: int
    stalled_at_limit: int
    stalled_free: int
    moving: int


def spectral_radius(robot: Robot, gains: StateSpace | StaticGain, q: FloatArray) -> FloatArray:
    """Return the radius of the system about postures q, shape (..., n), that reach a goal.

    Below one the error dies out.
    """
    turn = np.array(gains.frame)
    # What changes the error in the gains' units and axes, by a change of joints in theirs.
    change = turn @ robot.jacobian(q)[..., :3, :] * (gains.angle_unit_rad / gains.length_unit_m)
    eye = np.eye(3)
    if isinstance(gains, StaticGain):
        system = eye - change @ np.array(gains.K)
    else:
        a, b, c = (np.array(getattr(gains, name)) for name in "ABC")
        n, leading = len(a), change.shape[:-2]
        system = np.zeros((*leading, 3 + n, 3 + n))
        system[..., :3, :3] = eye
        system[..., :3, 3:] = -change @ c
        system[..., 3:, :3], system[..., 3:, 3:] = b, a
    radius: FloatArray = np.abs(np.linalg.eigvals(system)).max(axis=-1)
    return radius


def missed_and_reached(
    robot: Robot, gains: StateSpace | StaticGain
) -> tuple[FloatArray, FloatArray, NDArray[np.uint8]]:
    """Return goals J, answers and statuses of a gain set from zero, cap 1,000."""
    goals = joint_uniform(robot, GOALS, 1)
    ended = robot.ik(goals, solver=plain(gains, "zero"), position_tolerance=1e-3)
    return goals, ended.q, ended.status


def stability(robot: Robot) -> list[Stability]:
    """Return what is known of each of `SETS`, and of the static gain of the last one."""
    postures = joint_uniform_q(robot, POSTURES, 5)
    sets: dict[str, StateSpace | StaticGain] = {
        name: StateSpace.load(file, as_tuned=True) for name, file in SETS.items()
    }
    sets["static gain of the 15"] = static_gain("hydrolek_k15_cma")
    rows = []
    for name, gains in sets.items():
        radius = spectral_radius(robot, gains, postures)
        settled = gains.static_gain() if isinstance(gains, StateSpace) else np.array(gains.K)
        _, q, status = missed_and_reached(robot, gains)
        limited = (np.minimum(q - robot.lower, robot.upper - q) < AT_LIMIT).any(axis=1)
        reached, stalled = status == Status.CONVERGED, status == Status.STALLED
        unstable = spectral_radius(robot, gains, q) >= 1
        rows.append(
            Stability(
                name,
                gains.spectral_radius if isinstance(gains, StateSpace) else 0.0,
                int(np.linalg.matrix_rank(settled)),
                float((radius < 1).mean()),
                float(np.median(radius)),
                int(reached.sum()),
                int((reached & unstable & ~limited).sum()),
                int((stalled & limited).sum()),
                int((stalled & ~limited).sum()),
                int((~reached & ~stalled).sum()),
            )
        )
    return rows
