"""Every branch of arms with a closed form: this library against EAIK.

EAIK (C++) solves by subproblem decomposition; it gets each arm as axes in space, read off
the library's forward kinematics, which Pinocchio vouches for.
"""

from pathlib import Path

import numpy as np
import pytest
from eaik.IK_HP import HPRobot

import agrik_fast as ik
from branch_arms import of_reference, reference

DATA = Path(__file__).parent.parent / "data"
POSES = 2000
ROUNDING = 1e-6  # rad: between two solvers, near singular postures included


REFERENCE = reference()["six"]


def load(name: str) -> ik.Robot:
    if name in REFERENCE:
        return of_reference(REFERENCE[name], np.pi)
    path = DATA / f"{name}.urdf"
    return ik.Robot.load(path if path.exists() else name)


def axes_of(arm: ik.Robot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Axes (dof, 3), way from point to point on them (dof + 1, 3), tool's home rotation."""
    home = arm.fk(np.zeros(arm.dof))
    axes, points = [], [np.zeros(3)]
    for joint in range(arm.dof):
        quarter = np.zeros(arm.dof)
        quarter[joint] = np.pi / 2
        moved = arm.fk(quarter) @ np.linalg.inv(home)
        turn = moved[:3, :3]
        axes.append(
            np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
            / 2
        )
        # A point of the axis stays where it is.
        points.append(np.linalg.lstsq(np.eye(3) - turn, moved[:3, 3], rcond=1e-9)[0])
    points.append(home[:3, 3])
    return np.round(axes, 12), np.diff(np.round(points, 12), axis=0), home[:3, :3]


def apart(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Largest angle between joint values, whole turns aside."""
    off = q - other
    return np.abs(off - 2 * np.pi * np.round(off / (2 * np.pi))).max(axis=-1)


@pytest.mark.parametrize("name", ["puma560", "irb140", "kr16", "ur5", "ur5e", "z1"])
def test_as_many_branches_as_eaik_and_the_same_ones(name: str) -> None:
    arm = load(name)
    axes, ways, home = axes_of(arm)
    peer = HPRobot(axes, ways)
    assert peer.hasKnownDecomposition()
    targets = arm.fk(arm.random_q(POSES, seed=11))
    ours = arm.ik_all(targets)
    counts = []
    for target, q, reached in zip(targets, ours.q, ours.reached, strict=True):
        wanted = target.copy()
        wanted[:3, :3] = target[:3, :3] @ home.T
        found = peer.IK(wanted)
        theirs = np.asarray(found.Q)[~np.asarray(found.is_LS, bool)]
        # EAIK counts branches twice that meet; here each counts once.
        distinct = [a for i, a in enumerate(theirs) if not (apart(theirs[:i], a) < ROUNDING).any()]
        counts.append((int(reached.sum()), len(distinct)))
        between = apart(q[reached][:, None], np.array(distinct)[None])
        assert between.min(axis=1).max() < ROUNDING
        assert between.min(axis=0).max() < ROUNDING
    mine, peers = np.transpose(counts)
    assert (mine == peers).all()
    assert mine.max() == 8
