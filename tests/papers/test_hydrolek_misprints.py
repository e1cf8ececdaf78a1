"""The HydroLek paper as printed: every row of the table of misprints, with its error."""

from __future__ import annotations

import numpy as np
import pytest

from agrik_fast.papers import hydrolek
from agrik_fast.robot import Robot
from agrik_fast.solvers import IkPid, Plain, PseudoInverse, Transpose
from agrik_fast.tuning.goals import joint_uniform

ARM = Robot.load("hydrolek")
ROWS = [(row.a, row.alpha, row.d, row.theta) for row in ARM.dh or ()]
GOALS = joint_uniform(ARM, 200, 1)
TUNED = (0.012, 1e-7, 0.08)
PLANAR_ROWS = [(2.0, 0.0, 0.0, 0.0)] * 3


def test_equation_2_has_a_wrong_sign():
    postures = ARM.random_q(500, seed=1)
    tips = ARM.fk(postures)[:, :3, 3]

    def off(*, printed_sign):
        found = [hydrolek.printed_fk(ROWS, q, printed_sign=printed_sign) for q in postures]
        return np.linalg.norm(np.array(found)[:, :3, 3] - tips, axis=1)

    assert off(printed_sign=False).max() < 1e-14
    as_printed = 1000 * off(printed_sign=True)
    assert as_printed.min() == pytest.approx(735, abs=1)
    assert as_printed.max() == pytest.approx(991, abs=1)


def test_equation_2_leaves_out_the_last_row():
    tip = hydrolek.printed_fk(PLANAR_ROWS, np.zeros(3))[:2, 3]
    np.testing.assert_allclose(tip, [4.0, 0.0], atol=1e-15)
    whole = hydrolek.printed_fk(PLANAR_ROWS, np.zeros(3), tail=True)[:2, 3]
    np.testing.assert_allclose(whole, [6.0, 0.0], atol=1e-15)
    # The HydroLek's last a and alpha are zero.
    q = ARM.random_q(seed=2)
    short, long = (
        hydrolek.printed_fk(ROWS, q, printed_sign=False, tail=tail) for tail in (False, True)
    )
    np.testing.assert_array_equal(short, long)


def test_algorithm_1_corrected_is_the_librarys():
    found = hydrolek.algorithm1(ARM, GOALS, TUNED)
    solver = Plain(
        solver=IkPid.load("hydrolek_pid_published_tuned", as_tuned=True),
        start="zero",
        max_iterations=200,
    )
    native = ARM.ik(GOALS, solver=solver, position_tolerance=1e-3)
    np.testing.assert_array_equal(found.reached, native.success)
    np.testing.assert_array_equal(
        found.sweeps[found.reached], native.iterations[native.success].astype(int)
    )
    assert found.reached.sum() == 197


@pytest.mark.parametrize(
    ("line", "reached"), [("line14", 194), ("line15", 59), ("lines12_18", 0), ("both_plus", 0)]
)
def test_algorithm_1_as_printed_loses_goals(line, reached):
    found = hydrolek.algorithm1(ARM, GOALS, TUNED, hydrolek.Reading(**{line: True}))
    assert abs(int(found.reached.sum()) - reached) <= (3 if reached else 0)
    if line == "line14":
        literal = Plain(
            solver=IkPid(kp=TUNED[0], ki=TUNED[1], kd=TUNED[2], literal=True),
            start="zero",
            max_iterations=200,
        )
        native = ARM.ik(GOALS, solver=literal, position_tolerance=1e-3)
        assert native.success.sum() == found.reached.sum()


def test_algorithm_1_has_no_exit():
    found = hydrolek.algorithm1(
        ARM, GOALS[:50], TUNED, hydrolek.Reading(no_exit=True), most_sweeps=100
    )
    assert (found.sweeps == 100).all()
    with_exit = hydrolek.algorithm1(ARM, GOALS[:50], TUNED, most_sweeps=100)
    assert 40 < with_exit.sweeps[with_exit.reached].mean() < 60
    # As in Table II, whose times for IK-PID are the same at all tolerances; all others' grow.
    for method, times in hydrolek.TABLE_2_MS.items():
        known = [time for time in times if time is not None]
        growth = max(known) / min(known)
        assert growth < 1.01 if method == "IK-PID" else growth > 2


def test_the_singular_example_is_the_transpose_and_has_no_alpha():
    arm = hydrolek.planar_arm()
    jacobian = arm.jacobian(np.zeros(3))[:2]
    np.testing.assert_allclose(jacobian, [[0, 0, 0], [6, 4, 2]], atol=1e-15)
    error = np.array([-1.0, 0.0])
    assert not (jacobian.T @ error).any()
    with np.errstate(invalid="ignore"):
        alpha = (
            np.linalg.norm(jacobian.T @ error) / np.linalg.norm(jacobian @ jacobian.T @ error)
        ) ** 2
    assert np.isnan(alpha)  # printed: 0
    assert not (np.linalg.pinv(jacobian) @ error).any()
    for solver in (Transpose(), PseudoInverse(cutoff=1e-9)):
        ended = arm.ik([5.0, 0.0, 0.0], solver=Plain(solver=solver), q0=np.zeros(3))
        assert not ended.success and not ended.q.any()


def test_alpha_of_12_is_that_of_buss():
    q = ARM.random_q(50, seed=3)
    jacobian = ARM.jacobian(q)[:, :3]
    error = np.random.default_rng(0).normal(size=(50, 3))
    back = np.einsum("kij,ki->kj", jacobian, error)
    there = np.einsum("kij,kj->ki", jacobian, back)
    printed = (np.linalg.norm(back, axis=1) / np.linalg.norm(there, axis=1)) ** 2
    buss = (error * there).sum(axis=1) / (there * there).sum(axis=1)
    np.testing.assert_allclose(printed, buss, rtol=1e-12)


def test_sixty_five_percent_are_sixty_four_to_seventy_six():
    state, inverse = (hydrolek.TABLE_2_MS[name] for name in ("state space", "pseudo-inverse"))
    ratios = [100 * a / b for a, b in zip(state, inverse, strict=True)]
    np.testing.assert_allclose(ratios, [73.4, 68.4, 64.0, 75.9], atol=0.05)
    assert np.mean(ratios) == pytest.approx(70.4, abs=0.1)


def test_the_goal_is_no_place_that_the_arm_reaches():
    """(-10, 50, -20) in cm, in the frame in which the published gains work."""
    goal = ARM.frames["paper"][:3, :3].T @ np.array([-0.1, 0.5, -0.2])
    assert np.linalg.norm(goal) == pytest.approx(0.548, abs=1e-3)
    ended = ARM.ik(goal, position_tolerance=1e-3)
    assert not ended.success and ended.position_error > 0.5
    for unit in (1e-3, 0.0254, 0.1):  # mm, inches, dm: nowhere in any frame
        assert not 0.521 < unit * np.linalg.norm([10, 50, 20]) < 1.211


def test_robot_has_the_right_arm_alone():
    assert "the right arm of two" in ARM.description
