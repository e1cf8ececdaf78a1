"""Lines, arcs and ways through postures."""

from __future__ import annotations

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import rotations

ARM = ik.Robot.load("panda")
START = ARM.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
POINT = ARM.fk(START)[:3, 3]


def test_a_line_is_straight_and_turns_evenly() -> None:
    end = ARM.fk(START)
    turn = rotations.rotation_of(rotations.pose([0, 0, 0], axis_angle=[0, 0.5, 0]))
    end[:3, :3] = end[:3, :3] @ turn
    end[:3, 3] += [0.05, 0.2, -0.1]
    path = ARM.line(START, end, step=0.01)
    assert path.success
    assert path.of_tool
    assert (path.q[0] == START).all()
    poses = ARM.fk(path.q)
    share = np.linspace(0, 1, len(path))[:, None]
    np.testing.assert_allclose(poses[:, :3, 3], POINT + share * [0.05, 0.2, -0.1], atol=2e-6)
    angles = rotations.axis_angle_of(np.swapaxes(poses[:1, :3, :3], 1, 2) @ poses[:, :3, :3])
    np.testing.assert_allclose(angles, share * [0, 0.5, 0], atol=4e-6)
    assert path.lengths.sum() == pytest.approx(np.linalg.norm([0.05, 0.2, -0.1]))
    assert path.lengths.max() <= 0.01
    assert ARM.line(START, np.add(POINT, [0, 0.1, 0]), step=0.002).lengths.max() <= 0.002 + 1e-12


def test_a_turn_in_place_is_measured_in_radians() -> None:
    end = ARM.fk(START)
    end[:3, :3] = end[:3, :3] @ rotations.rotation_of(
        rotations.pose([0, 0, 0], axis_angle=[0, 0, 0.3])
    )
    path = ARM.line(START, end)
    assert path.success
    assert path.lengths.sum() == pytest.approx(0.3)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_an_arc_goes_through_all_three_points(share: float) -> None:
    angle = 1.6 * np.pi
    circle = [[0, 0.1 - 0.1 * np.cos(t), 0.1 * np.sin(t)] for t in (share * angle, angle)]
    path = ARM.arc(START, POINT + circle[0], POINT + circle[1])
    assert path.success
    points = ARM.fk(path.q)[:, :3, 3] - POINT
    np.testing.assert_allclose(np.linalg.norm(points - [0, 0.1, 0], axis=1), 0.1, atol=2e-6)
    np.testing.assert_allclose(points[-1], circle[1], atol=2e-6)
    assert path.lengths.sum() == pytest.approx(0.1 * angle)


def test_what_cannot_be_reached_ends_the_path() -> None:
    path = ARM.line(START, [2.0, 0, 0.5])
    assert not path.success
    assert 1 < len(path) < len(path.status)
    assert len(path.lengths) == len(path) - 1
    assert "not all reached" in repr(path)


def test_arms_of_few_joints_follow_points() -> None:
    arm = ik.Robot.load("strawberry")
    q = 0.5 * (arm.lower + arm.upper)
    end = arm.fk(q)[:3, 3] + [0.1, 0.05, 0.02]
    path = arm.line(q, end, task="position")
    assert path.success
    np.testing.assert_allclose(arm.fk(path.q[-1])[:3, 3], end, atol=2e-6)


def test_ways_through_postures() -> None:
    q = np.array([START, START + 0.2, START])
    path = ARM.joint_path(q, blend=0.5)
    assert path.blends is not None
    assert path.blends.tolist() == [0.0, 0.5 * path.lengths[0], 0.0]
    assert path.lengths[0] == pytest.approx((0.2 / ARM.velocity_limits).max())
    assert ARM.joint_path(q, smooth=True).blends is None
    assert len(ARM.joint_path([START])) == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start": START[:3]}, r"start.*shape \(3,\)"),
        ({"start": np.full(7, np.nan)}, "start"),
        ({"start": START + 9}, "start.*within its limits"),
        ({"end": np.zeros(2)}, r"end.*shape \(2,\)"),
        ({"end": [0, 0, np.inf]}, "end"),
        ({"end": np.zeros((4, 4))}, "end|poses|rotation"),
        ({"end": POINT}, "end.*stands already"),
        ({"step": 0.0}, "step"),
        ({"step": 1e-9}, "step.*postures"),
        ({"turn": -1.0}, "turn"),
        ({"max_joint_step": 0.0}, "max_joint_step"),
        ({"task": "fly"}, "task"),
    ],
)
def test_bad_lines(change: dict[str, object], message: str) -> None:
    given = {"start": START, "end": np.add(POINT, [0, 0.1, 0])} | change
    with pytest.raises((ik.ArgumentError, ik.UnknownNameError), match=message):
        ARM.line(**given)  # type: ignore[arg-type]


def test_bad_arcs() -> None:
    end = np.add(POINT, [0, 0.2, 0])
    for via in (np.add(POINT, [0, 0.1, 0]), POINT, end):
        with pytest.raises(ik.ArgumentError, match=r"via.*on the line through both ends"):
            ARM.arc(START, via, end)
    with pytest.raises(ik.ArgumentError, match="via"):
        ARM.arc(START, [0, np.nan, 0], end)
    with pytest.raises(ik.ArgumentError, match=r"via.*shape \(2,\)"):
        ARM.arc(START, [0, 0], end)
