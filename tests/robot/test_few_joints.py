"""All branches of arms of one to four joints that turn, behind a slide too, and least errors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import agrik_fast as ik
from agrik_fast import Robot, Status, Warnings, rotations
from branch_arms import Array, apart, matched, robot

KINDS = ("random", "planar", "yaw and pitches", "right angles", "wrist")
SLIDE = ((0.3, 1.0, 0.2), -0.1, 0.15)


def arm_of(
    kind: str, joints: int, rng: np.random.Generator, limit: float = 7.0, slide: bool = False
) -> Robot:
    """Return an arm of so many joints that turn."""
    axes = rng.normal(size=(joints, 3))
    points = 0.4 * rng.normal(size=(joints, 3))
    tool = random_frame(rng)
    if kind in ("planar", "yaw and pitches"):
        axes = np.tile([0.0, 1.0, 0.0], (joints, 1))
        points = np.cumsum(rng.uniform(0.1, 0.4, (joints, 3)), axis=0)
        if kind == "yaw and pitches":
            axes[0] = [0.0, 0.0, 1.0]
    if kind == "right angles":
        axes = np.eye(3)[np.arange(joints) % 3]
    if kind == "wrist":
        points = np.tile(points[:1], (joints, 1))
    if slide:
        # Where slide and first axis meet, the reach is the arm's size.
        points -= points[0]
    return robot(axes, points, tool, limit, slide=SLIDE if slide else None)


def random_frame(rng: np.random.Generator) -> Array:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    frame = np.eye(4)
    frame[:3, :3] = q * np.sign(np.linalg.det(q))
    frame[:3, 3] = rng.uniform(-0.5, 0.5, 3)
    return frame


def turned_aside(poses: Array, rng: np.random.Generator, size: float) -> Array:
    """Return poses turned and shifted by random amounts."""
    aside = np.array(
        [
            rotations.pose(size * rng.normal(size=3), rpy=2.0 * size * rng.normal(size=3))
            for _ in poses
        ]
    )
    return poses @ aside


def scale_of(arm: Robot) -> float:
    """Return the length that a radian counts as, m."""
    return 0.3 * arm.reach_radius


def residuals(arm: Robot, q: Array, pose: Array, task: str) -> Array:
    """Return what a posture leaves, m, orientations by the length of a radian."""
    at = arm.fk(q)
    off = at[:3, 3] - pose[:3, 3]
    if task == "position":
        return off
    if task == "axis":
        across = np.cross(at[:3, 2], pose[:3, 2])
        sine = np.linalg.norm(across)
        angle = np.arctan2(sine, at[:3, 2] @ pose[:3, 2])
        return np.r_[off, scale_of(arm) * angle * across / max(sine, 1e-300)]
    turn = Rotation.from_matrix(pose[:3, :3] @ at[:3, :3].T).as_rotvec()
    return np.r_[off, scale_of(arm) * turn]


def least_of_many(
    arm: Robot, pose: Array, task: str, rng: np.random.Generator, starts: int
) -> float:
    """Return the least error that SciPy's least squares find from many starts, m."""
    low, high = np.maximum(arm.lower, -np.pi - 7), np.minimum(arm.upper, np.pi + 7)
    best = np.inf
    for _ in range(starts):
        q0 = rng.uniform(np.maximum(low, -np.pi), np.minimum(high, np.pi))
        found = least_squares(
            lambda q: residuals(arm, q, pose, task), q0, bounds=(low, high), xtol=1e-12, ftol=1e-12
        )
        best = min(best, float(np.sqrt(2.0 * found.cost)))
    return best


@pytest.mark.parametrize("slide", [False, True])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("joints", [1, 2, 3, 4])
def test_a_pose_of_a_posture_has_all_its_branches(kind: str, joints: int, slide: bool) -> None:
    rng = np.random.default_rng(100 * joints + KINDS.index(kind))
    spare = (kind == "planar" or kind == "wrist") and joints == 4
    for _ in range(3):
        arm = arm_of(kind, joints, rng, slide=slide)
        q = rng.uniform(-np.pi, np.pi, (4, arm.dof))
        q[:, 0] = rng.uniform(-0.1, 0.15, 4) if slide else q[:, 0]
        poses = arm.fk(q)
        found = arm.ik_all(poses, q0=q)
        assert found.q.shape == (4, 8, arm.dof)
        solved = Status.SINGULAR_FAMILY if spare else Status.CONVERGED
        if not slide:
            assert (found.status == solved).all()
        assert np.isin(found.status, (Status.CONVERGED, Status.SINGULAR_FAMILY)).all()
        same = np.abs(found.q - q[:, None])
        same[..., slide:] = apart(found.q, q[:, None])[..., slide:]
        assert ((same.max(axis=2) < 1e-5) & found.valid).any(axis=1).all()
        row, branch = np.nonzero(found.reached)
        assert np.abs(arm.fk(found.q[row, branch]) - poses[row]).max() < 1e-9
        assert found.orientation_error.max() < 1e-9
        assert found.position_error.max() < 1e-9
        if (found.status == Status.SINGULAR_FAMILY).any():
            continue
        # What many starts find is among them.
        for pose, some, reached in zip(poses, found.q, found.reached, strict=True):
            starts = rng.uniform(-np.pi, np.pi, (100, arm.dof))
            tried = arm.ik(
                np.tile(pose, (100, 1, 1)),
                q0=starts,
                position_tolerance=1e-10,
                orientation_tolerance=1e-10,
            )
            missing, _ = matched(some[reached][:, slide:], tried.q[tried.success][:, slide:])
            assert missing.max() < 1e-4


@pytest.mark.parametrize("slide", [False, True])
@pytest.mark.parametrize("limit", [7.0, 1.2])
@pytest.mark.parametrize("joints", [1, 2, 3, 4])
def test_no_search_misses_a_pose_by_less(joints: int, limit: float, slide: bool) -> None:
    rng = np.random.default_rng(joints + 10 * slide)
    for kind in KINDS:
        arm = arm_of(kind, joints, rng, limit, slide)
        q = rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi), (3, arm.dof))
        poses = turned_aside(arm.fk(q), rng, 0.2)
        found = arm.ik_all(poses)
        assert np.isin(found.status, (Status.OVERDETERMINED, Status.OUT_OF_REACH)).all()
        assert not found.reached.any()
        first = found.q[:, 0]
        assert (first >= arm.lower).all()
        assert (first <= arm.upper).all()
        scale = scale_of(arm)
        mine = np.hypot(found.position_error, scale * found.orientation_error)
        told = [
            np.linalg.norm(residuals(arm, a, b, "pose")) for a, b in zip(first, poses, strict=True)
        ]
        np.testing.assert_allclose(mine, told, rtol=1e-9)
        # Levenberg and Marquardt's steps of this library.
        starts = 400
        q0 = rng.uniform(
            np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi), (starts, arm.dof)
        )
        lm = ik.solvers.LevenbergMarquardt(max_restarts=0)
        for pose, error in zip(poses, mine, strict=True):
            tried = arm.ik(np.tile(pose, (starts, 1, 1)), q0=q0, solver=lm)
            other = np.hypot(tried.position_error, scale * tried.orientation_error).min()
            assert error <= other * (1.0 + 1e-9)
        assert mine[0] <= least_of_many(arm, poses[0], "pose", rng, 20) * (1.0 + 1e-9)


@pytest.mark.parametrize("task", ["position", "axis"])
def test_less_than_a_pose_is_too_much_for_some_arms_too(task: str) -> None:
    rng = np.random.default_rng(31)
    wanted = {"position": 2, "axis": 4}[task]
    for joints in range(1, wanted + 1):
        arm = arm_of("random", joints, rng)
        q = rng.uniform(-np.pi, np.pi, (5, arm.dof))
        poses = arm.fk(q)
        asked = ik.tasks.Axis(tool_axis=(0, 0, 1)) if task == "axis" else "position"
        found = arm.ik_all(poses, task=asked)
        assert (found.status == Status.CONVERGED).all()
        off = apart(found.q, q[:, None]).max(axis=2)
        assert ((off < 1e-5) & found.valid).any(axis=1).all()
        if task == "position":
            again = arm.ik_all(poses[:, :3, 3])
            assert (again.q == found.q).all()
            assert found.orientation_error.max() == 0.0
        aside = turned_aside(poses, rng, 0.1)
        least = arm.ik_all(aside, task=asked)
        for pose, q0, one in zip(aside, least.q[:, 0], least, strict=True):
            assert one.status in (Status.OVERDETERMINED, Status.OUT_OF_REACH)
            error = np.linalg.norm(residuals(arm, q0, pose, task))
            told = np.hypot(one.position_error, scale_of(arm) * one.orientation_error)
            assert told == pytest.approx(error, rel=1e-9)
            assert error <= least_of_many(arm, pose, task, rng, 20) * (1.0 + 1e-9)


def test_a_slide_and_two_joints_for_a_point() -> None:
    """Just as many joints as are needed, and no closed form."""
    rng = np.random.default_rng(5)
    arm = arm_of("random", 2, rng, slide=True)
    q = np.c_[rng.uniform(-0.1, 0.15, 20), rng.uniform(-np.pi, np.pi, (20, 2))]
    found = arm.ik_all(arm.fk(q)[:, :3, 3])
    assert (found.status == Status.CONVERGED).all()
    assert (np.abs(found.q[..., 0] - q[:, None, 0]) < 1e-6).any(axis=1).all()
    assert found.reached.sum(axis=1).min() >= 1
    assert found.reached.sum(axis=1).max() > 1
    assert arm.family.name == "slide before 2R"


def test_joints_to_spare_behind_a_slide_leave_it_where_it_is() -> None:
    rng = np.random.default_rng(6)
    for joints, task in ((3, "position"), (4, "position"), (5, "axis"), (5, "position")):
        arm = arm_of("random", joints, rng, slide=True)
        q = np.c_[rng.uniform(-0.1, 0.15, 5), rng.uniform(-np.pi, np.pi, (5, joints))]
        asked = ik.tasks.Axis(tool_axis=(0, 0, 1)) if task == "axis" else task
        # Where the slide is held unasked, that nothing is found proves nothing.
        somewhere = arm.ik_all(arm.fk(q), task=asked)
        assert set(somewhere.status) <= {Status.SINGULAR_FAMILY, Status.NOT_FOUND}
        found = arm.ik_all(arm.fk(q), task=asked, q0=q)
        assert (found.status == Status.SINGULAR_FAMILY).all()
        assert (found.free_joint == 0).all()
        assert (np.abs(found.q[..., 0] - q[:, None, 0]) < 1e-12).all()
        off = apart(found.q, q[:, None]).max(axis=2)
        assert ((off < 1e-5) & found.valid).any(axis=1).all()


def test_a_joint_that_turns_freely_stays_where_it_is() -> None:
    """Four parallel axes have a joint to spare for the poses that they reach."""
    rng = np.random.default_rng(7)
    arm = arm_of("planar", 4, rng)
    q = rng.uniform(-np.pi, np.pi, (10, 4))
    found = arm.ik_all(arm.fk(q), q0=q)
    assert (found.status == Status.SINGULAR_FAMILY).all()
    assert (found.warnings & Warnings.SINGULAR_FAMILY).all()
    free = found.free_joint
    assert (free >= 0).all()
    for row in range(10):
        held = found.q[row][found.reached[row]][:, free[row]]
        assert np.abs(held - q[row, free[row]]).max() < 1e-9
    # Wherever it is held where the others cannot follow, some posture is given all the same.
    elsewhere = arm.ik_all(arm.fk(q), q0=q + 3.0)
    assert (elsewhere.status == Status.SINGULAR_FAMILY).all()


def test_statuses_of_few_joints() -> None:
    rng = np.random.default_rng(8)
    arm = arm_of("random", 4, rng, limit=0.5)
    q = np.array([[0.9, 0.2, 0.1, -0.3], [0.3, 0.2, 0.1, -0.3]])
    poses = np.concatenate([arm.fk(q), arm.fk(q[1:]), arm.fk(q[1:])])
    poses[2, :3, 3] += 50.0
    poses[3, 0, 0] = np.nan
    found = arm.ik_all(poses)
    wanted = [Status.JOINT_LIMITS, Status.CONVERGED, Status.OUT_OF_REACH, Status.BAD_INPUT]
    assert found.status.tolist() == wanted
    assert found.reached[0].any()
    assert not found.valid[0].any()
    assert np.isinf(found.position_error[3])
    assert found.position_error[2] > 40.0
    assert np.isfinite(found.q).all()
    # A tolerance that the nearest posture keeps makes it an answer.
    aside = poses[1].copy()
    aside[:3, 3] += [0.004, -0.003, 0.005]
    assert arm.ik_all(aside).status == Status.OVERDETERMINED
    near = arm.ik_all(aside, position_tolerance=0.05, orientation_tolerance=0.1)
    assert near.status == Status.CONVERGED
    assert near.valid[0]
    assert 0.0 < near.position_error < 0.05
    wrapped = arm.ik_all(poses, wrap=True)
    assert wrapped.status.tolist() == wanted
    assert (wrapped.position_error == found.position_error).all()


def test_proofs_hold_for_the_whole_of_three_tolerances() -> None:
    """What is beyond the smallest number may be within the others."""
    rng = np.random.default_rng(13)
    arm = arm_of("random", 2, rng, slide=True)
    q = np.c_[rng.uniform(-0.1, 0.15, 20), rng.uniform(-np.pi, np.pi, (20, 2))]
    points = arm.fk(q)[:, :3, 3] + [0.0, 0.0, 0.3]
    exact = arm.ik_all(points)
    proven = exact.status == Status.OUT_OF_REACH
    assert proven.sum() > 3
    # The posture that made each is within these.
    wide = arm.ik_all(points, position_tolerance=(1e-6, 1e-6, 0.31))
    assert (wide.status[proven] == Status.NOT_FOUND).all()
    four = arm_of("random", 4, rng)
    far = four.fk(rng.uniform(-np.pi, np.pi, 4))
    far[:3, 3] *= 4.0 * four.reach_radius / np.linalg.norm(far[:3, 3])
    assert four.ik_all(far).status == Status.OUT_OF_REACH
    much = four.ik_all(far, position_tolerance=(1e-6, 1e-6, 10.0 * four.reach_radius))
    assert much.status == Status.OVERDETERMINED


def test_one_target_many_and_any_number_of_threads_agree() -> None:
    rng = np.random.default_rng(9)
    for joints in (3, 4):
        arm = arm_of("right angles", joints, rng)
        poses = arm.fk(rng.uniform(-np.pi, np.pi, (6, joints)))
        poses[::2] = turned_aside(poses[::2], rng, 0.1)
        all_at_once = arm.ik_all(poses, threads=2)
        one_thread = arm.ik_all(poses, threads=1).to_dict()
        for name, values in all_at_once.to_dict().items():
            assert np.array_equal(values, one_thread[name], equal_nan=True), name
        for row, pose in enumerate(poses):
            for name, value in arm.ik_all(pose).to_dict().items():
                whole = all_at_once.to_dict()[name][row]
                assert np.array_equal(value, whole, equal_nan=True), name


def test_locked_joints_leave_few() -> None:
    arm = ik.Robot.load("ur5")
    q = np.array([0.3, -1.0, 0.8, 0.4, 1.2, -0.5])
    pose = arm.fk(q)
    for names in (arm.joint_names[:2], arm.joint_names[1:4]):
        locked = {name: q[arm.joint_names.index(name)] for name in names}
        found = arm.ik_all(pose, locked=locked)
        assert found.status == Status.CONVERGED
        assert (apart(found.q, q).max(axis=1) < 1e-5).any()
        locked[names[0]] += 0.1
        least = arm.ik_all(pose, locked=locked)
        assert least.status in (Status.OVERDETERMINED, Status.OUT_OF_REACH)
        assert least.position_error + least.orientation_error > 1e-3
        assert least.q[0, arm.joint_names.index(names[0])] == locked[names[0]]
    # Values at which the arm that is left has another number of branches.
    name, values = arm.joint_names[4], np.array([0.0, 0.1, 1.2])
    postures = np.tile(q, (3, 1))
    postures[:, 4] = values
    poses = arm.fk(postures)
    poses[0] = pose
    many = arm.ik_all(poses, locked={name: values})
    alone = [
        arm.ik_all(one, locked={name: value}) for one, value in zip(poses, values, strict=True)
    ]
    assert [len(one.q) for one in alone] == [16, 8, 8]
    assert many.q.shape == (3, 16, 6)
    assert many.reached.any(axis=1).tolist() == [False, True, True]
    for together, one in zip(many, alone, strict=True):
        count = len(one.q)
        assert (together.q[:count] == one.q).all()
        assert (together.valid[:count] == one.valid).all()
        assert (together.reached[:count] == one.reached).all()
        assert not together.reached[count:].any()
        for value in ("status", "free_joint", "orientation_error", "position_error"):
            assert getattr(together, value) == getattr(one, value)


def test_lengths_of_any_unit() -> None:
    rng = np.random.default_rng(10)
    axes, points = rng.normal(size=(4, 3)), 0.4 * rng.normal(size=(4, 3))
    tool = random_frame(rng)
    q = rng.uniform(-np.pi, np.pi, (5, 4))
    found = {}
    for factor in (1e-3, 1.0, 1e3):
        end = tool.copy()
        end[:3, 3] *= factor
        arm = robot(axes, factor * points, end)
        poses = arm.fk(q)
        exact = arm.ik_all(poses, position_tolerance=1e-6 * factor)
        assert (exact.status == Status.CONVERGED).all()
        aside = poses @ rotations.pose([0, 0, 0], rpy=[0.1, 0.2, -0.3])
        found[factor] = arm.ik_all(aside, position_tolerance=1e-6 * factor)
    for factor in (1e-3, 1e3):
        assert np.abs(apart(found[factor].q[:, 0], found[1.0].q[:, 0])).max() < 1e-6


def test_what_few_joints_are_told_to_be() -> None:
    rng = np.random.default_rng(11)
    names = {1: "1R", 2: "2R", 3: "3R", 4: "4R, 3R when 'j"}
    for joints, name in names.items():
        for slide in (False, True):
            family = arm_of("random", joints, rng, slide=slide).family
            assert family.name.startswith("slide before " + name if slide else name)
            assert "overdetermined" in family.reason
            assert family.branches == 8
    rail = robot(np.zeros((0, 3)), np.zeros((0, 3)), np.eye(4), slide=SLIDE)
    assert rail.family.name == "a slide"
    found = rail.ik_all(rail.fk([0.1]))
    assert found.status == Status.CONVERGED
    assert found.q[0, 0] == pytest.approx(0.1)
    off = rail.ik_all(rail.fk([0.1]) @ rotations.pose([0, 0, 0], rpy=[0.3, 0, 0]))
    assert off.status == Status.OVERDETERMINED
    assert off.orientation_error == pytest.approx(0.3)


def test_arms_that_hardly_move_and_arms_with_a_joint_too_many() -> None:
    still = robot(np.tile([0.0, 0.0, 1.0], (3, 1)), np.zeros((3, 3)), np.eye(4))
    on_axis = still.ik_all([0.0, 0.0, 0.0])
    assert on_axis.status == Status.SINGULAR_FAMILY
    assert np.isfinite(on_axis.q).all()
    assert still.ik_all([0.0, 0.0, 0.1]).status == Status.OUT_OF_REACH
    turned = still.ik_all(still.fk([0.1, 0.2, 0.3]))
    assert turned.status == Status.SINGULAR_FAMILY
    # Six joints of which the first slides: a pose has no spare joint, and no solver.
    rng = np.random.default_rng(12)
    arm = arm_of("random", 5, rng, slide=True)
    pose = arm.fk(np.full(6, 0.1))
    assert arm.ik_all(pose).status == Status.UNSUPPORTED
    assert arm.ik_all(pose, locked={"slide": 0.1}).status == Status.CONVERGED
    assert "with the slide locked" in arm.family.reason
    with pytest.raises(ik.errors.ArgumentError, match="arm_angle"):
        still.ik_all(np.eye(4), arm_angle=0.1)


@pytest.mark.parametrize("held", [[0], [1], [3], [0, 2]])
def test_points_are_reached_by_the_joints_that_limits_let_move(held: list[int]) -> None:
    rows = [[0, 1.57, 0.2, 0], [0.4, 0.3, 0, 0], [0.3, -1.2, 0.1, 0], [0.1, 0, 0.05, 0]]
    rows = rows if len(held) == 1 else [*rows, [0.1, 0.4, 0.1, 0]]
    limits = np.tile([-2.0, 2.0], (len(rows), 1))
    limits[held] = 0.3
    arm = Robot.from_dh(rows, limits=limits)
    q = arm.random_q(5, seed=1)
    found = arm.ik_all(arm.fk(q)[:, :3, 3])
    assert (found.status == Status.CONVERGED).all()
    assert (found.free_joint < 0).all()
    same = (np.abs(found.q - q[:, None]).max(2) < 1e-6) & found.valid
    assert same.any(1).all()
