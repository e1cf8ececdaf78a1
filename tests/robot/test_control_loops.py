"""Control loops: postures never jump, targets out of reach are followed, re-entry is quick."""

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import Status
from agrik_fast.errors import ArgumentError

ARMS = ("strawberry", "cucumber", "hydrolek", "tomato", "redundant7", "puma560", "ur5", "panda")
MOST = 0.02


def targets_of(arm, rng, ticks):
    """Return targets of a random drive: joint paths through limits, out of reach and back.

    With them, which targets belong to a joint path, so that they can be reached.
    """
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    poses, reachable = [], []
    q = rng.uniform(lower, upper)
    begin = q
    while len(poses) < ticks:
        to = rng.uniform(lower, upper)
        steps = int(np.ceil((abs(to - q) / (0.4 * MOST)).max()))
        path = q + np.linspace(0, 1, steps + 1)[1:, None] * (to - q)
        there = arm.fk(path)
        inside = np.ones(steps, dtype=bool)
        if rng.random() < 0.5:
            # A bump to beyond the reach, and back to the path.
            first, last = np.sort(rng.integers(0, steps, 2))
            way = rng.normal(size=3)
            way *= 3 * arm.reach_radius / np.linalg.norm(way)
            share = np.sin(np.linspace(0, np.pi, last - first + 1)) ** 2
            there[first : last + 1, :3, 3] += share[:, None] * way
            inside[first : last + 1] = False
        poses.append(there)
        reachable.append(inside)
        q = to
    return begin, np.concatenate(poses)[:ticks], np.concatenate(reachable)[:ticks]


def drive(arm, seed, ticks, most=MOST):
    """Return postures, statuses and reachability of a random drive."""
    rng = np.random.default_rng(seed)
    q, poses, reachable = targets_of(arm, rng, ticks)
    loop = arm.solver(max_change=most)
    postures, statuses = [q], []
    for k, pose in enumerate(poses):
        loop.solve(pose, q if k == 0 else None)
        postures.append(loop.q)
        statuses.append(loop.status)
    return np.array(postures), np.array(statuses), reachable, poses
