"""The same input, seed and version give bit-identical answers, however a batch is cut up."""

from itertools import pairwise

import numpy as np
import pytest

from agrik_fast import solvers, tasks

FIELDS = (
    "q",
    "success",
    "status",
    "position_error",
    "orientation_error",
    "iterations",
    "restarts",
)
# Several runs of the batch engine, the last one not full.
COUNT = 1500
# Two restarts leave some targets unsolved, whose best joint values count as well.
SOLVERS = (
    solvers.LevenbergMarquardt(max_restarts=2),
    solvers.DampedLeastSquares(max_restarts=2),
    solvers.PseudoInverse(max_restarts=2),
    solvers.Transpose(max_iterations=50, max_restarts=2),
)
TASKS = (
    tasks.Pose(),
    tasks.Position(),
    tasks.Axis(tool_axis=(1, 0, 0)),
    tasks.Masked((1, 1, 1, 0.5, 0, 0), "tool"),
)


def targets_of(robot):
    """Reachable poses, with some out of reach and some that are no numbers."""
    targets = robot.fk(robot.random_q(COUNT, seed=9))
    targets[::50, 2, 3] += 0.6
    targets[7::300, 0, 0] = np.nan
    return targets


def assert_identical(one, other):
    for field in FIELDS:
        a, b = getattr(one, field), getattr(other, field)
        assert a.tobytes() == b.tobytes(), field


def in_pieces(robot, targets, edges, q0=None, **options):
    pieces = []
    for first, end in pairwise(edges):
        start = q0[first:end] if q0 is not None else None
        pieces.append(robot.ik(targets[first:end], q0=start, first_index=first, **options))

    class Joined:
        pass

    joined = Joined()
    for field in FIELDS:
        setattr(joined, field, np.concatenate([getattr(piece, field) for piece in pieces]))
    return joined


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: solver.name)
@pytest.mark.parametrize("name", ["puma560", "cucumber"])
def test_threads_and_pieces_do_not_matter(load_robot, name, solver, task):
    robot = load_robot(name)
    targets = targets_of(robot)
    options = {"task": task, "solver": solver, "seed": 5}
    whole = robot.ik(targets, threads=1, **options)
    assert_identical(whole, robot.ik(targets, threads=2, **options))
    assert_identical(whole, robot.ik(targets.reshape(30, 50, 4, 4), threads=3, **options))
    edges = [0, 1, 2, 10, 310, 311, 900, COUNT]
    assert_identical(whole, in_pieces(robot, targets, edges, threads=2, **options))


def test_single_calls_give_the_answers_of_the_batch(load_robot):
    robot = load_robot("redundant7")
    targets = targets_of(robot)[:300]
    whole = robot.ik(targets, seed=2**64 - 1)
    assert_identical(whole, in_pieces(robot, targets, range(301), seed=2**64 - 1))


def test_starts_go_with_their_targets(load_robot):
    robot = load_robot("ur5")
    targets = targets_of(robot)
    q0 = robot.random_q(COUNT, seed=10)
    whole = robot.ik(targets, q0=q0, threads=2)
    assert_identical(whole, robot.ik(targets, q0=q0, threads=1))
    assert_identical(whole, in_pieces(robot, targets, [0, 333, 1234, COUNT], q0))


def test_neighbours_do_not_matter(load_robot):
    robot = load_robot("redundant7")
    targets = targets_of(robot)
    whole = robot.ik(targets)
    others = targets.copy()
    others[:700, :3, 3] = 50.0
    others[900:, 0, 0] = np.inf
    np.testing.assert_array_equal(robot.ik(others).q[700:900], whole.q[700:900])


def test_indices_wrap_around_at_the_end_of_their_range(load_robot):
    robot = load_robot("puma560")
    targets = targets_of(robot)[:4]
    last = robot.ik(targets, first_index=2**64 - 2)
    assert_identical(robot.ik(targets[2:]), in_pieces(robot, targets[2:], [0, 1, 2]))
    np.testing.assert_array_equal(last.q[2:], robot.ik(targets[2:]).q)
