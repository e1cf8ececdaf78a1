"""What the HydroLek paper leaves open: edge, singular starts, poses, stability, other robots."""

from __future__ import annotations

import numpy as np
import pytest

from agrik_fast import Status
from agrik_fast.papers import hydrolek
from agrik_fast.robot import Robot
from agrik_fast.solvers import Plain, StateSpace, StaticGain
from agrik_fast.tuning import goals

ARM = Robot.load("hydrolek")


def test_jacobian_methods_stand_in_the_success_counts():
    rows = {(row[0], row[1]): row for row in hydrolek.success_counts(ARM)}
    for name, reached in (("pseudo-inverse", 994), ("transpose", 984), ("damped, 200 mm", 992)):
        row = rows[name, "zero"]
        assert row[2] == "992 to 999"
        assert abs(row[3] - reached) <= 3
    for row in rows.values():
        assert 0 <= row[7] <= 1000 - row[3]
    # IK-PID's failures on the periphery: 4 of 7 of the first set from zero, 7 of 7 from the
    # middle.
    for start, at_edge in (("zero", 4), ("middle", 7)):
        assert abs(rows["IK-PID, tuned", start][7] - at_edge) <= 2


def test_goals_are_lost_at_the_edge_more_than_elsewhere():
    rows, points, first = hydrolek.lost_goals(ARM)
    by_name = {row.method: row for row in rows}
    wanted = {
        "pseudo-inverse": (18, 13),
        "transpose": (52, 7),
        "damped, 200 mm": (24, 5),
        "IK-PID, Kp 0.02": (170, 44),
        "IK-PID, tuned": (26, 15),
        "state space, optimised": (44, 39),
    }
    for name, (lost, at_edge) in wanted.items():
        row = by_name[name]
        assert row.goals == 3000 and row.edge_share == pytest.approx(0.058, abs=0.003)
        assert abs(row.lost - lost) <= 5 and abs(row.lost_at_edge - at_edge) <= 5
        # More often than goals are at the edge.
        assert row.lost_at_edge / row.lost > 1.5 * row.edge_share
        assert first[name].shape == (1000,)
    # Not "the points that fail are on the periphery": not all of them.
    assert by_name["IK-PID, tuned"].lost - by_name["IK-PID, tuned"].lost_at_edge >= 5
    assert points.shape == (1000, 3)


def test_the_edge_is_where_the_workspace_ends():
    edge = hydrolek.Edge(ARM)
    far = np.array([[3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert edge.holds(far).all()
    middle = 0.5 * (ARM.lower + ARM.upper)
    assert not edge.holds(ARM.fk(middle)[None, :3, 3]).any()


def test_within_its_limits_the_hydrolek_has_no_singular_posture():
    assert hydrolek.least_within_limits(ARM) == pytest.approx(0.0866, abs=5e-4)
    values = hydrolek.least_singular_value(ARM, ARM.random_q(20_000, seed=9))
    assert values.min() > 0.0865


def test_starts_beside_singular_postures():
    postures = hydrolek.singular_postures(12)
    assert postures.least.max() < 1e-6
    rows = hydrolek.singularity_study(12)
    assert len(rows) == len(hydrolek.methods()) * len(hydrolek.DISTANCES)
    reached = {(row[0], row[1]): row[2] for row in rows}
    for row in rows:
        assert row[2] + row[3] + row[4] == row[5] == 12
    for name in ("pseudo-inverse, closed form", "pseudo-inverse, SVD", "transpose"):
        for distance in hydrolek.DISTANCES[2:]:
            assert reached[name, distance] >= 11
    # Exactly singular: the transpose has no step, damped steps have one.
    assert reached["transpose", 0.0] <= 1
    # The state space does not notice, and reaches few from anywhere.
    own = [reached["state space, 90 (PSO)", distance] for distance in hydrolek.DISTANCES]
    assert max(own) - min(own) <= 2 and max(own) < 6


def test_a_radian_is_to_count_as_much_as_the_arm_is_large():
    rows = hydrolek.success_by_weight(ARM, 200)
    reached = {(row.method, row.length): row.reached for row in rows}
    for name in ("IK-PID, published", "transpose", "damped, 200 mm"):
        small, right = reached[name, 0.02], reached[name, 0.43]
        # Section 4 asks for the first.
        assert small < 40 and right > 170
    assert reached["IK-PID, published", 2.0] < 20
    tuned = hydrolek.PoseRow(*next(row for row in rows if "tuned for" in row.method))
    assert tuned.reached >= 0


def test_gains_for_poses_are_better_than_untuned_ones():
    poses = goals.joint_uniform_poses(ARM, 1000, 1)
    counts = []
    for solver in (StaticGain(), StaticGain.load("hydrolek_pose_cma", as_tuned=True)):
        ended = ARM.ik(poses, solver=Plain(solver=solver, start="zero"), **hydrolek.POSE_TOLERANCE)
        counts.append(int(ended.success.sum()))
    untuned, tuned = counts
    assert untuned < 660 and tuned > untuned + 100


def test_lost_goals_rest_at_limits_and_nowhere_else():
    for row in hydrolek.stability(ARM):
        assert row.rank == 3 and row.radius_of_a < 1
        assert row.stable_share > 0.99
        assert row.stalled_free == 0 and row.reached_unstable == 0
        assert row.reached + row.stalled_at_limit + row.moving == 1000


def test_the_radius_tells_how_fast_errors_die_out():
    gains = StateSpace.load("hydrolek_k15_cma", as_tuned=True)
    target = ARM.fk(0.5 * (ARM.lower + ARM.upper))[:3, 3]
    errors = hydrolek.error_trace(ARM, gains, target, "zero", 400, 1e-9)
    ended = ARM.ik(target, solver=Plain(solver=gains, start="zero"), position_tolerance=1e-9)
    assert ended.status == Status.CONVERGED
    radius = float(hydrolek.spectral_radius(ARM, gains, ended.q))
    tail = errors[errors < 1e-5]
    rate = (tail[-1] / tail[0]) ** (1 / (len(tail) - 1))
    assert rate == pytest.approx(radius, abs=0.05)
    # A static gain of half the inverse halves the error.
    half = np.linalg.pinv(ARM.jacobian(ended.q)[:3]) / 2
    by_hand = StaticGain(K=half.tolist())
    assert hydrolek.spectral_radius(ARM, by_hand, ended.q) == pytest.approx(0.5, abs=1e-9)


def test_tuned_gains_of_other_robots_reach_more():
    rows = {row.robot: row for row in hydrolek.tuned_robots()}
    assert set(rows) == set(hydrolek.OTHERS)
    for row in rows.values():
        assert row.tuned > row.untuned
