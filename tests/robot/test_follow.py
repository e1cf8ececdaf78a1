"""Paths: postures that continue one another, bounded steps, discontinuities that are told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.errors import ArgumentError
from numpy_fk import fk, pose_error

FROM = np.array([0.3, 0.5, -0.2, 1.0, 0.4, 0.8, 0.1])
TO = np.array([-1.2, 1.1, 0.7, 1.3, 1.0, 0.8, 1.5])


@pytest.fixture(scope="module")
def arm() -> ik.Robot:
    return ik.Robot.load("redundant7")


def line(arm: ik.Robot, steps: int) -> Any:
    share = np.linspace(0, 1, steps + 1)[1:, None]
    return arm.fk(FROM + share * (TO - FROM))


def test_a_path_is_followed_in_bounded_steps(arm: ik.Robot) -> None:
    poses = line(arm, 200)
    path = arm.follow(poses, FROM, 0.02)
    assert isinstance(path, ik.Path)
    assert path.success.all() and not path.discontinuity.any()
    assert np.abs(path.joint_step).max() <= 0.02
    np.testing.assert_allclose(path.joint_step, np.diff(path.q, axis=0, prepend=FROM[None]))
    position, orientation = pose_error(fk("redundant7", path.q), poses)
    assert position.max() <= 1e-6 + 1e-11
    assert orientation.max() <= 1e-6 + 1e-11
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
    assert repr(path) == "Path(200 targets: 200 reached, 0 discontinuities)"


def test_the_free_motion_is_kept_small(arm: ik.Robot) -> None:
    # Coarse steps: the posture nearest to the one before is not what a plain step finds.
    poses = line(arm, 6)
    pulled, plain = (arm.follow(poses, FROM, 1.0, pull=pull) for pull in (0.5, 0.0))
    length = [np.linalg.norm(path.joint_step, axis=1).sum() for path in (pulled, plain)]
    assert pulled.success.all() and plain.success.all()
    assert length[0] < length[1]


def test_a_path_too_fast_says_by_how_much(arm: ik.Robot) -> None:
    poses = line(arm, 40)
    path = arm.follow(poses, FROM, 0.001)
    assert path.success.all()
    assert not path.discontinuity.any()
    assert path.too_fast[1:].all() and not path.too_fast[0]
    np.testing.assert_allclose(path.speed[1:], abs(path.joint_step[1:]).max(1) / 0.001)
    assert "too fast by" in repr(path)
    poses[20:] = poses[20:][::-1]
    path = arm.follow(poses, FROM, 0.2)
    assert np.flatnonzero(path.too_fast | path.discontinuity)[0] == 20


def test_a_jump_to_another_branch_is_a_discontinuity() -> None:
    # The elbow has to turn over where its limit keeps it from doing so.
    arm = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], limits=[[-3, 3], [0.1, 2.5]])
    turns = np.linspace(1.0, 4.2, 200)
    points = np.stack([1.5 * np.cos(turns), 1.5 * np.sin(turns), 0 * turns], axis=1)
    path = arm.follow(points, arm.ik(points[0]).q, max_joint_step=0.05)
    assert path.discontinuity.any()


@pytest.mark.parametrize(
    "name",
    ["panda", "ur5", "puma560", "hydrolek", "redundant7", "xarm6", "xarm7", "fr3", "cucumber"],
)
def test_lines_in_joint_space_have_no_break(name: str) -> None:
    robot = ik.Robot.load(name)
    ends = robot.random_q(10, seed=12)
    for begin, end in zip(ends[::2], ends[1::2], strict=True):
        share = np.linspace(0, 1, 201)[1:, None]
        poses = robot.fk(begin + share * (end - begin))
        path = robot.follow(poses, begin, np.maximum(0.1, abs(end - begin) / 100))
        assert path.success.all() and not path.discontinuity.any()


def test_a_way_round_a_dead_end_keeps_to_the_steps() -> None:
    # Where the posture that is carried along comes to a limit, another way was open before.
    robot = ik.Robot.load("xarm7")
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    rng = np.random.default_rng(5)
    for _ in range(4):
        begin, end = rng.uniform(lower, upper, (2, 7))
        poses = robot.fk(begin + np.linspace(0, 1, 201)[1:, None] * (end - begin))
        most = np.maximum(0.1, 1.5 * abs(end - begin) / 200)
        path = robot.follow(poses, begin, most)
        assert path.success.all() and not path.discontinuity.any()
        assert (abs(path.joint_step) <= most).all()
        again = robot.follow(poses, begin, most)
        np.testing.assert_array_equal(path.q, again.q)


def test_without_start_values_the_start_is_one_whose_path_holds() -> None:
    robot = ik.Robot.load("ur5")
    for seed in range(6):
        begin, end = robot.fk(robot.random_q(2, seed=seed))
        poses = np.tile(begin, (100, 1, 1))
        way = 0.3 * (end[:3, 3] - begin[:3, 3])
        poses[:, :3, 3] += np.linspace(0, 1, 100)[:, None] * way
        if robot.follow(poses, max_joint_step=0.2).discontinuity.any():
            for start in range(12):
                first = robot.ik(poses[0], seed=start + 50)
                other = robot.follow(poses, first.q, max_joint_step=0.2)
                assert not first.success or other.discontinuity.any(), (seed, start)


def test_the_first_row_is_not_flagged_for_its_distance(arm: ik.Robot) -> None:
    path = arm.follow(line(arm, 20), FROM + 0.4, 0.1)
    assert path.success[0] and not path.discontinuity[0]


def test_start_values_a_hair_outside_are_taken() -> None:
    robot = ik.Robot.load("panda")
    q0 = robot.home.copy()
    q0[3] = robot.upper[3]
    poses = robot.fk(q0 - np.linspace(0, 0.2, 20)[:, None])
    q0[3] += 1e-9
    assert robot.follow(poses, q0, 0.1).success.all()
    q0[3] += 0.1
    with pytest.raises(ArgumentError, match=r"q0.*joint4.*within its limits"):
        robot.follow(poses, q0, 0.1)


def test_steps_may_differ_by_joint(arm: ik.Robot) -> None:
    limits = np.array([0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.02])
    path = arm.follow(line(arm, 200), FROM, limits)
    assert path.success.all()
    assert (np.abs(path.joint_step[~path.discontinuity]) <= limits).all()


def test_the_arm_waits_where_a_target_is_out_of_reach(arm: ik.Robot) -> None:
    poses = line(arm, 30)
    poses[10, :3, 3] = [5, 5, 5]
    poses[11, 0, 0] = np.nan
    path = arm.follow(poses, FROM, 0.3)
    assert path.status[[9, 10, 11, 12]].tolist() == [0, ik.Status.OUT_OF_REACH, 3, 0]
    np.testing.assert_array_equal(path.q[9], path.q[10])
    np.testing.assert_array_equal(path.q[9], path.q[11])
    assert np.flatnonzero(path.discontinuity).tolist() == [10, 11]


def test_points_a_free_beginning_and_nothing(arm: ik.Robot) -> None:
    points = line(arm, 50)[:, :3, 3]
    path = arm.follow(points, max_joint_step=0.1)
    assert path.success.all() and not path.discontinuity.any()
    assert not path.joint_step[0].any()
    np.testing.assert_array_equal(path.q, arm.follow(points, max_joint_step=0.1).q)
    empty = arm.follow(np.zeros((0, 4, 4)), FROM)
    assert empty.q.shape == (0, 7) and empty.joint_step.shape == (0, 7)


def test_continuous_joints_do_not_wind(load_robot: Any) -> None:
    planar = ik.Robot.from_dh([[1, 0, 0, 0], [0.5, 0, 0, 0]])
    turns = np.linspace(0, 4 * np.pi, 200)
    points = np.stack([1.2 * np.cos(turns), 1.2 * np.sin(turns), 0 * turns], axis=1)
    path = planar.follow(points, max_joint_step=0.2)
    assert path.success.all() and not path.discontinuity.any()
    assert abs(path.q[-1, 0] - path.q[0, 0] - 4 * np.pi) < 1e-3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"max_joint_step": 0.0}, "`max_joint_step`: expected finite numbers above 0"),
        ({"max_joint_step": [0.1] * 3}, r"`max_joint_step`: expected shape \(7,\)"),
        ({"q0": [9.0] * 7}, "`q0`: expected joint 'q?1' within its limits"),
        ({"q0": [0.0] * 6}, r"`q0`: expected shape \(7,\)"),
        ({"pull": 1.5}, "`pull`: expected a number, 0 to 1"),
        ({"targets": np.eye(4)}, "`targets`: expected a sequence of targets"),
    ],
)
def test_bad_arguments_are_named(arm: ik.Robot, changes: dict[str, Any], message: str) -> None:
    arguments = {"targets": line(arm, 3), "q0": FROM, **changes}
    with pytest.raises(ArgumentError, match=message):
        arm.follow(**arguments)
