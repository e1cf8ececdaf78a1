"""dynibo (Rust). It has no restarts, so a loop here supplies them; no position-only objective."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import dynibo
import numpy as np

from ..robots import BenchRobot
from . import Array, Evaluation, Solver, quaternion_xyzw

DISTRIBUTION = "dynibo"


def _native_target(target: Array) -> Any:
    x, y, z = (float(value) for value in target[:3, 3])
    return dynibo.Pose(translation=(x, y, z), rotation_xyzw=quaternion_xyzw(target[:3, :3]))


def _solver(robot: BenchRobot, urdf_path: str, options: Any, attempts: int, note: str) -> Solver:
    arm = dynibo.Robot.from_urdf(urdf_path)
    tool = arm.link_id("ee")
    starts = cycle(robot.random_starts())

    def solve(target: Any, start: Array) -> Any:
        for _ in range(attempts):
            try:
                return arm.inverse_kinematics(start, tool, target, options=options)
            except dynibo.SolverError:
                start = next(starts)
        return None

    return Solver(solve, note, prepare=_native_target)


def pose(robot: BenchRobot, urdf_path: str) -> Solver:
    options = dynibo.IkOptions(
        max_iterations=100, translation_tolerance=1e-6, rotation_tolerance=1e-6
    )
    note = "inverse_kinematics, 100 iterations, 1e-6/1e-6; our loop of 100 restarts"
    return _solver(robot, urdf_path, options, 100, note)


def position(robot: BenchRobot, urdf_path: str, tolerance_m: float) -> Solver:
    options = dynibo.IkOptions(
        max_iterations=100, translation_tolerance=tolerance_m, rotation_tolerance=10.0
    )
    note = "full-pose steps, rotation_tolerance=10 rad; our loop of 20 restarts"
    return _solver(robot, urdf_path, options, 20, note)


def fk(robot: BenchRobot, urdf_path: str) -> Evaluation:
    arm = dynibo.Robot.from_urdf(urdf_path)
    tool = arm.link_id("ee")
    return Evaluation(lambda q: arm.forward_kinematics(q, tool), "forward_kinematics")


def jacobian(robot: BenchRobot, urdf_path: str) -> Evaluation:
    arm = dynibo.Robot.from_urdf(urdf_path)
    tool, out = arm.link_id("ee"), np.empty(6 * arm.generalized_count)
    return Evaluation(lambda q: arm.jacobian(q, tool, out=out), "jacobian into a buffer")
