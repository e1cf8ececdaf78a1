"""Feedback solvers through the Python API: gains, units, frames, statuses, bad input."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import Status, solvers
from agrik_fast.errors import ArgumentError, UnknownNameError
from agrik_fast.tuning import goals

ARM = ik.Robot.load("hydrolek")
GOALS = goals.joint_uniform(ARM, 1000, 1)
FEEDBACK = ("ccd", "ik-pid", "state-space", "static-gain", "broyden")


def solve(solver, **options):
    return ARM.ik(GOALS, solver=solver, position_tolerance=1e-3, **options)


def assert_true(arm, targets, result, tolerance):
    done = result.success
    reached = arm.fk(result.q[done])[:, :3, 3]
    assert (np.linalg.norm(reached - targets[done], axis=1) <= tolerance).all()
    assert (result.q >= arm.lower - 1e-15).all() and (result.q <= arm.upper + 1e-15).all()


@pytest.mark.parametrize(
    ("name", "solved"),
    [
        ("hydrolek_full90_pso", 990),
        ("hydrolek_full90_cma", 987),
        ("hydrolek_diag24_pso", 983),
        ("hydrolek_diag24_cma", 991),
        ("hydrolek_k15_pso", 987),
        ("hydrolek_k15_cma", 991),
        ("hydrolek_trial_published", 739),
    ],
)
def test_bundled_state_spaces_reach_what_they_should(name, solved):
    result = solve(solvers.StateSpace.load(name, as_tuned=True))
    assert abs(int(result.success.sum()) - solved) <= 3
    assert_true(ARM, GOALS, result, 1e-3)
    failed = set(np.unique(result.status[~result.success]).tolist())
    assert failed <= {Status.NOT_FOUND, Status.STALLED}


@pytest.mark.parametrize(
    "solver",
    [
        solvers.CyclicCoordinateDescent(start="zero"),
        solvers.IkPid(start="zero"),
        solvers.Broyden(start="zero"),
        solvers.Plain(solver=solvers.DampedLeastSquares()),
    ],
)
def test_where_attempts_start_decides_no_turn(solver):
    """Without `q0` the turn nearest to the middle of the limits; with it the one nearest to it."""
    arm = ik.Robot.from_dh(
        [[0.5, 0, 0, 0], [0.4, 0, 0, 0], [0.3, 0, 0, 0]], limits=[[-1.0, 6.9]] * 3
    )
    targets = arm.fk(np.array([[-0.5, 0.6, -0.7], [-0.9, 0.3, -0.8], [0.3, 0.5, 0.2]]))[:, :3, 3]
    for q0, about in ((None, 2.95), (np.zeros(3), 0.0)):
        found = arm.ik(targets, q0=q0, solver=solver)
        assert found.success.all()
        for turn in (-2 * np.pi, 2 * np.pi):
            other = found.q + turn
            inside = (other > -1.0) & (other < 6.9)
            assert (np.abs(other - about) >= np.abs(found.q - about))[inside].all()
    assert (found.q < 0.0).any()


def test_the_frame_of_gains_follows_the_robots_first_link():
    gains = solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True)
    turned = ARM.in_frame("paper")
    there = GOALS @ ARM.frames["paper"][:3, :3].T
    result = turned.ik(there, solver=gains, position_tolerance=1e-3)
    here = solve(gains)
    assert abs(int(result.success.sum()) - int(here.success.sum())) <= 1
    both = result.success & here.success
    np.testing.assert_allclose(result.q[both], here.q[both], atol=1e-6)


def test_units_are_data_of_the_gains():
    gains = solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True)
    degree = np.pi / 180
    metric = dataclasses.replace(
        gains,
        B=np.array(gains.B) / gains.length_unit_m,
        C=np.array(gains.C) * degree,
        length_unit_m=1.0,
        angle_unit_rad=1.0,
    )
    np.testing.assert_allclose(solve(gains).q, solve(metric).q, atol=1e-9)


def test_restarts_make_feedback_solvers_reliable():
    for name in ("ccd", "ik-pid", "broyden"):
        result = solve(name)
        assert result.success.mean() >= 0.999, name
        assert_true(ARM, GOALS, result, 1e-3)


@pytest.mark.parametrize("robot", ["hydrolek", "ur5", "panda"])
def test_ik_pid_meets_the_default_tolerance(robot):
    arm = ik.Robot.load(robot)
    points = arm.fk(arm.random_q(100, seed=1))[:, :3, 3]
    result = arm.ik(points, solver=solvers.IkPid())
    assert result.success.mean() >= 0.98
    published = solvers.IkPid(ki=1e-7)
    assert arm.ik(points, solver=published).iterations.mean() > result.iterations.mean()


def test_answers_do_not_depend_on_lanes_threads_or_slices():
    for name in FEEDBACK:
        whole = solve(name, threads=1).q
        np.testing.assert_array_equal(whole, solve(name, threads=2).q)
        piece = ARM.ik(
            GOALS[300:340], solver=name, position_tolerance=1e-3, first_index=300, threads=1
        )
        np.testing.assert_array_equal(whole[300:340], piece.q)


@pytest.mark.parametrize("robot", ik.Robot.names())
@pytest.mark.parametrize("solver", ["ccd", "broyden", "pinv-closed"])
def test_every_robot_reaches_most_positions_without_tuning(robot, solver):
    arm = ik.Robot.load(robot)
    targets = goals.joint_uniform(arm, 200, 5)
    result = arm.ik(targets, solver=solver, position_tolerance=1e-3)
    assert result.success.mean() >= 0.97
    assert_true(arm, targets, result, 1e-3)


@pytest.mark.parametrize("robot", ik.Robot.names())
@pytest.mark.parametrize("solver", ["static-gain", "state-space"])
def test_one_matrix_serves_a_part_of_every_workspace(robot, solver):
    # The middle posture of redundant7 is singular: a matrix frozen there reached nothing.
    arm = ik.Robot.load(robot)
    targets = goals.joint_uniform(arm, 100, 5)
    result = arm.ik(targets, solver=solver, position_tolerance=1e-3)
    assert result.success.mean() >= 0.25
    assert_true(arm, targets, result, 1e-3)


def test_prismatic_joints_take_part():
    arm = ik.Robot.from_dh(
        [[0, np.pi / 2, 0.4, 0], [0, -np.pi / 2, 0.2, 0], [0, 0, 0.1, 0]],
        joint_types=["revolute", "revolute", "prismatic"],
        limits=[(-3, 3), (-2, 2), (0.1, 1.0)],
    )
    targets = goals.joint_uniform(arm, 200, 6)
    for solver in FEEDBACK:
        result = arm.ik(targets, solver=solver, position_tolerance=1e-3)
        assert_true(arm, targets, result, 1e-3)
    assert arm.ik(targets, solver="ccd", position_tolerance=1e-3).success.mean() >= 0.99


def test_poses_and_masks_take_six_columns():
    poses = ARM.fk(goals.joint_uniform_q(ARM, 50, 8))
    result = ARM.ik(poses, solver=solvers.Broyden(max_restarts=300), orientation_tolerance=1e-3)
    assert result.success.mean() >= 0.8
    with pytest.raises(ArgumentError, match=r"`B`: expected a 6 x 6 matrix, got 6 x 3"):
        ARM.ik(poses, solver=solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True))


def test_plain_steps_tell_a_stall_from_giving_up():
    arm = ik.Robot.from_dh(
        [[2, 0, 0, 0]] * 3, limits=[(-1.0472, 1.0472)] * 3, joint_types=["revolute"] * 3
    )
    for inner in (solvers.Transpose(), solvers.PseudoInverse(), solvers.DampedLeastSquares()):
        result = arm.ik([5.0, 0, 0], solver=solvers.Plain(solver=inner))
        assert result.status == Status.STALLED
        np.testing.assert_array_equal(result.q, 0)
    assert arm.ik([5.0, 0, 0]).success  # the default gets away


def test_an_unstable_state_warns_and_is_told_from_a_miss():
    gains = solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True)
    unstable = 3.0 * np.eye(6)
    with pytest.warns(UserWarning, match=r"spectral radius 3\.000"):
        bad = dataclasses.replace(gains, A=unstable)
    result = ARM.ik(GOALS[:50], solver=bad, position_tolerance=1e-6)
    assert (result.status == Status.NON_FINITE).any()
    assert np.isfinite(result.q).all()
    assert "non-finite" in repr(result)


def test_gains_for_another_robot_are_refused():
    gains = solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True)
    with pytest.raises(
        ArgumentError, match='gains for robot "ur5", got gains for robot "hydrolek"'
    ):
        ik.Robot.load("ur5").ik([0.3, 0.2, 0.4], solver=gains)
    anyones = dataclasses.replace(gains, robot=None)
    with pytest.raises(ArgumentError, match="`C`: expected a 7 x 6 matrix"):
        ik.Robot.load("redundant7").ik([0.3, 0.2, 0.4], solver=anyones)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"A": np.eye(2)}, "all three or none"),
        ({"A": np.ones((2, 3)), "B": np.ones((2, 3)), "C": np.ones((6, 2))}, "a square matrix"),
        ({"A": np.zeros((2, 2)), "B": np.ones((3, 3)), "C": np.ones((6, 2))}, "shape (2, 3)"),
        ({"A": np.zeros((2, 2)), "B": np.ones((2, 3)), "C": np.ones((6, 3))}, "shape (n, 2)"),
        ({"A": [[np.nan]], "B": [[1, 1, 1]], "C": [[1]]}, "finite numbers"),
        ({"frame": np.ones((3, 3))}, "a rotation matrix"),
        ({"length_unit_m": 0.0}, "> 0"),
        ({"robot": 5}, "a robot's name or None"),
    ],
)
def test_matrices_that_do_not_fit_are_refused(fields, message):
    with pytest.raises(ArgumentError) as caught:
        solvers.StateSpace(**fields)
    assert message in str(caught.value)


def test_a_state_space_may_have_fewer_states_than_joints():
    gain = np.array(solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True).static_gain())
    u, s, v = np.linalg.svd(gain, full_matrices=False)
    template = solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True)
    three = dataclasses.replace(template, A=np.zeros((3, 3)), B=v, C=u * s)
    assert solve(three).success.sum() >= 985


def test_words_are_checked():
    with pytest.raises(UnknownNameError, match="unknown start 'midle'"):
        solvers.StaticGain(start="midle")
    with pytest.raises(UnknownNameError, match="unknown order"):
        solvers.IkPid(order="tip")
    for field in ("literal", "incremental"):
        with pytest.raises(ArgumentError, match=f"`IkPid.{field}`: expected True or False"):
            solvers.IkPid(**{field: "no"})
    with pytest.raises(ArgumentError, match="a position task"):
        ARM.ik(ARM.fk(np.zeros(6)), solver="ccd")


def test_feedback_solvers_are_values():
    gains = solvers.StateSpace.load("hydrolek_full90_pso", as_tuned=True)
    again = pickle.loads(pickle.dumps(gains))
    assert again == gains and hash(again) == hash(gains)
