"""Position and orientation: how much a radian is to count, for methods that weigh them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...robot import Robot
from ...solvers import (
    DampedLeastSquares,
    Feedback,
    IkPid,
    JacobianSolver,
    LevenbergMarquardt,
    StaticGain,
    Transpose,
)
from ...tasks import Masked
from ...tuning.goals import joint_uniform_poses
from ._tables import GOALS, plain

LENGTHS_M = (0.01, 0.02, 0.05, 0.1, 0.2, 0.43, 1.0, 2.0)
"""Lengths that a radian counts as, m; 0.43 is what solvers count by default."""

POSE_TOLERANCE: dict[str, Any] = {"position_tolerance": 1e-3, "orientation_tolerance": 1e-2}
POSE_GAINS = "hydrolek_pose_cma"
DEFAULT_SHARE = 0.3
"""Of the reach: what a radian counts as by default."""


class PoseRow(NamedTuple):
    """Poses reached by a method.

    Attributes
    ----------
    method : str
        In words.
    length : float, m
        What a radian counts as.
    reached : int
        Poses of 1,000 within 1 mm and 0.01 rad.
    position : float, m
        Median distance at the end.
    orientation : float, rad
        Median angle at the end.
    """

    method: str
    length: float
    reached: int
    position: float
    orientation: float


def pose_solvers() -> dict[str, JacobianSolver | Feedback]:
    """Return the methods that are tried on poses."""
    return {
        "IK-PID, published": IkPid.load("hydrolek_pid_published_tuned", as_tuned=True),
        "transpose": Transpose(),
        "damped, 200 mm": DampedLeastSquares(damping=0.2),
        "static gain, untuned": StaticGain(),
        "static gain, tuned for poses": StaticGain.load(POSE_GAINS, as_tuned=True),
        "LM, one attempt": LevenbergMarquardt(),
    }


def success_by_weight(robot: Robot, count: int = GOALS) -> list[PoseRow]:
    """Return poses reached by every method of `pose_solvers` at every length."""
    poses = joint_uniform_poses(robot, count, 1)
    rows = []
    for name, solver in pose_solvers().items():
        for length in LENGTHS_M:
            weight = length / (DEFAULT_SHARE * robot.reach_radius)
            task = Masked((1.0, 1.0, 1.0, weight, weight, weight))
            ended = robot.ik(poses, task=task, solver=plain(solver, "zero"), **POSE_TOLERANCE)
            rows.append(
                PoseRow(
                    name,
                    length,
                    int(ended.success.sum()),
                    float(np.median(ended.position_error)),
                    float(np.median(ended.orientation_error)),
                )
            )
    return rows
