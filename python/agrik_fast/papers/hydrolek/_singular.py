"""Singular postures of the HydroLek itself: whether it has any, and who gets away from them.

The paper shows one singular start, of a planar arm, and asks for more. Within its limits the
HydroLek has no posture in which a direction of the tool point is lost; so the study takes
its limits away and starts beside postures that are singular without them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..._checks import FloatArray
from ...result import Status
from ...robot import Robot
from ...solvers import LevenbergMarquardt
from ...tuning.goals import splitmix64
from ._tables import methods, plain

DISTANCES = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
"""How far starts are from a singular posture, rad."""

POSTURES = 40
AWAY_M = 0.1
"""Distance of the goal from the singular posture's tool point, m."""

SINGULAR = 1e-6
"""A least singular value below this, m/rad, counts as singular."""


class SingularPostures(NamedTuple):
    """Singular postures with a goal each.

    Attributes
    ----------
    q : ndarray, shape (n, 6), rad
        Joint values.
    least : ndarray, shape (n,), m/rad
        Least singular values of the position Jacobian.
    goals : ndarray, shape (n, 3), m
        Points 0.1 m away in the direction that is lost, on a side that can be reached.
    """

    q: FloatArray
    least: FloatArray
    goals: FloatArray


def least_singular_value(robot: Robot, q: FloatArray) -> FloatArray:
    """Return the least singular values of position Jacobians, shape (...), m/rad."""
    values = np.linalg.svd(robot.jacobian(q)[..., :3, :], compute_uv=False)
    return np.asarray(values[..., -1])


def least_within_limits(robot: Robot, seed: int = 1) -> float:
    """Return the least singular value within a robot's limits that a search finds, m/rad.

    The smallest of 20,000 random postures, gone down from by L-BFGS-B.
    """
    q = robot.random_q(20_000, seed=seed)
    order = np.argsort(least_singular_value(robot, q))[:5]
    return min(_descend(robot, one)[1] for one in q[order])


def unlimited() -> Robot:
    """Return the HydroLek with limits of half a turn either way."""
    arm = Robot.load("hydrolek")
    rows = [(row.a, row.alpha, row.d, row.theta) for row in arm.dh or ()]
    limits = [(-np.pi, np.pi)] * arm.dof
    # The name is that which the gains are for.
    return Robot.from_dh(rows, limits=limits, name="hydrolek")


def singular_postures(count: int = POSTURES) -> SingularPostures:
    """Return singular postures of the arm without its limits, with goals."""
    arm = unlimited()
    found: list[tuple[FloatArray, float, FloatArray]] = []
    seed = 0
    while len(found) < count:
        seed += 1
        q, least = _descend(arm, arm.random_q(seed=seed))
        if least > SINGULAR:
            continue
        axes, _, _ = np.linalg.svd(arm.jacobian(q)[:3])
        point = arm.fk(q)[:3, 3]
        sides = point + AWAY_M * np.array([axes[:, 2], -axes[:, 2]])
        reached = arm.ik(sides, solver=LevenbergMarquardt()).success
        if reached.any():
            found.append((q, least, sides[int(np.argmax(reached))]))
    q, values, goals = (np.array(part) for part in zip(*found, strict=True))
    return SingularPostures(q, values, goals)


def singularity_study(count: int = POSTURES) -> list[list[object]]:
    """Return what becomes of starts beside singular postures.

    Columns: method, distance of the start (rad), goals reached, stalled, not found in 1,000
    steps, number of goals, mean iterations of those reached.
    """
    arm, postures = unlimited(), singular_postures(count)
    ways = 2 * splitmix64(7, count * arm.dof).reshape(count, arm.dof) - 1
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    rows: list[list[object]] = []
    for name, (solver, _) in methods().items():
        one = plain(solver, "zero")
        for distance in DISTANCES:
            start = postures.q + distance * ways
            ended = arm.ik(postures.goals, solver=one, q0=start, position_tolerance=1e-3)
            good = ended.success
            mean = round(float(ended.iterations[good].mean()), 1) if good.any() else None
            stalled = int((ended.status == Status.STALLED).sum())
            missed = int((~good).sum()) - stalled
            rows.append([name, distance, int(good.sum()), stalled, missed, count, mean])
    return rows


def _descend(robot: Robot, q: FloatArray) -> tuple[FloatArray, float]:
    """Go down to a posture whose least singular value is least."""
    from scipy.optimize import minimize

    bounds = list(zip(robot.lower, robot.upper, strict=True))

    def square(values: FloatArray) -> float:
        return float(least_singular_value(robot, values)) ** 2

    for _ in range(3):  # L-BFGS-B ends early where its differences are coarse
        options = {"ftol": 1e-18, "gtol": 1e-14, "maxiter": 300}
        q = minimize(square, q, method="L-BFGS-B", bounds=bounds, options=options).x
    return q, float(least_singular_value(robot, q))
