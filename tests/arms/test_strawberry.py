"""The strawberry arm in closed form: reference values, corrections, coverage, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import ArgumentError, Status, UnknownNameError
from agrik_fast.arms import Place, StrawberryArm
from agrik_fast.drivers import StrawberryRig
from agrik_fast.papers import strawberry as paper

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "data" / "strawberry_reference.json").read_text("utf-8")
)
ARM = StrawberryArm()
TARGETS = paper.targets()


def millimetres(q: np.ndarray) -> np.ndarray:
    return q * [1000, 1000, 1000, 1, 1]


def inside_box(count: int, seed: int) -> np.ndarray:
    low, high = ARM.target_box
    return low + np.random.default_rng(seed).random((count, 3)) * (high - low)


@pytest.mark.parametrize("row", REFERENCE["rows"], ids=lambda row: f"row{row['row']}")
@pytest.mark.parametrize(("method", "key"), [("exact", "NCOS"), ("ssas", "SSAS"), ("as", "AS")])
def test_reference_rows(row: dict, method: str, key: str) -> None:
    target = np.array(row["target_used"]) / 1000
    res = ARM.solve(target, method)
    assert res.success
    expected = row[key]["q_s10_s21_s32_theta_beta"]
    np.testing.assert_allclose(millimetres(res.q), expected, rtol=0, atol=2e-9)
    assert 1000 * float(res.energy) == pytest.approx(row[key]["J"], abs=1e-8)


def test_geometry_is_that_of_the_robot_file() -> None:
    robot = ik.Robot.load("strawberry")
    q = robot.random_q(500, seed=3)
    np.testing.assert_allclose(ARM.fk(q), robot.fk(q)[:, :3, 3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(ARM.lower, robot.lower, rtol=0, atol=1e-15)
    np.testing.assert_allclose(ARM.upper, robot.upper, rtol=0, atol=1e-15)


def test_every_answer_reaches_within_limits_by_the_robots_own_kinematics() -> None:
    robot = ik.Robot.load("strawberry")
    targets = inside_box(20_000, 0)
    share = {"exact": 0.95, "ssas": 0.85, "as": 0.85}
    for method, least in share.items():
        res = ARM.solve(targets, method)
        solved = res.success
        assert solved.mean() >= least, (method, solved.mean())
        reached = robot.fk(res.q[solved])[:, :3, 3]
        assert np.abs(reached - targets[solved]).max() < 1e-14
        assert (res.q[solved] >= ARM.lower).all() and (res.q[solved] <= ARM.upper).all()
        assert np.isnan(res.energy[~solved]).all() and (res.gap[~solved] != 0).all()
        assert (res.place[solved] == Place.REACHED).all()
        assert (res.q[~solved] == ARM.reset_pose).all()


def test_exact_is_the_least_and_solves_what_the_others_miss() -> None:
    targets = inside_box(5000, 1)
    exact, ssas, analytic = (ARM.solve(targets, m) for m in ("exact", "ssas", "as"))
    assert exact.success[ssas.success].all() and exact.success[analytic.success].all()
    for other in (ssas, analytic):
        both = other.success
        assert (exact.energy[both] <= other.energy[both] + 1e-9).all()
    both = ssas.success & analytic.success
    assert (ssas.energy[both] <= analytic.energy[both] + 1e-12).all()
    missed = exact.success & ~analytic.success
    assert missed.any()
    assert (analytic.status[missed] == Status.NOT_FOUND).all()
    assert (exact.status[~exact.success] == Status.OUT_OF_REACH).all()


def test_exact_agrees_with_slsqp_also_where_slides_are_at_limits() -> None:
    targets = inside_box(60, 2)
    exact, ncos = ARM.solve(targets), ARM.solve(targets, "ncos")
    found = ncos.success
    # From home SLSQP often ends at a point that does not reach the target.
    assert 0.5 < found.mean() < 0.75 and exact.success.mean() > 0.95
    assert exact.success[found].all()
    # SLSQP may stop short or in a worse minimum; it never finds less.
    excess = ncos.energy[found] - exact.energy[found]
    assert excess.min() > -1e-6
    assert np.median(excess) < 1e-9
    theta, _ = ARM.free_pose
    constrained = exact.q[found][:, 3] != theta
    assert constrained.sum() >= 10


def test_free_pose() -> None:
    np.testing.assert_allclose(ARM.free_pose, REFERENCE["free_pose_rad"], rtol=0, atol=1e-12)


def test_energy_misprints() -> None:
    """(21) as printed, and its sign: both far from the table that the paper computed."""
    res = ARM.solve(TARGETS, "exact")
    published = np.array([row["J_NCOS"] for row in paper.published()])
    assert np.abs(1000 * res.energy - published).max() < 0.06
    p = ARM.parameters
    s10, s21, s32, theta, beta = (millimetres(res.q)).T
    friction = p["friction"] * (s10 - 75 + s21 - 80 + s32 - 61)
    weight = (p["mass2"] + p["mass3"]) * p["gravity"]
    lift2 = (p["mass2"] / 2 + p["mass3"]) * p["gravity"] * 102 * (1 - np.cos(theta))
    bend = 1 - np.cos(beta) * np.cos(theta)
    used = weight * (s32 - 61) - lift2 - p["mass3"] * p["gravity"] * 30 * bend
    np.testing.assert_allclose(friction + used, 1000 * res.energy, atol=1e-9)
    # PE_f - PE_in instead of its negative: off by twice the potential part.
    off = np.abs(friction - used - published)
    assert (off.min(), off.max()) == pytest.approx((1838, 4447), abs=1)
    # The bracket as printed divides by 2 (1 - cos cos), with l2.
    printed = weight * (s32 - 61) - lift2 - p["mass3"] * p["gravity"] * 102 / (2 * bend)
    off = np.abs(friction + printed - published)
    np.testing.assert_allclose(off, 1257.56, atol=0.06)


def test_printed_signs_of_the_forward_kinematics() -> None:
    """(18) has -dz; with it the tool misses by twice dz."""
    res = ARM.solve(TARGETS[0], "as")
    s10, s21, s32, theta, beta = res.q
    p = ARM.parameters
    printed = -TARGETS[0, 2] - p["d"][2] - (p["l2"] + p["l3"] * np.cos(beta)) * np.cos(theta)
    assert abs(printed - s32) == pytest.approx(2 * abs(p["d"][2]), rel=1e-9)
    off = ARM.fk([s10, s21, printed, theta, beta]) - TARGETS[0]
    assert np.linalg.norm(off) > 0.05


def test_slopes_match_finite_differences_and_the_printed_ones_do_not() -> None:
    p = ARM.parameters
    l1, l2, l3, d = p["l1"], p["l2"], p["l3"], p["d"]
    q = np.array([0.3, 0.5, 0.15, -0.4, 0.9])
    target = ARM.fk(q)
    h = 1e-6

    def along(s10: float, case: str) -> np.ndarray:
        """Beta, theta, friction (J) and all other energy (J) at an s10."""
        beta = np.arcsin((target[1] - s10 - l1 + d[1]) / l3)
        r, r0 = l2 + l3 * np.cos(beta), l2 + l3 * np.cos(q[4])
        theta = {
            "fixed": q[3],
            "s21": np.arcsin(r0 * np.sin(q[3]) / r),
            "s32": -np.arccos(r0 * np.cos(q[3]) / r),
        }[case]
        s21 = target[0] - d[0] + r * np.sin(theta)
        s32 = -target[2] + d[2] - r * np.cos(theta)
        friction = p["friction"] * (s10 + s21 + s32)
        whole = float(ARM.energy([s10, s21, s32, theta, beta]))
        return np.array([beta, theta, friction, whole - friction])

    for case in ("fixed", "s21", "s32"):
        slopes = ARM.slopes(q[3], q[4], case)
        beta, theta, friction, rest = (along(q[0] + h, case) - along(q[0] - h, case)) / (2 * h)
        # (26), (27) and (28), (25), (24), each by itself.
        assert slopes["beta_by_s10"] == pytest.approx(beta, rel=1e-8)
        assert slopes["theta_by_beta"] == pytest.approx(theta / beta, abs=1e-7)
        assert slopes["friction_by_s10"] == pytest.approx(friction, abs=1e-6)
        assert slopes["potential_by_s10"] == pytest.approx(rest, abs=1e-6)
    # (26) as printed has l2 for l1: 4 to 9 % off at the targets of table 3.
    off = []
    for target, pose in zip(TARGETS, ARM.solve(TARGETS, "as").q, strict=True):
        printed = -1 / np.sqrt(l3**2 - (target[1] - pose[0] - l2 + d[1]) ** 2)
        off.append(abs(printed / ARM.slopes(*pose[3:])["beta_by_s10"] - 1))
    assert (min(off), max(off)) == pytest.approx((0.04, 0.09), abs=0.01)


def test_printed_conditions_cannot_hold() -> None:
    """(14), (24), (30), (31) and (34) as printed, each with its error."""
    p = ARM.parameters
    l2, l3, d = p["l2"], p["l3"], p["d"]
    # (14): an arcsine of numbers beyond 1 at every random reachable target.
    q = ik.Robot.load("strawberry").random_q(20_000, seed=1)
    x, r = ARM.fk(q)[:, 0], l2 + l3 * np.cos(q[:, 4])
    low, high = ((limit[1] + d[0] - x) / r for limit in (ARM.lower, ARM.upper))
    assert ((np.abs(low) > 1) | (np.abs(high) > 1)).all()
    # What (15) loses without its other branch.
    assert (q[:, 3] < 0).mean() == pytest.approx(0.53, abs=0.01)
    # (24) has the sign of PE_f - PE_in: off by twice its size, in N.
    postures = ARM.solve(TARGETS, "as").q
    slopes = [ARM.slopes(*posture[3:])["potential_by_s10"] for posture in postures]
    assert 2 * np.abs(slopes).min() == pytest.approx(7.830, abs=1e-3)
    assert 2 * np.abs(slopes).max() == pytest.approx(13.4, abs=0.05)
    # (30) wants the friction's derivative to vanish too: at the least energy it does not.
    best = ARM.solve(TARGETS).q
    friction = [abs(ARM.slopes(*posture[3:])["friction_by_s10"]) for posture in best]
    np.testing.assert_allclose(friction, 4.3534, atol=1e-4)
    # (31), (32): beta with l2 for l1.
    sine = (TARGETS[:, 1] - postures[:, 0] - l2 + d[1]) / l3
    off = np.degrees(np.abs(np.arcsin(sine) - postures[:, 4]))
    assert (off.min(), off.max()) == pytest.approx((11.7, 12.4), abs=0.1)
    # (34): the arcsine of (x - 80 mm - dx) / r at home, beyond 1 at all targets.
    assert ((TARGETS[:, 0] - ARM.lower[1] - d[0]) / (l2 + l3) > 2).all()


def test_box_corrections() -> None:
    """(6) uses beta_max, (9) and (10) pair the wrong extremes: both exclude reachable targets."""
    p = ARM.parameters
    low, high = ARM.target_box
    # x largest: long reach (beta 0), theta at its lower limit.
    q = np.array([0.3, ARM.upper[1], 0.1, ARM.lower[3], 0.0])
    assert ARM.fk(q)[0] == pytest.approx(high[0], abs=1e-15)
    short = p["l2"] + p["l3"] * np.cos(ARM.upper[4])
    printed_x_max = ARM.upper[1] + p["d"][0] - short * np.sin(ARM.lower[3])
    assert ARM.fk(q)[0] - printed_x_max == pytest.approx(0.0360, abs=1e-4)
    # z lowest: s32 drawn out, (9) has it drawn in.
    q = np.array([0.3, 0.5, ARM.upper[2], 0.0, 0.0])
    assert ARM.fk(q)[2] == pytest.approx(low[2], abs=1e-15)
    assert ARM.solve(ARM.fk(q)).success
    tips = ARM.fk(ik.Robot.load("strawberry").random_q(20_000, seed=1))
    assert (tips >= low).all() and (tips <= high).all()
    # As printed: the slide's ends exchanged, 190 mm lost below and above.
    cosine = min(np.cos(ARM.lower[3]), np.cos(ARM.upper[3]))
    printed_low = -ARM.lower[2] + p["d"][2] - (p["l2"] + p["l3"])
    printed_high = -ARM.upper[2] + p["d"][2] - short * cosine
    assert printed_low - low[2] == pytest.approx(0.190, abs=1e-12)
    assert high[2] - printed_high == pytest.approx(0.190, abs=1e-12)
    assert (tips[:, 2] < printed_low).mean() == pytest.approx(0.81, abs=0.01)
    assert (tips[:, 2] > printed_high).mean() == pytest.approx(0.67, abs=0.01)


def test_theta_sets_hold_the_negative_branch() -> None:
    """(15) gives one of two intervals; without the other, theta < 0 would be lost."""
    q = np.array([0.3, 0.2, 0.08, -0.7, 0.5])
    sets = ARM.theta_sets(ARM.fk(q), 0.5)
    assert len(sets["s32"]) == 2
    (a, b), (c, d) = sets["s32"]
    assert (a, b) == pytest.approx((-d, -c))
    assert any(low <= -0.7 <= high for low, high in sets["all"])
    low, high = ARM.s10_set(ARM.fk(q))
    assert low <= q[0] <= high
    assert ARM.s10_set([0.5, 5.0, -0.3]) is None


def test_gap_names_slide_and_travel() -> None:
    low, high = ARM.target_box
    middle = ARM.fk([0.3, 0.5, 0.15, 0.1, 0.5])
    cases = [(1, Place.S10), (0, Place.S21), (2, Place.S32)]
    for axis, place in cases:
        for bound, sign in ((high, 1), (low, -1)):
            target = middle.copy()
            target[axis] = bound[axis] + sign * 0.02
            res = ARM.solve(target)
            assert res.place == place and res.status == Status.OUT_OF_REACH
            # s32 grows downward.
            expected = 0.02 * sign * (-1 if axis == 2 else 1)
            assert float(res.gap) == pytest.approx(expected, abs=1e-12)


def test_gap_of_two_slides_together_is_the_smallest_shift_in_their_plane() -> None:
    low, high = ARM.target_box
    random = np.random.default_rng(0)
    targets = low - 0.05 + random.random((5000, 3)) * (high - low + 0.1)
    res = ARM.solve(targets)
    both = res.place == Place.THETA
    assert both.sum() > 40
    shifts = ARM.suggest_base_shift(targets[both], "xz")
    np.testing.assert_allclose(res.gap[both], np.linalg.norm(shifts, axis=1), rtol=0, atol=2e-8)


@pytest.mark.parametrize("axes", ["xyz", "xy"])
def test_base_shift_brings_targets_in_reach(axes: str) -> None:
    low, high = ARM.target_box
    random = np.random.default_rng(8)
    targets = low - 0.1 + random.random((400, 3)) * (high - low + 0.2)
    shift = ARM.suggest_base_shift(targets, axes)
    possible = np.isfinite(shift).all(axis=1)
    assert possible.mean() > (0.99 if axes == "xyz" else 0.4)
    assert ARM.solve(targets[possible] - shift[possible]).success.all()
    moved = np.linalg.norm(shift[possible], axis=1) > 0
    assert moved.sum() > 50
    assert (ARM.solve(targets[possible]).success == ~moved).all()
    shorter = targets[possible][moved] - 0.999 * shift[possible][moved]
    assert not ARM.solve(shorter).success.any()
    if axes == "xy":
        assert (shift[possible][:, 2] == 0).all()


def test_rules_of_remarks_1_and_2() -> None:
    target = TARGETS[0]
    low, high = ARM.s10_set(target)
    for share in (0.0, 0.25, 1.0):
        res = ARM.solve(target, "as", s10_share=share)
        assert float(res.q[0]) == pytest.approx(low + share * (high - low), abs=1e-15)
    assert float(ARM.solve(target, "as", theta_step=0.0).q[3]) == 0.0
    middle = ARM.solve(target, "as", theta_rule="middle")
    (interval,) = ARM.theta_sets(target, float(middle.q[4]))["all"][:1]
    assert middle.success and abs(float(middle.q[3])) > 0.01 and len(interval) == 2
    # The remark's text (no step) costs 15.3 mJ against the table's 0.01 rad.
    steps = [ARM.solve(target, "as", theta_step=step).energy for step in (0.0, 0.01)]
    assert 1000 * (steps[1] - steps[0]) == pytest.approx(15.3, abs=0.2)


def test_commands_wait_above_the_plant() -> None:
    q = ARM.solve(TARGETS[0]).q
    steps = ARM.commands(q, psi=0.2, h_extra=0.04)
    axes = ["gripper", "s32", "s10", "s21", "theta", "beta", "psi", "s32", "gripper"]
    assert [step.axis for step in steps] == axes
    assert steps[1].target == pytest.approx(float(q[2]) - 0.04)
    assert steps[7].target == float(q[2])
    # As printed, s32 + h_extra, the arm would first go 40 mm too deep.
    clearance = ARM.fk(q)[2] - ARM.fk([*q[:2], q[2] + 0.04, *q[3:]])[2]
    assert clearance == pytest.approx(0.04)
    with pytest.raises(ArgumentError):
        ARM.commands(q, h_extra=-0.01)
    with pytest.raises(ArgumentError):
        ARM.commands(q * 10)


def test_commands_go_home_the_way_they_came() -> None:
    """Step 7: lifted first, then back; checked like the way out."""
    q = ARM.solve(TARGETS[0]).q
    out = ARM.commands(q, psi=0.2, h_extra=0.04)
    home = ARM.commands(q, psi=0.2, h_extra=0.04, reset=True)
    assert [step.axis for step in home] == ["s32", "psi", "beta", "theta", "s21", "s10", "s32"]
    assert home[0] == out[1]  # as high as on the way out
    assert home.clearance == out.clearance == pytest.approx(0.04) and home.note == ""
    at = dict(zip(("s10", "s21", "s32", "theta", "beta"), q.tolist(), strict=True)) | {"psi": 0.2}
    for number, step in enumerate(home):
        at[step.axis] = step.target
        if 0 < number < 6:
            assert at["s32"] == pytest.approx(float(q[2]) - 0.04)
    names = ("s10", "s21", "s32", "theta", "beta")
    assert [at[name] for name in names] == ARM.reset_pose.tolist() and at["psi"] == 0
    for wrong in ({"h_extra": -0.01}, {"psi": 2.0}, {"reset": "yes"}):
        with pytest.raises(ArgumentError):
            ARM.commands(q, **{"reset": True, **wrong})
    with pytest.raises(ArgumentError):
        ARM.commands(q * 10, reset=True)


def test_commands_say_what_clearance_they_keep() -> None:
    low = ARM.lower[2]
    q = [0.3, 0.4, low + 0.02, 0.1, 0.5]
    for reset in (False, True):
        steps = ARM.commands(q, h_extra=0.05, reset=reset)
        assert steps.clearance == pytest.approx(0.02) and steps.wanted == 0.05
        assert steps.note == (
            "the clearance is 20.0 mm, not 50.0 mm: more would take slide s32 past its home"
        )
        assert min(step.target for step in steps if step.axis == "s32") == pytest.approx(low)
    assert ARM.commands(q, h_extra=0.02).note == ""


def test_the_sixth_joint_turns_the_gripper_and_nothing_else() -> None:
    five, six = ik.Robot.load("strawberry"), ik.Robot.load("strawberry6")
    q = six.random_q(300, seed=4)
    pose = six.fk(q)
    np.testing.assert_allclose(pose[:, :3, 3], five.fk(q[:, :5])[:, :3, 3], atol=1e-15)
    assert six.joint_names == (*five.joint_names, "psi")
    assert (six.lower[5], six.upper[5]) == pytest.approx((-np.pi / 2, np.pi / 2))
    # The gripper's axis: from the roll axis to the tip.
    roll = six.fk_links(q)[:, six.link_names.index("beta_link"), :3, 3]
    axis = (pose[:, :3, 3] - roll) / 0.06
    np.testing.assert_allclose(pose[:, :3, 2], axis, atol=1e-14)
    turned = six.fk(np.concatenate([q[:, :5], q[:, 5:] + 0.3], axis=1))
    np.testing.assert_allclose(turned[:, :3, 2], pose[:, :3, 2], atol=1e-15)
    across = np.einsum("ki,ki->k", turned[:, :3, 0], pose[:, :3, 0])
    np.testing.assert_allclose(across, np.cos(0.3), atol=1e-14)
    # With the axis given, psi is free: five of six rows.
    res = six.ik(pose, task=ik.tasks.Axis())
    assert res.success.mean() > 0.95


def test_one_servo_moves_fingers_and_cutter() -> None:
    six = ik.Robot.load("strawberry6")
    assert six.end_effector.moves == ("left_finger", "right_finger", "cutter")
    q = ARM.solve(TARGETS[0]).q
    for reset in (False, True):
        axes = {step.axis for step in ARM.commands(q, reset=reset)}
        assert axes <= {*six.joint_names, six.end_effector.servo}
        assert ("gripper" in axes) == (not reset)
    assert ik.Robot.load("strawberry").end_effector is None
    assert six.with_tool(np.eye(4)).end_effector == six.end_effector


def test_drivers_and_commands_have_the_same_axes() -> None:
    six = ik.Robot.load("strawberry6")
    assert StrawberryRig.joint_names == six.joint_names
    q = ARM.solve(TARGETS[0]).q
    axes = {step.axis for step in ARM.commands(q, psi=0.1)}
    assert axes == {*StrawberryRig.joint_names, six.end_effector.servo}


def test_base_moves_by_yaw_cost_least() -> None:
    low, high = ARM.target_box
    random = np.random.default_rng(5)
    targets = low - 0.3 + random.random((4, 3)) * (high - low + 0.6)
    shifts = ARM.suggest_base_shift(targets)
    for weight in (0.05, 0.5, 50.0):
        moves = ARM.suggest_base_shift(targets, yaw_weight=weight)
        assert moves.shape == (4, 4)
        for target, shift, move in zip(targets, shifts, moves, strict=True):
            c, s = np.cos(move[3]), np.sin(move[3])
            seen = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ target - move[:3]
            assert ARM.solve(seen).success
            cost = np.hypot(np.linalg.norm(move[:3]), weight * move[3])
            assert cost <= np.linalg.norm(shift) + 1e-12
            # Nor is anything on a grid of yaws cheaper.
            yaws = np.linspace(-np.pi, np.pi, 61)
            c, s = np.cos(yaws), np.sin(yaws)
            x, y, z = target
            seen = np.stack([c * x + s * y, c * y - s * x, np.full(61, z)], axis=1)
            far = np.linalg.norm(ARM.suggest_base_shift(seen), axis=1)
            assert np.hypot(far, weight * yaws).min() > cost - 1e-3
            if weight == 50.0:
                # Too dear to turn by more than a hair.
                assert abs(move[3]) < 0.02
    # A target behind the platform: turning is cheap, moving is not.
    behind = np.array([-0.45, -0.25, -0.33])
    move = ARM.suggest_base_shift(behind, yaw_weight=0.05)
    assert abs(move[3]) > 1.0
    assert np.linalg.norm(move[:3]) < 0.5 * np.linalg.norm(ARM.suggest_base_shift(behind))


def test_base_moves_within_reach_and_beyond_help() -> None:
    targets = np.array([TARGETS[0], [np.nan, 0, 0], [0.5, 0.3, -2.0]])
    moves = ARM.suggest_base_shift(targets, "xy", yaw_weight=0.3)
    assert not moves[0].any()
    assert np.isnan(moves[1]).all()
    assert np.isnan(moves[2]).all()  # too deep, however the platform turns
    for wrong in ({"yaw_weight": 0.0}, {"yaw_weight": np.nan}, {"axes": "xz", "yaw_weight": 0.3}):
        with pytest.raises(ArgumentError):
            ARM.suggest_base_shift(targets, **wrong)


def test_ncos_starts_where_it_is_told() -> None:
    points = TARGETS[:4]
    exact = ARM.solve(points)
    for start in (ARM.reset_pose, ARM.solve(points, "as").q, exact.q):
        res = ARM.solve(points, "ncos", q0=start)
        assert res.success.all()
        np.testing.assert_allclose(res.energy, exact.energy, atol=1e-9)
    # From the answer it has little to do.
    home = ARM.solve(points, "ncos").iterations
    assert (ARM.solve(points, "ncos", q0=exact.q).iterations < home).all()
    with pytest.raises(ArgumentError, match="q0"):
        ARM.solve(points, "exact", q0=exact.q)
    for wrong in (np.zeros(4), np.zeros((3, 5)), np.full(5, np.nan)):
        with pytest.raises(ArgumentError, match="q0"):
            ARM.solve(points, "ncos", q0=wrong)


def test_table_3_matches_as_far_as_the_specification_says() -> None:
    cells = paper.table3()
    count = {c: sum(x.matches for x in cells if x.column == c) for c in ("ncos", "ssas", "as")}
    assert count == {"ncos": 20, "ssas": 0, "as": 16}
    missed = {x.row: x.residual_mj for x in cells if x.column == "as" and not x.matches}
    assert set(missed) == {2, 3, 8, 10}
    np.testing.assert_allclose(list(missed.values()), [10.3, 45.8, 20.7, 20.7], atol=0.1)
    residual = [x.residual_mj for x in cells if x.column == "ssas"]
    quadrants = np.array(residual).reshape(4, 5)
    np.testing.assert_allclose(quadrants.mean(axis=1), [45.9, 22.7, 29.5, 52.4], atol=0.1)
    # The printed z is rounded to 0.1 mm, and the energy moves 24.5 mJ a millimetre.
    printed = [c for c in paper.table3(printed=True) if c.column == "exact"]
    sphere = [c for c in cells if c.column == "exact"]
    moved = [abs(a.energy_mj - b.energy_mj) for a, b in zip(printed, sphere, strict=True)]
    assert 2.0 < max(moved) < 2.5


def test_bad_arguments() -> None:
    bad = ARM.solve([[np.nan, 0, 0], TARGETS[0]])
    assert bad.status.tolist() == [Status.BAD_INPUT, Status.CONVERGED]
    assert bad.place.tolist() == [Place.BAD_INPUT, Place.REACHED]
    assert ARM.solve(np.empty((0, 3))).q.shape == (0, 5)
    assert ARM.solve(TARGETS.reshape(4, 5, 3), "ssas").energy.shape == (4, 5)
    for wrong in ([1.0, 2.0], "abc", [[1, 2, 3, 4]]):
        with pytest.raises(ArgumentError):
            ARM.solve(wrong)
        with pytest.raises(ArgumentError):
            ARM.solve(wrong, "ncos")
    with pytest.raises(UnknownNameError, match="exact"):
        ARM.solve(TARGETS, "exakt")
    with pytest.raises(UnknownNameError):
        ARM.solve(TARGETS, "as", theta_rule="median")
    with pytest.raises(ArgumentError):
        ARM.solve(TARGETS, "as", s10_share=1.5)
    with pytest.raises(ArgumentError):
        ARM.suggest_base_shift(TARGETS, "xq")
    for wrong in ({"l2": 0.0}, {"friction": -1.0}, {"lower": [0] * 4}, {"d": [0, 0, np.inf]}):
        with pytest.raises(ArgumentError):
            StrawberryArm(**wrong)
    for wrong in ({"mass2": "1"}, {"friction": True}, {"l3": np.nan}, {"gravity": [9.81]}):
        with pytest.raises(ArgumentError, match=f"`{next(iter(wrong))}`"):
            StrawberryArm(**wrong)
    # Rules are checked for all methods, those that have no use for them too.
    for method in ("exact", "as", "ssas", "ncos"):
        for wrong in ({"s10_share": np.nan}, {"theta_step": "0"}, {"theta_rule": None}):
            with pytest.raises((ArgumentError, UnknownNameError)):
                ARM.solve(TARGETS[:1], method, **wrong)
    q = ARM.solve(TARGETS[0]).q
    for call in (
        lambda: ARM.s10_set([np.nan, 0, 0]),
        lambda: ARM.theta_sets([np.nan, 0, 0], 0.1),
        lambda: ARM.theta_sets(TARGETS[0], np.nan),
        lambda: ARM.slopes(np.nan, 0.1),
        lambda: ARM.slopes(0.1, "0.1"),
        lambda: ARM.commands(q, psi="0"),
        lambda: ARM.commands(q, h_extra=None),
        lambda: ARM.suggest_base_shift(TARGETS, 3),
    ):
        with pytest.raises(ArgumentError):
            call()
    with pytest.raises(UnknownNameError, match="s32"):
        ARM.slopes(0.1, 0.1, "s3")
    with pytest.raises(ArgumentError, match="s32, got 3"):
        ARM.slopes(0.1, 0.1, 3)
    # Without friction the proof of the exact minimum does not hold, and it says so.
    with pytest.raises(ArgumentError, match="friction"):
        StrawberryArm(friction=0.1).solve(TARGETS)
    slippery = StrawberryArm(friction=0.1)
    assert slippery.solve(TARGETS, "as").success.all()
    # The baseline needs no proof, and no target beyond reach stops it.
    ncos = slippery.solve([TARGETS[0], [0.4, 1.2, -0.3]], "ncos")
    assert ncos.success.tolist() == [True, False]
    assert ncos.place.tolist() == [Place.REACHED, Place.S10]


def test_poses_without_derivatives_are_refused() -> None:
    assert all(
        np.isfinite(list(ARM.slopes(0.3, 0.5, case).values())).all()
        for case in ("fixed", "s21", "s32")
    )
    # (26) divides by cos(beta), (27) by cos(theta), (28) by sin(theta).
    for theta, beta, case in (
        (0.1, np.pi / 2, "fixed"),
        (np.pi / 2, 0.5, "s21"),
        (0.0, 0.5, "s32"),
    ):
        with pytest.raises(ArgumentError, match="derivatives"):
            ARM.slopes(theta, beta, case)


@pytest.mark.parametrize("method", ["exact", "as", "ssas", "ncos"])
def test_failed_rows_hold_the_reset_pose_and_how_far_it_is_off(method: str) -> None:
    targets = np.array([[0.4, 1.2, -0.3], [np.nan, 0, 0], TARGETS[0]])
    res = ARM.solve(targets, method)
    assert (res.q[:2] == ARM.reset_pose).all()
    off = np.linalg.norm(ARM.fk(ARM.reset_pose) - targets[0])
    assert res.position_error[0] == pytest.approx(off, rel=1e-14)
    assert res.position_error[1] == res.orientation_error[1] == np.inf
    assert res.orientation_error[[0, 2]].tolist() == [0, 0]
    assert res.position_error[2] < 1e-8
    assert res.restarts.tolist() == [0, 0, 0]
    # The closed forms take no steps, SLSQP does; bad input is not tried.
    assert res.iterations[1] == 0
    assert (res.iterations[[0, 2]] > 0).all() == (method == "ncos")


def test_theta_of_least_magnitude_is_that_of_the_sets() -> None:
    """The quick way by sines takes the element that the sets (14)-(16) say, also at ties."""
    solved = ties = 0
    for target in inside_box(2000, 31):
        res = ARM.solve(target, "as", theta_step=0.0)
        if not res.success:
            continue
        solved += 1
        beta = float(res.q[4])
        elements = [min(max(0.0, a), b) for a, b in ARM.theta_sets(target, beta)["all"]]
        ties += len(elements) == 2 and abs(elements[0] + elements[1]) < 1e-12
        # Of two as near to 0 the negative one, which costs less.
        assert float(res.q[3]) == pytest.approx(min(elements, key=abs), abs=1e-9)
    assert solved > 1000
    assert ties > 100
