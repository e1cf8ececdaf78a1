"""`Robot.ik_all` of any arm: every branch, families, statuses, sweeps, whole turns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import ArgumentError, Robot, Status, UnknownNameError, rotations, solvers
from agrik_fast.result import Singularity, Warnings
from branch_arms import Array, apart, holds, matched, of_reference, reference, robot

REFERENCE = reference()
SIX, SEVEN = REFERENCE["six"], REFERENCE["seven"]
CLOSED = {
    "puma560": "spherical wrist",
    "ur5": "three parallel axes",
    "ur5e": "three parallel axes",
    "z1": "three parallel axes",
    "thor": "three parallel axes",
}


def errors(arm: Robot, q: Array, pose: Array) -> float:
    return float(np.abs(arm.fk(q) - pose).max()) if len(q) else 0.0


@pytest.mark.parametrize("name", SIX)
def test_every_branch_of_the_reference_and_no_other(name: str) -> None:
    arm = of_reference(SIX[name])
    assert arm.family.name == CLOSED.get(name, "general 6R")
    for target in SIX[name]["targets"]:
        pose, wanted = np.array(target["T"]), np.array(target["branches"])
        found = arm.ik_all(pose)
        assert found.status == Status.CONVERGED
        mine = found.q[found.reached]
        assert len(mine) == len(wanted)
        tolerance = 1e-6 if target["kind"].startswith("near") else 1e-8
        missing, extra = matched(mine, wanted)
        assert missing.max() < tolerance
        assert extra.max() < tolerance
        assert errors(arm, mine, pose) < 1e-11


@pytest.mark.parametrize("name", SEVEN)
def test_seven_joints_with_one_locked(name: str) -> None:
    arm = of_reference(SEVEN[name])
    for target in SEVEN[name]["targets"]:
        pose, wanted = np.array(target["T"]), np.array(target["branches"])
        joint = f"j{target['locked']}"
        found = arm.ik_all(pose, locked={joint: target["value"]})
        mine = found.q[found.reached]
        assert len(mine) == len(wanted)
        missing, extra = matched(mine, wanted)
        assert max(missing.max(), extra.max()) < 1e-8
        assert errors(arm, mine, pose) < 1e-11


@pytest.mark.parametrize("name", SEVEN)
def test_each_joint_of_seven_locked_at_its_value(name: str) -> None:
    arm = of_reference(SEVEN[name])
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (1_000, 7))
    poses = arm.fk(q)
    for k, joint in enumerate(arm.joint_names):
        found = arm.ik_all(poses, q0=q, locked={joint: q[:, k]})
        # One of them is stretched to 0.07 mrad: an error of 1e-10 in the pose moves it by 1e-5.
        assert holds(found, q, 1e-4).all(), joint
        assert (np.abs(found.q[..., k] - q[:, None, k])[found.reached] < 1e-6).all()


def test_the_families() -> None:
    assert ik.Robot.load("ur5").family.name == "three parallel axes"
    panda = ik.Robot.load("panda").family
    assert (panda.locked, panda.branches) == ("panda_joint7", 8) or panda.locked is not None
    assert "spherical shoulder" in panda.name
    hydrolek = ik.Robot.load("hydrolek").family
    assert (hydrolek.name, hydrolek.branches) == ("general 6R", 16)
    assert "meet" in hydrolek.reason
    assert ik.Robot.load("redundant7").family.name == "S-R-S"
    assert ik.Robot.load("puma560").family.name == "spherical wrist"
    assert ik.Robot.load("cucumber").family.locked == "d1"
    slides = ik.Robot.load("strawberry").family
    assert (slides.name, slides.branches) == ("unsupported", 0)
    assert "slides" in slides.reason
    assert str(slides).startswith("unsupported (none): ")


@pytest.mark.parametrize("name", ["ur5e", "crx10ia", "jaco_j2n6", "m1013", "hydrolek", "xarm6"])
def test_random_postures_come_back(name: str) -> None:
    arm = of_reference(SIX[name])
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (2_000, 6))
    poses = arm.fk(q)
    found = arm.ik_all(poses)
    assert holds(found, q).sum() >= len(q) - 1
    assert (found.reached.sum(axis=1) % 2 == 0).mean() > 0.998
    row, branch = np.nonzero(found.reached)
    assert np.abs(arm.fk(found.q[row, branch]) - poses[row]).max() < 1e-9


@pytest.mark.parametrize("name", ["ur5", "hydrolek", "crx10ia", "piper", "manseur"])
def test_as_many_branches_as_many_starts_find(name: str) -> None:
    """A missed pair leaves the number even and the made posture in place: others have to tell."""
    arm = of_reference(SIX[name])
    poses = arm.fk(np.random.default_rng(4).uniform(-np.pi, np.pi, (12, 6)))
    found = arm.ik_all(poses)
    starts = np.random.default_rng(5).uniform(-np.pi, np.pi, (256, 6))
    for i, pose in enumerate(poses):
        tried = arm.ik(
            np.broadcast_to(pose, (256, 4, 4)),
            q0=starts,
            solver=ik.solvers.LevenbergMarquardt(max_restarts=0),
            position_tolerance=1e-10,
            orientation_tolerance=1e-10,
        )
        there = tried.q[tried.success]
        far = apart(there[:, None], found.q[i][found.reached[i]][None]).max(axis=2).min(axis=1)
        assert far.max() < 1e-4


@pytest.mark.parametrize("name", ["ur5", "ur5e", "z1", "puma560"])
def test_closed_forms_and_the_general_way_agree(name: str) -> None:
    """Axes a millionth of a radian off go the general way: the same sets, by other equations."""
    given = SIX[name]
    axes = np.array(given["axes"])
    axes = axes + 1e-6 * np.random.default_rng(19).normal(size=axes.shape)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    exact, general = of_reference(given), robot(axes, given["points"], np.array(given["tool"]))
    assert (exact.family.name, general.family.name) == (CLOSED[name], "general 6R")
    poses = exact.fk(np.random.default_rng(20).uniform(-np.pi, np.pi, (200, 6)))
    ours, theirs = exact.ik_all(poses), general.ik_all(poses)
    same = 0
    for i in range(len(poses)):
        mine, other = ours.q[i][ours.reached[i]], theirs.q[i][theirs.reached[i]]
        if len(mine) == len(other):
            missing, extra = matched(other, mine)
            same += max(missing.max(), extra.max()) < 1e-2
    # Beside a fold a pair of the one arm is none of the other.
    assert same >= 198
    if name == "puma560":
        there = Robot.load("puma560").family
        assert (there.name, there.branches) == (exact.family.name, 8)
        assert (ours.reached.sum(axis=1) == 8).all()


def test_manseur_and_doty_have_sixteen() -> None:
    arm = of_reference(SIX["manseur"])
    q = np.random.default_rng(6).uniform(-np.pi, np.pi, (1_000, 6))
    counts = arm.ik_all(arm.fk(q)).reached.sum(axis=1)
    assert counts.max() == 16
    assert 0.06 < (counts == 16).mean() < 0.15


@pytest.mark.parametrize("name", ["ur5e", "crx10ia", "jaco_j2n6", "hydrolek", "xarm6", "puma560"])
def test_round_angles(name: str) -> None:
    arm = of_reference(SIX[name])
    rng = np.random.default_rng(7)
    q = rng.integers(-3, 5, (40, 6)) * (np.pi / 4.0)
    q[0] = 0.0
    poses = arm.fk(q)
    found = arm.ik_all(poses, q0=q)
    assert np.isfinite(found.q).all()
    row, branch = np.nonzero(found.reached)
    assert np.abs(arm.fk(found.q[row, branch]) - poses[row]).max() < 1e-8
    # The posture itself, or one that leads to the same pose.
    assert found.reached.any(axis=1).all()
    assert holds(found, q, 1e-4).mean() > 0.9


def test_a_free_joint_is_told() -> None:
    arm = of_reference(SIX["ur5"])
    q = np.array([0.3, -0.8, 1.1, 0.4, 0.0, 0.7])
    found = arm.ik_all(arm.fk(q), q0=q)
    assert found.status == Status.SINGULAR_FAMILY
    assert found.free_joint == 5
    assert found.warnings & Warnings.SINGULAR_FAMILY
    assert found.warnings & Warnings.NEAR_SINGULAR
    assert holds(arm.ik_all(arm.fk(q)[None], q0=q), q[None]).all()
    assert (found.singular[found.reached] & Singularity.WRIST).any()


def test_limits_and_what_is_out_of_reach() -> None:
    given = SIX["ur5"]
    pose = np.array(given["targets"][0]["T"])
    narrow = of_reference(given, 0.05).ik_all(pose)
    assert narrow.status == Status.JOINT_LIMITS
    assert narrow.reached.sum() == 8
    assert not narrow.valid.any()
    far = pose.copy()
    far[0, 3] += 50.0
    for name in ("ur5", "hydrolek", "jaco_j2n6"):
        found = of_reference(SIX[name]).ik_all(far)
        assert found.status == Status.OUT_OF_REACH
        assert not found.reached.any()
    none = np.full((4, 4), np.nan)
    assert (of_reference(given).ik_all(np.stack([pose, none])).status == [0, 3]).all()


def test_whole_turns() -> None:
    given = SIX["ur5"]
    target = given["targets"][0]
    pose, count = np.array(target["T"]), len(target["branches"])
    arm = of_reference(given, 2.0 * np.pi)
    q0 = np.array(target["branches"][0])
    found = arm.ik_all(pose, q0=q0, wrap=True)
    assert found.valid.sum() == count * 2**6
    q = found.q[found.valid]
    assert (np.abs(q) <= 2.0 * np.pi).all()
    assert len(np.unique(q.round(6), axis=0)) == len(q)
    assert np.abs(arm.fk(q) - pose).max() < 1e-10
    far = np.linalg.norm(q - q0, axis=1)
    assert (np.diff(far) > -1e-9).all()
    assert far[0] < 1e-8
    # -20 to 380 deg: two values where the angle is within 20 deg of 0, else one.
    limits = np.tile(np.radians([-20.0, 380.0]), (6, 1))
    some = of_reference(given, limits).ik_all(pose, wrap=True)
    turned = np.mod(np.array(target["branches"]), 2.0 * np.pi)
    doubled = (turned < np.radians(20.0)) | (turned > np.radians(340.0))
    assert some.valid.sum() == (2 ** doubled.sum(axis=1)).sum()
    assert arm.ik_all(pose, wrap=False).valid.sum() == count


def test_sweep() -> None:
    panda = ik.Robot.load("panda")
    q = panda.random_q(3, seed=1)
    poses = panda.fk(q)
    found = panda.ik_all(poses, sweep=64)
    assert found.q.shape == (3, 64 * 8, 7)
    values = found.value.reshape(3, 64, 8)
    assert np.allclose(values[..., 0], np.linspace(panda.lower[6], panda.upper[6], 64))
    assert (found.branch.reshape(3, 64, 8) == np.arange(8)).all()
    assert np.allclose(found.q[..., 6], found.value)
    row, branch = np.nonzero(found.reached)
    assert np.abs(panda.fk(found.q[row, branch]) - poses[row]).max() < 1e-9
    one = panda.ik_all(poses[0], locked={panda.joint_names[6]: values[0, 10, 0]})
    part = slice(80, 88)
    assert (one.q == found.q[0, part]).all()
    srs = ik.Robot.load("redundant7")
    angles = srs.ik_all(srs.fk(srs.random_q(seed=2)), sweep=8)
    assert angles.q.shape == (64, 7)
    assert len(np.unique(angles.value)) == 8
    cucumber = ik.Robot.load("cucumber")
    slide = cucumber.ik_all(cucumber.fk(cucumber.random_q(seed=3)), sweep=5)
    places = np.linspace(cucumber.lower[0], cucumber.upper[0], 5)
    assert np.allclose(np.unique(slide.value), places)
    nowhere = np.eye(4)
    nowhere[0, 3] = 30.0
    assert panda.ik_all(nowhere, sweep=4).status == Status.NOT_FOUND


def test_five_joints_reach_a_point_and_an_axis() -> None:
    for given in REFERENCE["axis_task_5R"].values():
        arm = of_reference(given)
        for target in given["targets"]:
            axis = np.array(target["axis"])
            task = ik.tasks.Axis(tool_axis=(0, 0, 1), direction=tuple(axis))
            found = arm.ik_all(target["point"], task=task)
            missing, extra = matched(found.q[found.reached], np.array(target["branches"]))
            assert max(missing.max(), extra.max()) < 1e-8
            q = np.array(target["made_from"])
            pose = arm.fk(q)
            full = arm.ik_all(pose)
            assert full.status == Status.CONVERGED
            assert holds(arm.ik_all(pose[None]), q[None]).all()
            assert full.orientation_error < 1e-9
            about = np.eye(4)
            c, s = np.cos(0.2), np.sin(0.2)
            about[:2, :2] = [[c, -s], [s, c]]
            much = arm.ik_all(pose @ about)
            assert much.status == Status.OVERDETERMINED
            assert 0.0 < much.orientation_error <= 0.2 + 1e-9


def test_yaw_three_pitches_and_roll() -> None:
    """The roll does nothing for a point and the tool axis: a joint to spare, and one too few."""
    axes = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, -1, 0], [0.6, 0, 0.8]]
    points = [[0, 0, 0], [0.05, 0, 0.1], [0.1, 0.02, 0.4], [0.4, 0, 0.42], [0.55, 0, 0.62]]
    tool = np.eye(4)
    tool[:3, :3] = rotations.pose([0, 0, 0], rpy=[0.0, np.arctan2(0.6, 0.8), 0.0])[:3, :3]
    tool[:3, 3] = [0.61, 0, 0.7]
    arm = robot(np.array(axes), np.array(points), tool)
    assert np.abs(tool[:3, 2] - axes[4]).max() < 1e-12
    rng = np.random.default_rng(18)
    q = rng.uniform(-np.pi, np.pi, (200, 5))
    poses = arm.fk(q)
    found = arm.ik_all(poses)
    assert (found.status == Status.CONVERGED).all()
    assert holds(found, q).all()
    assert found.orientation_error.max() < 1e-9
    row, branch = np.nonzero(found.reached)
    assert np.abs(arm.fk(found.q[row, branch]) - poses[row]).max() < 1e-9
    # The point and the axis alone: any roll does, so that it stays where it is.
    axis = ik.tasks.Axis(tool_axis=(0, 0, 1))
    q0 = rng.uniform(-1.0, 1.0, 5)
    pointed = arm.ik_all(poses, task=axis, q0=q0)
    assert (pointed.status == Status.SINGULAR_FAMILY).all()
    assert (pointed.free_joint == 4).all()
    assert (np.abs(pointed.q[pointed.reached][:, 4] - q0[4]) < 1e-9).all()
    # Out of the plane of the pitches: by how much is told, and no search does better.
    off = poses @ rotations.pose([0, 0, 0], rpy=[0.1, -0.2, 0.3])
    much = arm.ik_all(off)
    some = much.status == Status.OVERDETERMINED
    # The others bend too far: no posture at the point has its pitch.
    assert some.mean() > 0.9
    assert set(much.status[~some]) <= {Status.NOT_FOUND, Status.OUT_OF_REACH}
    off, much = off[some], much[some]
    tried = arm.ik(off, task=ik.tasks.PositionFirst(), position_tolerance=1e-9)
    assert tried.success.all()
    better = much.orientation_error - tried.orientation_error
    # Where the elbow cannot reach the point at the nearest pitch, another pitch would do better
    # than the branches that there are: the one shortfall of the least angle.
    assert (better < 1e-6).mean() > 0.95
    assert (better > -1e-3).mean() > 0.9
    assert (much.orientation_error[better > 1e-6] > 2.0).all()
    off, much = off[better < 1e-6], much[better < 1e-6]
    near = arm.ik_all(off, orientation_tolerance=1.0)
    assert (near.status == Status.CONVERGED).all()
    assert np.allclose(near.orientation_error, much.orientation_error)


def test_three_joints_reach_a_point() -> None:
    for given in REFERENCE["point_task_3R"].values():
        arm = of_reference(given)
        for target in given["targets"]:
            found = arm.ik_all(target["point"])
            missing, extra = matched(found.q[found.reached], np.array(target["branches"]))
            assert max(missing.max(), extra.max()) < 1e-8
            much = arm.ik_all(np.vstack([np.c_[np.eye(3), target["point"]], [0, 0, 0, 1]]))
            assert much.status == Status.OVERDETERMINED
            assert much.orientation_error > 1e-3


def test_more_joints_than_a_point_needs() -> None:
    """What is to spare stays where `q0` has it; the joint is named, and the family tells."""
    given = REFERENCE["axis_task_5R"]
    axes, points = (np.array(next(iter(given.values()))[key]) for key in ("axes", "points"))
    tool = np.eye(4)
    tool[:3, 3] = points[3] + [0.1, 0.2, 0.05]
    four = robot(axes[:4], points[:4], tool)
    assert four.family.name.startswith("4R, 3R when 'j")
    assert "one dimension" in four.family.reason
    for arm in (four, of_reference(SIX["ur5"]), ik.Robot.load("panda")):
        q = np.random.default_rng(21).uniform(0.9 * arm.lower, 0.9 * arm.upper, (50, arm.dof))
        q = np.where(np.abs(q) > np.pi, 0.3 * q, q)
        places = arm.fk(q)[:, :3, 3]
        for targets in (places, arm.fk(q)):
            found = arm.ik_all(targets, q0=q, task="position")
            assert (found.status == Status.SINGULAR_FAMILY).all()
            assert (found.warnings & Warnings.SINGULAR_FAMILY).all()
            assert holds(found, q).all()
            row, branch = np.nonzero(found.reached)
            assert np.abs(arm.fk(found.q[row, branch])[:, :3, 3] - places[row]).max() < 1e-9
            free = found.free_joint
            if arm is four:
                assert (four.joint_names[free[0]] == four.family.locked) and (free == free[0]).all()
            assert (np.abs(found.q[row, branch, free[row]] - q[row, free[row]]) < 1e-12).all()
    far = np.array([40.0, 0.0, 0.0])
    assert not four.ik_all(far).reached.any()


@pytest.mark.parametrize(
    ("name", "task"), [("ur5", "position"), ("panda", "position"), ("panda", None)]
)
def test_a_joint_held_unasked_proves_nothing_of_the_arm(name: str, task: str | None) -> None:
    arm = ik.Robot.load(name)
    poses = arm.fk(arm.random_q(300, seed=5))
    found = arm.ik_all(poses, task=task)
    none = ~found.valid.any(axis=1)
    assert 20 < none.sum() < 280
    assert (found.status[none] == Status.NOT_FOUND).all()
    # Of what the bounds of the whole arm exclude the proof stands.
    poses[:, 0, 3] += 9.0
    assert (arm.ik_all(poses, task=task).status == Status.OUT_OF_REACH).all()
    if task is None:
        # At a place that was asked for, what is proven is proven of it.
        locked = {str(arm.family.locked): 0.0}
        assert (arm.ik_all(poses, locked=locked).status == Status.OUT_OF_REACH).all()
        there = arm.ik_all(arm.fk(arm.random_q(300, seed=5)), locked=locked)
        assert {Status.JOINT_LIMITS, Status.OUT_OF_REACH} <= set(there.status)


def test_points_for_arms_with_a_closed_form() -> None:
    """The joints that move the point least stay where they are; an arm angle is of no use."""
    for name in ("puma560", "redundant7"):
        arm = ik.Robot.load(name)
        q = 0.5 * arm.random_q(50, seed=6)
        poses = arm.fk(q)
        found = arm.ik_all(poses[:, :3, 3], q0=q)
        assert (found.status == Status.SINGULAR_FAMILY).all()
        assert holds(found, q).all()
        row, branch = np.nonzero(found.reached)
        assert np.abs(arm.fk(found.q[row, branch])[:, :3, 3] - poses[row, :3, 3]).max() < 1e-9
        assert (found.q == arm.ik_all(poses, q0=q, task="position").q).all()
        assert (arm.ik_all(poses[7, :3, 3], q0=q[7]).q == found.q[7]).all()
        for task in ("position", ik.tasks.Axis(tool_axis=(0, 0, 1))):
            with pytest.raises(ArgumentError, match="arm_angle"):
                arm.ik_all(poses, task=task, arm_angle=0.1)


def test_five_joints_miss_a_pose_by_least_within_their_limits() -> None:
    inside = outside = 0
    for given in REFERENCE["axis_task_5R"].values():
        arm = of_reference(given, 1.5)
        q = np.random.default_rng(22).uniform(-1.8, 1.8, (60, 5))
        poses = arm.fk(q) @ rotations.pose([0, 0, 0], rpy=[0.0, 0.0, 1.5])
        much = arm.ik_all(poses)
        assert set(much.status) <= {Status.OVERDETERMINED, Status.NOT_FOUND}
        every = arm.ik_all(poses, orientation_tolerance=4.0)
        for pose, one, all_of_it in zip(poses, much, every, strict=True):
            if one.status == Status.NOT_FOUND:
                continue
            which = all_of_it.valid if all_of_it.valid.any() else all_of_it.reached
            at = arm.fk(all_of_it.q[which])
            cosine = 0.5 * (np.einsum("ij,kij->k", pose[:3, :3], at[:, :3, :3]) - 1.0)
            angles = np.arccos(np.clip(cosine, -1.0, 1.0))
            assert one.orientation_error == pytest.approx(angles.min(), abs=1e-6)
            assert np.abs(one.q[0] - all_of_it.q[which][angles.argmin()]).max() < 1e-9
            assert one.position_error < 1e-9
            within = (np.abs(one.q[0]) <= 1.5).all()
            assert within == all_of_it.valid.any()
            inside += within and all_of_it.orientation_error < one.orientation_error - 1e-6
            outside += not within
    assert min(inside, outside) > 3
    # Where nothing reaches the point, nothing is told of either.
    poses[:, 0, 3] += 50.0
    poses[0, 0, 0] = np.nan
    nothing = arm.ik_all(poses)
    assert np.isinf(nothing.orientation_error).all()
    assert np.isinf(nothing.position_error).all()


def test_what_nothing_here_solves_says_so() -> None:
    arm = ik.Robot.load("strawberry")
    found = arm.ik_all(arm.fk(arm.random_q(2, seed=1)))
    assert (found.status == Status.UNSUPPORTED).all()
    assert not found.reached.any()


def moved(given: dict[str, Any], base: Array, tool: Array, factor: float = 1.0) -> Robot:
    turn, shift = base[:3, :3], base[:3, 3]
    axes = np.array(given["axes"]) @ turn.T
    points = (np.array(given["points"]) @ turn.T + shift) * factor
    end = base @ np.array(given["tool"]) @ tool
    end[:3, 3] *= factor
    return robot(axes, points, end)


def random_frame(rng: np.random.Generator) -> Array:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    frame = np.eye(4)
    frame[:3, :3] = q * np.sign(np.linalg.det(q))
    frame[:3, 3] = rng.uniform(-0.5, 0.5, 3)
    return frame


@pytest.mark.parametrize("name", ["ur5", "crx10ia", "hydrolek", "jaco_j2n6"])
def test_scale_base_and_tool_change_nothing(name: str) -> None:
    given = SIX[name]
    rng = np.random.default_rng(8)
    q = rng.uniform(-np.pi, np.pi, (50, 6))
    plain = of_reference(given)
    counts = plain.ik_all(plain.fk(q)).reached.sum(axis=1)
    for factor in (1.0, 1e3, 1e-3):
        other = moved(given, random_frame(rng), random_frame(rng), factor)
        found = other.ik_all(other.fk(q), position_tolerance=1e-6 * max(factor, 1e-3))
        assert holds(found, q).all()
        assert (found.reached.sum(axis=1) == counts).all()


@pytest.mark.parametrize("name", ["crx10ia", "hydrolek", "ur5", "puma560"])
def test_the_ring_cut_elsewhere(name: str) -> None:
    """The ring of joints and goal read from another joint on is an arm with as many branches."""
    given = SIX[name]
    axes, points = np.array(given["axes"]), np.array(given["points"])
    plain = robot(axes, points, np.eye(4))
    q = np.random.default_rng(9).uniform(-np.pi, np.pi, (20, 6))
    for one in q:
        goal = plain.fk(one)
        back = np.linalg.inv(goal)
        for first in range(1, 6):
            seen_axes = axes[:first] @ back[:3, :3].T
            seen_points = points[:first] @ back[:3, :3].T + back[:3, 3]
            ring = robot(
                np.vstack([axes[first:], seen_axes]),
                np.vstack([points[first:], seen_points]),
                np.eye(4),
            )
            turned = np.roll(one, -first)
            assert np.abs(ring.fk(turned) - goal).max() < 1e-9
            found, wanted = ring.ik_all(goal), plain.ik_all(goal)
            assert found.reached.sum() == wanted.reached.sum(), first


@pytest.mark.parametrize("digits", [4, 6])
@pytest.mark.parametrize("name", ["ur5", "puma560", "hydrolek"])
def test_rounded_angles_are_the_given_arm(name: str, digits: int) -> None:
    """Directions rounded as URDF angles are: not the neighbouring exact arm."""
    given = SIX[name]
    rng = np.random.default_rng(10)
    angles = np.round(rng.uniform(-1, 1, (6, 3)) * 10.0**-digits, digits + 1)
    axes = np.array(given["axes"]) + angles
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    arm = robot(axes, given["points"], np.array(given["tool"]))
    exact = of_reference(given)
    q = rng.uniform(-np.pi, np.pi, (100, 6))
    poses = arm.fk(q)
    found = arm.ik_all(poses)
    row, branch = np.nonzero(found.reached)
    assert np.abs(arm.fk(found.q[row, branch]) - poses[row]).max() < 1e-9
    assert holds(found, q).all()
    same = found.reached.sum(axis=1) == exact.ik_all(exact.fk(q)).reached.sum(axis=1)
    assert same.mean() > 0.95


@pytest.mark.parametrize("name", ["ur5", "crx10ia", "hydrolek", "m1013"])
def test_bits_do_not_depend_on_the_batch(name: str) -> None:
    arm = of_reference(SIX[name])
    poses = arm.fk(np.random.default_rng(11).uniform(-np.pi, np.pi, (200, 6)))
    whole = arm.ik_all(poses, threads=1)
    split = arm.ik_all(poses, threads=2)
    for what in ("q", "reached", "valid", "status", "warnings"):
        assert (getattr(whole, what) == getattr(split, what)).all()
        parts = [getattr(arm.ik_all(poses[a:b]), what) for a, b in ((0, 7), (7, 200))]
        assert (np.concatenate(parts) == getattr(whole, what)).all()
    for i in range(20):
        assert (arm.ik_all(poses[i]).q == whole.q[i]).all()


def almost_meeting(end: str) -> Robot:
    """Return an arm whose axes meet to ten digits only, as rounded frames have them."""
    axes, points, tool = (np.array(SIX["puma560"][key]) for key in ("axes", "points", "tool"))
    points = points + 1e-10 * np.random.default_rng(14).normal(size=points.shape)
    if end == "shoulder":
        # The same arm from its tool to its base.
        back = np.linalg.inv(tool)
        axes = -axes[::-1] @ back[:3, :3].T
        points = points[::-1] @ back[:3, :3].T + back[:3, 3]
        tool = back
    return robot(axes, points, tool)


@pytest.mark.parametrize("name", ["ur5", "z1", "wrist", "shoulder", "crx10ia"])
def test_bits_do_not_depend_on_the_batch_at_straight_postures(name: str) -> None:
    """Where branches meet some need steps: those of one target, whatever its neighbours need."""
    arm = of_reference(SIX[name]) if name in SIX else almost_meeting(name)
    rng = np.random.default_rng(15)
    q = rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi, 0.3, 1.1], (120, 6))
    q += rng.choice([0.0, 1e-9, 1e-7, 1e-6], (120, 6)) * rng.normal(size=(120, 6))
    poses = arm.fk(q)
    whole = arm.ik_all(poses)
    best = arm.ik(poses, solver="auto")
    for cuts in ([7, 40, 41, 96], list(range(1, 120))):
        parts = [arm.ik_all(part) for part in np.split(poses, cuts)]
        for what in ("q", "reached", "valid", "status", "warnings"):
            pieces = np.concatenate([getattr(part, what) for part in parts])
            assert pieces.tobytes() == getattr(whole, what).tobytes(), what
    # A single pose has a record of its own.
    for row in range(120):
        one = arm.ik_all(poses[row])
        for what in ("q", "reached", "valid", "singular", "status", "warnings", "free_joint"):
            assert getattr(one, what).tobytes() == getattr(whole, what)[row].tobytes(), what
    for row in range(120):
        alone = arm.ik(poses[row], solver="auto", first_index=row)
        assert alone.q.tobytes() == best.q[row].tobytes()


def test_what_the_tolerances_allow_is_never_proven_away() -> None:
    """No branch of the pose itself is no proof where the orientation counts for little."""
    rng = np.random.default_rng(16)
    loose = 0
    for name in ("ur5", "z1", "thor", "jaco_j2n6", "crx10ia"):
        arm = of_reference(SIX[name])
        q = rng.uniform(-np.pi, np.pi, (200, 6))
        poses = arm.fk(q)
        # The same point, another way round: most of these have no branch of their own.
        poses[:, :3, :3] = arm.fk(rng.uniform(-np.pi, np.pi, (200, 6)))[:, :3, :3]
        strict = arm.ik_all(poses)
        found = arm.ik_all(poses, orientation_tolerance=4.0)
        loose += int((strict.status == Status.OUT_OF_REACH).sum())
        assert (found.status != Status.OUT_OF_REACH).all()
        # What is proven of the pose itself, no search comes near.
        proven = poses[strict.status == Status.OUT_OF_REACH]
        if len(proven):
            tried = arm.ik(proven, solver=solvers.LevenbergMarquardt(max_restarts=20))
            assert not tried.success.any()
    assert loose > 20


@pytest.mark.parametrize("size", [1e-7, 1e-4, 1e-2])
@pytest.mark.parametrize("name", ["ur5", "z1", "wrist", "shoulder"])
def test_poses_beside_reached_ones_are_not_proven_away(name: str, size: float) -> None:
    """A pose within the tolerances of a reached one counts, at singular postures above all."""
    arm = of_reference(SIX[name]) if name in SIX else almost_meeting(name)
    rng = np.random.default_rng(17)
    q = rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi, 0.3, 1.1], (400, 6))
    q += rng.choice([0.0, size, 1.0], (400, 1)) * rng.normal(size=(400, 6))
    poses = arm.fk(q)
    turns = rng.normal(size=(400, 3))
    turns *= size / np.linalg.norm(turns, axis=1, keepdims=True)
    poses[:, :3, :3] = rotations.pose([0, 0, 0], axis_angle=turns)[:, :3, :3] @ poses[:, :3, :3]
    ways = rng.normal(size=(400, 3))
    poses[:, :3, 3] += ways * size / np.linalg.norm(ways, axis=1, keepdims=True)
    wide = 1.000001 * size
    found = arm.ik_all(poses, position_tolerance=wide, orientation_tolerance=wide)
    assert (found.status != Status.OUT_OF_REACH).all()


def test_tolerances_widen_what_is_proven() -> None:
    arm = of_reference(SIX["ur5"])
    far = arm.fk(np.zeros(6))
    far[:3, 3] *= 10.0
    reach = np.linalg.norm(far[:3, 3])
    assert arm.ik_all(far).status == Status.OUT_OF_REACH
    assert arm.ik_all(far, position_tolerance=2 * reach).status == Status.NOT_FOUND


def test_a_tool_of_the_call() -> None:
    arm = of_reference(SIX["jaco_j2n6"])
    tool = random_frame(np.random.default_rng(12))
    q = np.random.default_rng(13).uniform(-np.pi, np.pi, (20, 6))
    assert holds(arm.ik_all(arm.fk(q) @ tool, tool=tool), q).all()


def test_wrong_arguments_say_what_was_expected() -> None:
    panda = ik.Robot.load("panda")
    pose = panda.fk(panda.random_q(seed=1))
    last = panda.joint_names[6]
    with pytest.raises(UnknownNameError, match="joint"):
        panda.ik_all(pose, locked={"j99": 0.1})
    with pytest.raises(ArgumentError, match="within its limits"):
        panda.ik_all(pose, locked={last: 50.0})
    with pytest.raises(ArgumentError, match="locked"):
        panda.ik_all(pose, locked={last: [0.1, 0.2]})
    for wrong in (0, -1, 2.5, True, "many"):
        with pytest.raises(ArgumentError, match="sweep"):
            panda.ik_all(pose, sweep=wrong)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="sweep"):
        panda.ik_all(pose, sweep=3, locked={last: 0.1})
    with pytest.raises(ArgumentError, match="sweep"):
        of_reference(SIX["ur5"]).ik_all(pose, sweep=3)
    with pytest.raises(ArgumentError, match="rigid"):
        panda.ik_all(2.0 * np.eye(4), invalid="raise")
    assert panda.ik_all(2.0 * np.eye(4)).status == Status.BAD_INPUT
    with pytest.raises(ArgumentError, match="arm_angle"):
        panda.ik_all(pose, arm_angle=0.1)
    assert panda.ik_all(pose, locked={last: np.nan}).status == Status.BAD_INPUT
