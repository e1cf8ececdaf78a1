"""Every branch of arms with offset wrists: this library against ssik.

ssik (Python, C++) eliminates a pair of joints inside the arm, in a build of its own for each
arm; it gets the poses, and its arms are read off its forward kinematics.
"""

import numpy as np
import pytest
import ssik

from branch_arms import apart, read_off

POSES = 40
ARMS = (
    "jaco2_ik",
    "fanuc_crx10ia_ik",
    "xarm6_ik",
    "piper_ik",
    "gen3_lite_ik",
    "m1013_ik",
    "hc10_ik",
    "xmatecr7_ik",
    "ur5_ik",
    "ur5e_ik",
    "z1_ik",
    "puma560_ik",
)


@pytest.mark.parametrize("name", ARMS)
def test_the_same_branches_as_ssik(name: str) -> None:
    peer = ssik.Manipulator.from_prebuilt(name)
    arm = read_off(peer.fk)
    q = np.random.default_rng(17).uniform(-np.pi, np.pi, (POSES, 6))
    poses = arm.fk(q)
    assert np.abs(poses[0] - np.asarray(peer.fk(q[0]))).max() < 1e-10
    ours = arm.ik_all(poses)
    for i, pose in enumerate(poses):
        found = peer.solve(
            pose, respect_limits=False, allow_refinement=True, enumerate_windings=False
        )
        theirs = np.array([solution.q for solution in found])
        mine = ours.q[i][ours.reached[i]]
        far = apart(theirs[:, None], mine[None]).max(axis=2)
        assert far.min(axis=1).max() < 1e-3, "one of theirs is not ours"
        assert far.min(axis=0).max() < 1e-3, "one of ours is not theirs"
        assert len(mine) == len(theirs)
