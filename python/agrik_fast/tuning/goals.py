"""Goal sets: tool points drawn from a stream that is the same everywhere.

The stream is SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number
generators", 2014), so that other programs can draw the same goals.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, real_number, whole_number
from ..robot import Robot

__all__ = [
    "joint_uniform",
    "joint_uniform_poses",
    "joint_uniform_q",
    "splitmix64",
    "volume_uniform",
]

_MASK = 2**64 - 1
_GAMMA = 0x9E3779B97F4A7C15


def splitmix64(seed: int, count: int) -> FloatArray:
    """Return the first numbers of a stream.

    Parameters
    ----------
    seed : int
        0 to 2**64 - 1.
    count : int
        How many, >= 0.

    Returns
    -------
    ndarray, shape (count,)
        Numbers in [0, 1) with 53 random bits.
    """
    seed = whole_number("seed", seed, 0, _MASK)
    index = np.arange(1, whole_number("count", count, 0) + 1, dtype=np.uint64)
    z: NDArray[np.uint64] = index * np.uint64(_GAMMA) + np.uint64(seed)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z ^= z >> np.uint64(31)
    return (z >> np.uint64(11)).astype(np.float64) * 2.0**-53


def joint_uniform_q(robot: Robot, count: int, seed: int) -> FloatArray:
    """Return joint values uniform in the limits, shape (count, n), rad or m.

    Row by row, joint by joint from one stream; continuous joints in [-pi, pi).
    """
    lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    u = splitmix64(seed, whole_number("count", count, 0) * robot.dof)
    drawn: FloatArray = lower + (upper - lower) * u.reshape(-1, robot.dof)
    return drawn


def joint_uniform(robot: Robot, count: int, seed: int) -> FloatArray:
    """Return tool points at postures uniform in the limits, shape (count, 3), m."""
    return robot.fk(joint_uniform_q(robot, count, seed))[:, :3, 3]


def joint_uniform_poses(robot: Robot, count: int, seed: int) -> FloatArray:
    """Return poses at postures uniform in the limits, shape (count, 4, 4), m."""
    return robot.fk(joint_uniform_q(robot, count, seed))


def volume_uniform(
    robot: Robot, count: int, seed: int, *, draws: int = 200_000, voxel_m: float = 0.04
) -> FloatArray:
    """Return tool points spread evenly over the workspace.

    Parameters
    ----------
    robot : Robot
        The arm.
    count : int
        How many points, >= 1.
    seed : int
        Seed of the stream.
    draws : int
        Postures that the workspace is explored with.
    voxel_m : float
        Edge of the cubes, m, of which every n-th gives its first point.

    Returns
    -------
    ndarray, shape (count, 3)
        Points, m; each is the tool point of a posture within the limits.
    """
    count = whole_number("count", count, 1)
    draws = whole_number("draws", draws, 1)
    voxel_m = real_number("voxel_m", voxel_m, 0, open_low=True, unit="m")
    points = joint_uniform(robot, draws, seed)
    _, first = np.unique(np.floor(points / voxel_m), axis=0, return_index=True)
    first = np.sort(first)
    return points[first[np.arange(count) * len(first) // count]]
