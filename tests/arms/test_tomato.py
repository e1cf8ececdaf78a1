"""The tomato arm: branches, corrections, servo limits, iterations, torques."""

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import ArgumentError, Status, UnknownNameError
from agrik_fast.arms import (
    BRANCHES,
    Load,
    Outcome,
    Servo,
    TomatoArm,
    TransposeStepWarning,
    holding_torques,
)
from agrik_fast.papers import tomato as paper

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "data" / "tomato_reference.json").read_text("utf-8")
)
PI = math.pi
FREE = TomatoArm(lower=[-PI] * 3, upper=[PI] * 3)
SERVOS = TomatoArm()


def around(count: int, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    return FREE.fk(random.uniform(-3.1, 3.1, (count, 3)))


def test_reference_kinematics() -> None:
    rows = REFERENCE["fk"]
    q = np.array([row["q"] for row in rows])
    np.testing.assert_allclose(FREE.fk(q), [row["e"] for row in rows], atol=1e-15)
    np.testing.assert_allclose(FREE.jacobian(q), [row["J"] for row in rows], atol=1e-15)
    robot = ik.Robot.load("tomato")
    inside = robot.random_q(200, seed=1)
    np.testing.assert_allclose(FREE.fk(inside), robot.fk(inside)[:, :3, 3], atol=1e-15)
    determinant = -0.16 * 0.16 * np.hypot(*FREE.fk(q)[:, :2].T) * np.sin(q[:, 1])
    sign = np.sign(np.cos(q[:, 0]) + np.cos(q[:, 0] + q[:, 1]))
    np.testing.assert_allclose(np.linalg.det(FREE.jacobian(q)), sign * determinant, atol=1e-15)


def test_reference_branches() -> None:
    rows = REFERENCE["analytic"]
    made = FREE.branches([row["t"] for row in rows])
    expected = [[row["branches"][name] for name in BRANCHES] for row in rows]
    np.testing.assert_allclose(made.q, expected, atol=5e-15)
    assert made.valid.all() and (made.outcome == Outcome.OK).all()


@pytest.mark.parametrize("links", [(0.16, 0.16), (0.2, 0.12)])
def test_all_branches_reach_all_targets(links: tuple[float, float]) -> None:
    arm = TomatoArm(*links, lower=[-PI] * 3, upper=[PI] * 3)
    targets = arm.fk(np.random.default_rng(2).uniform(-PI, PI, (20_000, 3)))
    made = arm.branches(targets)
    assert (made.outcome == Outcome.OK).all()
    assert np.abs(arm.fk(made.q) - targets[:, None]).max() < 1e-14


def test_printed_formulas_miss() -> None:
    """Section 2 of the specification: elbow sign, X for the distance, lost sign of z.

    Medians (m) over targets that fill the reach evenly; the specification's, over its own
    targets, are 0.283, 0.046, 0.220 and 0.394.
    """
    random = np.random.default_rng(4)
    way = random.normal(size=(20_000, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    targets = 0.32 * np.cbrt(random.random((20_000, 1))) * way
    x, y, z = targets.T
    rho, distance = np.hypot(x, y), np.linalg.norm(targets, axis=1)
    pan = np.arctan2(y, x)
    link = 0.16

    def angles(far: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angle between link 1 and the line to the target, and that at the elbow."""
        inner = np.arccos(np.clip(far / (2 * link), -1, 1))
        return inner, np.arccos(np.clip(1 - far**2 / (2 * link**2), -1, 1))

    def miss(phi1: np.ndarray, phi2: np.ndarray, phi3: np.ndarray, keep: object = ...) -> float:
        off = FREE.fk(np.stack([phi1, phi2, phi3], axis=-1)) - targets
        return float(np.median(np.linalg.norm(off, axis=1)[keep]))

    inner, theta = angles(distance)
    elevation = np.arctan2(z, rho)
    assert miss(elevation + inner, theta - PI, pan) < 1e-12
    # (5) with (7): two arc cosines added, phi2 positive.
    assert miss(elevation + inner, PI - theta, pan) == pytest.approx(0.281, abs=2e-3)
    # (5), (6): X where the distance from the pan axis is meant.
    short, bent = angles(np.hypot(x, z))
    assert miss(np.arctan2(z, np.abs(x)) + short, bent - PI, pan) == pytest.approx(0.046, abs=2e-3)
    # (5), the first of its arc cosines: it has no sign.
    lost = miss(np.arccos(rho / distance) + inner, theta - PI, pan, z < 0)
    assert lost == pytest.approx(0.227, abs=2e-3)
    # (8): an arctan of a quotient points forward.
    lost = miss(elevation + inner, theta - PI, np.arctan(y / x), x < 0)
    assert lost == pytest.approx(0.388, abs=2e-3)
    # (8) has C - y, (11) has y: the pan of one is the other's mirrored.
    mirrored = miss(elevation + inner, theta - PI, np.arctan2(-y, x))
    assert mirrored == pytest.approx(0.219, abs=2e-3)
    # (16) with (17) is (14): J is square.
    q = np.random.default_rng(5).uniform(0.3, 1.2, (50, 3)) * [1, -1, 1]
    jacobian, step = FREE.jacobian(q), np.array([[1e-3], [-2e-3], [1e-3]])
    square = np.swapaxes(jacobian, 1, 2) @ jacobian
    by_17 = np.linalg.solve(square, np.swapaxes(jacobian, 1, 2) @ step)
    np.testing.assert_allclose(by_17, np.linalg.solve(jacobian, step), rtol=1e-8)


def test_centre_takes_the_images_axis() -> None:
    """C - y of (8): y grows to the right, from a place that need not be the arm's middle."""
    centre = 0.16
    image = TomatoArm(lower=[-PI] * 3, upper=[PI] * 3, centre=centre)
    targets = around(500, 3)
    turned = targets * [1, -1, 1] + [0, centre, 0]
    np.testing.assert_array_equal(image.solve(turned).outcome, FREE.solve(targets).outcome)
    found = image.solve(turned)
    np.testing.assert_allclose(image.fk(found.q), turned, atol=1e-14)
    np.testing.assert_allclose(found.q, FREE.solve(targets).q, atol=1e-13)
    # (8) as printed, where its arctan holds.
    front = targets[:, 0] > 0.05
    x, y, _ = turned[front].T
    pan = image.branches(turned[front]).q[:, 0, 2]
    np.testing.assert_allclose(pan, np.arctan((centre - y) / x), atol=1e-12)
    step = 1e-6
    for joint in range(3):
        moved = found.q + step * np.eye(3)[joint]
        slope = (image.fk(moved) - image.fk(found.q)) / step
        np.testing.assert_allclose(image.jacobian(found.q)[..., joint], slope, atol=1e-6)
    ended = image.iterate(turned[front][:20], "inverse", gain=0.1)
    assert (ended.success == FREE.iterate(targets[front][:20], "inverse", gain=0.1).success).all()
    assert np.abs(image.fk(ended.q) - turned[front][:20])[ended.success].max() < 5e-4
    assert FREE.centre is None
    # A point of the image's middle is straight ahead.
    assert TomatoArm(centre=0.3).solve([0.2, 0.3, 0.1]).q[2] == 0.0


def test_outcomes_and_statuses() -> None:
    cases = {
        (0.33, 0.0, 0.0): (Outcome.TOO_FAR, Status.OUT_OF_REACH),
        (0.0, 0.0, 1e-10): (Outcome.TOO_NEAR, Status.OUT_OF_REACH),
        (0.0, 0.0, 0.2): (Outcome.ON_AXIS, Status.CONVERGED),
        (math.nan, 0.0, 0.0): (Outcome.BAD_INPUT, Status.BAD_INPUT),
        (0.2, 0.0, 0.1): (Outcome.OK, Status.CONVERGED),
        (0.05, 0.0, -0.3): (Outcome.SERVO_LIMIT, Status.OUT_OF_REACH),
    }
    current = (1.0, -1.5, 0.4)
    res = SERVOS.solve(list(cases), current=current)
    assert list(zip(res.outcome, res.status, strict=True)) == list(cases.values())
    # Nothing moves unless the target is reached.
    assert (res.q[~res.success] == current).all()
    assert res.q[2, 2] == current[2]
    assert (res.branch[~res.success] == -1).all()


def test_servo_limits_hold_and_coverage() -> None:
    robot = ik.Robot.load("tomato")
    targets = robot.fk(robot.random_q(20_000, seed=7))[:, :3, 3]
    res = SERVOS.solve(targets)
    assert res.success.all()
    assert (res.q >= SERVOS.lower).all() and (res.q <= SERVOS.upper).all()
    assert np.abs(SERVOS.fk(res.q) - targets).max() < 1e-14
    # Targets all around: the servos reach some, and every refusal is right.
    targets = around(5000, 8)
    res = SERVOS.solve(targets)
    assert 0.05 < res.success.mean() < 0.6
    valid = SERVOS.branches(targets).valid.any(axis=1)
    assert (valid == res.success).all()
    assert (res.outcome[~res.success] == Outcome.SERVO_LIMIT).all()


def test_hysteresis_keeps_the_branch() -> None:
    path = np.stack([np.full(100, 0.2), np.linspace(-0.1, 0.1, 100), np.full(100, 0.05)], axis=1)
    for number, name in enumerate(BRANCHES):
        res = FREE.solve(path, branch=name, follow=True)
        assert (res.branch == number).all()
        moved = np.diff(res.q, axis=0)
        assert np.abs(moved - 2 * PI * np.round(moved / (2 * PI))).max() < 0.05
    assert (FREE.solve(path).branch == 0).all()
    with pytest.raises(UnknownNameError):
        FREE.solve(path, branch="sideways")
    with pytest.raises(ArgumentError):
        FREE.solve(path, branch=4)


def test_iterations_fall_geometrically_with_the_gain() -> None:
    targets = paper.targets()
    counts = {}
    for gain in (0.5, 0.1, 0.02):
        res = FREE.iterate(targets, "inverse", gain=gain)
        assert res.success.all() and (res.reason == "ok").all()
        counts[gain] = res.iterations
        start = np.linalg.norm(targets - FREE.fk([PI / 3, -PI / 2, 0.0]), axis=1)
        expected = np.log(start / 5e-4) / -math.log1p(-gain)
        if gain <= 0.1:
            assert np.abs(res.iterations / expected - 1).max() < 0.25
    # Inverse and pseudo-inverse are one for a square Jacobian.
    same = FREE.iterate(targets, "pinv", gain=0.1)
    assert (same.iterations == counts[0.1]).all()
    fixed = FREE.iterate(targets, "inverse", step_length=1e-3)
    assert fixed.success.all() and 50 < fixed.iterations.mean() < 400
    assert FREE.iterate(targets, "dls").iterations.mean() < 8


def test_transpose_step_above_its_bound_fails_where_predicted() -> None:
    targets = paper.targets(200)
    bound = FREE.transpose_bound(FREE.branches(targets).q[:, 0])
    jacobian = FREE.jacobian(FREE.branches(targets).q[:, 0])
    largest = np.linalg.norm(jacobian, 2, axis=(1, 2)) ** 2
    np.testing.assert_allclose(bound, 2 / largest, rtol=1e-12)
    assert 17.5 < bound.min() < 19
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        calm = FREE.iterate(targets, "transpose", alpha=0.9 * float(bound.min()))
    assert calm.success.all()
    with pytest.warns(TransposeStepWarning, match="stability bound"):
        wild = FREE.iterate(targets, "transpose", alpha=20.0, max_iterations=3000)
    # Just below the bound the iteration converges, but slowly.
    above, below = bound < 20, bound > 20.3
    assert 5 < above.sum() < 100 and below.sum() > 100
    assert not wild.success[above].any() and wild.success[below].all()
    with pytest.warns(TransposeStepWarning):
        hopeless = FREE.iterate(targets, "transpose", alpha=70.0, max_iterations=500)
    assert hopeless.success.mean() < 0.05  # by luck
    automatic = FREE.iterate(targets, "transpose")
    assert automatic.success.all() and automatic.iterations.mean() < 60


def test_straight_arm_stalls() -> None:
    target, start = [0.3, 0.0, 0.0], (0.0, 0.0, 0.0)
    assert FREE.iterate(target, "transpose", q0=start, alpha=5.0).reason == "stalled"
    for method in ("inverse", "pinv"):
        assert FREE.iterate(target, method, q0=start).reason == "singular"
    assert FREE.iterate([1.0, 0, 0], "inverse").reason == "too_far"
    assert FREE.iterate([math.inf, 0, 0], "inverse").reason == "bad_input"
    assert FREE.iterate([0.2, 0, 0.1], "inverse", gain=0.01, max_iterations=3).reason == "cap"


def test_torques() -> None:
    arguments = REFERENCE["torque"]["args_l1_l2_m1_m2_mm_mo"]
    l1, l2, link1, link2, motor, payload = arguments
    load = Load(link1=link1, link2=link2, motor=motor, payload=payload)
    found = holding_torques(l1, l2, load)
    np.testing.assert_allclose(found[:2], REFERENCE["torque"]["M"], rtol=1e-12)
    assert found.enough and found.shoulder_factor == pytest.approx(1.75, abs=0.01)
    heavy = holding_torques(0.2, 0.2, Load(link1=0.04, link2=0.04))
    assert heavy[:2] == pytest.approx((0.437, 0.137), abs=1e-3)
    assert not heavy.enough
    # The paper's (3) lets only link 1 balance off its middle.
    off = holding_torques(load=Load(balance2=0.3))
    # As printed M2 is 11 % and M1 3 % too large for a second link that balances at 0.3 l2.
    assert found.elbow / off.elbow == pytest.approx(1.107, abs=1e-3)
    assert found.shoulder / off.shoulder == pytest.approx(1.032, abs=1e-3)
    upright = holding_torques(phi1=PI / 2, phi2=0.0)
    assert abs(upright.shoulder) < 1e-12
    # a in metres, for the share of the length.
    assert holding_torques(load=Load(a2=0.3 * l2)) == pytest.approx(off)
    # (3) and (4) as printed: right for a1, not for a2.
    for load in (Load(), Load(a1=0.05), Load(a1=-0.03), Load(balance1=0.2)):
        held = holding_torques(load=load, gravity=9.80665)
        assert paper.printed_torques(0.16, 0.16, load) == pytest.approx(held[:2], rel=1e-12)
    both = Load(a1=0.05, a2=0.05)
    off_middle, printed = holding_torques(load=both), paper.printed_torques(0.16, 0.16, both)
    assert off_middle[:2] == pytest.approx((0.3060, 0.0941), abs=1e-4)
    assert printed == pytest.approx((0.3154, 0.1036), abs=1e-4)
    with pytest.raises(ArgumentError):
        holding_torques(l1=-1.0)
    with pytest.raises(ArgumentError):
        holding_torques(load=Load(payload=-1.0))


def test_bad_arguments() -> None:
    for wrong in ({"l1": 0.0}, {"l2": math.nan}, {"lower": [0, 0]}, {"lower": [4, 0, 0]}):
        with pytest.raises(ArgumentError):
            TomatoArm(**wrong)
    with pytest.raises(ArgumentError):
        FREE.solve([1.0, 2.0])
    for wrong in (
        {"gain": 0.0},
        {"gain": 1.1},
        {"step_length": -1.0},
        {"tolerance": 0.0},
        {"max_iterations": 0},
    ):
        with pytest.raises(ArgumentError):
            FREE.iterate([0.2, 0, 0], "inverse", **wrong)
    with pytest.raises(ArgumentError):
        FREE.iterate([0.2, 0, 0], "transpose", alpha=-1.0)
    with pytest.raises(UnknownNameError):
        FREE.iterate([0.2, 0, 0], "newton")
    for call in (
        lambda: TomatoArm("0.16"),
        lambda: FREE.solve([0.2, 0, 0], current=[np.nan, 0, 0]),
        lambda: FREE.solve([0.2, 0, 0], follow="no"),
        lambda: FREE.branches([0, 0, 0.2], pan=np.nan),
        lambda: FREE.branches([0, 0, 0.2], pan="0"),
        # Also where the method has no use for them.
        lambda: FREE.iterate([0.2, 0, 0], "inverse", alpha=-1.0),
        lambda: FREE.iterate([0.2, 0, 0], "inverse", damping=0.0),
    ):
        with pytest.raises(ArgumentError):
            call()
    targets = np.tile([0.2, 0.0, 0.1], (3, 1))
    with pytest.raises(ArgumentError, match=r"^`q0`: .*broadcasts to \(3, 3\), got shape \(2, 3\)"):
        FREE.iterate(targets, "inverse", q0=[[1.0, -1.0, 0.0]] * 2)
    starts = np.array([[1.0, -1.0, 0.0], [1.2, -1.7, 0.1], [0.9, -1.4, -0.2]])
    each = FREE.iterate(targets, "inverse", q0=starts, gain=0.2)
    for start, count in zip(starts, each.iterations, strict=True):
        assert FREE.iterate(targets[0], "inverse", q0=start, gain=0.2).iterations == count


def test_bad_torques() -> None:
    servo = {"name": "x", "torque": 0.3, "mass": 0.04, "speed": 5.0, "source": ""}
    for call in (
        lambda: Servo(**{**servo, "torque": -0.3}),
        lambda: Servo(**{**servo, "speed": np.nan}),
        lambda: Load(link2=-0.1),
        lambda: Load(balance1=np.nan),
        lambda: Load(a1=np.inf),
        lambda: TomatoArm(centre=np.nan),
        lambda: holding_torques(gravity=np.nan),
        lambda: holding_torques(gravity=-9.8),
        lambda: holding_torques(phi1="0"),
        lambda: holding_torques(load={"link1": 0.1}),
        lambda: holding_torques(elbow="HS-311"),
        lambda: holding_torques(safety_factor=0),
    ):
        with pytest.raises(ArgumentError):
            call()


def test_failed_rows_hold_the_present_pose_and_how_far_it_is_off() -> None:
    current = (1.0, -1.5, 0.3)
    targets = np.array([[9.0, 0, 0], [0.05, 0, -0.3], [np.nan, 0, 0], [0.2, 0, 0.1]])
    res = SERVOS.solve(targets, current=current)
    off = np.linalg.norm(SERVOS.fk(current) - targets[:2], axis=1)
    np.testing.assert_allclose(res.position_error[:2], off, rtol=1e-14)
    assert res.position_error[2] == res.orientation_error[2] == np.inf
    assert res.orientation_error[[0, 1, 3]].tolist() == [0, 0, 0]
    assert res.position_error[3] < 1e-14
