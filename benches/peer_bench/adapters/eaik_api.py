"""EAIK (C++): closed form, every solution; only for arms whose geometry it knows."""

from __future__ import annotations

from typing import Any

import numpy as np
from eaik.IK_HP import HPRobot

from ..robots import BenchRobot, product_of_exponentials
from . import Array, Solver

DISTRIBUTION = "eaik"


def pose(robot: BenchRobot, urdf_path: str) -> Solver | None:
    if robot.dof != 6:
        return None
    axes, offsets, home = product_of_exponentials(robot)
    arm = HPRobot(axes, offsets)
    if not arm.hasKnownDecomposition():
        return None

    def prepare(target: Array) -> Array:
        # EAIK's tool frame has no home rotation; take ours out of the target.
        out = target.copy()
        out[:3, :3] = target[:3, :3] @ home.T
        return out

    def solve(target: Array, start: Array) -> Any:
        return np.asarray(arm.IK(target).Q)

    def count(target: Array) -> int:
        # Least-squares answers stand in for solutions that do not exist.
        return int((~np.asarray(arm.IK(target).is_LS, bool)).sum())

    return Solver(
        solve, "closed form, every solution", prepare=prepare, every_solution=True, count=count
    )


def closed_form(robot: BenchRobot, urdf_path: str) -> Solver | None:
    return pose(robot, urdf_path)
