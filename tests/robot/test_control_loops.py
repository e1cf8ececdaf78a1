"""Control loops: postures never jump, targets out of reach are followed, re-entry is quick."""

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import Status
from agrik_fast.errors import ArgumentError

ARMS = ("strawberry", "cucumber", "hydrolek", "tomato", "redundant7", "puma560", "ur5", "panda")
MOST = 0.02


def targets_of(arm, rng, ticks):
    """Return targets of a random drive: joint paths through limits, out of reach and back.

    With them, which targets belong to a joint path, so that they can be reached.
    """
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    poses, reachable = [], []
    q = rng.uniform(lower, upper)
    begin = q
    while len(poses) < ticks:
        to = rng.uniform(lower, upper)
        steps = int(np.ceil((abs(to - q) / (0.4 * MOST)).max()))
        path = q + np.linspace(0, 1, steps + 1)[1:, None] * (to - q)
        there = arm.fk(path)
        inside = np.ones(steps, dtype=bool)
        if rng.random() < 0.5:
            # A bump to beyond the reach, and back to the path.
            first, last = np.sort(rng.integers(0, steps, 2))
            way = rng.normal(size=3)
            way *= 3 * arm.reach_radius / np.linalg.norm(way)
            share = np.sin(np.linspace(0, np.pi, last - first + 1)) ** 2
            there[first : last + 1, :3, 3] += share[:, None] * way
            inside[first : last + 1] = False
        poses.append(there)
        reachable.append(inside)
        q = to
    return begin, np.concatenate(poses)[:ticks], np.concatenate(reachable)[:ticks]


def drive(arm, seed, ticks, most=MOST):
    """Return postures, statuses and reachability of a random drive."""
    rng = np.random.default_rng(seed)
    q, poses, reachable = targets_of(arm, rng, ticks)
    loop = arm.solver(max_change=most)
    postures, statuses = [q], []
    for k, pose in enumerate(poses):
        loop.solve(pose, q if k == 0 else None)
        postures.append(loop.q)
        statuses.append(loop.status)
    return np.array(postures), np.array(statuses), reachable, poses


def stretched(arm, loop, most):
    """Return whether a loop comes to rest as near to a far target as the arm gets."""
    far = arm.fk(arm.random_q(seed=4))
    far[:3, 3] = arm.reach_center + np.array([0.3, 2.0 * arm.reach_radius, 0.1])
    nearest = arm.ik(far).position_error
    for _ in range(int(8 / most)):
        loop.solve(far)
    return loop.position_error <= nearest + 0.05 * arm.reach_radius


@pytest.mark.parametrize("name", ARMS)
def test_postures_never_jump_and_targets_are_found_again(name):
    arm = ik.Robot.load(name)
    q, status, reachable, poses = drive(arm, 3, 1200)
    assert abs(np.diff(q, axis=0)).max() <= MOST
    assert set(status.tolist()) <= {Status.CONVERGED, Status.HELD}
    assert ((q >= arm.lower) & (q <= arm.upper)).all()
    solved = np.flatnonzero(status == Status.CONVERGED)
    for row in solved[:: max(len(solved) // 50, 1)]:
        assert abs(arm.fk(q[row + 1]) - poses[row]).max() < 3e-6
    entries = np.flatnonzero(reachable[1:] & ~reachable[:-1]) + 1
    for entry in entries:
        there = arm.ik(poses[entry], q0=q[entry], nearest=True)
        ticks = 2 * (abs(there.q - q[entry]) / MOST).max() + 10
        after = np.flatnonzero(status[entry:] == Status.CONVERGED)
        wait = after[0] if len(after) else len(status) - entry
        outside = np.flatnonzero(~reachable[entry:])
        left = outside[0] if len(outside) else len(status) - entry
        assert wait <= ticks or left <= ticks, (name, entry, wait, ticks)


@pytest.mark.parametrize("name", ARMS)
def test_most_ticks_on_joint_paths_arrive(name):
    # One drive may stand on a posture that runs away for long: shares are of three.
    arm = ik.Robot.load(name)
    shares = []
    for seed in (3, 4, 5):
        _, status, reachable, _ = drive(arm, seed, 1200)
        shares.append((status[reachable] == Status.CONVERGED).mean())
    assert np.mean(shares) > 0.55


def test_a_posture_that_runs_out_of_its_limits_is_not_gone_to():
    # Of the two postures of a plane arm the nearer one leaves its limits while the arm is on its
    # way there: the loop goes to the other one, whose elbow bends the other way.
    arm = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], limits=[[-3, 3], [-2.6, 1.2]])
    bends = 0.9 + 0.008 * np.arange(120)
    points = arm.fk(np.stack([np.zeros_like(bends), bends], axis=1))[:, :3, 3]
    for begin in ([0.9, 0.2], [0.5, 0.2], [0.9, 0.3]):
        loop = arm.solver("position", max_change=0.02)
        reached = [loop.solve(p, begin if k == 0 else None) for k, p in enumerate(points)]
        assert 60 < reached.index(True) < 110
        assert loop.q[1] < 0
        assert abs(arm.fk(loop.q)[:3, 3] - points[-1]).max() < 3e-6


def test_a_far_target_is_stretched_towards():
    for name in ("ur5", "panda"):
        arm = ik.Robot.load(name)
        loop = arm.solver(max_change=0.02)
        loop.solve(arm.fk(arm.random_q(seed=2)))
        assert stretched(arm, loop, 0.02), name
        assert loop.status == Status.HELD


def test_a_bound_for_each_joint_and_from_velocity_limits():
    arm = ik.Robot.load("panda")
    q = arm.home + 0.3 * (arm.random_q(seed=1) - arm.home)
    most = np.linspace(0.001, 0.02, 7)
    loop = arm.solver(max_change=most)
    target = arm.fk(arm.random_q(seed=5))
    for _ in range(100):
        loop.solve(target, q)
        assert (abs(loop.q - q) <= most).all()
        q = loop.q
    clock = arm.solver(rate_hz=100.0)
    clock.solve(target, q)
    assert (abs(clock.q - q) <= arm.velocity_limits / 100).all()
    assert abs(clock.q - q).max() > 0


def test_the_same_ticks_give_the_same_bits():
    arm = ik.Robot.load("ur5")
    one, other = (drive(arm, 8, 300)[0] for _ in range(2))
    assert np.array_equal(one, other)


def test_bad_input_stays_where_it_is():
    arm = ik.Robot.load("ur5")
    loop = arm.solver(max_change=0.01)
    q = arm.random_q(seed=1)
    loop.solve(arm.fk(q), q)
    before = loop.q
    assert not loop.solve(np.full((4, 4), np.nan))
    assert loop.status == Status.BAD_INPUT
    assert np.array_equal(loop.q, before)
    with pytest.raises(ArgumentError, match="q0"):
        loop.solve(arm.fk(q), np.zeros(5))


@pytest.mark.parametrize("wrong", [0, -0.1, np.nan, np.inf, [0.1] * 5, [0.1] * 5 + [0.0]])
def test_a_bound_is_above_zero(wrong):
    with pytest.raises(ArgumentError, match="max_change"):
        ik.Robot.load("ur5").solver(max_change=wrong)


def test_a_rate_needs_velocity_limits():
    arm = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]])
    with pytest.raises(ArgumentError, match=r"rate_hz.*velocity limit"):
        arm.solver(rate_hz=100)
    for wrong in (0, -1, np.nan):
        with pytest.raises(ArgumentError, match="rate_hz"):
            ik.Robot.load("panda").solver(rate_hz=wrong)
    with pytest.raises(ArgumentError, match="max_change"):
        ik.Robot.load("panda").solver(rate_hz=10, max_change=0.1)
