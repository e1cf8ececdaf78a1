"""Motions along paths: within the limits, at rest at both ends, on the path."""

from __future__ import annotations

import itertools
import pickle

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import motion
from agrik_fast.robot import JointPath


def within_limits(trajectory: motion.Trajectory, arm: ik.Robot) -> None:
    """Check every limit by finite differences, the rests and the times."""
    fine = trajectory.sampled(max(2000.0 / max(trajectory.duration, 1e-9), 1.0))
    assert (np.diff(fine.times) > 0).all()
    for end in (0, -1):
        assert np.abs(fine.velocities[end]).max() == 0
        # Just behind the last phase the arm rests.
        assert np.abs(fine.accelerations[end]).max() <= 1e-9
    h = 1e-5 * trajectory.duration
    times = np.linspace(2 * h, trajectory.duration - 2 * h, 3001)
    (q0, v0, a0), (q1, v1, a1) = trajectory.at(times - h), trajectory.at(times + h)
    _, v, a = trajectory.at(times)
    assert (np.abs(v) <= arm.velocity_limits * (1 + 1e-9)).all()
    assert (np.abs(a) <= arm.acceleration_limits * (1 + 1e-9)).all()
    jerk = (a1 - a0) / (2 * h)
    assert (np.abs(jerk) <= arm.jerk_limits * (1 + 1e-4)).all()
    assert (
        np.abs((q1 - q0) / (2 * h) - v) <= 1e-6 * arm.velocity_limits + arm.jerk_limits * h**2
    ).all()
    assert (np.abs((v1 - v0) / (2 * h) - a) <= arm.jerk_limits * h).all()


def published(v: float, a: float, j: float) -> float:
    """Return the duration of one segment of length 1, as the field writes it."""
    tj = a / j if v * j >= a * a else np.sqrt(v / j)
    ta = tj + v / (j * tj)
    if v * ta <= 1:
        return float(2 * ta + (1 / v - ta))
    tj = a / j
    ta = tj / 2 + np.sqrt(tj * tj / 4 + 1 / a)
    return float(2 * ta if ta >= 2 * tj else 4 * (1 / (2 * j)) ** (1 / 3))


@pytest.mark.parametrize("name", ["panda", "cucumber", "ur5", "strawberry", "tomato"])
def test_straight_segments_take_the_published_time(name: str) -> None:
    arm = ik.Robot.load(name)
    q = arm.random_q(4, seed=3)
    trajectory = motion.time_law(arm, q)
    wanted = 0.0
    for change in np.abs(np.diff(q, axis=0)):
        rows = (arm.velocity_limits, arm.acceleration_limits, arm.jerk_limits)
        wanted += published(*(float((row / change).min()) for row in rows))
    assert trajectory.duration == pytest.approx(wanted, rel=1e-12)
    within_limits(trajectory, arm)
    np.testing.assert_allclose(trajectory.positions[0], q[0], atol=1e-15)
    assert (trajectory.positions[-1] == q[-1]).all()
    # Straight in the joint values: every point lies on a segment.
    share = np.linspace(0, trajectory.duration, 200)
    for point in trajectory.at(share)[0]:
        off = [distance(point, a, b) for a, b in itertools.pairwise(q)]
        assert min(off) < 1e-12


def distance(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Return the distance of a point from a segment."""
    way = b - a
    share = np.clip((point - a) @ way / (way @ way), 0, 1)
    return float(np.linalg.norm(a + share * way - point))


def test_rounded_corners_keep_the_limits_and_their_distance() -> None:
    arm = ik.Robot.load("cucumber")
    q = arm.random_q(7, seed=11)
    resting = motion.time_law(arm, q)
    rounded = motion.time_law(arm, q, blend=0.4)
    within_limits(rounded, arm)
    assert rounded.duration < resting.duration
    assert resting.deviation == 0
    points = rounded.at(np.linspace(0, rounded.duration, 20_000))[0]
    for corner in q[1:-1]:
        nearest = np.abs(points - corner).max(axis=1).min()
        assert nearest <= rounded.deviation + 1e-4


def test_a_smooth_curve_goes_through_all_postures() -> None:
    arm = ik.Robot.load("panda")
    turn = np.linspace(0, 1, 25)[:, None]
    start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    q = start + 0.4 * np.sin(2 * turn * np.arange(1, 8))
    trajectory = motion.time_law(arm, q, smooth=True)
    within_limits(trajectory, arm)
    points = trajectory.at(np.linspace(0, trajectory.duration, 20_000))[0]
    for posture in q:
        assert np.abs(points - posture).max(axis=1).min() < 1e-3


def test_lines_and_arcs_stay_on_their_way_and_below_the_speed() -> None:
    arm = ik.Robot.load("panda")
    start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    point = arm.fk(start)[:3, 3]
    line = motion.time_law(arm, arm.line(start, np.add(point, [0, 0.3, 0])), speed=0.25)
    within_limits(line, arm)
    tool = arm.fk(line.positions)[:, :3, 3]
    assert np.abs(tool[:, [0, 2]] - point[[0, 2]]).max() < 1e-7
    speeds = np.linalg.norm(np.diff(tool, axis=0), axis=1) / np.diff(line.times)
    assert 0.2499 < speeds.max() < 0.25 * (1 + 1e-6)
    arc = motion.time_law(
        arm, arm.arc(start, np.add(point, [0, 0.1, 0.1]), np.add(point, [0, 0.2, 0]))
    )
    within_limits(arc, arm)
    tool = arm.fk(arc.positions)[:, :3, 3]
    radius = np.linalg.norm(tool - (np.add(point, [0, 0.1, 0])), axis=1)
    assert np.abs(radius - 0.1).max() < 1e-6
    followed = arm.follow(arm.fk(line.positions[::10]), line.positions[0])
    assert motion.time_law(arm, followed).duration > 0


def test_scale_makes_the_same_motion_slower() -> None:
    arm = ik.Robot.load("ur5")
    q = arm.random_q(3, seed=1)
    quick, slow = motion.time_law(arm, q), motion.time_law(arm, q, scale=0.25)
    assert slow.duration == pytest.approx(4 * quick.duration, rel=1e-12)
    times = np.linspace(0, 1, 50)
    np.testing.assert_allclose(
        slow.at(times * slow.duration)[0], quick.at(times * quick.duration)[0], atol=1e-9
    )


def test_points_are_at_a_fixed_rate_or_one_a_phase() -> None:
    arm = ik.Robot.load("ur5")
    trajectory = motion.time_law(arm, [arm.home, arm.home + 0.5], rate=100.0)
    steps = np.diff(trajectory.times)
    np.testing.assert_allclose(steps[:-1], 0.01, atol=1e-12)
    assert 0 < steps[-1] <= 0.01 * (1 + 1e-5)
    assert trajectory.times[-1] == trajectory.duration
    phases = trajectory.sampled(None)
    assert (phases.times == trajectory.phase_times).all()
    # One joint value of a straight move between two points is a cubic of time.
    a, b = phases.times[1:3]
    q, v, acc = trajectory.at(a)
    jerk = phases.jerks[1]
    dt = b - a
    np.testing.assert_allclose(
        trajectory.at(b)[0], q + v * dt + acc * dt**2 / 2 + jerk * dt**3 / 6, atol=1e-14
    )
    again = pickle.loads(pickle.dumps(trajectory))
    assert (again.positions == trajectory.positions).all()
    assert again.rate == 100.0
    shaped = trajectory.at(np.zeros((2, 3)))
    assert shaped[0].shape == (2, 3, 6)


def test_what_does_not_move_takes_no_time() -> None:
    arm = ik.Robot.load("ur5")
    for q in ([arm.home], [arm.home, arm.home]):
        trajectory = motion.time_law(arm, q)
        assert trajectory.duration == 0
        assert trajectory.times.tolist() == [0.0]
        assert (trajectory.positions == arm.home).all()


def test_jerk_may_be_free() -> None:
    arm = ik.Robot.load("ur5")
    q = [arm.home, arm.home + 1.0]
    free = motion.time_law(arm, q, jerk=np.inf)
    assert free.duration == pytest.approx(2 * np.sqrt(1 / (2 * np.pi)), rel=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"path": [[0.0, 0.0]]}, r"waypoints.*shape \(1, 2\)"),
        ({"path": np.zeros((0, 6))}, "waypoints"),
        ({"path": [[0, 0, 0, 0, 0, np.nan]]}, "waypoints.*NaN"),
        ({"path": [[0, 0, 0, 0, 0, 9.0]]}, r"waypoints\[0\].*9 for joint 'wrist_3'"),
        ({"path": "home"}, "waypoints"),
        ({"blend": 0.6}, "blend"),
        ({"blend": 0.2, "smooth": True}, "blend"),
        ({"scale": 0.0}, "scale"),
        ({"scale": 2.0}, "scale"),
        ({"speed": 0.1}, "speed.*a path of the joints"),
        ({"rate": 0.0}, "rate"),
        ({"rate": 1e12}, "rate.*points"),
        ({"rate": "fast"}, "rate"),
        ({"velocity": [1.0, 2.0]}, r"velocity.*shape \(2,\)"),
        ({"acceleration": -1.0}, "acceleration"),
        ({"acceleration": np.inf}, "acceleration.*no limit of joint 'shoulder_pan'"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    arm = ik.Robot.load("ur5")
    given = {"path": [arm.home, arm.home + 0.1]} | change
    with pytest.raises(ik.ArgumentError, match=message):
        motion.time_law(arm, given.pop("path"), **given)  # type: ignore[arg-type]


def test_bad_paths() -> None:
    arm, other = ik.Robot.load("ur5"), ik.Robot.load("panda")
    with pytest.raises(ik.ArgumentError, match="arm"):
        motion.time_law("ur5", [arm.home])  # type: ignore[arg-type]
    path = arm.joint_path([arm.home, arm.home + 0.1])
    with pytest.raises(ik.ArgumentError, match=r"path.*shape \(2, 6\)"):
        motion.time_law(other, path)
    with pytest.raises(ik.ArgumentError, match=r"blend.*the path says"):
        motion.time_law(arm, path, blend=0.1)
    start = arm.joint_values({"shoulder_lift": -1.0, "elbow": 1.5, "wrist_2": 1.0})
    far = arm.line(start, [3.0, 0, 0])
    assert not far.success
    assert len(far) < len(far.status)
    with pytest.raises(ik.ArgumentError, match=r"path.*reaches \d+ of its \d+ targets"):
        motion.time_law(arm, far)
    with pytest.raises(ik.ArgumentError, match=r"path.*reaches \d+ of its \d+ targets"):
        motion.time_law(arm, arm.follow([[3.0, 0, 0], [3.1, 0, 0]], start))
    plain = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]])
    with pytest.raises(ik.ArgumentError, match=r"acceleration.*no limit of joint 'q2'"):
        motion.time_law(plain, [[0, 0], [0, 1]])
    done = motion.time_law(plain, [[0, 0], [0, 1]], velocity=1.0, acceleration=1.0, jerk=10.0)
    assert done.duration > 1
    with pytest.raises(ik.ArgumentError, match="times"):
        done.at([0.0, np.nan])


def test_paths_may_be_made_by_hand() -> None:
    arm = ik.Robot.load("ur5")
    q = np.array([arm.home, arm.home + 0.2, arm.home])
    made = JointPath(q, np.array([2.0, 2.0]), np.array([0.0, 0.5, 0.0]))
    trajectory = motion.time_law(arm, made)
    within_limits(trajectory, arm)
    assert 0 < trajectory.deviation < 0.2
    bad = JointPath(q, np.array([2.0, 2.0]), np.array([0.0, 2.5, 0.0]))
    with pytest.raises(ik.ArgumentError, match="blends"):
        motion.time_law(arm, bad)
