"""Shares of random reachable targets solved, judged by the independent NumPy FK."""

import numpy as np
import pytest

import agrik_fast as ik
import numpy_fk

ROWS = 10_000


def pose_errors(reached, wanted):
    """Distances, m, and rotation angles, rad, between poses of shape (n, 4, 4)."""
    distance = np.linalg.norm(reached[:, :3, 3] - wanted[:, :3, 3], axis=-1)
    turn = np.swapaxes(reached[:, :3, :3], -1, -2) @ wanted[:, :3, :3]
    sine = np.stack(
        [
            turn[:, 2, 1] - turn[:, 1, 2],
            turn[:, 0, 2] - turn[:, 2, 0],
            turn[:, 1, 0] - turn[:, 0, 1],
        ],
        axis=-1,
    )
    cosine = np.trace(turn, axis1=-2, axis2=-1) - 1
    return distance, np.arctan2(np.linalg.norm(sine, axis=-1), cosine)


def inside_limits(arm, q):
    return np.all((q >= arm.lower) & (q <= arm.upper), axis=-1)


@pytest.mark.parametrize("name", ["redundant7", "hydrolek", "puma560", "ur5", "panda"])
def test_random_poses_from_independent_starts(name):
    arm = ik.Robot.load(name)
    targets = numpy_fk.fk(name, arm.random_q(ROWS, seed=11))
    result = arm.ik(
        targets,
        q0=arm.random_q(ROWS, seed=12),
        position_tolerance=1e-5,
        orientation_tolerance=1e-4,
    )
    distance, angle = pose_errors(numpy_fk.fk(name, result.q), targets)
    solved = (distance <= 1e-5) & (angle <= 1e-4) & inside_limits(arm, result.q)
    assert solved.mean() >= 0.999
    # Success is claimed where it is true, and nowhere else.
    assert np.array_equal(solved, result.success)


def test_hydrolek_reaches_every_point_within_a_tenth_of_a_millimetre():
    arm = ik.Robot.load("hydrolek")
    points = numpy_fk.fk("hydrolek", arm.random_q(ROWS, seed=13))[:, :3, 3]
    result = arm.ik(points, q0=arm.random_q(ROWS, seed=14), position_tolerance=1e-4)
    reached = numpy_fk.fk("hydrolek", result.q)[:, :3, 3]
    assert result.success.all()
    assert np.linalg.norm(reached - points, axis=-1).max() <= 1e-4
    assert inside_limits(arm, result.q).all()


# Share of 2,000 random poses of redundant7 that each other step solver reaches at its
# default caps; the transpose converges too slowly for a tight tolerance.
@pytest.mark.parametrize(("solver", "least"), [("dls", 0.99), ("pinv", 0.99), ("transpose", 0.9)])
def test_the_other_steps_reach_most_random_poses(solver, least):
    arm = ik.Robot.load("redundant7")
    targets = numpy_fk.fk("redundant7", arm.random_q(2_000, seed=15))
    result = arm.ik(targets, solver=solver, position_tolerance=1e-4, orientation_tolerance=1e-3)
    distance, angle = pose_errors(numpy_fk.fk("redundant7", result.q), targets)
    solved = (distance <= 1e-4) & (angle <= 1e-3) & inside_limits(arm, result.q)
    assert np.array_equal(solved, result.success)
    assert solved.mean() >= least
