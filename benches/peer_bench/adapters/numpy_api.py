"""Plain NumPy FK (that of robots.py), the batch FK a user would write without a library."""

from __future__ import annotations

import numpy as np

from ..robots import BenchRobot
from . import Evaluation

DISTRIBUTION = "numpy"


def fk(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return Evaluation(robot.fk, "one 4x4 product a joint", np.asarray)


def fk_batch(robot: BenchRobot, urdf_path: str) -> Evaluation:
    return fk(robot, urdf_path)
