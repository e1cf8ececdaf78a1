"""What the freedom of answers is used for: second aims, limits kept off, nearest solutions."""

import numpy as np
import pytest
from scipy.optimize import minimize

import agrik_fast as ik
from agrik_fast.errors import ArgumentError, UnknownNameError
from agrik_fast.tasks import Axis, Pose, Position, SecondAim

SEVEN = ("redundant7", "panda", "iiwa14")
MEASURES = ("near", "middle", "limits", "manipulability")


def value(arm, measure, q, about=None):
    """Return what a measure makes of a posture; the less the better."""
    middle, half = (arm.lower + arm.upper) / 2, (arm.upper - arm.lower) / 2
    if measure == "near":
        return 0.5 * ((q - (middle if about is None else about)) ** 2).sum(-1)
    if measure == "middle":
        return 0.5 * (((q - middle) / half) ** 2).sum(-1)
    if measure == "limits":
        return (half**2 / ((arm.upper - q) * (q - arm.lower))).sum(-1)
    jacobian = arm.jacobian(q)
    return -0.5 * np.linalg.slogdet(jacobian @ np.swapaxes(jacobian, -1, -2))[1]


@pytest.mark.parametrize("name", SEVEN)
@pytest.mark.parametrize("measure", MEASURES)
def test_success_stays_and_the_measure_betters(name, measure):
    arm = ik.Robot.load(name)
    poses = arm.fk(arm.random_q(400, seed=3))
    plain, aimed = arm.ik(poses), arm.ik(poses, second_aim=measure)
    assert np.array_equal(plain.success, aimed.success)
    ok = aimed.success
    assert ok.mean() > 0.99
    assert abs(arm.fk(aimed.q[ok]) - poses[ok]).max() < 3e-6
    assert ((aimed.q >= arm.lower) & (aimed.q <= arm.upper)).all()
    inside = ok & ((plain.q > arm.lower) & (plain.q < arm.upper)).all(1)
    # Plain answers that were looked for elsewhere, off a limit, are other solutions.
    inside &= plain.restarts == aimed.restarts
    assert inside.mean() > 0.85
    if measure == "limits":
        inside &= ((aimed.q > arm.lower) & (aimed.q < arm.upper)).all(1)
    before, after = value(arm, measure, plain.q[inside]), value(arm, measure, aimed.q[inside])
    better = after < before + 1e-6
    # Some that reach their solution with a joint at a limit stay there, where the plain answer
    # is moved off it; and turns count by the arm's size, which the plain determinant does not.
    assert better.mean() > (0.94 if measure == "manipulability" else 0.97)
    assert np.median(before - after) > 0


@pytest.mark.parametrize("measure", ["near", "middle"])
def test_the_end_is_a_local_optimum(measure):
    arm = ik.Robot.load("panda")
    poses = arm.fk(arm.random_q(30, seed=8))
    found = arm.ik(poses, second_aim=measure)
    missed = 0
    for q, pose in zip(found.q, poses, strict=True):

        def off(x, pose=pose):
            error = arm.fk(x) - pose
            return np.concatenate([error[:3, 3], error[:3, :3].ravel()[:6]])

        best = minimize(
            lambda x: value(arm, measure, x),
            q,
            constraints={"type": "eq", "fun": off},
            bounds=list(zip(arm.lower, arm.upper, strict=True)),
            method="SLSQP",
            options={"ftol": 1e-10},
        )
        gain = value(arm, measure, q) - best.fun
        near = abs(off(best.x)).max() < 1e-5
        missed += bool(near and gain > 1e-3)
    assert missed <= 1


def betterable(arm, task, measure, found, gain=1e-3):
    """Return which answers 0.01 rad along the arm's own freedom, to either side, are better."""
    position = task == Position()

    def rows(q):
        jacobian = arm.jacobian(q)
        if position:
            return jacobian[:, :3]
        if task == Pose():
            return jacobian
        # Turns about the tool's own axis are free.
        across = np.swapaxes(arm.fk(q)[:, :3, :2], 1, 2)
        return np.concatenate([jacobian[:, :3], across @ jacobian[:, 3:]], 1)

    def error(q):
        now, goal = arm.fk(q), arm.fk(found.q)
        moved = goal[:, :3, 3] - now[:, :3, 3]
        if position:
            return moved
        if task == Pose():
            return np.concatenate(
                [moved, np.cross(now[:, :3, :3], goal[:, :3, :3], axis=1).sum(2) / 2], 1
            )
        turned = np.cross(now[:, :3, 2], goal[:, :3, 2])
        return np.concatenate([moved, np.einsum("nij,ni->nj", now[:, :3, :2], turned)], 1)

    before, better = value(arm, measure, found.q), np.zeros(len(found.q), dtype=bool)
    along = np.linalg.svd(rows(found.q))[2][:, -1]
    for side in (0.01, -0.01):
        q = found.q + side * along
        for _ in range(4):
            q = q + np.einsum("nij,nj->ni", np.linalg.pinv(rows(q)), error(q))
        inside = ((q >= arm.lower) & (q <= arm.upper)).all(1) & (abs(error(q)).max(1) < 1e-6)
        better |= inside & (value(arm, measure, q) < before - gain)
    return better & found.success


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("name", [*SEVEN, "sliding"])
def test_few_steps_lead_to_where_nothing_near_is_better(name, measure):
    # One joint is to spare: a search along a curve, of 4 to 5 steps on average.
    arm = sliding() if name == "sliding" else ik.Robot.load(name)
    poses = arm.fk(arm.random_q(400, seed=8))
    found, plain = arm.ik(poses, second_aim=measure), arm.ik(poses)
    assert betterable(arm, Pose(), measure, found).mean() <= 0.01
    alike = found.restarts == plain.restarts
    steps = found.iterations[alike].astype(int) - plain.iterations[alike].astype(int)
    assert 2 < steps.mean() < 6


def sliding():
    """Return the iiwa 14 on a rail that its last joint was given up for, in its kind of units."""
    rows = [(0, -np.pi / 2, 0.36, 0), (0, np.pi / 2, 0, 0), (0, np.pi / 2, 0.42, 0)]
    rows += [(0, -np.pi / 2, 0, 0), (0, -np.pi / 2, 0.4, 0), (0, np.pi / 2, 0, 0)]
    rows = [(0, np.pi / 2, 0, 0), *rows]
    limits = [(-0.5, 0.5), *[(-2.9, 2.9)] * 6]
    kinds = ["prismatic", *["revolute"] * 6]
    return ik.Robot.from_dh(rows, limits=limits, joint_types=kinds)


@pytest.mark.parametrize(
    ("name", "task"), [("ur5", Axis()), ("planar", Position())], ids=["axis", "position"]
)
@pytest.mark.parametrize("measure", ["near", "middle", "limits"])
def test_other_tasks_with_one_joint_to_spare(name, task, measure):
    arm = ik.Robot.load("ur5") if name == "ur5" else four()
    found = arm.ik(arm.fk(arm.random_q(300, seed=8)), task, second_aim=measure)
    assert found.success.mean() > 0.98
    assert betterable(arm, task, measure, found).mean() <= 0.02


def four():
    """Return an arm of four joints whose places fill a space."""
    rows = [(0, np.pi / 2, 0.3, 0), (0.3, 0, 0, 0), (0.3, np.pi / 2, 0, 0), (0.25, 0, 0.1, 0)]
    return ik.Robot.from_dh(rows, limits=[(-2.5, 2.5)] * 4)


def test_weights_and_a_posture_decide():
    arm = ik.Robot.load("panda")
    posture = arm.random_q(seed=4)
    pose = arm.fk(arm.random_q(seed=5))
    heavy = arm.ik(pose, second_aim=SecondAim("near", posture, [100, 1, 1, 1, 1, 1, 1]))
    light = arm.ik(pose, second_aim=SecondAim("near", posture, [0.01, 1, 1, 1, 1, 1, 1]))
    assert abs(heavy.q[0] - posture[0]) <= abs(light.q[0] - posture[0]) + 1e-6


@pytest.mark.parametrize("solver", ["lm", "dls", "pinv", "auto", "state-space"])
def test_every_solver_takes_one(solver):
    arm = ik.Robot.load("iiwa14")
    poses = arm.fk(0.3 * arm.random_q(50, seed=6))
    plain = arm.ik(poses, solver=solver)
    aimed = arm.ik(poses, solver=solver, second_aim="middle")
    assert np.array_equal(plain.success, aimed.success)
    ok = aimed.success
    assert ok.any()
    assert value(arm, "middle", aimed.q[ok]).sum() < value(arm, "middle", plain.q[ok]).sum()


@pytest.mark.parametrize("name", SEVEN)
def test_answers_keep_off_limits(name):
    arm = ik.Robot.load(name)
    result = arm.ik(arm.fk(arm.random_q(3000, seed=9)))
    at = ((result.q <= arm.lower) | (result.q >= arm.upper)).any(1)
    assert result.success.mean() > 0.999
    assert at[result.success].mean() <= 0.01


def test_second_aims_are_the_same_for_any_batch():
    arm = ik.Robot.load("panda")
    poses = arm.fk(arm.random_q(50, seed=7))
    for aim in (None, "limits"):
        whole = arm.ik(poses, second_aim=aim)
        for row in (0, 17, 49):
            alone = arm.ik(poses[row], second_aim=aim, first_index=row)
            assert np.array_equal(alone.q, whole.q[row])
        assert np.array_equal(arm.ik(poses, second_aim=aim, threads=1).q, whole.q)


@pytest.mark.parametrize("name", ["ur5", "puma560", "xarm6"])
def test_nearest_of_all_branches(name):
    arm = ik.Robot.load(name)
    q = arm.random_q(500, seed=4)
    rng = np.random.default_rng(1)
    q0 = np.clip(q + rng.uniform(-0.3, 0.3, q.shape), arm.lower, arm.upper)
    poses = arm.fk(q)
    nearest = arm.ik(poses, q0=q0, nearest=True)
    assert nearest.success.all()
    every = arm.ik_all(poses, q0=q0, wrap=True)
    away = np.where(every.valid, np.linalg.norm(every.q - q0[:, None], axis=2), np.inf).min(1)
    assert (np.linalg.norm(nearest.q - q0, axis=1) <= away + 1e-5).mean() >= 0.998


def near_by(arm, count):
    """Return postures 0.3 rad beside others, and the poses of these."""
    q = arm.random_q(count, seed=4)
    q0 = q + np.random.default_rng(1).uniform(-0.3, 0.3, q.shape)
    return np.clip(q0, arm.lower, arm.upper), arm.fk(q)


@pytest.mark.parametrize("name", ["panda", "iiwa14", "gen3", "xarm7", "cucumber"])
def test_nearest_of_a_sweep(name):
    # Every branch at 1500 values of the free quantity is a solution, and none is nearer. An arm
    # angle, a last joint, one inside the chain and a slide are swept.
    arm = ik.Robot.load(name)
    q0, poses = near_by(arm, 25)
    nearest = arm.ik(poses, q0=q0, nearest=True)
    assert nearest.success.all()
    away = np.linalg.norm(nearest.q - q0, axis=1)
    every = arm.ik_all(poses, q0=q0, sweep=1500)
    least = np.where(every.valid, np.linalg.norm(every.q - q0[:, None], axis=2), np.inf).min(1)
    assert (away <= least + 1e-5).all()
    # Near a singularity a tool that is off by the usual tolerance is worth 1e-4 rad.
    exact = {"q0": q0, "position_tolerance": 1e-9, "orientation_tolerance": 1e-9}
    away, many = (
        np.linalg.norm(arm.ik(poses, nearest=starts, **exact).q - q0, axis=1)
        for starts in (True, 256)
    )
    assert (away <= many + 1e-6).all()
    for row in (0, 13):
        alone = arm.ik(poses[row], q0=q0[row], nearest=True, first_index=row)
        assert np.array_equal(alone.q, nearest.q[row])


def test_starts_lead_to_what_is_near_the_start_values():
    # Each start is moved towards q0, not left where it arrived.
    arm = ik.Robot.load("panda")
    q0, poses = near_by(arm, 40)
    few, many = (arm.ik(poses, q0=q0, nearest=count) for count in (32, 256))
    assert (few.restarts >= 31).all() and (many.restarts >= 255).all()
    away, least = (np.linalg.norm(r.q - q0, axis=1) for r in (few, many))
    assert (away <= least + 1e-5).mean() >= 0.97


def test_nearest_by_weights():
    arm = ik.Robot.load("panda")
    q0, poses = near_by(arm, 60)
    plain = arm.ik(poses, q0=q0, nearest=True)
    weights = [10, 1, 1, 1, 1, 1, 1]
    heavy = arm.ik(poses, q0=q0, nearest=True, joint_weights=weights)
    cost = [(weights * (r.q - q0) ** 2).sum(1) for r in (heavy, plain)]
    assert (cost[0] <= cost[1] + 1e-6).all()
    assert (cost[0] < cost[1] - 1e-3).any()


def test_wrong_wishes_are_named():
    arm = ik.Robot.load("panda")
    pose = arm.fk(arm.random_q(seed=1))
    with pytest.raises(UnknownNameError, match="second_aim"):
        arm.ik(pose, second_aim="middel")
    with pytest.raises(ArgumentError, match="q0"):
        arm.ik(pose, nearest=True)
    with pytest.raises(ArgumentError, match="nearest"):
        arm.ik(pose, q0=arm.home, nearest=0)
    with pytest.raises(ArgumentError, match="joint_weights"):
        arm.ik(pose, q0=arm.home, joint_weights=[1] * 7)
    with pytest.raises(ArgumentError, match="weights"):
        arm.ik(pose, q0=arm.home, nearest=True, joint_weights=[-1] * 7)
    with pytest.raises(ArgumentError, match="posture"):
        SecondAim("middle", posture=[0] * 7)
    with pytest.raises(ArgumentError, match="weights"):
        SecondAim("near", weights=[0] * 7)
    with pytest.raises(ArgumentError, match="posture"):
        arm.ik(pose, second_aim=SecondAim("near", posture=[0] * 6))
