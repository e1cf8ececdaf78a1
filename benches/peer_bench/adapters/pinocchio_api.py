"""Pinocchio. It has no IK of its own: its documented CLIK loop, with restarts added here."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import numpy as np
import pinocchio as pin

from ..robots import BenchRobot
from . import Array, Evaluation, Solver

DISTRIBUTION = "pin"
ATTEMPTS = 30
ITERATIONS = 60
DAMPING = 1e-6


def _model(urdf_path: str) -> tuple[Any, Any, int]:
    model = pin.buildModelFromUrdf(urdf_path)
    return model, model.createData(), model.getFrameId("ee")


def pose(robot: BenchRobot, urdf_path: str) -> Solver:
    model, data, frame = _model(urdf_path)
    damping = DAMPING * np.eye(6)
    starts = cycle(robot.random_starts())
    norm, linear_solve = np.linalg.norm, np.linalg.solve

    def solve(target: Any, q: Array) -> Array | None:
        for _ in range(ATTEMPTS):
            for _ in range(ITERATIONS):
                pin.forwardKinematics(model, data, q)
                placement = pin.updateFramePlacement(model, data, frame)
                error_pose = placement.actInv(target)
                error = pin.log6(error_pose).vector
                if norm(error) < 1e-6:
                    wrapped = robot.wrapped(q)
                    if robot.inside(wrapped):
                        return wrapped
                    break
                j = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL)
                j = -pin.Jlog6(error_pose.inverse()) @ j
                step = -j.T.dot(linear_solve(j.dot(j.T) + damping, error))
                length = norm(step)
                q = q + (step / length if length > 1.0 else step)
            q = next(starts)
        return None

    note = "CLIK loop in Python, damping 1e-6, 60 steps of <= 1 rad; our loop of 30 restarts"
    return Solver(solve, note, prepare=pin.SE3)


def position(robot: BenchRobot, urdf_path: str, tolerance_m: float) -> Solver:
    model, data, frame = _model(urdf_path)
    damping = DAMPING * np.eye(3)
    starts = cycle(robot.random_starts())
    norm, linear_solve = np.linalg.norm, np.linalg.solve

    def solve(point: Array, q: Array) -> Array | None:
        for _ in range(ATTEMPTS):
            for _ in range(ITERATIONS):
                pin.forwardKinematics(model, data, q)
                error = point - pin.updateFramePlacement(model, data, frame).translation
                if norm(error) < tolerance_m:
                    return q
                j = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
                step = j.T @ linear_solve(j @ j.T + damping, error)
                q = np.clip(q + step, robot.lower, robot.upper)
            q = next(starts)
        return None

    note = "3-row damped CLIK loop in Python, clipped to the limits; our loop of 30 restarts"
    return Solver(solve, note, prepare=lambda target: target[:3, 3].copy())


def fk(robot: BenchRobot, urdf_path: str) -> Evaluation:
    model, data, frame = _model(urdf_path)

    def call(q: Array) -> Any:
        pin.forwardKinematics(model, data, q)
        return pin.updateFramePlacement(model, data, frame)

    return Evaluation(call, "forwardKinematics + one frame", lambda result: result.homogeneous)


def jacobian(robot: BenchRobot, urdf_path: str) -> Evaluation:
    model, data, frame = _model(urdf_path)
    reference = pin.LOCAL_WORLD_ALIGNED
    return Evaluation(
        lambda q: pin.computeFrameJacobian(model, data, q, frame, reference),
        "computeFrameJacobian (includes FK)",
    )
