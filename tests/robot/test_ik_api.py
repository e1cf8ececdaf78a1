"""`Robot.ik`: shapes, statuses, starts, tool offset, solvers, tasks, limits."""

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest

import agrik_fast as ik
import numpy_fk
from agrik_fast import _native, solvers, tasks

# The last digits of two forward kinematics differ.
ROUNDING = 1e-11
SOLVERS = (
    solvers.LevenbergMarquardt(),
    solvers.DampedLeastSquares(),
    solvers.PseudoInverse(),
    solvers.Transpose(),
)


def reachable(robot, count, seed=0):
    """Poses that `robot` takes at random joint values, by the library."""
    return robot.fk(robot.random_q(count, seed=seed))


def assert_true_successes(name, targets, result, position=1e-6, orientation=1e-6):
    """Success means: within tolerance and limits, by a forward kinematics written apart."""
    pose = numpy_fk.fk(name, result.q)[result.success]
    goal = targets[result.success]
    if goal.shape[-2:] == (4, 4):
        distance, angle = numpy_fk.pose_error(pose, goal)
        assert (angle <= orientation + ROUNDING).all()
    else:
        distance = np.linalg.norm(pose[..., :3, 3] - goal, axis=-1)
    assert (distance <= position + ROUNDING).all()
    assert_limits(name, result.q)


def assert_limits(name, q):
    lower, upper = numpy_fk.limits(name).T
    assert (q >= lower).all()
    assert (q <= upper).all()


@pytest.mark.parametrize("leading", [(), (0,), (5,), (2, 3), (2, 0, 3)])
@pytest.mark.parametrize("kind", ["pose", "position"])
def test_results_have_the_leading_shape_of_the_targets(load_robot, leading, kind):
    arm = load_robot("puma560")
    targets = arm.fk(arm.random_q(leading, seed=3))
    if kind == "position":
        targets = targets[..., :3, 3]
    result = arm.ik(targets)
    expected = {
        "q": ((*leading, 6), np.float64),
        "success": (leading, np.bool_),
        "status": (leading, np.uint8),
        "position_error": (leading, np.float64),
        "orientation_error": (leading, np.float64),
        "iterations": (leading, np.uint32),
        "restarts": (leading, np.uint32),
    }
    for name, (shape, dtype) in expected.items():
        array = getattr(result, name)
        assert isinstance(array, np.ndarray)
        assert (array.shape, array.dtype) == (shape, dtype), name
        assert array.flags.c_contiguous
        assert getattr(result, name) is array, "made once"
    assert result.success.all()


def test_a_large_result_is_handed_over_with_its_memory(load_robot):
    arm = load_robot("tomato")
    result = arm.ik(reachable(arm, 2000)[:, :3, 3])
    assert result.q.shape == (2000, 3)
    assert result.q.base is not None
    assert not result.q.flags.owndata


def test_repr_counts_the_outcomes(load_robot):
    arm = load_robot("puma560")
    targets = reachable(arm, 4)
    targets[1, 0, 0] = np.nan
    targets[2, :3, 3] = 50.0
    text = repr(arm.ik(targets))
    assert text == "IkResult(4 targets: 2 converged, 1 out of reach, 1 bad input)"
    assert repr(arm.ik(np.empty((0, 3)))) == "IkResult(0 targets)"


@pytest.mark.parametrize("name", ["puma560", "redundant7"])
@pytest.mark.parametrize(
    ("solver", "share"),
    list(zip(SOLVERS, (1.0, 0.95, 0.97, 0.6), strict=True)),
    ids=[solver.name for solver in SOLVERS],
)
def test_every_solver_reaches_most_random_poses(load_robot, name, solver, share):
    arm = load_robot(name)
    targets = reachable(arm, 100, seed=11)
    result = arm.ik(targets, solver=solver)
    assert result.success.mean() >= share
    assert_true_successes(name, targets, result)


@pytest.mark.parametrize("name", ik.Robot.names())
def test_every_robot_reaches_its_own_positions(load_robot, name):
    arm = load_robot(name)
    targets = reachable(arm, 200, seed=12)[:, :3, 3]
    result = arm.ik(targets)
    assert result.success.all()
    assert (result.orientation_error == 0).all()
    assert_true_successes(name, targets, result)


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: solver.name)
def test_a_name_means_the_default_options(load_robot, solver):
    arm = load_robot("ur5")
    targets = reachable(arm, 20)
    by_name = arm.ik(targets, solver=solver.name)
    by_object = arm.ik(targets, solver=solver)
    np.testing.assert_array_equal(by_name.q, by_object.q)
    np.testing.assert_array_equal(by_name.iterations, by_object.iterations)


def test_the_defaults_of_the_dataclasses_are_those_of_the_core():
    core = _native.default_settings()
    for solver in SOLVERS:
        assert core[solver.name] == {
            field.name: getattr(solver, field.name) for field in fields(solver)
        }


def test_options_of_a_solver_are_kept(load_robot):
    arm = load_robot("redundant7")
    targets = reachable(arm, 50)
    result = arm.ik(targets, solver=solvers.DampedLeastSquares(max_iterations=3, max_restarts=2))
    unsolved = result.status == ik.Status.NOT_FOUND
    assert unsolved.any()
    assert (result.restarts[unsolved] == 2).all()
    assert (result.restarts <= 2).all()
    # Attempts that are closing in get some more steps.
    assert result.iterations.max() < arm.ik(targets, solver="dls").iterations.max()


def test_iterations_are_zero_where_the_start_is_the_answer(load_robot):
    arm = load_robot("redundant7")
    q = arm.random_q((4, 5), seed=2)
    result = arm.ik(arm.fk(q), q0=q)
    assert (result.iterations == 0).all()
    np.testing.assert_array_equal(result.q, q)


def test_q0_is_broadcast(load_robot):
    arm = load_robot("redundant7")
    q = arm.random_q((4, 5), seed=2)
    targets = arm.fk(q)
    one = arm.ik(targets, q0=q[0, 0])
    assert one.iterations[0, 0] == 0
    each = np.broadcast_to(q[0, 0], (4, 5, 7))
    np.testing.assert_array_equal(one.q, arm.ik(targets, q0=each).q)
    per_column = arm.ik(targets, q0=q[0])
    assert (per_column.iterations[0] == 0).all()
    per_row = arm.ik(targets, q0=q[:, :1])
    assert (per_row.iterations[:, 0] == 0).all()
    assert per_row.success.all()


def test_q0_outside_the_limits_is_no_fault(load_robot):
    arm = load_robot("puma560")
    targets = reachable(arm, 10)
    result = arm.ik(targets, q0=np.full(6, 100.0))
    assert result.success.all()
    assert_true_successes("puma560", targets, result)


def test_the_seed_decides(load_robot):
    arm = load_robot("redundant7")
    targets = reachable(arm, 10)
    first = arm.ik(targets, seed=1).q
    np.testing.assert_array_equal(first, arm.ik(targets, seed=1).q)
    assert not np.array_equal(first, arm.ik(targets, seed=2**64 - 1).q)


def test_a_place_alone_is_a_tool_that_is_not_turned(load_robot):
    place, matrix = [0.01, 0.0, 0.12], np.eye(4)
    matrix[:3, 3] = place
    arm = load_robot("redundant7")
    assert arm.with_tool(place) == arm.with_tool(matrix)
    assert arm.with_base(place) == arm.with_base(matrix)
    assert ik.Robot.load("redundant7", tool=place) == arm.with_tool(matrix)
    rows = [{"a": 0.3, "alpha": 0.0, "d": 0.0, "theta": 0.0}] * 3
    assert ik.Robot.from_dh(rows, tool=place, base=place) == ik.Robot.from_dh(
        rows, tool=matrix, base=matrix
    )
    q = arm.random_q(3, seed=1)
    targets = arm.fk(q) @ matrix
    calls = [
        lambda tool: arm.ik(targets, tool=tool).q,
        lambda tool: arm.ik(targets, tool=tool, limits=np.stack([arm.lower, arm.upper], -1)).q,
        lambda tool: next(iter(arm.ik_stream([targets], tool=tool))).q,
        lambda tool: arm.ik_all(targets, tool=tool).q,
        lambda tool: arm.follow(targets, tool=tool).q,
        lambda tool: arm.velocity(q, np.full(6, 0.01), tool=tool),
        lambda tool: np.concatenate(arm.arm_angle_intervals(targets[0], tool)),
        lambda tool: arm.cost_history(targets[0], tool=tool),
        lambda tool: (solver := arm.solver(tool=tool), solver.solve(targets[0]), solver.q)[2],
    ]
    for call in calls:
        np.testing.assert_array_equal(call(place), call(matrix))
    for wrong in ([0.0, 1.0], np.eye(3)):
        with pytest.raises(ik.ArgumentError, match="tool"):
            arm.ik(targets, tool=wrong)


def test_tool_is_an_offset_behind_the_robots_tool(load_robot):
    arm = load_robot("ur5")
    offset = numpy_fk.translation([0.05, -0.1, 0.2]) @ numpy_fk.rotation_about([1, 2, 3], 0.7)
    targets = reachable(arm, 100) @ offset
    result = arm.ik(targets, tool=offset)
    assert result.success.all()
    distance, angle = numpy_fk.pose_error(numpy_fk.fk("ur5", result.q) @ offset, targets)
    assert distance.max() <= 1e-6 + ROUNDING
    assert angle.max() <= 1e-6 + ROUNDING


def test_tolerances_are_those_asked_for(load_robot):
    arm = load_robot("puma560")
    targets = reachable(arm, 100)
    coarse = arm.ik(targets, position_tolerance=1e-2, orientation_tolerance=1e-1)
    fine = arm.ik(targets, position_tolerance=1e-9, orientation_tolerance=1e-9)
    assert coarse.position_error.max() > 1e-6
    assert coarse.position_error.max() <= 1e-2
    assert coarse.orientation_error.max() <= 1e-1
    assert fine.success.all()
    assert_true_successes("puma560", targets, fine, 1e-9, 1e-9)


# -- tasks ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["puma560", "cucumber"])
def test_axis_task_with_the_direction_of_the_targets(load_robot, name):
    arm = load_robot(name)
    targets = reachable(arm, 100, seed=4)
    axis = np.array([1.0, 2.0, 0.5]) / np.linalg.norm([1.0, 2.0, 0.5])
    result = arm.ik(targets, task=tasks.Axis(tool_axis=tuple(axis)))
    assert result.success.all()
    pose = numpy_fk.fk(name, result.q)
    direction = targets[:, :3, :3] @ axis
    sine = np.linalg.norm(np.cross(pose[:, :3, :3] @ axis, direction), axis=-1)
    assert sine.max() <= 1e-6 + ROUNDING
    assert (np.vecdot(pose[:, :3, :3] @ axis, direction) > 0).all()
    assert np.linalg.norm(pose[:, :3, 3] - targets[:, :3, 3], axis=-1).max() <= 1e-6 + ROUNDING
    turned = numpy_fk.pose_error(pose, targets)[1]
    assert turned.max() > 0.1, "free about the axis"


def test_axis_task_with_one_direction_for_points_and_poses(load_robot):
    arm = load_robot("ur5")
    down = tasks.Axis(tool_axis=(0, 0, 1), direction=(0, 0, -2))
    targets = reachable(arm, 60, seed=5)
    points = arm.ik(targets[:, :3, 3], task=down)
    poses = arm.ik(targets, task=down)
    np.testing.assert_array_equal(points.q, poses.q)
    assert points.success.mean() > 0.4
    z = numpy_fk.fk("ur5", points.q)[points.success][:, :3, 2]
    np.testing.assert_allclose(z, np.broadcast_to([0, 0, -1], z.shape), atol=1.1e-6)


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_masked_task_frees_the_rows_of_weight_zero(load_robot, frame):
    arm = load_robot("redundant7")
    targets = reachable(arm, 100, seed=6)
    weights = (1, 1, 0, 2, 2, 0)
    result = arm.ik(targets, task=tasks.Masked(weights, frame))
    assert result.success.all()
    pose = numpy_fk.fk("redundant7", result.q)
    offset = targets[:, :3, 3] - pose[:, :3, 3]
    turn = targets[:, :3, :3] @ np.swapaxes(pose[:, :3, :3], -1, -2)
    vector = rotation_vectors(turn)
    if frame == "tool":
        offset = np.einsum("nij,ni->nj", pose[:, :3, :3], offset)
        vector = np.einsum("nij,ni->nj", pose[:, :3, :3], vector)
    assert np.linalg.norm(offset[:, :2], axis=1).max() <= 1e-6 + ROUNDING
    assert np.linalg.norm(vector[:, :2], axis=1).max() <= 1e-6 + ROUNDING
    assert np.abs(offset[:, 2]).max() > 1e-2
    assert np.abs(vector[:, 2]).max() > 1e-2


def rotation_vectors(turn):
    """Axis times angle of rotation matrices (n, 3, 3) that turn by less than pi."""
    skew = np.stack(
        [
            turn[:, 2, 1] - turn[:, 1, 2],
            turn[:, 0, 2] - turn[:, 2, 0],
            turn[:, 1, 0] - turn[:, 0, 1],
        ],
        axis=-1,
    )
    sine = np.linalg.norm(skew, axis=-1) / 2
    angle = np.arctan2(sine, (np.trace(turn, axis1=-2, axis2=-1) - 1) / 2)
    return skew * (angle / (2 * np.maximum(sine, 1e-300)))[:, None]


def test_position_task_ignores_the_orientation_of_poses(load_robot):
    arm = load_robot("hydrolek")
    targets = reachable(arm, 50)
    by_pose = arm.ik(targets, task="position")
    by_point = arm.ik(targets[:, :3, 3])
    np.testing.assert_array_equal(by_pose.q, by_point.q)
    assert by_pose.success.all()


# -- joints, limits, statuses -----------------------------------------------------------


def test_continuous_joints_stay_within_half_a_turn_of_their_start():
    rows = [[0.1, np.pi / 2, 0.3, 0], [0.5, 0, 0, 0], [0.4, np.pi / 2, 0, 0], [0, 0, 0.2, 0]]
    arm = ik.Robot.from_dh(rows)
    assert arm.joint_types == ("continuous",) * 4
    targets = arm.fk(arm.random_q(300, seed=1))[:, :3, 3]
    free = arm.ik(targets)
    assert free.success.all()
    assert (np.abs(free.q) <= np.pi + ROUNDING).all()
    start = np.array([20.0, -30.0, 7.0, 100.0])
    near = arm.ik(targets, q0=start)
    assert near.success.all()
    assert (np.abs(near.q - start) <= np.pi + ROUNDING).all()


def test_prismatic_joints_are_neither_wrapped_nor_left_behind():
    rows = [[0, 0, 0, 0], [0.6, 0, 0, 0], [0.5, 0, 0, 0]]
    arm = ik.Robot.from_dh(
        rows,
        joint_types=["prismatic", "revolute", "revolute"],
        limits=[[-20, 20], [-3, 3], [-2.5, 2.5]],
    )
    targets = arm.fk(arm.random_q(300, seed=1))[:, :3, 3]
    result = arm.ik(targets)
    assert result.success.all()
    np.testing.assert_allclose(result.q[:, 0], targets[:, 2], atol=1e-6)


@pytest.mark.parametrize("name", ["strawberry", "hydrolek", "panda"])
def test_limits_hold_for_failed_targets_too(load_robot, name):
    arm = load_robot(name)
    rng = np.random.Generator(np.random.PCG64(1))
    low, high = arm.reach_box
    targets = rng.uniform(low - 0.2, high + 0.2, (300, 3))
    result = arm.ik(targets, solver=solvers.LevenbergMarquardt(max_restarts=3))
    assert not result.success.all()
    assert_limits(name, result.q)
    assert_true_successes(name, targets, result)


def test_statuses():
    arm = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], limits=[[-3, 3], [1, 2]])
    targets = np.array([[1.0, 1.0, 0], [3, 0, 0], [1.0, 0, 0.5], [1.9, 0, 0], [1, np.inf, 0]])
    result = arm.ik(targets)
    assert [ik.Status(code) for code in result.status] == [
        ik.Status.CONVERGED,
        ik.Status.OUT_OF_REACH,
        ik.Status.OUT_OF_REACH,
        ik.Status.NOT_FOUND,
        ik.Status.BAD_INPUT,
    ]
    np.testing.assert_array_equal(result.success, result.status == ik.Status.CONVERGED)
    assert result.position_error[1] >= 3 - np.hypot(1 + np.cos(1), np.sin(1))
    assert result.position_error[2] >= 0.5
    assert result.position_error[4] == np.inf
    assert np.isfinite(result.q).all()
    told_elsewhere = {
        *(ik.Status.STALLED, ik.Status.NON_FINITE),  # feedback
        ik.Status.IN_COLLISION,  # scenes
        *(ik.Status.JOINT_LIMITS, ik.Status.SINGULAR_FAMILY),  # all branches
        *(ik.Status.OVERDETERMINED, ik.Status.UNSUPPORTED),
        ik.Status.HELD,  # control loops
    }
    assert set(result.status.tolist()) == set(ik.Status) - told_elsewhere


def test_threads_are_set_for_the_process():
    before = ik.get_num_threads()
    try:
        ik.set_num_threads(3)
        assert ik.get_num_threads() == 3
    finally:
        ik.set_num_threads(None)
    assert ik.get_num_threads() == before
    assert ik.simd_level() in ("scalar", "neon", "avx2", "avx512")


@pytest.mark.parametrize(("text", "number"), [("5", 5), (" 2 ", 2), ("0", None), ("many", None)])
def test_the_environment_sets_the_threads(text, number):
    code = "import agrik_fast as ik; print(ik.get_num_threads())"
    environment = {key: value for key, value in os.environ.items() if key != "AGRIK_NUM_THREADS"}
    outputs = [
        subprocess.run(
            [sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True
        ).stdout
        for env in (environment, environment | {"AGRIK_NUM_THREADS": text})
    ]
    cores = int(outputs[0])
    assert cores >= 1
    assert int(outputs[1]) == (cores if number is None else number)


def test_threads_that_read_a_result_at_once_get_the_same_arrays(load_robot):
    arm = load_robot("puma560")
    targets = arm.fk(arm.random_q(300, seed=4))
    switch = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        # Arrays of a few numbers are copied, those of many handed over.
        for count in (1, 2, 300) * 60:
            result, branches = arm.ik(targets[:count]), arm.ik_all(targets[count - 1])
            barrier = threading.Barrier(3)

            def read(result=result, branches=branches, barrier=barrier):
                barrier.wait()
                return result.q, result.status, result.success, branches.q, branches.valid

            with ThreadPoolExecutor(3) as pool:
                first, *others = [job.result() for job in [pool.submit(read) for _ in range(3)]]
            for other in others:
                assert all(a is b for a, b in zip(first, other, strict=True))
            assert first[0].shape == (count, 6)
    finally:
        sys.setswitchinterval(switch)
