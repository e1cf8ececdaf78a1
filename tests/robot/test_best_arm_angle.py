"""The best arm angle of S-R-S arms is the best: against dense grids, limits, random starts."""

from pathlib import Path

import numpy as np
import pytest

from agrik_fast import Robot, Status, solvers

DATA = Path(__file__).parents[1] / "data"
# What `ClosedForm.certify` promises of the cost, and the rounding of this file's own.
TOLERANCE = 1e-9 + 1e-10
ANGLES = np.linspace(-np.pi, np.pi, 1441)[:-1] + 1e-4
CHOICES = ("nearest", "margin", "middle")


def load(name: str) -> Robot:
    path = DATA / f"{name}.urdf"
    return Robot.load(path if path.exists() else name)


def costs(arm: Robot, q: np.ndarray, choose: str, centre: np.ndarray) -> np.ndarray:
    """What each choice means, written out again."""
    if choose == "nearest":
        return ((q - centre) ** 2).sum(axis=-1)
    share = (q - (arm.lower + arm.upper) / 2) / ((arm.upper - arm.lower) / 2)
    return (share**2).sum(axis=-1) if choose == "middle" else np.abs(share).max(axis=-1)


def grid_best(
    arm: Robot, target: np.ndarray, choose: str, centre: np.ndarray
) -> tuple[float, float]:
    """Least cost of the grid's angles and of the ends of all allowed intervals."""
    ends = np.concatenate([branch.ravel() for branch in arm.arm_angle_intervals(target)])
    angles = np.concatenate([ANGLES, ends, ends + 1e-9, ends - 1e-9])
    targets = np.broadcast_to(target, (len(angles), 4, 4))
    found = arm.ik_all(targets, arm_angle=angles)
    # The proof is about postures that solve the target; beyond a limit by a hair, `ik_all` gives
    # one that is within the tolerances at the limit, and costs a little less.
    exact = np.abs(arm.fk(found.q) - targets[:, None]).max(axis=(-2, -1)) < 1e-11
    cost = np.where(found.valid & exact, costs(arm, found.q, choose, centre), np.inf)
    best = np.unravel_index(cost.argmin(), cost.shape)
    return float(cost[best]), float(angles[best[0]])


@pytest.mark.parametrize("name", ["redundant7", "iiwa14"])
@pytest.mark.parametrize("choose", CHOICES)
def test_no_arm_angle_of_a_dense_grid_is_better(name, choose):
    arm = load(name)
    count = 60
    targets = arm.fk(arm.random_q(count, seed=21))
    q0 = arm.random_q(count, seed=22)
    solver = solvers.ClosedForm(choose=choose, certify=True)
    result = arm.ik(targets, q0=q0, solver=solver)
    assert result.success.all()
    got = costs(arm, result.q, choose, q0)
    quick = arm.ik(targets, q0=q0, solver=solvers.ClosedForm(choose=choose))
    looked_at = costs(arm, quick.q, choose, q0)
    assert (got <= looked_at + TOLERANCE).all()
    gains, improved = [], 0
    for target, start, cost in zip(targets, q0, got, strict=True):
        best, angle = grid_best(arm, target, choose, start)
        assert cost <= best + TOLERANCE, angle
        # The grid's best is near: the answer's cost is no fancy.
        gains.append(best - cost)
        improved += cost < best - 1e-7
    assert np.median(gains) < 1e-2
    assert improved > count // 6  # between the grid's angles


@pytest.mark.parametrize("choose", CHOICES)
def test_batches_of_random_poses_never_do_worse_than_the_quick_look(choose):
    for name in ("redundant7", "iiwa14"):
        arm = load(name)
        q = arm.random_q(20_000, seed=23)
        targets = arm.fk(q)
        best = arm.ik(targets, solver=solvers.ClosedForm(choose=choose, certify=True))
        quick = arm.ik(targets, solver=solvers.ClosedForm(choose=choose))
        assert best.success.all() and quick.success.all()
        middle = (arm.lower + arm.upper) / 2
        cost, other, own = (costs(arm, x, choose, middle) for x in (best.q, quick.q, q))
        assert (cost <= other + TOLERANCE).all()
        # The posture that a pose was made from is a branch as well.
        assert (cost <= own + TOLERANCE).all()
        # The quick look is right for most poses, not for all.
        assert 0.005 < (cost < other - 1e-6).mean() < 0.4


@pytest.mark.parametrize("count", [1, 200])
def test_the_solver_by_its_name_is_that_with_the_defaults(count):
    arm = load("redundant7")
    targets = arm.fk(arm.random_q(count, seed=25))
    by_name = arm.ik(targets, solver="closed_form")
    assert by_name.success.all()
    assert (by_name.q == arm.ik(targets, solver=solvers.ClosedForm()).q).all()
    assert (by_name.q == arm.ik(targets, solver="auto").q).all()


@pytest.mark.parametrize("name", ["redundant7", "iiwa14"])
def test_a_start_that_solves_the_pose_is_the_nearest(name):
    arm = load(name)
    q = arm.random_q(5000, seed=24)
    result = arm.ik(arm.fk(q), q0=q, solver="closed_form")
    assert result.success.all()
    # 1e-9 rad^2 in the cost.
    assert np.linalg.norm(result.q - q, axis=1).max() < 4e-5


def test_limits_that_leave_little(load_robot):
    """Tight limits: pieces of arm angles are short, the best is at an end, or there is none."""
    whole = load_robot("redundant7")
    rows = [[row.a, row.alpha, row.d, row.theta] for row in whole.dh]
    rng = np.random.default_rng(5)
    solved = unreachable = unproven = 0
    for _ in range(40):
        middle = rng.uniform(-1, 1, 7)
        limits = np.stack([middle - 0.5, middle + 0.5], axis=1)
        arm = Robot.from_dh(rows, limits=limits)
        inside = arm.random_q(3, seed=1)
        other = np.clip(inside + rng.normal(scale=0.6, size=inside.shape), -2, 2)
        for target in (*arm.fk(inside), *arm.fk(other)):
            for choose in CHOICES:
                result = arm.ik(target, solver=solvers.ClosedForm(choose=choose, certify=True))
                best, _ = grid_best(arm, target, choose, middle)
                if result.success:
                    solved += 1
                    assert costs(arm, result.q, choose, middle) <= best + TOLERANCE
                else:
                    # Within rounding of a limit nothing is proven.
                    unreachable += result.status == Status.OUT_OF_REACH
                    unproven += result.status == Status.NOT_FOUND
                    assert best == np.inf
    assert solved > 300
    assert unreachable > 100
    assert unproven < 10


@pytest.mark.parametrize("certify", [False, True])
def test_axes_in_line_are_no_proof_of_out_of_reach(load_robot, certify):
    """Joints in line share a turn in any way, more than arm angles tell of."""
    rows = [[row.a, row.alpha, row.d, row.theta] for row in load_robot("redundant7").dh]
    arm = Robot.from_dh(rows, limits=np.tile([-1.2, 1.2], (7, 1)))
    q = arm.random_q(200, seed=3)
    q[:, [1, 3, 5]] = 0.0
    q[100:, 5] = 0.7
    # Out of reach for want of height, though the arm's axes are in line.
    beyond = arm.fk(q[:5])
    beyond[:, 2, 3] += 0.01
    solver = solvers.ClosedForm(certify=certify)
    result = arm.ik(arm.fk(q), solver=solver)
    assert set(result.status) <= {Status.CONVERGED, Status.NOT_FOUND}
    assert result.success.mean() > 0.5
    assert (arm.ik(beyond, solver=solver).status == Status.OUT_OF_REACH).all()


def test_joints_that_turn_freely(load_robot):
    rows = [[row.a, row.alpha, row.d, row.theta] for row in load_robot("redundant7").dh]
    arm = Robot.from_dh(rows)
    q0 = arm.random_q(40, seed=1)
    targets = arm.fk(arm.random_q(40, seed=2))
    result = arm.ik(targets, q0=q0, solver=solvers.ClosedForm(certify=True))
    assert result.success.all()
    for target, start, q in zip(targets, q0, result.q, strict=True):
        found = arm.ik_all(np.broadcast_to(target, (len(ANGLES), 4, 4)), arm_angle=ANGLES, q0=start)
        cost = np.where(found.valid, ((found.q - start) ** 2).sum(axis=-1), np.inf)
        assert ((q - start) ** 2).sum() <= cost.min() + TOLERANCE


@pytest.mark.parametrize("certify", [False, True])
def test_alone_and_in_a_batch(load_robot, certify):
    arm = load_robot("redundant7")
    targets = arm.fk(arm.random_q(50, seed=25))
    solver = solvers.ClosedForm(certify=certify)
    batch = arm.ik(targets, solver=solver)
    for i in range(0, 50, 7):
        assert (arm.ik(targets[i], solver=solver).q == batch.q[i]).all()
    assert (arm.ik(targets, solver=solver, threads=2).q == batch.q).all()
