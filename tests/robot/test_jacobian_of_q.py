"""How answers follow their targets and the numbers of the arm, against finite differences."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import tasks

STEP = 1e-4
TIGHT: dict[str, Any] = {"position_tolerance": 1e-12, "orientation_tolerance": 1e-11}


def turned(axis: int, angle: float) -> np.ndarray[Any, Any]:
    return ik.rotations.pose((0, 0, 0), axis_angle=angle * np.eye(3)[axis])[:3, :3]


def displaced(targets: np.ndarray[Any, Any], j: int, step: float) -> np.ndarray[Any, Any]:
    """Targets, moved along or turned about an axis of the base frame."""
    moved = targets.copy()
    if targets.shape[-1] == 3:
        moved[..., j] += step
    elif j < 3:
        moved[..., j, 3] += step
    else:
        moved[..., :3, :3] = turned(j - 3, step) @ moved[..., :3, :3]
    return moved


def middle(robot: str, count: int = 12) -> np.ndarray[Any, Any]:
    """Postures well within the limits and away from singularities."""
    arm = ik.Robot.load(robot)
    q = arm.random_q(40 * count, seed=4)
    low, high = np.maximum(arm.lower, -3), np.minimum(arm.upper, 3)
    q = low + (high - low) * (0.2 + 0.6 * (q - q.min(0)) / np.ptp(q, axis=0))
    least = np.linalg.svd(arm.jacobian(q), compute_uv=False).min(-1)
    return q[np.argsort(-least)[:count]]


CASES = {
    "ur5": ("ur5", "pose"),
    "puma560": ("puma560", "pose"),
    "slide and six joints": ("cucumber", "pose"),
    "points": ("ur5", "position"),
    "poses of which the point counts": ("puma560", tasks.Position()),
    "axis": ("ur5", tasks.Axis(tool_axis=(0, 0.6, 0.8))),
    "mask of the tool": ("puma560", tasks.Masked((1, 1, 1, 2, 0, 1), "tool")),
    "mask of the base": ("puma560", tasks.Masked((1, 0, 1, 1, 1, 0.5), "base")),
}


@pytest.mark.parametrize("case", CASES)
def test_targets_that_move(case: str) -> None:
    name, task = CASES[case]
    arm = ik.Robot.load(name)
    q = middle(name)
    targets = arm.fk(q)
    if task == "position":
        targets = targets[:, :3, 3]
    result = arm.ik(targets, task=task, q0=q, **TIGHT)
    assert result.success.all()
    follows = result.jacobian_of_q()
    assert follows.shape == (len(q), arm.dof, 3 if task == "position" else 6)
    for j in range(follows.shape[-1]):
        ends = [
            arm.ik(displaced(targets, j, sign * STEP), task=task, q0=result.q, **TIGHT)
            for sign in (1, -1)
        ]
        assert all(end.success.all() for end in ends)
        change = (ends[0].q - ends[1].q) / (2 * STEP)
        if arm.dof == 6 and task == "pose":
            np.testing.assert_allclose(follows[..., j], change, rtol=0, atol=1e-5)
        # A redundant arm's answer is any near the first one: compare what the task sees.
        moved = arm.jacobian(result.q) @ (follows[..., j] - change)[..., None]
        assert np.abs(task_rows(arm, result.q, task) @ moved).max() < 1e-6


def task_rows(arm: ik.Robot, q: np.ndarray[Any, Any], task: Any) -> np.ndarray[Any, Any]:
    """Rows of a twist that a task counts."""
    rows = np.tile(np.eye(6), (len(q), 1, 1))
    R = arm.fk(q)[:, :3, :3]
    if task == "position" or isinstance(task, tasks.Position):
        rows[:, 3:] = 0
    elif isinstance(task, tasks.Axis):
        axis = R @ np.asarray(task.tool_axis)
        rows[:, 3:, 3:] -= axis[:, :, None] * axis[:, None, :]
    elif isinstance(task, tasks.Masked):
        if task.frame == "tool":
            rows[:, :3, :3] = rows[:, 3:, 3:] = R.transpose(0, 2, 1)
        rows *= (np.asarray(task.weights) > 0)[:, None]
    return rows


def test_the_smallest_change_that_keeps_up() -> None:
    arm = ik.Robot.load("panda")
    result = arm.ik(arm.fk(middle("panda")), q0=middle("panda"))
    np.testing.assert_allclose(
        result.jacobian_of_q(), np.linalg.pinv(arm.jacobian(result.q)), rtol=0, atol=1e-8
    )
    points = arm.ik(arm.fk(middle("panda"))[:, :3, 3])
    wanted = np.linalg.pinv(arm.jacobian(points.q)[:, :3])
    np.testing.assert_allclose(points.jacobian_of_q(), wanted, rtol=0, atol=1e-8)


def test_directions_that_are_lost_are_left_out() -> None:
    arm = ik.Robot.load("puma560")
    # The wrist's first and last axis are in line.
    q = np.array([0.3, 0.5, -0.6, 0.2, 0.0, 0.4])
    result = arm.ik(arm.fk(q), q0=q)
    np.testing.assert_array_equal(result.q, q)
    follows = result.jacobian_of_q()
    assert np.isfinite(follows).all() and np.abs(follows).max() < 1e3
    # What the arm can do is undone by what it answers.
    can = arm.jacobian(q)
    np.testing.assert_allclose(can @ follows @ can, can, rtol=0, atol=1e-9)
    np.testing.assert_allclose(follows @ can @ follows, follows, rtol=0, atol=1e-9)
    assert np.linalg.matrix_rank(follows, tol=1e-6) == 5


def test_a_pose_for_five_joints() -> None:
    arm = ik.Robot.load("strawberry")
    q = arm.random_q(20, seed=2)
    result = arm.ik(arm.fk(q), q0=q)
    assert result.success.all()
    can = arm.jacobian(result.q)
    np.testing.assert_allclose(
        result.jacobian_of_q() @ can, np.tile(np.eye(5), (20, 1, 1)), atol=1e-6
    )


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_rows_of_the_arm_that_change(convention: Any) -> None:
    rows = np.array(
        [
            [0.02, 1.4, 0.3, 0.1],
            [0.4, 0.1, 0.05, 0],
            [0.3, -1.2, 0, 0.2],
            [0.03, 1.5, 0.2, 0],
            [0.01, -1.5, 0.1, 0],
            [0.02, 0.3, 0.1, 0.3],
        ]
    )
    tool = ik.rotations.pose((0.01, 0.02, 0.1), rpy=(0.1, 0.2, 0.3))
    base = ik.rotations.pose((0.3, 0.2, 0.1), rpy=(0.3, 0.2, 0.3))

    def arm_of(numbers: np.ndarray[Any, Any]) -> ik.Robot:
        return ik.Robot.from_dh(numbers, convention, tool=tool, base=base)

    arm = arm_of(rows)
    q = arm.random_q(200, seed=5)
    least = np.linalg.svd(arm.jacobian(q), compute_uv=False).min(-1)
    q = q[np.argsort(-least)[:6]]
    behind = ik.rotations.pose((0, 0.05, 0.02), rpy=(0, 0.5, 0))
    targets = arm.fk(q) @ behind
    result = arm.ik(targets, q0=q, tool=behind, **TIGHT)
    follows = result.jacobian_of_q("dh")
    assert follows.shape == (6, 6, 6, 4)
    for row, column in np.ndindex(6, 4):
        step = np.zeros_like(rows)
        step[row, column] = STEP
        ends = [
            arm_of(rows + sign * step).ik(targets, q0=result.q, tool=behind, **TIGHT)
            for sign in (1, -1)
        ]
        assert all(end.success.all() for end in ends)
        change = (ends[0].q - ends[1].q) / (2 * STEP)
        np.testing.assert_allclose(follows[..., row, column], change, rtol=3e-6, atol=1e-5)


def test_a_row_has_the_derivatives_of_the_batch_whatever_the_threads() -> None:
    arm = ik.Robot.load("redundant7")
    targets = arm.fk(arm.random_q(3000, seed=6)).reshape(2, 1500, 4, 4)
    result = arm.ik(targets)
    follows = result.jacobian_of_q()
    assert follows.shape == (2, 1500, 7, 6)
    before = ik.get_num_threads()
    try:
        ik.set_num_threads(1)
        np.testing.assert_array_equal(result.jacobian_of_q(), follows)
    finally:
        ik.set_num_threads(before)
    np.testing.assert_array_equal(result[1, 7].jacobian_of_q(), follows[1, 7])
    np.testing.assert_array_equal(result[:, 3:9].jacobian_of_q(), follows[:, 3:9])
    missed = arm.ik([[0.3, 0.2, 0.4], [9.0, 0, 0]]).jacobian_of_q()
    assert missed[0].any() and not missed[1].any()


def test_one_direction_for_all_does_not_turn_with_the_targets() -> None:
    arm = ik.Robot.load("ur5")
    task = tasks.Axis(direction=(0, 0, -1))
    poses = arm.fk(middle("ur5"))
    follows = arm.ik(poses, task=task).jacobian_of_q()
    assert not follows[..., 3:].any() and follows[..., :3].any()
    assert arm.ik(poses[:, :3, 3], task=task).jacobian_of_q().shape == (12, 6, 3)


def test_what_has_no_derivatives_is_said() -> None:
    arm = ik.Robot.load("ur5")
    result = arm.ik(arm.fk(middle("ur5")))
    with pytest.raises(ik.ArgumentError, match="one that was pickled"):
        pickle.loads(pickle.dumps(result)).jacobian_of_q()
    with pytest.raises(ik.UnknownNameError, match="unknown wrt 'T'"):
        result.jacobian_of_q("T")  # type: ignore[arg-type]
    with pytest.raises(ik.ArgumentError, match="not made from DH rows"):
        ik.Robot.load("tomato").ik([[0.2, 0.1, 0.3]]).jacobian_of_q("dh")
    first = arm.ik(arm.fk(middle("ur5")), task=tasks.PositionFirst())
    with pytest.raises(ik.ArgumentError, match="position-first"):
        first.jacobian_of_q()
