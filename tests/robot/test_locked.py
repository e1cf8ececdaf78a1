"""Locked joints: the arm on a slide of the cucumber harvester, and joints of other arms."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.result import Singularity, Status

REFERENCE = Path(__file__).parents[1] / "data" / "cucumber" / "reference.json"
MM = 1e-3


@pytest.fixture(scope="module")
def arm() -> ik.Robot:
    return ik.Robot.load("cucumber")


@pytest.fixture(scope="module")
def reference() -> dict[str, Any]:
    data: dict[str, Any] = json.loads(REFERENCE.read_text())
    return data


def joint_values(case: dict[str, Any]) -> np.ndarray:
    q = np.array(case["q"], dtype=float)
    q[0] *= MM
    return q


def pose_of(case: dict[str, Any]) -> np.ndarray:
    pose = np.array(case["tcp_world"], dtype=float)
    pose = np.vstack([pose, [0, 0, 0, 1]]) if pose.shape == (3, 4) else pose
    pose[:3, 3] *= MM
    return pose


def turns_apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi)


def test_forward_kinematics_agrees_with_fifty_digits(
    arm: ik.Robot, reference: dict[str, Any]
) -> None:
    for case in reference["cases"] + [one for one in reference["special"] if "q" in one]:
        off = arm.fk(joint_values(case)) - pose_of(case)
        assert np.abs(off[:3, 3]).max() < 1e-9 * MM
        assert np.abs(off[:3, :3]).max() < 1e-12


def test_every_branch_of_the_reference_and_no_other(
    arm: ik.Robot, reference: dict[str, Any]
) -> None:
    cases = [case for case in reference["cases"] if "branches" in case]
    assert len(cases) >= 10
    for case in cases:
        found = arm.ik_all(pose_of(case), locked={"d1": joint_values(case)[0]})
        mine = found.q[found.reached]
        wanted = np.array([branch["theta"] for branch in case["branches"]])
        assert len(mine) == len(wanted)
        apart = turns_apart(mine[:, None, 1:], wanted[None]).max(axis=2)
        assert apart.min(axis=0).max() < 1e-8
        assert apart.min(axis=1).max() < 1e-8
        assert len(set(apart.argmin(axis=0))) == len(wanted)
        inside = sum(branch["within_limits"] for branch in case["branches"])
        assert found.valid.sum() == inside


def test_random_vectors_come_back(arm: ik.Robot) -> None:
    rng = np.random.default_rng(1)
    q = rng.uniform(-np.pi, np.pi, (100_000, 7))
    q[:, 0] = rng.uniform(0, 1, len(q))
    poses = arm.fk(q)
    found = arm.ik_all(poses, locked={"d1": q[:, 0]})
    assert (found.q[..., 0] == q[:, None, 0]).all()
    apart = turns_apart(found.q[..., 1:], q[:, None, 1:]).max(axis=2)
    nearest = np.where(found.reached, apart, np.inf).min(axis=1)
    # Where branches meet, an angle is known to the root of the rounding only.
    assert (nearest < 1e-8).mean() > 0.9999
    assert nearest.max() < 1e-4
    off = arm.fk(found.q) - poses[:, None]
    # Exact to rounding, but that a posture in the limits may stand in for one outside them.
    off = np.abs(off).max(axis=(2, 3))
    assert off[found.reached & ~found.valid].max() < 1e-12
    assert off[found.reached].max() < 1e-6
    assert (off[found.reached] < 1e-12).mean() > 0.99999
    counts = np.bincount(found.reached.sum(axis=1), minlength=9)
    assert counts[8] + counts[4] > 99_990
    inside = ((arm.lower <= found.q) & (found.q <= arm.upper)).all(axis=2)
    assert (found.valid == (found.reached & inside)).all()


@pytest.mark.parametrize("straight", [0.0, np.pi])
def test_nearly_straight_wrists(arm: ik.Robot, straight: float) -> None:
    rng = np.random.default_rng(2)
    for sine in [0.0, *10.0 ** np.arange(-12, -2)]:
        q = rng.uniform(-1, 1, (200, 7)) * [0.5, 2, 1, 1, 2, 0, 2] + [0.5, 0, -0.5, 0.3, 0, 0, 3]
        q[:, 5] = straight + np.arcsin(sine)
        poses = arm.fk(q)
        found = arm.ik_all(poses, locked={"d1": q[:, 0]})
        assert found.reached.any(axis=1).all()
        off = np.abs(arm.fk(found.q) - poses[:, None]).max(axis=(2, 3))
        within = ((arm.lower <= q) & (q <= arm.upper)).all(axis=1)
        assert off[within][found.reached[within]].max(initial=0) < 1e-9
        # Postures in the limits that stand in for ones outside are within the tolerances.
        assert off[found.reached & ~found.valid].max(initial=0) < 1e-9
        fine = arm.ik_all(
            poses,
            locked={"d1": q[:, 0]},
            position_tolerance=1e-9,
            orientation_tolerance=1e-9,
        )
        off = np.abs(arm.fk(fine.q) - poses[:, None])[fine.reached]
        assert off.max() < 1e-9
        if sine < 1e-7:
            here = turns_apart(found.q[..., 5], np.full_like(found.q[..., 5], straight)) < 1e-6
            assert (found.singular[here & found.reached] & Singularity.WRIST).all()


def test_a_straight_wrist_shares_its_turn_inside_the_limits(arm: ik.Robot) -> None:
    rng = np.random.default_rng(3)
    q = rng.uniform(arm.lower, arm.upper, (2000, 7))
    q[:, 5] = 0
    found = arm.ik_all(arm.fk(q), locked={"d1": q[:, 0]})
    assert found.valid.any(axis=1).all()
    # The same where a start asks for shares that are not to be had.
    start = np.where(np.arange(7) == 4, arm.upper, q)
    found = arm.ik_all(arm.fk(q), start, locked={"d1": q[:, 0]})
    assert found.valid.any(axis=1).all()


def test_whole_turns_stay_near_the_start(arm: ik.Robot) -> None:
    q = np.array([0.4, 0.3, -0.8, 0.2, 0.5, 0.9, 0.1])
    low = arm.ik_all(arm.fk(q), q, locked={"d1": 0.4})
    assert np.abs(low.q - q).max(axis=1).min() < 1e-9
    q[6] += 2 * np.pi
    high = arm.ik_all(arm.fk(q), q, locked={"d1": 0.4})
    assert np.abs(high.q - q).max(axis=1).min() < 1e-9


def test_one_value_and_one_a_row_are_the_same(arm: ik.Robot) -> None:
    rng = np.random.default_rng(4)
    poses = arm.fk(rng.uniform(arm.lower, arm.upper, (3, 5, 7)))
    one = arm.ik_all(poses, locked={"d1": 0.25})
    each = arm.ik_all(poses, locked={"d1": np.full((3, 5), 0.25)})
    assert one.q.shape == (3, 5, 8, 7)
    for name in ("q", "valid", "reached", "singular", "status"):
        assert (getattr(one, name) == getattr(each, name)).all()
    for threads in (1, 2):
        again = arm.ik_all(poses, threads=threads, locked={"d1": 0.25})
        assert (again.q == one.q).all()


def test_a_tool_of_the_call_counts(arm: ik.Robot) -> None:
    tool = np.eye(4)
    tool[:3, 3] = [0.02, -0.01, 0.05]
    q = np.array([0.4, 0.3, -0.8, 0.2, 0.5, 0.9, 0.1])
    pose = arm.fk(q) @ tool
    found = arm.ik_all(pose, q, tool, locked={"d1": 0.4})
    assert np.abs(found.q - q).max(axis=1).min() < 1e-9


def test_a_joint_in_the_middle() -> None:
    # Without its third joint this S-R-S arm has an offset elbow and a spherical wrist.
    whole = ik.Robot.load("panda")
    names = whole.joint_names
    rng = np.random.default_rng(5)
    q = rng.uniform(whole.lower, whole.upper, (40, whole.dof))
    pose = whole.fk(q)
    found = whole.ik_all(pose, locked={names[2]: q[:, 2]})
    apart = turns_apart(found.q, q[:, None]).max(axis=2)
    assert ((apart < 1e-6) & found.valid).any(axis=1).all()
    arm = ik.Robot.from_dh(
        [
            [0.1, np.pi / 2, 0.3, 0],
            [0.0, -np.pi / 2, 0.0, 0],
            [0.4, np.pi / 2, 0.1, 0],
            [0.02, -np.pi / 2, 0.1, 0],
            [0.0, np.pi / 2, 0.4, 0],
            [0.0, -np.pi / 2, 0.0, 0],
            [0.0, 0.0, 0.1, 0],
        ],
        limits=[[-3, 3]] * 7,
    )
    q = rng.uniform(-3, 3, (60, 7))
    for joint in (0, 1, 2):
        # Equal values and different ones in one call.
        q[::2, joint] = q[0, joint]
        found = arm.ik_all(arm.fk(q), q, locked={f"q{joint + 1}": q[:, joint]})
        off = np.abs(found.q - q[:, None]).max(axis=2)
        assert np.where(found.valid, off, np.inf).min(axis=1).max() < 1e-5, joint
        assert (found.q[..., joint] == q[:, None, joint]).all()
        again = arm.ik_all(arm.fk(q[3]), q[3], locked={f"q{joint + 1}": q[3, joint]})
        assert np.abs(again.q - found.q[3]).max() < 1e-9


def test_several_joints() -> None:
    arm = ik.Robot.from_dh(
        [
            [0.0, 0.0, 0.0, 0],
            [0.1, 1.0, 0.0, 0],
            [0.1, -1.0, 0.3, 0],
            [0.1, -np.pi / 2, 0.0, 0],
            [0.4, 0.0, 0.0, 0],
            [0.05, -np.pi / 2, 0.3, 0],
            [0.0, np.pi / 2, 0.0, 0],
            [0.0, -np.pi / 2, 0.0, 0],
        ],
        "modified",
        limits=[[-1, 1]] * 2 + [[-3, 3]] * 6,
        joint_types=["prismatic"] * 2 + ["revolute"] * 6,
        joint_names=["x", "y", *(f"q{i}" for i in range(6))],
    )
    rng = np.random.default_rng(6)
    q = rng.uniform(-1, 1, (20, 8))
    found = arm.ik_all(arm.fk(q), q, locked={"y": q[:, 1], "x": q[:, 0]})
    off = np.abs(found.q - q[:, None]).max(axis=2)
    assert np.where(found.valid, off, np.inf).min(axis=1).max() < 1e-6


def test_auto_sweeps_the_slide(arm: ik.Robot) -> None:
    rng = np.random.default_rng(7)
    q = rng.uniform(arm.lower, arm.upper, (200, 7))
    poses = arm.fk(q)
    result = arm.ik(poses, solver="auto")
    assert result.success.all()
    assert (result.iterations == 0).mean() > 0.9, "by the closed form, not by steps"
    assert np.abs(arm.fk(result.q) - poses).max() < 1e-6
    # From the posture itself there is nothing to move.
    stay = arm.ik(poses, solver="auto", q0=q)
    assert np.abs(stay.q - q).max() < 1e-6
    near = q + rng.uniform(-0.05, 0.05, q.shape)
    near = np.clip(near, arm.lower, arm.upper)
    moved = arm.ik(poses, solver="auto", q0=near)
    steps = arm.ik(poses, solver="lm", q0=near)
    way = np.linalg.norm(moved.q - near, axis=1)
    assert (way <= np.linalg.norm(steps.q - near, axis=1) + 1e-6).mean() > 0.95
    far = poses.copy()
    far[:, 0, 3] += 10
    far = arm.ik(far, solver="auto")
    assert not far.success.any()
    one = arm.ik(poses, solver="auto", threads=1)
    two = arm.ik(poses, solver="auto", threads=2)
    assert (one.q == two.q).all()


def test_bad_locks(arm: ik.Robot) -> None:
    pose = arm.fk(np.zeros(7))
    with pytest.raises(ik.ArgumentError, match=r"`locked`: .* slide 'd1'"):
        arm.ik_all(pose)
    with pytest.raises(ik.UnknownNameError, match="d1"):
        arm.ik_all(pose, locked={"d2": 0.1})
    with pytest.raises(ik.ArgumentError, match=r"`locked`: .*'d1'.*limits, 0 to 1.*1\.5"):
        arm.ik_all(pose, locked={"d1": 1.5})
    with pytest.raises(ik.ArgumentError, match=r"locked.*shape"):
        arm.ik_all(pose[None], locked={"d1": [0.1, 0.2]})
    with pytest.raises(ik.ArgumentError, match=r"locked.*dict"):
        arm.ik_all(pose, locked=0.5)  # type: ignore[arg-type]
    with pytest.raises(ik.ArgumentError, match="closed form"):
        arm.ik_all(pose, locked={"theta2": 0.1})
    mixed = arm.ik_all(np.stack([pose] * 3), locked={"d1": [0.1, np.nan, 0.2]})
    assert mixed.status[1] == Status.BAD_INPUT
    assert (mixed.status[[0, 2]] != Status.BAD_INPUT).all()
    assert np.isfinite(mixed.q).all()
