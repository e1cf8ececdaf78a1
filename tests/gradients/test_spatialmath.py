"""Poses of spatialmath."""

from __future__ import annotations

import numpy as np
from spatialmath import SE3

import agrik_fast as ik

UR5 = ik.Robot.load("ur5")
POSES = UR5.fk(UR5.random_q(20, seed=1))


def test_poses_are_targets() -> None:
    one = UR5.ik(SE3(POSES[0]))
    np.testing.assert_array_equal(one.q, UR5.ik(POSES[0]).q)
    assert one.q.shape == (6,)
    wanted = UR5.ik(POSES).q
    np.testing.assert_array_equal(UR5.ik(SE3(list(POSES))).q, wanted)
    np.testing.assert_array_equal(UR5.ik([SE3(pose) for pose in POSES]).q, wanted)
