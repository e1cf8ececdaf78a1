"""The solver object for control loops: the answers of `ik`, one target at a time."""

import gc
import tracemalloc

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.errors import ArgumentError


@pytest.fixture(scope="module")
def arm():
    return ik.Robot.load("puma560")


@pytest.fixture(scope="module")
def poses(arm):
    return arm.fk(arm.random_q(300, seed=21))


def test_answers_are_those_of_ik(arm, poses):
    solver = arm.solver(seed=5)
    reached = 0
    for pose in poses:
        wanted = arm.ik(pose, seed=5)
        assert solver.solve(pose) == wanted.success
        assert np.array_equal(solver.q, wanted.q)
        assert solver.status == wanted.status
        assert solver.iterations == wanted.iterations
        assert solver.restarts == wanted.restarts
        assert solver.position_error == wanted.position_error
        assert solver.orientation_error == wanted.orientation_error
        reached += solver.success
    assert reached >= 299


def test_starts_and_tasks(arm, poses):
    solver = arm.solver(task="position", position_tolerance=1e-4)
    q = arm.random_q(1, seed=22)[0]
    for pose in poses[:50]:
        wanted = arm.ik(pose[:3, 3], q0=q, position_tolerance=1e-4)
        assert solver.solve(pose[:3, 3], q)
        assert np.array_equal(solver.q, wanted.q)
        q = solver.q


def test_a_posture_that_was_taken_stays_what_it_was(arm, poses):
    solver = arm.solver()
    solver.solve(poses[0])
    first = solver.q
    kept = first.copy()
    solver.solve(poses[1])
    assert np.array_equal(first, kept)
    assert not np.array_equal(solver.q, first)


def test_a_call_allocates_nothing_that_stays(arm, poses):
    solver = arm.solver()
    targets = list(poses)
    for target in targets:
        solver.solve(target, solver.q)
    gc.collect()
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        for target in targets:
            solver.solve(target, solver.q)
        after, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # The loop itself keeps an iterator; a call may not add an array.
    assert after - before < 512
    assert peak - before < 1024


def test_bad_input(arm, poses):
    solver = arm.solver()
    with pytest.raises(ArgumentError, match="a single target"):
        solver.solve(poses)
    assert not solver.solve(2 * poses[0])
    assert solver.status == ik.Status.BAD_INPUT
    assert solver.solve(np.round(poses[0], 4))
    with pytest.raises(ArgumentError, match="q0"):
        solver.solve(poses[0], np.zeros(5))
    with pytest.raises(ArgumentError, match="targets"):
        solver.solve(np.zeros(3))
    with pytest.raises(ArgumentError, match="step solver"):
        arm.solver(solver=ik.solvers.DifferentialEvolution())
    assert not solver.solve(np.full((4, 4), np.nan))
    assert solver.status == ik.Status.BAD_INPUT
    assert np.isfinite(solver.q).all()
