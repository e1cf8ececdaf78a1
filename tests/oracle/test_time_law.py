"""Motions against Ruckig (from rest to rest, jerk-limited) and TOPP-RA (along a path)."""

from __future__ import annotations

import numpy as np
import pytest
import ruckig
import toppra
from toppra import algorithm, constraint

import agrik_fast as ik
from agrik_fast import motion

CASES = 300


def test_straight_segments_take_as_long_as_ruckig_says() -> None:
    rng = np.random.default_rng(5)
    arm = ik.Robot.from_dh([[1, 0, 0, 0]], name="one")
    for _ in range(CASES):
        v, a, j = np.exp(rng.uniform(-3, 3, 3))
        way = float(np.exp(rng.uniform(-4, 3)))
        trajectory = motion.time_law(arm, [[0], [way]], velocity=v, acceleration=a, jerk=j)
        asked = ruckig.InputParameter(1)
        asked.current_position, asked.target_position = [0.0], [way]
        asked.max_velocity, asked.max_acceleration, asked.max_jerk = [v], [a], [j]
        found = ruckig.Trajectory(1)
        ruckig.Ruckig(1).calculate(asked, found)
        assert trajectory.duration == pytest.approx(found.duration, rel=1e-12)
        times = np.linspace(0, found.duration, 50)
        q, speed, _ = trajectory.at(times)
        theirs = np.array([found.at_time(time)[:2] for time in times])
        np.testing.assert_allclose(q, theirs[:, 0], atol=1e-9 * way)
        np.testing.assert_allclose(speed, theirs[:, 1], atol=1e-9 * v)


@pytest.mark.parametrize("name", ["panda", "ur5", "cucumber"])
def test_smooth_paths_are_not_much_slower_than_topp_ra(name: str) -> None:
    """TOPP-RA knows no jerk, so that it is given up here; it is the shortest time there is."""
    toppra.setup_logging("ERROR")
    arm = ik.Robot.load(name)
    for seed in range(5):
        ends = arm.random_q(4, seed=seed)
        knots = np.linspace(0, 1, 4)
        way = toppra.SplineInterpolator(knots, ends)
        fine = np.linspace(0, 1, 61)
        q = np.clip(way(fine), arm.lower, arm.upper)
        ours = motion.time_law(arm, q, smooth=True, jerk=np.inf)
        path = toppra.SplineInterpolator(fine, q)
        pairs = [np.column_stack([-x, x]) for x in (arm.velocity_limits, arm.acceleration_limits)]
        limits = [
            constraint.JointVelocityConstraint(pairs[0]),
            constraint.JointAccelerationConstraint(pairs[1]),
        ]
        solver = algorithm.TOPPRA(limits, path, parametrizer="ParametrizeConstAccel")
        shortest = solver.compute_trajectory(0, 0).duration
        assert 0.99 * shortest <= ours.duration <= 2.0 * shortest, (seed, ours.duration / shortest)
