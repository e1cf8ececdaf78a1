"""roboticstoolbox-python, its C++ Levenberg-Marquardt.

Its default tol=1e-6 reports success on answers that miss the criterion; 1e-12 meets it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from roboticstoolbox import ET

from ..robots import BenchRobot
from . import Array, Evaluation, Solver

DISTRIBUTION = "roboticstoolbox-python"


def _transforms(robot: BenchRobot) -> Any:
    parts = []
    for i in range(robot.dof):
        if robot.theta[i]:
            parts.append(ET.Rz(robot.theta[i]))
        parts.append(ET.Rz(qlim=[robot.lower[i], robot.upper[i]]))
        if robot.d[i]:
            parts.append(ET.tz(robot.d[i]))
        if robot.a[i]:
            parts.append(ET.tx(robot.a[i]))
        if robot.alpha[i]:
            parts.append(ET.Rx(robot.alpha[i]))
    chain = parts[0]
    for part in parts[1:]:
        chain = chain * part
    return chain


def pose(robot: BenchRobot, urdf_path: str) -> Solver:
    ik = _transforms(robot).ik_LM

    def solve(target: Array, start: Array) -> Any:
        result = ik(target, q0=start, tol=1e-12, method="chan", k=0.1)
        return result.q if result.success else None

    return Solver(solve, "ik_LM(method='chan', k=0.1, tol=1e-12), 30 iterations, 100 searches")


def position(robot: BenchRobot, urdf_path: str, tolerance_m: float) -> Solver:
    ik = _transforms(robot).ik_LM
    mask = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    tol = 0.5 * tolerance_m**2  # its test is on half the squared, weighted error

    def solve(target: Array, start: Array) -> Any:
        result = ik(target, q0=start, tol=tol, mask=mask, method="chan", k=0.1)
        return result.q if result.success else None

    return Solver(solve, "ik_LM(method='chan', k=0.1), mask of the position, tol = tolerance^2/2")


def fk(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return Evaluation(_transforms(robot).eval, "ETS.eval", np.asarray)


def fk_batch(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return fk(robot, urdf_path)


def jacobian(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return Evaluation(_transforms(robot).jacob0, "ETS.jacob0")
