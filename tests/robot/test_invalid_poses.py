"""Poses that are no rigid transforms: straightened where rounding explains it, or marked."""

from __future__ import annotations

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import Status, Warnings

UR5 = ik.Robot.load("ur5")
POSES = UR5.fk(UR5.random_q(60, seed=1))


@pytest.mark.parametrize("decimals", [8, 6, 5, 4, 3])
def test_rounded_poses_are_solved_and_said_to_be_straightened(decimals: int) -> None:
    rounded = np.round(POSES, decimals)
    found = UR5.ik(rounded)
    assert found.success.all()
    straight = found.warnings == Warnings.STRAIGHTENED
    defect = np.abs(rounded[:, :3, :3].transpose(0, 2, 1) @ rounded[:, :3, :3] - np.eye(3))
    # Matrices that are rigid to 1e-6 are taken as they are.
    np.testing.assert_array_equal(straight, defect.max(axis=(1, 2)) > 1e-6)
    # The nearest rotation in place of each, which `straighten` gives as well.
    wanted = np.where(straight[:, None, None], ik.rotations.straighten(rounded).pose, rounded)
    np.testing.assert_allclose(UR5.fk(found.q), wanted, rtol=0, atol=3e-6)
    # As close to what was rounded as rounding can be.
    assert np.abs(UR5.fk(found.q) - POSES).max() < 2 * 10.0**-decimals + 1e-5


def test_what_rounding_does_not_explain_is_bad_input_and_its_neighbours_are_solved() -> None:
    poses = POSES[:8].copy()
    poses[1, :3, 0] *= 1.01
    poses[2, :3, 0] *= -1
    poses[3, 3, 0] = 1e-3
    poses[4, 0, 0] = np.nan
    poses[5] = 0
    for found in (UR5.ik(poses), UR5.ik(poses, solver="auto")):
        bad = [False, True, True, True, True, True, False, False]
        np.testing.assert_array_equal(found.status == Status.BAD_INPUT, bad)
        assert found.success[[0, 6, 7]].all()
        assert not found.warnings.any()
    straightened = UR5.ik(poses, invalid="straighten")
    assert straightened.success[1]
    assert straightened.warnings[1] == Warnings.STRAIGHTENED
    np.testing.assert_array_equal(straightened.status[[2, 3, 4, 5]], Status.BAD_INPUT)
    with pytest.raises(ik.ArgumentError, match=r"`targets\[1\]`: expected a rigid transform"):
        UR5.ik(poses, invalid="raise")
    with pytest.raises(ik.UnknownNameError, match="unknown invalid 'ignore'"):
        UR5.ik(poses, invalid="ignore")  # type: ignore[arg-type]


def test_a_row_alone_has_the_answer_of_the_batch() -> None:
    rounded = np.round(POSES, 4)
    rounded[7, :3, 1] *= 2
    whole = UR5.ik(rounded)
    for row, pose in enumerate(rounded):
        alone = UR5.ik(pose, first_index=row)
        np.testing.assert_array_equal(alone.q, whole.q[row])
        assert alone.warnings == whole.warnings[row]
    chunks = list(UR5.ik_stream([rounded[:11], rounded[11:]]))
    np.testing.assert_array_equal(np.concatenate([chunk.q for chunk in chunks]), whole.q)


def test_branches_say_so_too() -> None:
    puma = ik.Robot.load("puma560")
    poses = puma.fk(puma.random_q(9, seed=2))
    rounded = np.round(poses, 4)
    rounded[3, :3, :3] *= 3
    found = puma.ik_all(rounded)
    assert found.status[3] == Status.BAD_INPUT
    others = np.arange(9) != 3
    assert (found.warnings[others] & Warnings.STRAIGHTENED).all()
    assert found.valid[others].any(axis=1).all()
    alone = puma.ik_all(rounded[0])
    np.testing.assert_array_equal(alone.q, found.q[0])
    assert alone.warnings & Warnings.STRAIGHTENED
