"""Options of solvers and tasks: frozen, checked, and the same defaults as in the core."""

from __future__ import annotations

import dataclasses
import math
import pickle
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import solvers
from agrik_fast._native import default_settings
from agrik_fast.errors import ArgumentError, UnknownNameError
from agrik_fast.solvers import (
    Broyden,
    ClosedPseudoInverse,
    CyclicCoordinateDescent,
    DampedLeastSquares,
    IkPid,
    LevenbergMarquardt,
    PseudoInverse,
    StateSpace,
    StaticGain,
    Transpose,
)
from agrik_fast.tasks import Axis, Masked, Pose, Position

SOLVERS = (
    LevenbergMarquardt,
    DampedLeastSquares,
    PseudoInverse,
    ClosedPseudoInverse,
    Transpose,
)
FEEDBACK = (CyclicCoordinateDescent, IkPid, StateSpace, StaticGain, Broyden)


@pytest.mark.parametrize("solver", SOLVERS)
def test_defaults_are_those_of_the_core(solver: type[Any]) -> None:
    assert dataclasses.asdict(solver()) == default_settings()[solver.name]


def test_the_core_knows_no_other_solver() -> None:
    classes = [getattr(solvers, name) for name in solvers.__all__]
    # Neither has defaults of the core: one takes another's steps, one takes none.
    others = {solvers.Plain.name, solvers.ClosedForm.name}
    named = {it.name for it in classes if isinstance(it, type)} - others
    assert set(default_settings()) == named


@pytest.mark.parametrize("solver", FEEDBACK)
def test_defaults_of_feedback_solvers_are_those_of_the_core(solver: type[Any]) -> None:
    core = default_settings()[solver.name]
    made = dataclasses.asdict(solver())
    assert {"max_iterations", "max_restarts"} <= core.keys()
    assert {name: made[name] for name in core} == core


@pytest.mark.parametrize("solver", SOLVERS)
def test_solvers_are_frozen(solver: type[Any]) -> None:
    made = solver()
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.max_restarts = 3
    assert pickle.loads(pickle.dumps(made)) == made


@pytest.mark.parametrize("solver", SOLVERS)
def test_every_field_is_documented_with_its_default(solver: type[Any]) -> None:
    for field in dataclasses.fields(solver):
        kind = "int" if isinstance(field.default, int) else "float"
        assert f"{field.name} : {kind}, default {field.default!r}" in solver.__doc__


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("max_iterations", 0, "a whole number, 1 to 4294967295"),
        ("max_iterations", 2.5, "a whole number, 1 to 4294967295"),
        ("max_iterations", True, "a whole number, 1 to 4294967295"),
        ("max_restarts", -1, "a whole number, 0 to 4294967295"),
        ("max_restarts", 2**32, "a whole number, 0 to 4294967295"),
        ("max_step", 0.0, "a finite number > 0 rad or m"),
        ("max_step", math.inf, "a finite number > 0 rad or m"),
        ("max_step", "1", "a finite number > 0 rad or m"),
    ],
)
def test_fields_of_the_loop_are_checked(
    solver: type[Any], field: str, value: object, expected: str
) -> None:
    with pytest.raises(ArgumentError) as caught:
        solver(**{field: value})
    error = caught.value
    assert error.argument == f"{solver.__name__}.{field}"
    assert (error.expected, error.received) == (expected, repr(value))


@pytest.mark.parametrize(
    ("solver", "field", "value"),
    [
        (LevenbergMarquardt, "damping", 0.0),
        (LevenbergMarquardt, "damping", math.nan),
        (DampedLeastSquares, "damping", -0.1),
        (PseudoInverse, "cutoff", 0),
        (PseudoInverse, "cutoff", 1.0),
        (PseudoInverse, "cutoff", 2.0),
    ],
)
def test_fields_of_the_step_are_checked(solver: type[Any], field: str, value: float) -> None:
    with pytest.raises(ArgumentError, match=rf"`{solver.__name__}\.{field}`: expected a finite"):
        solver(**{field: value})


def test_numpy_scalars_are_welcome() -> None:
    made = LevenbergMarquardt(damping=np.float32(0.5), max_restarts=np.int64(3))
    assert (made.damping, made.max_restarts) == (0.5, 3)


@pytest.fixture(scope="module")
def arm() -> ik.Robot:
    return ik.Robot.load("ur5")


@pytest.mark.parametrize("solver", SOLVERS + FEEDBACK)
def test_a_name_means_the_solver_with_its_defaults(solver: type[Any], arm: ik.Robot) -> None:
    points = arm.fk(arm.random_q(20, seed=1))[:, :3, 3]
    poses = points if solver in FEEDBACK else arm.fk(arm.random_q(20, seed=1))
    by_name, by_object = arm.ik(poses, solver=solver.name), arm.ik(poses, solver=solver())
    np.testing.assert_array_equal(by_name.q, by_object.q)
    np.testing.assert_array_equal(by_name.iterations, by_object.iterations)


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_caps_hold(solver: type[Any], arm: ik.Robot) -> None:
    poses = arm.fk(arm.random_q(20, seed=2))
    result = arm.ik(poses, solver=solver(max_iterations=2, max_restarts=3), seed=3)
    assert result.restarts.max() == 3
    unsolved = ~result.success
    # Two steps in each of four attempts; one that has come near a solution gets eight times
    # as many.
    assert np.median(result.iterations[unsolved]) == 8
    assert result.iterations.max() <= 8 * 8
    assert (result.status[unsolved] == ik.Status.NOT_FOUND).all()


def test_an_unknown_solver_names_the_nearest(arm: ik.Robot) -> None:
    with pytest.raises(UnknownNameError) as caught:
        arm.ik(np.eye(4), solver="lmm")
    message = "unknown solver 'lmm'; did you mean 'lm'? Known: lm, dls, pinv, "
    assert str(caught.value).startswith(message)
    with pytest.raises(ArgumentError, match="`solver`: expected a solver"):
        arm.ik(np.eye(4), solver=3)  # type: ignore[arg-type]


def test_an_unknown_name_error_survives_pickling() -> None:
    error = UnknownNameError("robot", "pumma560", ["puma560", "ur5"])
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error)
    assert str(copy) == "unknown robot 'pumma560'; did you mean 'puma560'? Known: puma560, ur5"
    assert (copy.kind, copy.nearest) == ("robot", ("puma560",))
    other = ArgumentError("q", "shape (3,)", "shape (..., 7)")
    assert str(pickle.loads(pickle.dumps(other))) == "`q`: expected shape (..., 7), got shape (3,)"


def test_tasks_are_inferred_or_named(arm: ik.Robot) -> None:
    poses = arm.fk(arm.random_q((2, 5), seed=4))
    points = poses[..., :3, 3]

    def q(targets: Any, task: Any) -> Any:
        return arm.ik(targets, task).q

    np.testing.assert_array_equal(q(poses, None), q(poses, Pose()))
    np.testing.assert_array_equal(q(poses, "pose"), q(poses, Pose()))
    np.testing.assert_array_equal(q(points, None), q(points, Position()))
    np.testing.assert_array_equal(q(poses, "position"), q(points, None))
    np.testing.assert_array_equal(q(poses, "axis"), q(poses, Axis()))
    assert arm.ik(np.zeros((0, 3))).q.shape == (0, 6)


def test_unknown_tasks_and_shapes_are_refused(arm: ik.Robot) -> None:
    with pytest.raises(UnknownNameError, match="unknown task 'poses'; did you mean 'pose'"):
        arm.ik(np.eye(4), "poses")
    with pytest.raises(ArgumentError, match=r"`targets`: expected shape .* for poses"):
        arm.ik(np.zeros((5, 2)))
    with pytest.raises(ArgumentError, match="`task`: expected a task"):
        arm.ik(np.zeros(3), 1)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="`targets`: expected poses"):
        arm.ik(np.zeros(3), Pose())
    with pytest.raises(ArgumentError, match="`direction`: expected a direction for the tool axis"):
        arm.ik(np.zeros(3), Axis())


def test_directions_are_kept_as_unit_vectors() -> None:
    task = Axis(tool_axis=[2, 0, 0], direction=np.array([0, 3, -4]))  # type: ignore[arg-type]
    assert task.tool_axis == (1.0, 0.0, 0.0)
    assert task.direction == (0.0, 0.6, -0.8)
    assert pickle.loads(pickle.dumps(task)) == task


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Axis((0, 0, 0)), "`Axis.tool_axis`: expected a finite direction of non-zero"),
        (lambda: Axis((0, 0)), r"`Axis.tool_axis`: expected shape \(3,\), got shape \(2,\)"),
        (lambda: Axis(direction=(0, math.nan, 1)), "`Axis.direction`: expected a finite dir"),
        (lambda: Axis("xyz"), "`Axis.tool_axis`: expected an array of numbers"),
        (lambda: Masked((1, 1, 1)), r"`Masked.weights`: expected shape \(6,\)"),
        (lambda: Masked((0,) * 6), "at least one above 0"),
        (lambda: Masked((1, 1, 1, 0, 0, -1)), "`Masked.weights`: expected finite weights >= 0"),
        (lambda: Masked((1,) * 6, frame="world"), "`Masked.frame`: expected 'base' or 'tool'"),
    ],
)
def test_fields_of_tasks_are_checked(make: Any, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        make()
