"""Population solvers from Python: shares solved, records, options, what is refused."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast._native import default_settings
from agrik_fast.errors import ArgumentError, UnknownNameError
from agrik_fast.papers import redundant7
from agrik_fast.solvers import DifferentialEvolution, GeneticAlgorithm
from numpy_fk import fk, pose_error

COARSE = {"position_tolerance": 1e-4, "orientation_tolerance": 1e-3}
SOLVERS = (DifferentialEvolution, GeneticAlgorithm)


@pytest.fixture(scope="module")
def arm() -> ik.Robot:
    return ik.Robot.load("redundant7")


def test_the_published_recipe_on_the_published_target(arm: ik.Robot) -> None:
    poses = np.broadcast_to(redundant7.target(), (1000, 4, 4))
    result = arm.ik(poses, solver=DifferentialEvolution.paper(), **COARSE)
    assert 0.91 <= result.success.mean() <= 0.96
    assert (result.iterations == 200).all() and not result.restarts.any()
    # Every run that fails ends with a joint at a limit.
    stuck = result.q[~result.success]
    assert (np.minimum(stuck - arm.lower, arm.upper - stuck).min(axis=1) < 1e-3).mean() > 0.9
    costs = redundant7.cost(arm, result.q, redundant7.target())
    assert 3e-7 < np.median(costs) < 1e-5
    # Every answer has the one |q4| that reaches the target.
    solved = result.q[result.success]
    assert np.abs(np.abs(solved[:, 3]) - 1.7293153436083457).max() < 1e-3


def test_the_published_recipe_on_random_targets(arm: ik.Robot) -> None:
    poses = arm.fk(arm.random_q(1000, seed=1))
    result = arm.ik(poses, solver=DifferentialEvolution.paper(), **COARSE)
    assert 0.89 <= result.success.mean() <= 0.94


def test_the_default_solves_ten_thousand_random_targets(arm: ik.Robot) -> None:
    poses = arm.fk(arm.random_q(10_000, seed=2))
    result = arm.ik(poses, solver="de")
    assert result.success.mean() >= 0.999
    good = result.success
    position, orientation = pose_error(fk("redundant7", result.q[good]), poses[good])
    assert position.max() <= 1e-6 + 1e-11
    assert orientation.max() <= 1e-6 + 1e-11
    inside = (result.q >= arm.lower) & (result.q <= arm.upper)
    assert inside.all()


@pytest.mark.parametrize("name", ["ur5", "panda", "puma560", "hydrolek", "cucumber", "tomato"])
@pytest.mark.parametrize("solver", ["de", "ga"])
def test_other_robots_and_tasks(
    name: str, solver: str, load_robot: Callable[[str], ik.Robot]
) -> None:
    robot = load_robot(name)
    poses = robot.fk(robot.random_q(40, seed=3))
    task = "pose" if robot.dof >= 6 else "position"
    assert robot.ik(poses, task, solver=solver).success.mean() >= 0.95
    assert robot.ik(poses[:, :3, 3], solver=solver).success.mean() >= 0.95
    if robot.dof >= 5:
        assert robot.ik(poses, "axis", solver=solver).success.mean() >= 0.95


@pytest.mark.parametrize("solver", [*SOLVERS, DifferentialEvolution.paper])
def test_answers_depend_on_seed_and_index_alone(arm: ik.Robot, solver: Any) -> None:
    poses = arm.fk(arm.random_q(12, seed=4))
    made = solver()
    whole = arm.ik(poses, solver=made, threads=1)
    np.testing.assert_array_equal(whole.q, arm.ik(poses, solver=made, threads=3).q)
    parts = [arm.ik(poses[i : i + 5], solver=made, first_index=i).q for i in range(0, 12, 5)]
    np.testing.assert_array_equal(whole.q, np.concatenate(parts))
    assert not np.array_equal(whole.q, arm.ik(poses, solver=made, seed=1).q)


def test_defaults_are_those_of_the_core() -> None:
    for solver in SOLVERS:
        assert dataclasses.asdict(solver()) == default_settings()[solver.name]


@pytest.mark.parametrize("solver", SOLVERS)
def test_solvers_are_frozen_and_documented(solver: type[Any]) -> None:
    made = solver(population=60)
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.population = 3
    assert pickle.loads(pickle.dumps(made)) == made
    for field in dataclasses.fields(solver):
        shown = repr(field.default).replace("'", '"')
        assert f"{field.name} : " in solver.__doc__
        assert f"default {shown}" in solver.__doc__


def test_the_paper_recipe_is_the_published_one() -> None:
    recipe = DifferentialEvolution.paper()
    assert (recipe.weight, recipe.crossover, recipe.redraw) == (0.5, (0.375, 1.125), "gene")
    assert (recipe.mutation, recipe.boundary, recipe.generations) == ("best1", "median", 200)
    assert not recipe.polish


@pytest.mark.parametrize(
    ("changes", "argument", "expected"),
    [
        ({"population": 0}, "population", "a whole number, 4 to 1048576"),
        ({"population": 3}, "population", "a whole number, 4 to 1048576"),
        ({"generations": 0}, "generations", "a whole number, 1 to 4294967295"),
        ({"position_weight": np.nan}, "position_weight", "a finite number >= 0 per m"),
        ({"orientation_weight": -1.0}, "orientation_weight", "a finite number >= 0 per rad"),
        ({"position_weight": 0.0}, "position_weight", "one of the weights above 0"),
        ({"start_weight": np.inf}, "start_weight", "a finite number >= 0"),
        ({"boundary": 3}, "boundary", "one of median, clamp, reflect, redraw"),
        ({"polish": 1}, "polish", "True or False"),
        ({"weight": 0.0}, "weight", "a finite number > 0 and <= 2"),
        ({"crossover": (0.5,)}, "crossover", "two numbers"),
        ({"crossover": (0.6, 0.5)}, "crossover", "a finite number >= 0.6 and <= 2"),
    ],
)
def test_fields_are_checked(changes: dict[str, Any], argument: str, expected: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        DifferentialEvolution(**changes)
    assert caught.value.argument == f"DifferentialEvolution.{argument}"
    assert caught.value.expected == expected


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"tournament": 0}, "tournament"),
        ({"tournament": 49}, "tournament"),
        ({"elites": 48}, "elites"),
        ({"crossover_rate": 1.5}, "crossover_rate"),
        ({"mutation_rate": -0.1}, "mutation_rate"),
        ({"mutation_width": np.nan}, "mutation_width"),
    ],
)
def test_fields_of_the_genetic_algorithm_are_checked(
    changes: dict[str, Any], argument: str
) -> None:
    with pytest.raises(ArgumentError, match=rf"`GeneticAlgorithm\.{argument}`"):
        GeneticAlgorithm(**changes)


def test_unknown_words_name_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="unknown boundary 'clam'; did you mean 'clamp'"):
        DifferentialEvolution(boundary="clam")  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="unknown mutation 'best2'; did you mean 'best1'"):
        DifferentialEvolution(mutation="best2")  # type: ignore[arg-type]


def test_euler_angles_need_a_full_orientation(arm: ik.Robot) -> None:
    pose = arm.fk(np.zeros(7))
    with pytest.raises(ArgumentError, match="`orientation`: expected the rotation vector"):
        arm.ik(pose, "axis", solver=DifferentialEvolution.paper())


def test_statuses(arm: ik.Robot) -> None:
    poses = arm.fk(arm.random_q(4, seed=5))
    poses[1, :3, 3] = [9, 0, 0]
    poses[2, 0, 0] = np.nan
    result = arm.ik(poses, solver="de")
    wanted = [ik.Status.CONVERGED, ik.Status.OUT_OF_REACH, ik.Status.BAD_INPUT]
    assert result.status.tolist() == [*wanted, ik.Status.CONVERGED]


@pytest.mark.parametrize("solver", ["de", "ga", "lm", DifferentialEvolution.paper()])
def test_the_wrist_has_bounds(arm: ik.Robot, solver: Any) -> None:
    # The elbow folds to 400 mm from shoulder to wrist (Table I, q4) and stretches to 800;
    # the tool hangs below the wrist or stands on it.
    distances = np.array([0.2, 0.399, 0.401, 0.799, 0.801])
    poses = np.tile(np.eye(4), (5, 1, 1))
    poses[:, 2, 3] = 0.34 + distances + 0.126
    result = arm.ik(poses, solver=solver, **COARSE)
    reachable = [False, False, True, True, False]
    assert ((result.status == ik.Status.OUT_OF_REACH) != reachable).all()
    # Told before the run, not after all restarts.
    assert not result.restarts[np.logical_not(reachable)].any()


def test_a_local_minimum_is_told(arm: ik.Robot) -> None:
    poses = np.broadcast_to(redundant7.target(), (300, 4, 4))
    long = dataclasses.replace(DifferentialEvolution.paper(), redraw="individual", generations=300)
    result = arm.ik(poses, solver=long, **COARSE)
    failed = result.status[~result.success]
    assert len(failed) and (failed == ik.Status.STALLED).mean() > 0.8
    short = dataclasses.replace(long, generations=10)
    assert (arm.ik(poses[:20], solver=short).status == ik.Status.NOT_FOUND).all()
    assert "stalled" in repr(result)


def test_a_warm_start_is_used_and_kept_near(arm: ik.Robot) -> None:
    q = arm.random_q(100, seed=6)
    poses, start = arm.fk(q), np.clip(q + 0.05, arm.lower, arm.upper)
    near = arm.ik(poses, solver=DifferentialEvolution(start_weight=0.01), q0=start)
    assert near.success.mean() > 0.98
    free = arm.ik(poses, solver="de")
    way = [np.linalg.norm(r.q - start, axis=1) for r in (near, free)]
    assert np.median(way[0]) < 0.2 < np.median(way[1])
    assert (near.iterations == 0).mean() > 0.9


def test_cost_history(arm: ik.Robot) -> None:
    recipe = DifferentialEvolution.paper()
    curve = arm.cost_history(redundant7.target(), recipe, seed=3)
    assert curve.shape == (201,)
    assert (np.diff(curve) <= 0).all() and curve[-1] < 1e-3 < 10 < curve[0]
    # It is the history of the run that `ik` makes.
    result = arm.ik(redundant7.target(), solver=recipe, seed=3)
    cost = redundant7.cost(arm, result.q, redundant7.target())
    np.testing.assert_allclose(curve[-1], cost, rtol=1e-6, atol=1e-9)
    with pytest.raises(ArgumentError, match="`solver`: expected a population solver"):
        arm.cost_history(redundant7.target(), "lm")
    with pytest.raises(ArgumentError, match="`targets`: expected one target, got 2 targets"):
        arm.cost_history(np.stack([np.eye(4)] * 2))


def test_more_generations_and_variants(arm: ik.Robot) -> None:
    poses = arm.fk(arm.random_q(100, seed=8))
    recipe = DifferentialEvolution.paper()
    for changes, least in (
        ({"adaptation": "lshade"}, 0.85),
        ({"adaptation": "jde", "crossover": (0.9, 0.9)}, 0.75),
        ({"mutation": "current-to-best1"}, 0.85),
        ({"boundary": "redraw"}, 0.85),
        ({"stagnation": 40}, 0.8),
    ):
        solver = dataclasses.replace(recipe, **changes)
        assert arm.ik(poses, solver=solver, **COARSE).success.mean() >= least, changes
