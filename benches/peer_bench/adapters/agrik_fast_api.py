"""agrik_fast itself, at its default tolerances (1e-6 m, 1e-6 rad) and with no start given.

The tolerance is tighter than the success criterion, as the peers' are; position-only runs at the
task's own tolerance, as theirs do.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import agrik_fast

from ..robots import BenchRobot
from . import Array, Evaluation, Solver

DISTRIBUTION = "agrik-fast"


def native_notes() -> str:
    """Say what the report tells about the build."""
    try:
        from agrik_fast import simd_level
    except ImportError:
        from agrik_fast._native import simd_level
    return f"simd level {simd_level()}"


def pose(robot: BenchRobot, urdf_path: str) -> Solver:
    arm = agrik_fast.Robot.load(robot.bundled)

    def solve(target: Array, start: Array) -> Array | None:
        result = arm.ik(target)
        return result.q if result.success else None

    def batch(poses: Array, threads: int) -> tuple[Array, Any]:
        result = arm.ik(poses, threads=threads)
        return result.q, result.success

    return Solver(
        solve,
        "arm.ik(T), all defaults, no start given",
        batch=batch,
        overhead=lambda target, q: arm.ik(target, q0=q),
    )


def closed_form(robot: BenchRobot, urdf_path: str) -> Solver | None:
    arm = agrik_fast.Robot.load(robot.bundled)
    if arm.closed_form is None:
        return None

    def batch(poses: Array, threads: int) -> Any:
        return arm.ik_all(poses, threads=threads)

    def unpack(found: Any) -> tuple[Array, Any]:
        first = found.valid.argmax(axis=1)
        return found.q[np.arange(len(first)), first], found.status == agrik_fast.Status.CONVERGED

    return Solver(
        lambda target, start: arm.ik_all(target).q,
        f"arm.ik_all(T), {arm.closed_form}, all defaults",
        every_solution=True,
        batch=batch,
        unpack=unpack,
        count=lambda target: int(arm.ik_all(target).reached.sum()),
    )


def batch_arrays(robot: BenchRobot, poses: Array) -> list[Array]:
    """Solve a batch and return every array of its result."""
    result = agrik_fast.Robot.load(robot.bundled).ik(poses)
    fields = "q success status position_error orientation_error iterations restarts"
    return [np.asarray(getattr(result, field)) for field in fields.split()]


def position(robot: BenchRobot, urdf_path: str, tolerance_m: float) -> Solver:
    arm = agrik_fast.Robot.load(robot.bundled)

    def solve(point: Array, start: Array) -> Array | None:
        result = arm.ik(point, task="position", position_tolerance=tolerance_m)
        return result.q if result.success else None

    def batch(poses: Array, threads: int) -> tuple[Array, Any]:
        points = np.ascontiguousarray(poses[:, :3, 3])
        result = arm.ik(points, task="position", threads=threads, position_tolerance=tolerance_m)
        return result.q, result.success

    return Solver(
        solve,
        'arm.ik(p, task="position", position_tolerance=1e-4), no start given',
        prepare=lambda target: np.ascontiguousarray(target[:3, 3]),
        batch=batch,
    )


def fk(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return Evaluation(agrik_fast.Robot.load(robot.bundled).fk, "arm.fk(q)", np.asarray)


def jacobian(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return Evaluation(agrik_fast.Robot.load(robot.bundled).jacobian, "arm.jacobian(q)")


def fk_batch(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return fk(robot, urdf_path)


def jacobian_batch(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return jacobian(robot, urdf_path)
