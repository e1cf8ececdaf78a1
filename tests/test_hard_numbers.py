"""Numbers without sense are refused or BAD_INPUT, at once, and never become an answer."""

import dataclasses

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import solvers, tasks
from agrik_fast.arms import StrawberryArm, TomatoArm
from agrik_fast.errors import ArgumentError
from agrik_fast.solvers import DifferentialEvolution, GeneticAlgorithm

UR5 = ik.Robot.load("ur5")
PUMA = ik.Robot.load("puma560")
# All continuous.
FREE = ik.Robot.from_dh([[0, np.pi / 2, 0.3, 0], [0.4, 0, 0, 0], [0.3, 0, 0, 0]])
HUGE = [1.1e50, 1e150, 1e160, 1e300, np.finfo(float).max]
EVERY = [
    "auto",
    "closed_form",
    "lm",
    "dls",
    "pinv",
    "pinv-closed",
    "transpose",
    "ccd",
    "ik-pid",
    "state-space",
    "static-gain",
    "broyden",
    DifferentialEvolution(generations=2, max_restarts=0),
    GeneticAlgorithm(generations=2, max_restarts=0),
]


def name_of(solver) -> str:
    return solver if isinstance(solver, str) else solver.name


def at(x: float) -> np.ndarray:
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


@pytest.mark.parametrize("solver", EVERY, ids=name_of)
@pytest.mark.parametrize("x", HUGE)
def test_a_huge_target_is_bad_input_and_leaves_the_others_alone(solver, x):
    poses = PUMA.fk(PUMA.random_q(3, seed=1))
    task = "position" if solver == "ccd" else "pose"
    wanted = PUMA.ik(poses, task=task, solver=solver)
    poses[1, 1, 3] = -x
    result = PUMA.ik(poses, task=task, solver=solver)
    assert result.status[1] == ik.Status.BAD_INPUT
    assert not result.success[1] and np.isfinite(result.q).all()
    assert np.array_equal(result.q[[0, 2]], wanted.q[[0, 2]])


@pytest.mark.parametrize(
    ("arm", "solver"),
    # Only one of the two has a closed form.
    [(PUMA, solver) for solver in EVERY]
    + [(FREE, solver) for solver in EVERY if solver != "closed_form"],
    ids=name_of,
)
def test_a_huge_start_is_bad_input(arm, solver):
    poses = arm.fk(arm.random_q(len(HUGE), seed=2))
    q0 = np.zeros((len(HUGE), arm.dof))
    q0[:, 1] = HUGE
    task = "position" if solver == "ccd" else "pose"
    result = arm.ik(poses, task=task, solver=solver, q0=q0)
    assert (result.status == ik.Status.BAD_INPUT).all()
    assert np.isfinite(result.q).all()


def test_branches_and_paths_and_histories_of_huge_numbers():
    branches = PUMA.ik_all(np.stack([at(1e160), np.eye(4)]))
    assert branches.status[0] == ik.Status.BAD_INPUT and not branches.valid[0].any()
    path = PUMA.follow(np.stack([at(1e160)]), max_joint_step=0.1)
    assert path.status[0] == ik.Status.BAD_INPUT
    with pytest.raises(ArgumentError, match="1e50"):
        PUMA.cost_history(at(1e160), solver=DifferentialEvolution())
    one = PUMA.solver()
    assert not one.solve(at(1e160)) and one.status == ik.Status.BAD_INPUT


@pytest.mark.parametrize("x", HUGE)
def test_huge_geometry_is_refused(x):
    tool = at(x)
    for call in (
        lambda: UR5.with_tool(tool),
        lambda: UR5.with_base(tool),
        lambda: UR5.ik(np.eye(4), tool=tool),
        lambda: ik.Robot.from_dh([[x, 0, 0, 0]]),
        lambda: ik.Robot.from_dh([[0, 0, -x, 0]]),
        lambda: ik.Robot.from_dh([[1, 0, 0, 0]], base=tool),
    ):
        with pytest.raises(ArgumentError, match="1e50"):
            call()


@pytest.mark.parametrize("solver", ["static-gain", "state-space", "broyden", "lm", "pinv"])
@pytest.mark.parametrize("weight", HUGE)
def test_a_huge_weight_is_refused(solver, weight):
    with pytest.raises(ArgumentError, match="weights"):
        UR5.ik(np.eye(4), task=tasks.Masked((1, 1, 1, 1, weight, 1)), solver=solver)


@pytest.mark.parametrize("solver", ["static-gain", "state-space", "broyden", "lm", "pinv", "dls"])
@pytest.mark.parametrize("weight", [1e-300, 1e-50, 1e30, 1e50])
def test_any_weight_in_range_ends(solver, weight):
    task = tasks.Masked((1, 1, 1, 1, weight, 1))
    pose = UR5.fk(UR5.random_q(1, seed=3)[0])
    chosen = dataclasses.replace(KNOWN[solver], max_restarts=2)
    result = UR5.ik(pose, task=task, solver=chosen)
    assert np.isfinite(result.q).all()
    assert not result.success or np.isfinite(result.position_error)


KNOWN = {
    "lm": solvers.LevenbergMarquardt(),
    "dls": solvers.DampedLeastSquares(),
    "pinv": solvers.PseudoInverse(),
    "static-gain": solvers.StaticGain(),
    "state-space": solvers.StateSpace(),
    "broyden": solvers.Broyden(),
}


@pytest.mark.parametrize("x", HUGE)
def test_huge_gains_are_refused(x):
    rows = np.zeros((6, 3))
    rows[2, 1] = x
    for make in (
        lambda: solvers.StaticGain(K=rows),
        lambda: solvers.Broyden(K=rows),
        lambda: solvers.StateSpace(A=np.zeros((6, 6)), B=rows, C=np.eye(6)),
        lambda: solvers.StaticGain(K=np.ones((6, 3)), angle_unit_rad=x),
        lambda: solvers.StaticGain(K=np.ones((6, 3)), length_unit_m=1 / x),
        lambda: solvers.IkPid(kp=x),
    ):
        with pytest.raises(ArgumentError, match=r"1e50|finite"):
            PUMA.ik([0.3, 0.2, 0.4], solver=make())


@pytest.mark.parametrize("dimensions", [31, 32, 33, 40, 64])
def test_too_many_dimensions_are_refused(dimensions):
    leading = (1,) * (dimensions - 1)
    pairs = [
        (lambda: PUMA.ik(np.full((*leading, 3), 0.3)), 0),
        (lambda: PUMA.ik(np.tile(np.eye(4), (*leading[1:], 1, 1))), 0),
        (lambda: PUMA.ik_all(np.tile(np.eye(4), (*leading[1:], 1, 1))), 0),
        (lambda: PUMA.fk(np.zeros((*leading, 6))), 1),
        (lambda: PUMA.fk_links(np.zeros((*leading, 6))), 2),
        (lambda: PUMA.jacobian(np.zeros((*leading, 6))), 1),
        (lambda: TomatoArm().branches(np.full((*leading, 3), 0.1)), 1),
        (lambda: StrawberryArm().solve(np.full((*leading, 3), 0.1)), 0),
    ]
    for call, more in pairs:
        if dimensions + more > 32:
            with pytest.raises(ArgumentError, match="at most 32 dimensions"):
                call()
        else:
            answer = call()
            answer = getattr(answer, "q", answer)
            assert answer.ndim >= dimensions - 1


# -- angles of many turns -------------------------------------------------------------------

ROWS = [[0.3, 1.0, 0.2, 0.7], [0.2, 0.3, 0.1, 0.9], [0.25, -0.4, 0.1, -0.4]]


def turned_fk(q):
    """Forward kinematics with each angle brought to a turn before its offset is added."""
    pose = np.eye(4)
    for (a, alpha, d, theta), x in zip(ROWS, q, strict=True):
        angle = np.arctan2(np.sin(x), np.cos(x)) + theta
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        pose = pose @ [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    return pose


@pytest.mark.parametrize("size", [90.0, 1e3, 1.1e4, 1e6, 1e10, 1e15, 1e16, 1e22, 1e49])
def test_angles_of_many_turns_lose_no_digits(size):
    arm = ik.Robot.from_dh(ROWS, limits=[[-1e16, 1e16]] * 3)
    q = size * np.random.default_rng(1).uniform(-1, 1, (40, 3))
    q[::3, 1] = 0.3
    poses = arm.fk(q)
    np.testing.assert_allclose(poses, [turned_fk(row) for row in q], atol=2e-13, rtol=0)
    assert np.array_equal(arm.fk(q[7]), poses[7])
    small = np.arctan2(np.sin(q), np.cos(q))
    np.testing.assert_allclose(arm.jacobian(q), arm.jacobian(small), atol=2e-13, rtol=0)
    np.testing.assert_allclose(arm.fk_links(q)[:, -1], poses, atol=1e-12, rtol=0)


@pytest.mark.parametrize("name", ["puma560", "ur5", "panda", "iiwa14", "cucumber", "hydrolek"])
@pytest.mark.parametrize("solver", ["auto", "lm"])
def test_starts_of_many_turns_are_brought_back(name, solver):
    bundled = ik.Robot.load(name)
    turns = np.array(bundled.joint_types) != "prismatic"
    arm = bundled.with_limits(np.where(turns[:, None], [-1e16, 1e16], np.nan))
    rng = np.random.default_rng(5)
    middle = 0.5 * (bundled.lower + bundled.upper)
    poses = arm.fk(np.where(turns, rng.uniform(-3, 3, (200, arm.dof)), middle))
    q0 = np.where(turns, rng.uniform(-1e6, 1e6, (200, arm.dof)), middle)
    result = arm.ik(poses, q0=q0, solver=solver)
    assert result.success.mean() >= 0.995
    # Those of fewer turns are kept: what is near to them is what was asked for.
    back = np.where(np.abs(q0) > 1e4, q0 - 2 * np.pi * np.round(q0 / (2 * np.pi)), q0)
    assert np.abs(result.q - back)[:, turns].max() <= np.pi + 1e-6


@pytest.mark.parametrize("solver", ["lm", "dls", "auto", "closed_form"])
def test_angles_of_many_turns_are_no_answer_where_their_last_digit_counts(solver):
    """An arm of 100 km, nanometres of it, and starts of hundreds of turns (found by fuzzing)."""
    rows = [(1e5 * row.a, row.alpha, 1e5 * row.d, row.theta) for row in PUMA.dh]
    arm = ik.Robot.from_dh(rows, limits=[(-1e16, 1e16)] * 6)
    q = PUMA.random_q(200, seed=4)
    rng = np.random.default_rng(5)
    starts = q + rng.normal(scale=0.3, size=q.shape) + 2 * np.pi * rng.integers(150, 900, q.shape)
    poses = arm.fk(q)
    tight = {"position_tolerance": 4e-9, "orientation_tolerance": 1e-9}
    result = arm.ik(poses, solver=solver, q0=starts, **tight)
    off = np.linalg.norm(arm.fk(result.q)[:, :3, 3] - poses[:, :3, 3], axis=1)
    assert (off[result.success] <= 5e-9).all()
    assert result.success.mean() > 0.9
    # With tolerances that such angles can keep they stay near the start.
    wide = arm.ik(poses, solver=solver, q0=starts, position_tolerance=1e-2)
    assert wide.success.mean() > 0.99
    assert np.abs(wide.q - starts)[wide.success].max() < 2 * np.pi


def test_laws_that_run_away_return_angles_that_are_known():
    """Their steps have no bound, and the answer is told to its last digit (found by fuzzing)."""
    rows = [(1e3 * row.a, row.alpha, 1e3 * row.d, row.theta) for row in PUMA.dh]
    arm = ik.Robot.from_dh(rows, joint_types=["continuous"] * 6)
    poses = arm.fk(np.random.default_rng(2).uniform(-3, 3, (60, 6)))
    poses[:, :3, 3] *= 1e7
    result = arm.ik(poses, solver="broyden")
    assert np.abs(result.q).max() < 1e4
    turned = poses[:, :3, :3].transpose(0, 2, 1) @ arm.fk(result.q)[:, :3, :3]
    cosine = (np.trace(turned, axis1=1, axis2=2) - 1) / 2
    assert np.allclose(np.cos(result.orientation_error), cosine, atol=1e-9)


def test_a_place_met_after_all_is_brought_near_the_start():
    """Ends of laws that meet the position first are solutions only at last (found by fuzzing)."""
    arm = PUMA.with_limits([(-2 * np.pi, 2 * np.pi)] * 6)
    rng = np.random.default_rng(6)
    starts = rng.uniform(-0.9, 0.9, (600, 6))
    poses = arm.fk(rng.uniform(-2, 2, (600, 6)))
    poses[:, :3, :3] = arm.fk(rng.uniform(-3, 3, (600, 6)))[:, :3, :3]
    tight = {"position_tolerance": 3e-3, "orientation_tolerance": 1e-9}
    result = arm.ik(poses, solver="broyden", task=tasks.PositionFirst(), q0=starts, **tight)
    assert result.success.mean() > 0.9
    assert np.abs(result.q - starts)[result.success].max() < np.pi + 1e-9
