"""Differential inverse kinematics: twists met, limits kept, singularities survived."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import agrik_fast as ik
from agrik_fast.errors import ArgumentError, UnknownNameError


def test_twists_are_met_where_the_limits_allow_it():
    for name in ("panda", "ur5", "puma560"):
        arm = ik.Robot.load(name)
        q = 0.5 * (arm.random_q(40, seed=1) + arm.home)
        rng = np.random.default_rng(2)
        wanted = np.einsum("kij,kj->ki", arm.jacobian(q), 0.05 * rng.normal(size=q.shape))
        rates = arm.velocity(q, wanted, velocity_limits=2.0, acceleration_limits=np.inf)
        left = np.einsum("kij,kj->ki", arm.jacobian(q), rates) - wanted
        assert np.median(abs(left).max(1)) < 1e-5
        assert abs(rates).max() <= 2.0


def test_the_least_error_between_bounds_is_that_of_scipy():
    arm = ik.Robot.load("panda")
    rng = np.random.default_rng(3)
    size = arm.reach_radius
    weights = np.array([1, 1, 1, size, size, size])
    middle = 0.5 * (arm.lower + arm.upper)
    worse = 0
    for _ in range(30):
        q = middle + 0.3 * rng.normal(size=7)
        twist = rng.normal(size=6)
        rates = arm.velocity(q, twist, velocity_limits=0.5, acceleration_limits=np.inf)
        jacobian = weights[:, None] * arm.jacobian(q)
        best = lsq_linear(jacobian, weights * twist, (-0.5, 0.5), tol=1e-12)
        mine = 0.5 * ((jacobian @ rates - weights * twist) ** 2).sum()
        worse += mine > best.cost * 1.02 + 1e-6
    assert worse <= 2


@pytest.mark.parametrize("aim", [None, "middle", "limits", "manipulability"])
def test_a_servo_loop_keeps_all_limits(aim):
    arm = ik.Robot.load("panda")
    hz = 200.0
    rng = np.random.default_rng(4)
    q = np.tile(0.5 * (arm.lower + arm.upper), (50, 1))
    rates = np.zeros_like(q)
    twists = rng.normal(size=(50, 6))
    for _ in range(300):
        new = arm.velocity(q, twists, rate_hz=hz, rates=rates, second_aim=aim)
        assert np.isfinite(new).all()
        assert (abs(new) <= arm.velocity_limits + 1e-9).all()
        assert (abs(new - rates) <= arm.acceleration_limits / hz + 1e-9).all()
        rates, q = new, q + new / hz
        assert ((q >= arm.lower - 1e-9) & (q <= arm.upper + 1e-9)).all()
        twists += 0.1 * rng.normal(size=twists.shape)


def test_rates_stay_small_at_a_singularity():
    arm = ik.Robot.load("ur5")
    q = np.zeros(6)  # stretched out
    rates = arm.velocity(q, [0.1, 0.1, 0.1, 0, 0, 0], velocity_limits=50)
    assert np.isfinite(rates).all() and abs(rates).max() < 10


def test_second_aims_use_the_null_space():
    arm = ik.Robot.load("panda")
    q = 0.7 * arm.upper + 0.3 * arm.lower
    still = arm.velocity(q, np.zeros(6))
    moved = arm.velocity(q, np.zeros(6), second_aim="middle", acceleration_limits=np.inf)
    assert abs(still).max() < 1e-9
    assert abs(moved).max() > 1e-3
    assert abs(arm.jacobian(q) @ moved).max() < 1e-5
    middle = 0.5 * (arm.lower + arm.upper)
    assert ((moved * (middle - q)) / (arm.upper - arm.lower) ** 2).sum() > 0


def test_shapes_and_bad_input():
    arm = ik.Robot.load("ur5")
    q = arm.random_q((2, 3), seed=1)
    assert arm.velocity(q, np.zeros(6)).shape == (2, 3, 6)
    assert arm.velocity(q[0, 0], [0.1, 0, 0], task="position").shape == (6,)
    bad = q.copy()
    bad[0, 1, 2] = np.nan
    rates = arm.velocity(bad, [0.1, 0, 0, 0, 0, 0], velocity_limits=1)
    assert (rates[0, 1] == 0).all() and (rates[0, 0] != 0).any()
    assert np.array_equal(
        arm.velocity(q, [0.1] * 6, threads=1), arm.velocity(q, [0.1] * 6, threads=2)
    )
    for changes, name in (
        ({"q": [0.0] * 5}, "q"),
        ({"twist": [0.0] * 4}, "twist"),
        ({"rate_hz": 0}, "rate_hz"),
        ({"velocity_limits": -1}, "velocity_limits"),
        ({"acceleration_limits": [1, 2]}, "acceleration_limits"),
        ({"rates": [0.0]}, "rates"),
    ):
        with pytest.raises(ArgumentError, match=name):
            arm.velocity(**({"q": q[0, 0], "twist": np.zeros(6)} | changes))
    with pytest.raises(UnknownNameError, match="second_aim"):
        arm.velocity(q, np.zeros(6), second_aim="fast")


def test_a_tool_behind_the_robots_own_gets_the_twist():
    arm = ik.Robot.load("panda")
    q = arm.home + 0.05 * arm.random_q(5, seed=3)
    twist = np.array([0.05, 0.0, 0.02, 0.1, 0.0, 0.0])
    offset = np.eye(4)
    offset[:3, 3] = 0.02, 0.0, 0.15
    rates = arm.velocity(q, twist, tool=offset, velocity_limits=50, acceleration_limits=np.inf)
    own = np.linalg.inv(arm.fk_links(q[0])[-2]) @ arm.fk(q[0])
    there = arm.with_tool(own @ offset)
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", there.jacobian(q), rates), np.tile(twist, (5, 1)), atol=1e-4
    )
    with pytest.raises(ArgumentError, match="tool"):
        arm.velocity(q, twist, tool=np.eye(3))
    with pytest.raises(ArgumentError, match="tool"):
        arm.velocity(q, twist, tool=2 * np.eye(4))
