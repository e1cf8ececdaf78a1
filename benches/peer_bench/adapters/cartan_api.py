"""cartan-bindings (Rust), its speed solver with the library's own restarts."""

from __future__ import annotations

from typing import Any

import cartan
import numpy as np

from ..robots import BenchRobot
from . import Array, Evaluation, Solver

DISTRIBUTION = "cartan-bindings"


def _solver(urdf_path: str, config: Any, note: str) -> Solver:
    chain = cartan.load_urdf(urdf_path).chain

    def solve(target: Any, start: Array) -> Any:
        result = cartan.solve_ik_speed(chain, target, start, config)
        return result.q if result.converged else None

    return Solver(solve, note, prepare=cartan.SE3.from_matrix)


def pose(robot: BenchRobot, urdf_path: str) -> Solver:
    config = cartan.IkConfig(
        position_tol=1e-6,
        orientation_tol=1e-6,
        max_iterations_per_attempt=100,
        max_total_iterations=5000,
        max_total_work_units=5000,
    )
    note = "solve_ik_speed, 1e-6/1e-6, 100 iterations an attempt, 5000 in all, its own restarts"
    return _solver(urdf_path, config, note)


def position(robot: BenchRobot, urdf_path: str, tolerance_m: float) -> Solver:
    config = cartan.IkConfig(
        position_tol=tolerance_m,
        orientation_tol=10.0,
        max_total_iterations=5000,
        max_total_work_units=5000,
    )
    return _solver(urdf_path, config, "solve_ik_speed, orientation_tol=10 rad (it has no mask)")


def fk(robot: BenchRobot, urdf_path: str) -> Evaluation:
    chain = cartan.load_urdf(urdf_path).chain
    return Evaluation(
        lambda q: cartan.forward_kinematics(chain, q),
        "forward_kinematics",
        lambda result: np.asarray(result.matrix()),
    )


def jacobian(robot: BenchRobot, urdf_path: str) -> Evaluation:
    chain = cartan.load_urdf(urdf_path).chain
    return Evaluation(lambda q: cartan.body_jacobian(chain, q), "body_jacobian")
