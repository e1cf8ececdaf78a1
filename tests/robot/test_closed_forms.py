"""`Robot.ik_all` and `solver="closed_form"`: every branch, limits, singular postures, S-R-S."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import ArgumentError, Robot, Singularity, Status, solvers

POSES = 100_000
DATA = Path(__file__).parents[1] / "data"
SIX = ("puma560", "irb140", "kr16")
SEVEN = ("redundant7", "iiwa14")
# The last digits of forward kinematics.
POSITION_M = 1e-9
ROTATION = 1e-9


@pytest.fixture(scope="module")
def arm_of(load_robot: Callable[[str], Robot]) -> Callable[[str], Robot]:
    """Return a bundled robot or one of the URDFs written for these tests."""

    def load(name: str) -> Robot:
        path = DATA / f"{name}.urdf"
        return Robot.load(path) if path.exists() else load_robot(name)

    return load


def turns_apart(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Largest angle between joint values, whole turns aside."""
    off = q - other
    return np.abs(off - 2 * np.pi * np.round(off / (2 * np.pi))).max(axis=-1)


def assert_branches_reach(
    arm: Robot, targets: np.ndarray, q: np.ndarray, which: np.ndarray
) -> None:
    """The branches `which` put the tool at their targets, by forward kinematics."""
    got = arm.fk(q[which])
    wanted = np.broadcast_to(targets[..., None, :, :], (*which.shape, 4, 4))[which]
    assert np.linalg.norm(got[:, :3, 3] - wanted[:, :3, 3], axis=-1).max() < POSITION_M
    assert np.abs(got[:, :3, :3] - wanted[:, :3, :3]).max() < ROTATION


def assert_within_limits(arm: Robot, q: np.ndarray) -> None:
    assert (q >= arm.lower).all()
    assert (q <= arm.upper).all()


@pytest.mark.parametrize("name", SIX)
def test_every_branch_of_a_spherical_wrist(arm_of, name):
    arm = arm_of(name)
    q = arm.random_q(POSES, seed=1)
    targets = arm.fk(q)
    found = arm.ik_all(targets)
    assert arm.closed_form == "spherical wrist"
    assert found.q.shape == (POSES, 8, 6)
    assert (found.status == Status.CONVERGED).all()
    assert_branches_reach(arm, targets, found.q, found.reached)
    assert_within_limits(arm, found.q[found.valid])
    assert not (found.valid & ~found.reached).any()
    off = np.where(found.valid, turns_apart(found.q, q[:, None, :]), np.inf).min(axis=1)
    assert off.max() < 1e-8
    # Branches come in pairs of the wrist, and in arms without offset limits in fours.
    assert set(np.unique(found.reached.sum(axis=1))) <= {2, 4, 6, 8}


@pytest.mark.parametrize("name", SEVEN)
def test_every_branch_of_an_srs_arm_at_its_own_arm_angle(arm_of, name):
    arm = arm_of(name)
    q = arm.random_q(POSES, seed=1)
    targets = arm.fk(q)
    angle = arm.arm_angle(q)
    found = arm.ik_all(targets, arm_angle=angle)
    assert arm.closed_form == "S-R-S"
    assert (found.status == Status.CONVERGED).all()
    assert found.reached.all()
    assert_branches_reach(arm, targets, found.q, found.reached)
    assert_within_limits(arm, found.q[found.valid])
    off = np.where(found.valid, turns_apart(found.q, q[:, None, :]), np.inf).min(axis=1)
    assert off.max() < 1e-8
    # Every branch has the arm angle that was asked for.
    apart = turns_apart(arm.arm_angle(found.q)[..., None], angle[:, None, None])
    assert apart.max() < 1e-8


def test_the_elbow_of_the_published_target(load_robot):
    # Spec redundant7, section 1: any solution of the target has this |q4|.
    arm = load_robot("redundant7")
    a, b, c = np.pi / 2, np.pi / 4, np.pi / 6
    turn = lambda i, t: _axis_rotation(i, t)  # noqa: E731
    target = np.eye(4)
    target[:3, :3] = turn(2, a) @ turn(1, b) @ turn(2, c)
    target[:3, 3] = 0.334, 0.471, 0.539
    found = arm.ik_all(target, arm_angle=0.4)
    assert np.abs(np.abs(found.q[:, 3]) - 1.7293153436).max() < 1e-10
    assert arm.ik(target, solver="closed_form").success


def _axis_rotation(axis: int, angle: float) -> np.ndarray:
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i] = out[j, j] = np.cos(angle)
    out[j, i] = np.sin(angle)
    out[i, j] = -np.sin(angle)
    return out


@pytest.mark.parametrize("name", SIX + SEVEN)
@pytest.mark.parametrize("choose", ["nearest", "margin", "middle"])
def test_the_best_branch_is_reached_within_the_limits(arm_of, name, choose):
    arm = arm_of(name)
    targets = arm.fk(arm.random_q(20_000, seed=2))
    result = arm.ik(targets, solver=solvers.ClosedForm(choose=choose))
    assert result.success.all()
    assert result.position_error.max() < POSITION_M
    assert result.orientation_error.max() < ROTATION
    assert_within_limits(arm, result.q)
    got = arm.fk(result.q)
    assert np.abs(got - targets).max() < ROTATION


@pytest.mark.parametrize("name", SIX)
def test_the_choice_is_the_best_of_all_branches(arm_of, name):
    arm = arm_of(name)
    q0 = arm.random_q(500, seed=4)
    targets = arm.fk(arm.random_q(500, seed=3))
    found = arm.ik_all(targets, q0=q0)
    middle, half = (arm.upper + arm.lower) / 2, (arm.upper - arm.lower) / 2
    share = (arm.ik_all(targets).q - middle) / half
    costs = {
        "nearest": ((found.q - q0[:, None]) ** 2).sum(axis=-1),
        "middle": (share**2).sum(axis=-1),
        "margin": np.abs(share).max(axis=-1),
    }
    for choose, cost in costs.items():
        start = q0 if choose == "nearest" else None
        result = arm.ik(targets, q0=start, solver=solvers.ClosedForm(choose=choose))
        best = np.where(found.valid, cost, np.inf).min(axis=1)
        if choose == "nearest":
            got = ((result.q - q0) ** 2).sum(axis=-1)
        else:
            off = (result.q - middle) / half
            got = (off**2).sum(-1) if choose == "middle" else np.abs(off).max(-1)
        assert np.abs(got - best).max() < 1e-9


def test_near_its_own_start_the_answer_is_the_start(arm_of):
    for name in SIX:
        arm = arm_of(name)
        q = arm.random_q(2000, seed=5)
        result = arm.ik(arm.fk(q), q0=q, solver="closed_form")
        assert np.abs(result.q - q).max() < 1e-8


@pytest.mark.parametrize("name", SEVEN)
def test_arm_angle_intervals_hold_just_what_the_limits_allow(arm_of, name):
    arm = arm_of(name)
    angles = np.linspace(-np.pi, np.pi, 721)[:-1] + 1e-3
    for target in arm.fk(arm.random_q(40, seed=6)):
        intervals = arm.arm_angle_intervals(target)
        valid = arm.ik_all(np.broadcast_to(target, (720, 4, 4)), arm_angle=angles).valid
        for branch, inside in zip(intervals, valid.T, strict=True):
            low, high = branch[:, 0], branch[:, 1]
            assert ((low >= -np.pi) & (low < np.pi) & (high > low)).all()
            turn = 2 * np.pi * np.ceil((low - angles[:, None]) / (2 * np.pi))
            held = ((angles[:, None] + turn) <= high).any(axis=1)
            # At the very edge rounding decides.
            edges = np.concatenate([low, high])
            off = np.abs((angles[:, None] - edges + np.pi) % (2 * np.pi) - np.pi)
            clear = (off > 1e-7).all(axis=1)
            assert (held == inside)[clear].all()


@pytest.mark.parametrize("name", SEVEN)
def test_a_few_narrow_arm_angles_are_found(arm_of, name):
    # Postures near the limits, whose arm angles leave little room.
    arm = arm_of(name)
    rng = np.random.default_rng(0)
    side = rng.choice([-1.0, 1.0], (3000, 7))
    q = (1 - 1e-3 * rng.random((3000, 7))) * side * arm.upper
    targets = arm.fk(q)
    result = arm.ik(targets, solver="closed_form")
    assert result.success.all()
    assert_within_limits(arm, result.q)


def test_out_of_reach_and_out_of_limits_are_told(load_robot):
    puma = load_robot("puma560")
    far = np.eye(4)
    far[:3, 3] = 2.0, 0.0, 0.5
    assert puma.ik_all(far).status == Status.OUT_OF_REACH
    assert not puma.ik_all(far).reached.any()
    result = puma.ik(far, solver="closed_form")
    assert not result.success
    assert result.status == Status.OUT_OF_REACH
    assert result.position_error > 0.9
    assert_within_limits(puma, result.q)
    # A posture outside the limits of which no branch is inside.
    q = np.array([0.3, -2.0, 0.5, 0.2, 1.0, 0.1])
    found = puma.ik_all(puma.fk(q))
    assert found.reached.any()
    assert not found.valid.any()
    assert found.status == Status.OUT_OF_REACH

    arm = load_robot("redundant7")
    far[:3, 3] = 0.0, 0.0, 2.0
    assert arm.ik(far, solver="closed_form").status == Status.OUT_OF_REACH
    close = np.eye(4)
    close[:3, 3] = 0.05, 0.0, 0.34 + 0.126
    # The wrist is nearer to the shoulder than |q4| = 120 degrees allows: no arm angle helps.
    assert arm.ik(close, solver="closed_form").status == Status.OUT_OF_REACH


def test_singular_postures_are_solved_and_told(load_robot):
    arm = load_robot("puma560")
    # Wrist in line.
    q = np.array([0.2, 0.7, -0.3, 0.5, 0.0, 0.4])
    found = arm.ik_all(arm.fk(q), q0=q)
    assert (found.singular[found.valid] & Singularity.WRIST).any()
    assert_branches_reach(arm, arm.fk(q), found.q, found.reached)
    assert np.abs(found.q - q).max(axis=-1)[found.valid].min() < 1e-8
    # One of the four arms leaves the wrist in line: its two branches are one.
    assert found.reached.sum() == 7
    # Elbow stretched: the wrist's centre at the edge of the reach.
    q = np.array([0.2, 0.7, -np.pi / 2 + np.arctan2(0.0203, 0.4318), 0.5, 0.6, 0.4])
    found = arm.ik_all(arm.fk(q))
    assert found.reached.any()
    assert_branches_reach(arm, arm.fk(q), found.q, found.reached)


def test_shoulder_singularity_takes_the_first_joint_from_the_start(arm_of):
    arm = arm_of("irb140")
    # The wrist's centre on the first axis.
    for q2 in (-0.4, 0.1):
        lift = 0.07 + 0.36 * np.sin(q2)
        q = np.array([0.8, q2, np.arccos(-lift / 0.38) - q2, 0.3, 0.6, -0.2])
        target = arm.fk(q)
        found = arm.ik_all(target, q0=q)
        assert (found.singular[found.reached] & Singularity.SHOULDER).all()
        assert_branches_reach(arm, target, found.q, found.reached)
        assert np.abs(found.q - q).max(axis=-1).min() < 1e-7


def test_stretched_srs_arm(load_robot):
    arm = load_robot("redundant7")
    for q in ([0.3, 0.5, 0.2, 0.0, 0.4, 0.6, 0.1], [0.3, 0.0, 0.2, 1.0, 0.4, 0.0, 0.1], [0.0] * 7):
        target = arm.fk(np.array(q))
        found = arm.ik_all(target, arm_angle=arm.arm_angle(q))
        assert found.status == Status.CONVERGED
        assert found.singular[found.valid].any()
        assert_branches_reach(arm, target, found.q, found.reached)
        assert arm.ik(target, solver="closed_form").success


def test_every_whole_turn_within_the_limits_counts(arm_of):
    # Joint 6 of the IRB 140 turns by more than two turns.
    arm = arm_of("irb140")
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 6.5])
    target = arm.fk(q)
    near_middle = arm.ik(target, solver="closed_form")
    assert abs(near_middle.q[5]) <= np.pi
    near_start = arm.ik(target, q0=q, solver="closed_form")
    assert np.abs(near_start.q - q).max() < 1e-9


def test_a_tool_for_one_call_is_behind_the_robots_own(arm_of):
    own, tool = np.eye(4), np.eye(4)
    own[:3, :3] = _axis_rotation(2, -0.7)
    own[:3, 3] = 0.05, 0.02, 0.1
    tool[:3, :3] = _axis_rotation(1, 0.4)
    tool[:3, 3] = 0.1, -0.2, 0.3
    for name in ("kr16", "iiwa14"):
        arm = arm_of(name).with_tool(own)
        q = arm.random_q(100, seed=8)
        other = arm.with_tool(own @ tool)
        targets = other.fk(q)
        found = arm.ik_all(targets, tool=tool)
        assert (found.valid.sum(axis=1) > 0).mean() > 0.5
        assert_branches_reach(other, targets, found.q, found.reached)
        best = arm.ik(targets, tool=tool, solver="closed_form")
        assert best.success.all()
        assert np.abs(other.fk(best.q) - targets).max() < ROTATION
    pairs = zip(
        arm.arm_angle_intervals(targets[0], tool=tool),
        other.arm_angle_intervals(targets[0]),
        strict=True,
    )
    assert all(np.abs(one - two).max(initial=0.0) < 1e-9 for one, two in pairs)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_recognition_is_scaled_by_the_reach(arm_of, size):
    """Rounding in a file hides no wrist, at any size of arm; a calibrated arm is refused."""
    for name, family, steps in (("puma560", "spherical wrist", 4), ("redundant7", "S-R-S", 5)):
        arm = arm_of(name)
        rows = np.array([[row.a, row.alpha, row.d, row.theta] for row in arm.dh])
        rows[:, [0, 2]] *= size
        reach = size * arm.reach_radius
        limits = np.stack([arm.lower, arm.upper], axis=1)
        assert Robot.from_dh(rows, limits=limits).closed_form == family
        rounded = rows.copy()
        rounded[steps, 0] += 1e-7 * reach
        rounded[1, 1] += 1e-7
        close = Robot.from_dh(rounded, limits=limits)
        assert close.closed_form == family
        # Answers are for the arm as given: within its tolerances, not its recognition's.
        targets = close.fk(close.random_q(200, seed=1))
        result = close.ik(
            targets,
            solver="closed_form",
            position_tolerance=1e-5 * size,
            orientation_tolerance=1e-5,
        )
        assert result.success.all()
        rows[steps, 0] += 1e-5 * reach
        assert Robot.from_dh(rows, limits=limits).closed_form is None


def test_bad_input_is_a_status_and_bad_arguments_raise(load_robot):
    arm = load_robot("puma560")
    targets = arm.fk(arm.random_q(5, seed=1))
    targets[2, 0, 3] = np.nan
    found = arm.ik_all(targets)
    assert found.status.tolist() == [0, 0, Status.BAD_INPUT, 0, 0]
    assert not found.valid[2].any()
    assert arm.ik(targets, solver="closed_form").status[2] == Status.BAD_INPUT
    points = arm.ik_all(targets[:, :3, 3], q0=arm.random_q(5, seed=1))
    assert points.status[2] == Status.BAD_INPUT
    assert (np.delete(points.status, 2) == Status.SINGULAR_FAMILY).all()
    with pytest.raises(ArgumentError, match="full pose"):
        arm.ik(targets[:, :3, 3], solver="closed_form")
    with pytest.raises(ArgumentError, match="not redundant"):
        arm.ik_all(targets, arm_angle=0.1)
    with pytest.raises(ArgumentError, match="not redundant"):
        arm.arm_angle(arm.random_q(3))
    with pytest.raises(ArgumentError, match="arm_angle"):
        load_robot("redundant7").ik_all(np.eye(4), arm_angle=np.nan)
    with pytest.raises(ArgumentError, match=r"ClosedForm.choose"):
        solvers.ClosedForm(choose="best")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"ClosedForm.arm_angle"):
        solvers.ClosedForm(arm_angle=float("inf"))
    with pytest.raises(ArgumentError, match=r"ClosedForm.certify"):
        solvers.ClosedForm(certify="yes")  # type: ignore[arg-type]
    srs = load_robot("redundant7")
    for wrong in ("a", [0.1], True, 1j):
        with pytest.raises(ArgumentError, match="arm_angle"):
            srs.ik_all(np.eye(4), arm_angle=wrong)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("ur5", "miss a common point by 94.650 mm"),
        ("panda", "miss a common point by 88.000 mm"),
        ("cucumber", "prismatic"),
        ("hydrolek", "joint variables|miss|parallel"),
    ],
)
def test_an_arm_without_closed_form_says_why(load_robot, name, why):
    arm = load_robot(name)
    assert arm.closed_form is None
    target = arm.fk(arm.random_q(seed=0))
    with pytest.raises(ArgumentError, match=why):
        arm.ik(target, solver="closed_form")


def test_auto_is_the_closed_form_for_poses_and_lm_for_the_rest(load_robot):
    arm = load_robot("puma560")
    targets = arm.fk(arm.random_q(200, seed=1))
    auto = arm.ik(targets, solver="auto")
    assert (auto.q == arm.ik(targets, solver="closed_form").q).all()
    assert (auto.iterations == 0).all()
    points = targets[:, :3, 3]
    assert (arm.ik(points, solver="auto").q == arm.ik(points).q).all()
    other = load_robot("hydrolek")
    targets = other.fk(other.random_q(50, seed=1))
    assert (other.ik(targets, solver="auto").q == other.ik(targets).q).all()


def test_auto_takes_other_closed_forms_and_is_never_worse_than_lm(load_robot):
    arm = load_robot("ur5")
    rng = np.random.default_rng(4)
    q = arm.random_q(500, seed=1)
    q[:50, 4] = 0.0  # straight wrists
    q[50:100] = np.where(rng.random((50, 6)) < 0.5, arm.lower, arm.upper)
    targets = arm.fk(q)
    auto = arm.ik(targets, solver="auto")
    plain = arm.ik(targets)
    assert (auto.success | ~plain.success).all()
    assert (auto.iterations[100:] == 0).mean() > 0.99
    assert auto.position_error[auto.success].max() < 1e-9
    near = arm.ik(targets[100:], q0=q[100:], solver="auto")
    assert np.abs(near.q - q[100:]).max() < 1e-6
    far = targets[:3].copy()
    far[:, 0, 3] += 10.0
    assert (arm.ik(far, solver="auto").status == arm.ik(far).status).all()
    for i in range(100, 110):
        assert (arm.ik(targets[i], solver="auto").q == auto.q[i]).all()


@pytest.mark.parametrize("name", ["puma560", "redundant7"])
def test_answers_do_not_depend_on_batch_or_threads(load_robot, name):
    arm = load_robot(name)
    targets = arm.fk(arm.random_q(3000, seed=9))
    whole = arm.ik_all(targets, threads=1)
    split = arm.ik_all(targets, threads=2)
    assert (whole.q == split.q).all()
    assert (whole.valid == split.valid).all()
    for i in range(3):
        alone = arm.ik_all(targets[i])
        assert (alone.q == whole.q[i]).all()
        assert (alone.valid == whole.valid[i]).all()
    shaped = arm.ik_all(targets[:12].reshape(3, 4, 4, 4))
    assert shaped.q.shape == (3, 4, 8, arm.dof)
    assert (shaped.q.reshape(12, 8, -1) == whole.q[:12]).all()
    assert arm.ik_all(targets[:0]).q.shape == (0, 8, arm.dof)
    best = arm.ik(targets, solver="closed_form")
    assert (arm.ik(targets[5], solver="closed_form").q == best.q[5]).all()


def test_names_are_public():
    assert ik.Singularity.WRIST == 4
    assert ik.Branches.__name__ == "Branches"
