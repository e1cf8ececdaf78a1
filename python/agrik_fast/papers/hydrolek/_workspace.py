"""The edge of a robot's workspace."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...robot import Robot
from ...tuning.goals import joint_uniform

VOXEL_M = 0.04
EXPLORED = 200_000
"""Postures that the workspace is explored with."""


class Edge:
    """The edge of a robot's workspace: cubes of 4 cm that have an empty neighbour."""

    def __init__(self, robot: Robot) -> None:
        cubes = np.floor(joint_uniform(robot, EXPLORED, 2) / VOXEL_M).astype(np.int64)
        self._low = cubes.min(axis=0) - 1
        shape = cubes.max(axis=0) + 2 - self._low
        full = np.zeros(shape, dtype=bool)
        full[tuple((cubes - self._low).T)] = True
        inside = full.copy()
        for axis in range(3):
            for side in (-1, 1):
                inside &= np.roll(full, side, axis=axis)
        self._inside = inside

    def holds(self, points: FloatArray) -> NDArray[np.bool_]:
        """Say which points, shape (n, 3), m, are at the edge."""
        cubes = np.floor(points / VOXEL_M).astype(np.int64) - self._low
        cubes = np.clip(cubes, 0, np.array(self._inside.shape) - 1)
        at_edge: NDArray[np.bool_] = ~self._inside[tuple(cubes.T)]
        return at_edge
