"""What each task fixes and what it leaves free, checked by a separate NumPy FK."""

from __future__ import annotations

import numpy as np
import pytest

import agrik_fast as ik
import numpy_fk
from agrik_fast.tasks import Axis, Masked

DOWN = np.array([0.0, 0.0, -1.0])


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle of unit vectors (..., 3), rad, accurate near 0."""
    cross = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.arctan2(cross, (a * b).sum(-1))


def solved(name: str, targets: np.ndarray, task: object) -> tuple[ik.IkResult, np.ndarray]:
    """The result and the poses it reaches; every target must be solved within the limits."""
    arm = ik.Robot.load(name)
    result = arm.ik(targets, task)  # type: ignore[arg-type]
    assert result.success.all()
    assert ((result.q >= arm.lower) & (result.q <= arm.upper)).all()
    return result, numpy_fk.fk(name, result.q)


def test_the_cucumber_gripper_points_down_with_a_free_azimuth() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform([0.5, -0.2, 0.9], [0.7, 0.2, 1.1], (200, 3))
    _, reached = solved("cucumber", points, Axis(tool_axis=(1, 0, 0), direction=(0, 0, -1)))
    assert np.linalg.norm(reached[:, :3, 3] - points, axis=-1).max() <= 1e-6
    assert angle_between(reached[:, :3, 0], np.broadcast_to(DOWN, (200, 3))).max() <= 1e-6


def test_an_axis_task_takes_the_direction_from_poses() -> None:
    poses = ik.Robot.load("ur5").fk(ik.Robot.load("ur5").random_q(200, seed=1))
    tilted = np.array([0.6, 0.0, 0.8])
    _, reached = solved("ur5", poses, Axis(tool_axis=(0.6, 0.0, 0.8)))
    assert np.linalg.norm((reached - poses)[:, :3, 3], axis=-1).max() <= 1e-6
    assert angle_between(reached[:, :3, :3] @ tilted, poses[:, :3, :3] @ tilted).max() <= 1e-6
    _, turn = numpy_fk.pose_error(reached, poses)
    assert np.median(turn) > 0.1  # free about the axis


def test_the_direction_of_a_task_goes_before_the_poses() -> None:
    arm = ik.Robot.load("panda")
    poses = arm.fk(arm.random_q(50, seed=2))
    task = Axis(direction=(0, 0, -1))
    result = arm.ik(poses, task)
    np.testing.assert_array_equal(result.q, arm.ik(poses[:, :3, 3], task).q)
    reached = numpy_fk.fk("panda", result.q[result.success])
    assert result.success.sum() > 25
    assert angle_between(reached[:, :3, 2], np.broadcast_to(DOWN, (len(reached), 3))).max() <= 1e-6


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_a_mask_of_positions_is_a_position_task(frame: str) -> None:
    arm = ik.Robot.load("hydrolek")
    poses = arm.fk(arm.random_q(100, seed=3))
    _, reached = solved("hydrolek", poses, Masked((1, 1, 1, 0, 0, 0), frame=frame))  # type: ignore[arg-type]
    assert np.linalg.norm((reached - poses)[:, :3, 3], axis=-1).max() <= 1e-6


def test_a_mask_in_the_base_frame_frees_its_rows() -> None:
    arm = ik.Robot.load("redundant7")
    poses = arm.fk(arm.random_q(100, seed=4))
    _, reached = solved("redundant7", poses, Masked((1, 0, 1, 0, 0, 0)))
    off = np.abs((reached - poses)[:, :3, 3])
    assert np.hypot(off[:, 0], off[:, 2]).max() <= 1e-6
    assert np.median(off[:, 1]) > 0.01


def test_a_mask_in_the_tool_frame_frees_the_turn_about_the_tool() -> None:
    arm = ik.Robot.load("redundant7")
    poses = arm.fk(arm.random_q(100, seed=5))
    _, reached = solved("redundant7", poses, Masked((1, 1, 1, 1, 1, 0), frame="tool"))
    assert np.linalg.norm((reached - poses)[:, :3, 3], axis=-1).max() <= 1e-6
    # Two of three components of the rotation vector are nil: it lies along the tool's z.
    turn = np.swapaxes(reached[:, :3, :3], -1, -2) @ poses[:, :3, :3]
    assert angle_between(turn[..., :, 2], np.broadcast_to(-DOWN, (100, 3))).max() <= 2e-6


def test_weights_do_not_change_what_counts_as_reached() -> None:
    arm = ik.Robot.load("ur5")
    poses = arm.fk(arm.random_q(100, seed=6))
    _, reached = solved("ur5", poses, Masked((1, 1, 1, 0.01, 0.01, 0.01)))
    position, turn = numpy_fk.pose_error(reached, poses)
    assert position.max() <= 1e-6
    assert turn.max() <= 1e-6


def test_a_half_turn_is_solved() -> None:
    arm = ik.Robot.load("redundant7")
    q = arm.random_q(100, seed=7)
    flipped = arm.fk(q) @ np.diag([1.0, -1.0, -1.0, 1.0])
    reachable = arm.ik(flipped)
    result = arm.ik(flipped, q0=q)  # starts at an orientation error of exactly pi
    assert reachable.success.mean() > 0.3
    np.testing.assert_array_equal(result.success, reachable.success)
    assert (result.position_error[result.success] <= 1e-6).all()
