"""Goal sets: tool points drawn from a stream that is the same everywhere.

The stream is SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number
generators", 2014), so that other programs can draw the same goals.
"""

from __future__ import annotations

import numpy as np

from .._checks import FloatArray, real_number, whole_number
from .._splitmix import uniform
from ..robot import Robot

__all__ = [
    "joint_uniform",
    "joint_uniform_poses",
    "joint_uniform_q",
    "splitmix64",
    "volume_uniform",
]


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

    Examples
    --------
    >>> from agrik_fast.tuning import goals
    >>> goals.splitmix64(seed=1, count=2).round(6)
    array([0.566562, 0.745782])
    """
    seed = whole_number("seed", seed, 0, 2**64 - 1)
    return uniform(seed, 0, whole_number("count", count, 0))


def joint_uniform_q(robot: Robot, count: int, seed: int) -> FloatArray:
    """Return joint values uniform in the limits, shape (count, n), rad or m.

    Row by row, joint by joint from one stream; continuous joints in [-pi, pi).

    Examples
    --------
    >>> from agrik_fast.tuning import goals
    >>> goals.joint_uniform_q(ik.Robot.load("ur5"), 10, seed=1).shape
    (10, 6)
    """
    lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    u = splitmix64(seed, whole_number("count", count, 0) * robot.dof)
    drawn: FloatArray = lower + (upper - lower) * u.reshape(-1, robot.dof)
    return drawn


def joint_uniform(robot: Robot, count: int, seed: int) -> FloatArray:
    """Return tool points at postures uniform in the limits, shape (count, 3), m.

    Examples
    --------
    >>> from agrik_fast.tuning import goals
    >>> goals.joint_uniform(ik.Robot.load("ur5"), 10, seed=1).shape
    (10, 3)
    """
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

    Examples
    --------
    >>> from agrik_fast.tuning import goals
    >>> goals.volume_uniform(ik.Robot.load("tomato"), 10, seed=1, draws=20_000).shape
    (10, 3)
    """
    count = whole_number("count", count, 1)
    draws = whole_number("draws", draws, 1)
    voxel_m = real_number("voxel_m", voxel_m, 0, open_low=True, unit="m")
    points = joint_uniform(robot, draws, seed)
    _, first = np.unique(np.floor(points / voxel_m), axis=0, return_index=True)
    first = np.sort(first)
    return points[first[np.arange(count) * len(first) // count]]
