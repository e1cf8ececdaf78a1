"""Poses from every form of an orientation, back again, and straightened."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from agrik_fast import ArgumentError, euler, rotations

POINT = np.array([0.1, -0.2, 0.3])
FORMS = ("quat", "rpy", "zyz", "axis_angle")


def turns(count: int = 200) -> Rotation:
    return Rotation.random(count, random_state=3)


def as_form(turn: Rotation, form: str) -> np.ndarray:
    if form == "quat":
        return turn.as_quat()
    if form == "axis_angle":
        return turn.as_rotvec()
    return turn.as_euler("xyz" if form == "rpy" else "ZYZ")


def back(poses: np.ndarray, form: str) -> np.ndarray:
    found = getattr(rotations, f"{form}_of")(poses)
    return found.angles if form in ("rpy", "zyz") else found


@pytest.mark.parametrize("form", FORMS)
def test_poses_are_scipys(form: str) -> None:
    turn = turns()
    found = rotations.pose(POINT, **{form: as_form(turn, form)})
    assert found.shape == (200, 4, 4)
    np.testing.assert_allclose(found[:, :3, :3], turn.as_matrix(), atol=4e-15)
    np.testing.assert_array_equal(found[:, :3, 3], np.tile(POINT, (200, 1)))
    np.testing.assert_array_equal(found[:, 3], np.tile([0.0, 0.0, 0.0, 1.0], (200, 1)))
    np.testing.assert_array_equal(rotations.position_of(found), np.tile(POINT, (200, 1)))


@pytest.mark.parametrize("form", FORMS)
def test_there_and_back(form: str) -> None:
    turn = turns()
    numbers = back(rotations.pose(POINT, quat=turn.as_quat()), form)
    again = rotations.pose(POINT, **{form: numbers})
    np.testing.assert_allclose(again[:, :3, :3], turn.as_matrix(), atol=4e-15)
    # A rotation without a position will do.
    np.testing.assert_allclose(back(turn.as_matrix(), form), numbers, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 1e-8, 1e-4, np.pi - 1e-9, np.pi])
def test_small_and_half_turns(angle: float) -> None:
    vector = angle * np.array([1.0, 2.0, -2.0]) / 3
    found = rotations.axis_angle_of(rotations.pose(POINT, axis_angle=vector))
    np.testing.assert_allclose(found, vector, atol=2e-15)


@given(st.lists(st.floats(-10, 10), min_size=3, max_size=3))
def test_any_rotation_vector_is_a_rotation(vector: list[float]) -> None:
    matrix = rotations.pose(POINT, axis_angle=vector)[:3, :3]
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(matrix, Rotation.from_rotvec(vector).as_matrix(), atol=1e-14)


def test_leading_dimensions_broadcast() -> None:
    found = rotations.pose(np.zeros((4, 1, 3)), rpy=np.zeros((5, 3)))
    assert found.shape == (4, 5, 4, 4)
    assert rotations.pose(POINT).shape == (4, 4)
    np.testing.assert_array_equal(rotations.rotation_of(rotations.pose(POINT)), np.eye(3))
    assert rotations.quat_of(found).shape == (4, 5, 4)
    assert rotations.rpy_of(found).gimbal.shape == (4, 5)
    assert rotations.pose(np.zeros((0, 3)), quat=np.zeros((0, 4))).shape == (0, 4, 4)
    for empty in (np.zeros((0, 4, 4)), np.zeros((0, 3, 3))):
        assert rotations.quat_of(empty).shape == (0, 4)
        assert rotations.straighten(empty).pose.shape == empty.shape


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_gimbal_of_roll_and_yaw(pitch: float) -> None:
    given_pose = rotations.pose(POINT, rpy=[0.4, pitch, -0.9])
    angles, gimbal = rotations.rpy_of(given_pose)
    assert gimbal
    assert angles[0] == 0.0
    np.testing.assert_allclose(rotations.pose(POINT, rpy=angles), given_pose, atol=1e-9)
    assert not rotations.rpy_of(rotations.pose(POINT, rpy=[0.4, 0.9 * pitch, -0.9])).gimbal


@pytest.mark.parametrize("form", FORMS)
def test_rows_without_numbers_stay_alone(form: str) -> None:
    numbers = as_form(turns(5), form)
    numbers[2, 1] = np.nan
    poses = rotations.pose(POINT, **{form: numbers})
    bad = ~np.isfinite(poses).all(axis=(1, 2))
    assert bad.tolist() == [False, False, True, False, False]
    poses[2, :3, :3] = np.inf
    values = back(poses, form)
    assert np.isfinite(values[[0, 1, 3, 4]]).all()
    assert not np.isfinite(values[2]).any()


def test_wrong_arguments_are_named() -> None:
    with pytest.raises(ArgumentError, match="`rpy`: expected at most one orientation, got quat"):
        rotations.pose(POINT, quat=[0, 0, 0, 1], rpy=[0, 0, 0])
    with pytest.raises(ArgumentError, match=r"`quat`: expected shape \(\.\.\., 4\)"):
        rotations.pose(POINT, quat=[0, 0, 1])
    with pytest.raises(ArgumentError, match=r"`xyz`: expected shape \(\.\.\., 3\)"):
        rotations.pose([0, 0])
    with pytest.raises(ArgumentError, match=r"`quat\[1\]`: .* length one, got one of length 2"):
        rotations.pose(POINT, quat=[[0, 0, 0, 1], [0, 0, 0, 2]])
    with pytest.raises(ArgumentError, match="`zyz`: expected leading dimensions that broadcast"):
        rotations.pose(np.zeros((2, 3)), zyz=np.zeros((3, 3)))
    with pytest.raises(ArgumentError, match=r"`poses\[0, 1\]`: expected a rotation"):
        rotations.quat_of([[np.eye(3), np.eye(3).round(1) * 1.1]])
    with pytest.raises(ArgumentError, match="`poses`: expected a rotation"):
        rotations.rpy_of(np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(ArgumentError, match="`poses`: expected shape"):
        rotations.position_of(np.eye(3))
    with pytest.raises(ArgumentError, match="`tolerance`"):
        rotations.straighten(np.eye(3), tolerance=0.0)


@pytest.mark.parametrize("digits", [2, 3, 4, 6])
def test_rounded_rotations_are_straightened(digits: int) -> None:
    exact = turns(500).as_matrix()
    found = rotations.straighten(exact.round(digits))
    assert (found.reason == "ok").all()
    assert found.off.max() < 1.6 * 10.0**-digits
    np.testing.assert_allclose(
        found.pose @ np.swapaxes(found.pose, 1, 2), [np.eye(3)] * 500, atol=1e-14
    )
    # No rotation is nearer, the one that was rounded included.
    rough = exact.round(digits)
    distance = np.linalg.norm(found.pose - rough, axis=(1, 2))
    assert (distance <= np.linalg.norm(exact - rough, axis=(1, 2)) + 1e-15).all()
    rotations.quat_of(found.pose)


def test_straight_poses_stay_and_crooked_ones_are_told() -> None:
    poses = rotations.pose(np.arange(21.0).reshape(7, 3), quat=turns(7).as_quat())
    rough = poses.copy()
    rough[1, 0, 0] = np.nan
    rough[2, 3, 0] = 0.5
    rough[3, :3, :3] *= 1.1
    rough[4, :3, 0] *= -1.0
    rough[5, :3, 2] = 0.0
    rough[6, 0, 3] = np.inf
    found = rotations.straighten(rough)
    reasons = ["ok", "not finite", "last row", "too far", "mirrored", "too far", "not finite"]
    assert found.reason.tolist() == reasons
    np.testing.assert_allclose(found.pose[0], poses[0], atol=1e-15)
    np.testing.assert_array_equal(found.pose[0, :, 3], poses[0, :, 3])
    assert np.isnan(found.pose[1:]).all()
    np.testing.assert_allclose(found.off[[3, 5]], [0.1, 1.0], atol=1e-12)
    wide = rotations.straighten(rough[3], tolerance=0.2)
    assert wide.reason == "ok"
    np.testing.assert_allclose(wide.pose, poses[3], atol=1e-14)


def test_euler_is_the_same_under_its_former_names() -> None:
    angles = turns(20).as_euler("ZYZ")
    poses = euler.pose_from_zyz(POINT, angles)
    np.testing.assert_array_equal(poses, rotations.pose(POINT, zyz=angles))
    np.testing.assert_array_equal(euler.rotation_from_zyz(angles), poses[:, :3, :3])
    np.testing.assert_array_equal(euler.zyz_from_pose(poses).angles, rotations.zyz_of(poses).angles)
    assert euler.ZyzAngles is rotations.EulerAngles
