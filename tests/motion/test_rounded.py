"""Rounded corners: as far as they are proven, and no farther."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import motion
from agrik_fast.collision import Capsule, Scene, SceneObject
from agrik_fast.errors import ArgumentError

LoadRobot = Callable[[str], ik.Robot]
POST = Scene([SceneObject.of("post", Capsule([0.5, 0, 0], [0.5, 0, 1], 0.05))])
START = np.array([-1, 0, 0, -1.5, 0, 1.5, 0])
GOAL = np.array([1, 0, 0, -1.5, 0, 1.5, 0])


def test_curves_inside_proven_corners_are_free(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    plan = motion.plan(arm, START, GOAL, POST)
    way = motion.rounded(arm, plan, POST, clear=0.002)
    assert way.blends is not None and (way.blends[1:-1] > 0).any()
    assert motion.check(arm, way, POST, clear=0.002).safe
    t = np.linspace(0, 1, 60)[:, None]
    for k in np.flatnonzero(way.blends[1:-1] > 0) + 1:
        corner, width = way.q[k], way.blends[k]
        a = corner + width / way.lengths[k - 1] * (way.q[k - 1] - corner)
        b = corner + width / way.lengths[k] * (way.q[k + 1] - corner)
        curve = (1 - t) ** 2 * a + 2 * t * (1 - t) * corner + t * t * b
        assert not POST.collides(arm, curve, clear=0.002).any()
    motion_of = motion.time_law(arm, way)
    q = motion_of.positions
    assert not POST.collides(arm, q, clear=0.002).any()
    # Corners that are hardly rounded may cost a little more than stops.
    assert motion_of.duration < 1.02 * motion.time_law(arm, plan.path).duration


def test_corners_that_are_not_proven_are_not_safe(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    plan = motion.plan(arm, START, GOAL, POST)
    smooth = arm.joint_path(plan.path, smooth=True)
    with pytest.raises(ArgumentError, match="smooth"):
        motion.check(arm, smooth, POST)
    with pytest.raises(ArgumentError, match="blend"):
        motion.rounded(arm, plan, POST, blend=0.7)
    straight = motion.rounded(arm, plan.path[:2], POST)
    assert straight.blends is not None and not straight.blends.any()
