"""optik-py (Rust), one thread. It solves on a worker thread, so only process time is fair."""

from __future__ import annotations

from typing import Any

import numpy as np
import optik

from ..robots import BenchRobot
from . import Array, Evaluation, Solver

DISTRIBUTION = "optik-py"


def _robot(urdf_path: str) -> Any:
    arm = optik.Robot.from_urdf_file(urdf_path, "base", "ee")
    arm.set_parallelism(1)
    return arm


def _solver(urdf_path: str, config: Any, note: str) -> Solver:
    arm = _robot(urdf_path)

    def solve(target: Array, start: Array) -> Any:
        result = arm.ik(config, target, start)
        return None if result is None else result[0]

    return Solver(solve, note)


def pose(robot: BenchRobot, urdf_path: str) -> Solver:
    config = optik.SolverConfig(
        solution_mode="speed", max_time=0.5, max_restarts=0, tol_f=1e-12, tol_df=-1.0, tol_dx=-1.0
    )
    return _solver(urdf_path, config, "speed mode, tol_f=1e-12, at most 0.5 s, 1 thread")


def position(robot: BenchRobot, urdf_path: str, tolerance_m: float) -> Solver:
    config = optik.SolverConfig(
        solution_mode="speed",
        max_time=0.5,
        max_restarts=0,
        tol_f=tolerance_m**2,
        tol_df=-1.0,
        tol_dx=-1.0,
        linear_weight=[1.0, 1.0, 1.0],
        angular_weight=[0.0, 0.0, 0.0],
    )
    return _solver(urdf_path, config, "speed mode, angular_weight=0, tol_f = tolerance^2, 1 thread")


def fk(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return Evaluation(_robot(urdf_path).fk, "fk, nested lists", np.array)


def jacobian(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return Evaluation(_robot(urdf_path).joint_jacobian, "joint_jacobian, nested lists")
