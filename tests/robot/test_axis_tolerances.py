"""Tolerances axis by axis, and the task that puts the position first.

Every answer is judged by a forward kinematics written apart; every test says how many of
targets that can be solved are.
"""

import numpy as np
import pytest

import agrik_fast as ik
import numpy_fk
from agrik_fast import solvers, tasks
from agrik_fast.errors import ArgumentError

# The last digits of two forward kinematics differ.
ROUNDING = 1e-11
INF = np.inf

# Five joints of which the tool's turn about its own axis is the last: a full pose has one
# number too many for it.
FIVE_ROWS = [
    [0, np.pi / 2, 0.1, 0],
    [0.12, 0, 0, 0],
    [0.13, 0, 0, 0],
    [0, np.pi / 2, 0, np.pi / 2],
    [0, 0, 0.1, 0],
]
FIVE_LIMITS = [[-2, 2], [-1.7, 1.7], [-1.7, 1.7], [-1.7, 1.7], [-2.8, 2.8]]
STEPS = ("lm", "dls", "pinv", "transpose")


@pytest.fixture(scope="module")
def five():
    return ik.Robot.from_dh(FIVE_ROWS, limits=FIVE_LIMITS)


def five_fk(q):
    pose = np.eye(4)
    for (a, alpha, d, theta), angle in zip(FIVE_ROWS, np.moveaxis(q, -1, 0), strict=True):
        twist = numpy_fk.rotation_about([1, 0, 0], alpha)
        turn = numpy_fk.rotation_about([0, 0, 1], theta + angle)
        pose = pose @ turn @ numpy_fk.translation([a, 0, d]) @ twist
    return pose


def rotation_vector(rotation):
    twice = np.stack(
        [
            rotation[..., 2, 1] - rotation[..., 1, 2],
            rotation[..., 0, 2] - rotation[..., 2, 0],
            rotation[..., 1, 0] - rotation[..., 0, 1],
        ],
        axis=-1,
    )
    sine = np.linalg.norm(twice, axis=-1) / 2
    cosine = (np.trace(rotation, axis1=-2, axis2=-1) - 1) / 2
    angle = np.arctan2(sine, cosine)
    return twice / 2 * (angle / np.where(sine > 1e-12, sine, 1.0))[..., None]


def errors(reached, goal, frame):
    """Errors along and about the axes of a frame, shape (..., 6)."""
    way = goal[..., :3, 3] - reached[..., :3, 3]
    turn = rotation_vector(goal[..., :3, :3] @ np.swapaxes(reached[..., :3, :3], -1, -2))
    if frame == "tool":
        way = np.einsum("...ji,...j->...i", reached[..., :3, :3], way)
        turn = np.einsum("...ji,...j->...i", reached[..., :3, :3], turn)
    return np.concatenate([way, turn], axis=-1)


def moved(poses, offsets, frame):
    """Poses of which each is off by errors along and about the axes of a frame."""
    poses = poses.copy()
    for pose, off in zip(poses, offsets, strict=True):
        angle = np.linalg.norm(off[3:])
        turn = numpy_fk.rotation_about(off[3:] if angle else [0, 0, 1], angle)[:3, :3]
        if frame == "tool":
            pose[:3, 3] += pose[:3, :3] @ off[:3]
            pose[:3, :3] = pose[:3, :3] @ turn
        else:
            pose[:3, 3] += off[:3]
            pose[:3, :3] = turn @ pose[:3, :3]
    return poses


def assert_within(reached, goal, result, position, orientation, frame):
    """What is called a success is one, axis by axis or as a whole."""
    left = np.abs(errors(reached, goal, frame))[result.success]
    for part, most in ((left[:, :3], position), (left[:, 3:], orientation)):
        part = part if np.ndim(most) else np.linalg.norm(part, axis=-1)
        assert (part <= np.asarray(most) + ROUNDING).all()


CASES = {
    "free about tool z": (1e-6, (1e-6, 1e-6, INF), "tool", [0, 0, 0, 0, 0, 3.0]),
    "free about base z": (1e-6, (1e-6, 1e-6, INF), "base", [0, 0, 0, 0, 0, 3.0]),
    "a little about base z": (1e-6, (1e-6, 1e-6, 0.31), "base", [0, 0, 0, 0, 0, 0.3]),
    "free along tool z": ((1e-6, 1e-6, INF), 1e-6, "tool", [0, 0, 0.2, 0, 0, 0]),
    "a plate": ((0.021, 0.021, 1e-6), 1e-6, "base", [0.02, 0.02, 0, 0, 0, 0]),
    "a box": ((0.012, 0.021, 0.002), (0.12, 0.07, INF), "tool", [0.01, 0.02, 1e-3, 0.1, 0.05, 0]),
}


@pytest.mark.parametrize("case", CASES)
def test_an_arm_of_five_joints_solves_poses_that_it_cannot_take(five, case):
    position, orientation, frame, off = CASES[case]
    q = five.random_q(400, seed=3)
    offsets = np.random.default_rng(4).uniform(-1, 1, (400, 6)) * off
    goals = moved(five_fk(q), offsets, frame)
    result = five.ik(
        goals,
        position_tolerance=position,
        orientation_tolerance=orientation,
        tolerance_frame=frame,
    )
    assert result.success.mean() >= 0.99
    assert_within(five_fk(result.q), goals, result, position, orientation, frame)
    if case != "free about tool z":
        # Poses as a whole are out of this arm's reach, but for turns of its last joint.
        assert five.ik(goals).success.mean() < 0.5


@pytest.mark.parametrize("solver", [*STEPS, "pinv-closed", "ik-pid", "de"])
@pytest.mark.parametrize("frame", ["base", "tool"])
def test_every_solver_counts_bounds_of_axes(load_robot, solver, frame):
    arm = load_robot("puma560")
    count = 20 if solver == "de" else 100
    off = np.array([0.009, 0.009, 0.019, 0.09, 0.04, 0.09])
    offsets = np.random.default_rng(5).uniform(-1, 1, (count, 6)) * off
    goals = moved(arm.fk(arm.random_q(count, seed=6)), offsets, frame)
    position, orientation = (0.01, 0.01, 0.02), (0.1, 0.05, INF)
    options = {"position_tolerance": position, "orientation_tolerance": orientation}
    result = arm.ik(goals, solver=solver, tolerance_frame=frame, **options)
    assert result.success.mean() >= (0.9 if solver == "pinv-closed" else 0.99)
    reached = numpy_fk.fk("puma560", result.q)
    assert_within(reached, goals, result, position, orientation, frame)


def test_a_wide_box_is_used_where_the_goal_itself_is_out_of_reach(load_robot):
    arm = load_robot("puma560")
    # Stretched: beyond by up to 3 cm, along the base's x.
    stretched = arm.fk([0, 0, np.pi / 2, 0, 0, 0])[:3, 3]
    beyond = np.linspace(0.0, 0.03, 20)[:, None] * [1, 0, 0]
    goals = stretched + beyond
    wide = arm.ik(goals, position_tolerance=(0.05, 1e-6, 1e-6))
    assert wide.success.all()
    reached = numpy_fk.fk("puma560", wide.q)[:, :3, 3]
    assert (np.abs(goals - reached) <= np.array([0.05, 1e-6, 1e-6]) + ROUNDING).all()


@pytest.mark.parametrize("solver", ["closed_form", "auto", "lm"])
def test_proofs_hold_for_the_wider_tolerance(load_robot, solver):
    arm = load_robot("puma560")
    q = arm.random_q(300, seed=8)
    # Everywhere but along z the arm is there already.
    goals = moved(numpy_fk.fk("puma560", q), np.tile([0, 0, 5.0, 0, 0, 0], (300, 1)), "base")
    options = {"position_tolerance": (1e-6, 1e-6, INF)}
    result = arm.ik(goals, solver=solver, **options)
    assert not (result.status == ik.Status.OUT_OF_REACH).any()
    if solver != "closed_form":
        assert result.success.mean() >= 0.99
    assert_within(
        numpy_fk.fk("puma560", result.q), goals, result, options["position_tolerance"], 1e-6, "base"
    )
    # The same goals exactly are proven to be out of reach.
    exact = arm.ik(goals, solver=solver)
    assert (exact.status == ik.Status.OUT_OF_REACH).all()


def test_closed_forms_solve_what_they_solve_exactly(load_robot):
    arm = load_robot("puma560")
    goals = arm.fk(arm.random_q(200, seed=9))
    options = {"position_tolerance": (1e-3, 1e-6, INF), "orientation_tolerance": (0.1, 1e-6, INF)}
    for solver in ("closed_form", "auto"):
        assert arm.ik(goals, solver=solver, **options).success.all()
    assert arm.ik_all(goals, **options).valid.any(axis=-1).all()


def test_one_number_for_every_axis_is_a_box_around_a_ball(load_robot):
    arm = load_robot("ur5")
    goals = arm.fk(arm.random_q(200, seed=10))
    each = arm.ik(goals, position_tolerance=(1e-4,) * 3, orientation_tolerance=(1e-3,) * 3)
    assert each.success.all()
    left = np.abs(errors(numpy_fk.fk("ur5", each.q), goals, "base"))
    assert (left <= np.array([1e-4] * 3 + [1e-3] * 3) + ROUNDING).all()


def test_errors_are_told_of_the_axes_that_count(five):
    goals = moved(
        five_fk(five.random_q(50, seed=11)), np.tile([0, 0, 0, 0, 0, 2.0], (50, 1)), "tool"
    )
    result = five.ik(goals, orientation_tolerance=(1e-6, 1e-6, INF), tolerance_frame="tool")
    left = errors(five_fk(result.q), goals, "tool")
    told = np.linalg.norm(left[:, 3:5], axis=-1)
    np.testing.assert_allclose(result.orientation_error, told, atol=1e-9)
    assert (result.orientation_error[result.success] <= np.sqrt(2) * 1e-6).all()


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_bounds_and_masks_share_a_frame(load_robot, frame):
    arm = load_robot("puma560")
    goals = arm.fk(arm.random_q(50, seed=12))
    task = tasks.Masked((1, 1, 1, 1, 1, 0), frame=frame)
    result = arm.ik(goals, task=task, orientation_tolerance=(0.01, 0.02, 0.03))
    assert result.success.all()
    left = np.abs(errors(numpy_fk.fk("puma560", result.q), goals, frame))
    # The row without a weight is free whatever its bound.
    assert (left[:, 3:5] <= np.array([0.01, 0.02]) + ROUNDING).all()
    other = "tool" if frame == "base" else "base"
    with pytest.raises(ArgumentError, match="frame of the mask") as error:
        arm.ik(goals, task=task, orientation_tolerance=(0.01, 0.02, 0.03), tolerance_frame=other)
    assert error.value.argument == "tolerance_frame"


def test_positions_and_axes_have_bounds_too(load_robot):
    arm = load_robot("hydrolek")
    points = arm.fk(arm.random_q(200, seed=13))[:, :3, 3] + [0, 0, 0.01]
    result = arm.ik(points, position_tolerance=(1e-6, 1e-6, 0.011))
    assert result.success.mean() >= 0.99
    left = np.abs(points - numpy_fk.fk("hydrolek", result.q)[:, :3, 3])[result.success]
    assert (left <= np.array([1e-6, 1e-6, 0.011]) + ROUNDING).all()

    arm = load_robot("ur5")
    goals = arm.fk(arm.random_q(200, seed=14))
    options = {
        "position_tolerance": (1e-3, 1e-4, 1e-5),
        "orientation_tolerance": (0.1, 0.01, 0.05),
    }
    result = arm.ik(goals, task="axis", **options)
    assert result.success.mean() >= 0.99
    reached = numpy_fk.fk("ur5", result.q)
    across = np.cross(reached[:, :3, 2], goals[:, :3, 2])
    sine = np.linalg.norm(across, axis=-1, keepdims=True)
    cosine = (reached[:, :3, 2] * goals[:, :3, 2]).sum(-1, keepdims=True)
    turn = across * np.arctan2(sine, cosine) / np.maximum(sine, 1e-12)
    left = np.abs(np.concatenate([goals[:, :3, 3] - reached[:, :3, 3], turn], axis=-1))
    most = np.array([1e-3, 1e-4, 1e-5, 0.1, 0.01, 0.05])
    assert (left[result.success] <= most + ROUNDING).all()
    # About the axis the tool is free.
    assert np.median(numpy_fk.pose_error(reached, goals)[1]) > 0.1


def test_paths_and_control_loops_take_bounds(five):
    way = np.linspace([0.0, 0.3, -0.6, 0.2, 0.0], [0.6, 0.5, -0.9, 0.5, 0.4], 60)
    goals = moved(five_fk(way), np.tile([0, 0, 0, 0, 0, 2.0], (60, 1)), "tool")
    options = {"orientation_tolerance": (1e-6, 1e-6, INF), "tolerance_frame": "tool"}
    path = five.follow(goals, q0=way[0], **options)
    assert path.success.all()
    assert not path.discontinuity.any()
    loop = five.solver(**options)
    wanted = five.ik(goals, **options)
    for i, goal in enumerate(goals):
        assert loop.solve(goal) == wanted.success[i] or i > 0
        alone = five.ik(goal, **options)
        assert np.array_equal(loop.q, alone.q)
    assert_within(five_fk(path.q), goals, path, 1e-6, options["orientation_tolerance"], "tool")


@pytest.mark.parametrize("name", ["position_tolerance", "orientation_tolerance"])
@pytest.mark.parametrize(
    "value",
    [
        (1e-3, np.nan, 1),
        (1, -1, 1),
        (1, 1, 0.0),
        (1, 1),
        (1, 1, 1, 1),
        [[1, 1, 1]],
        "1,1,1",
        ["a"] * 3,
    ],
)
def test_bad_bounds(load_robot, name, value):
    arm = load_robot("puma560")
    with pytest.raises(ArgumentError) as error:
        arm.ik(np.eye(4), **{name: value})
    assert error.value.argument == name


def test_something_has_to_be_wanted(load_robot):
    arm = load_robot("puma560")
    free = (INF, INF, INF)
    with pytest.raises(ArgumentError, match="finite tolerance of some axis"):
        arm.ik(np.eye(4), position_tolerance=free, orientation_tolerance=free)
    with pytest.raises(ArgumentError, match="finite tolerance of some axis"):
        arm.ik(np.zeros(3), position_tolerance=free)
    for frame in ("world", 1, ""):
        with pytest.raises(ArgumentError, match="'base' or 'tool'"):
            arm.ik(np.eye(4), position_tolerance=(1, 1, 1), tolerance_frame=frame)
    with pytest.raises(ArgumentError, match="single axes"):
        arm.ik(np.zeros(3), position_tolerance=(1e-3, 1e-3, INF), solver="ccd")


# -- the position first -------------------------------------------------------------------


def test_position_first_meets_the_position_and_turns_the_tool_well(five):
    from scipy.optimize import minimize

    rng = np.random.default_rng(15)
    goals = moved(
        five_fk(five.random_q(40, seed=16)),
        np.concatenate([np.zeros((40, 3)), rng.uniform(-0.4, 0.4, (40, 3))], axis=1),
        "base",
    )
    result = five.ik(goals, task=tasks.PositionFirst())
    assert result.success.all()
    left = errors(five_fk(result.q), goals, "base")
    assert (np.linalg.norm(left[:, :3], axis=-1) <= 1e-6 + ROUNDING).all()
    angle = np.linalg.norm(left[:, 3:], axis=-1)
    np.testing.assert_allclose(result.orientation_error, angle, atol=1e-9)
    # No better one is found by SciPy from the answer or from a few other postures.
    for goal, q, least in zip(goals[:10], result.q, angle, strict=False):
        place = {"type": "eq", "fun": lambda x, g=goal: (five_fk(x) - g)[:3, 3]}

        def turn(x, g=goal):
            return float(np.sum(errors(five_fk(x), g, "base")[3:] ** 2))

        for start in (q, *five.random_q(4, seed=17)):
            found = minimize(turn, start, method="SLSQP", bounds=FIVE_LIMITS, constraints=place)
            if np.linalg.norm(place["fun"](found.x)) < 1e-6:
                assert np.sqrt(found.fun) >= least - 1e-3


@pytest.mark.parametrize("solver", ["lm", "dls", "pinv", "de", "auto"])
def test_position_first_solves_poses_that_can_be_had(load_robot, solver):
    arm = load_robot("puma560")
    goals = arm.fk(arm.random_q(20 if solver == "de" else 100, seed=18))
    result = arm.ik(goals, task=tasks.PositionFirst(), solver=solver)
    assert result.success.all()
    distance, angle = numpy_fk.pose_error(numpy_fk.fk("puma560", result.q), goals)
    assert (distance <= 1e-6 + ROUNDING).all()
    # A population search ends with the best of a few.
    assert (angle <= 1e-3).mean() >= (0.8 if solver == "de" else 0.99)


def test_position_first_out_of_reach_is_proven_and_near(load_robot):
    arm = load_robot("puma560")
    goals = arm.fk(arm.random_q(20, seed=19))
    goals[:, :3, 3] += [0, 0, 5.0]
    result = arm.ik(goals, task=tasks.PositionFirst())
    assert (result.status == ik.Status.OUT_OF_REACH).all()
    nearest = arm.ik(goals[:, :3, 3])
    assert (result.position_error <= nearest.position_error + 1e-5).all()


def test_position_first_needs_orientations_and_a_loop_that_can(load_robot):
    arm = load_robot("puma560")
    with pytest.raises(ArgumentError, match="poses"):
        arm.ik(np.zeros(3), task=tasks.PositionFirst())
    with pytest.raises(ArgumentError, match="full pose"):
        arm.ik(np.eye(4), task=tasks.PositionFirst(), solver="closed_form")
    with pytest.raises(ArgumentError, match="position task"):
        arm.ik(np.eye(4), task=tasks.PositionFirst(), solver=solvers.CyclicCoordinateDescent())
