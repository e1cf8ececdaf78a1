"""What is wrong with answers, by forward kinematics of our own and by the documented promises."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from agrik_fast import Status

from .chain import EPS, Arm, Array, axis_angles, rotation_vectors, unit

FIELDS = ("q", "status", "position_error", "orientation_error", "iterations", "restarts")
TURN = 2 * np.pi
TOLERANCES = ("position_tolerance", "orientation_tolerance")


@dataclass(frozen=True)
class Fault:
    """A broken promise."""

    kind: str
    row: int
    text: str


def errors(task: Any, task_name: str, reached: Array, wanted: Array) -> tuple[Array, Array]:
    """Errors that a task's tolerances mean: of position (m) and orientation (rad), each (m,)."""
    off = reached[:, :3, 3] - wanted[:, :3, 3]
    if task_name == "position":
        return np.linalg.norm(off, axis=1), np.zeros(len(off))
    if task_name in ("pose", "position-first"):
        turn = np.swapaxes(reached[:, :3, :3], 1, 2) @ wanted[:, :3, :3]
        return np.linalg.norm(off, axis=1), np.linalg.norm(rotation_vectors(turn), axis=1)
    if task_name == "axis":
        own = np.asarray(task.tool_axis, float)
        is_at = reached[:, :3, :3] @ own
        if task.direction is None:
            should = wanted[:, :3, :3] @ own
        else:
            should = np.broadcast_to(unit(task.direction), is_at.shape)
        return np.linalg.norm(off, axis=1), axis_angles(is_at, should)
    if task_name == "masked":
        counted = np.asarray(task.weights) > 0
        turn = rotation_vectors(wanted[:, :3, :3] @ np.swapaxes(reached[:, :3, :3], 1, 2))
        if task.frame == "tool":
            back = np.swapaxes(reached[:, :3, :3], 1, 2)
            off = (back @ off[:, :, None])[:, :, 0]
            turn = (back @ turn[:, :, None])[:, :, 0]
        return (
            np.linalg.norm(off[:, counted[:3]], axis=1),
            np.linalg.norm(turn[:, counted[3:]], axis=1),
        )
    raise ValueError(f"no task is called {task_name!r}")


def axis_errors(request: Any, reached: Array) -> Array:
    """Errors along and about the axes of the request's frame, (m, 6)."""
    wanted = request.poses
    off = wanted[:, :3, 3] - reached[:, :3, 3]
    turn = rotation_vectors(wanted[:, :3, :3] @ np.swapaxes(reached[:, :3, :3], 1, 2))
    if request.task_name == "axis":
        own = np.asarray(request.task.tool_axis, float)
        is_at = reached[:, :3, :3] @ own
        if request.task.direction is None:
            should = wanted[:, :3, :3] @ own
        else:
            should = np.broadcast_to(unit(request.task.direction), is_at.shape)
        across = np.cross(is_at, should)
        sine = np.linalg.norm(across, axis=1, keepdims=True)
        turn = across * axis_angles(is_at, should)[:, None] / np.maximum(sine, 1e-300)
    if request.frame == "tool":
        back = np.swapaxes(reached[:, :3, :3], 1, 2)
        off, turn = ((back @ each[:, :, None])[:, :, 0] for each in (off, turn))
    return np.concatenate([off, turn], axis=1)


def measured(request: Any, reached: Array) -> tuple[Array, Array, Array, Array]:
    """Errors of position and orientation over the axes that count, and single ones, with bounds.

    Single errors are those of axes that have a bound, (m, 6), and the bounds, (6,), infinite
    where there is none.
    """
    position, orientation = errors(request.task, request.task_name, reached, request.poses)
    bounds = request.bounds
    if bounds is None:
        return position, orientation, np.zeros((len(reached), 6)), np.full(6, np.inf)
    single = axis_errors(request, reached)
    counted = np.asarray(getattr(request.task, "weights", np.ones(6))) > 0
    bounds = np.where(counted, bounds, np.inf)
    if request.task_name == "position":
        bounds[3:] = np.inf
    parts = []
    for part, whole, name in ((slice(0, 3), position, 0), (slice(3, 6), orientation, 1)):
        given = request.options.get(TOLERANCES[name], 1e-6)
        taken = np.isfinite(bounds[part])
        parts.append(np.linalg.norm(single[:, part][:, taken], axis=1) if np.ndim(given) else whole)
    if request.task_name == "position":
        parts[1] = orientation
    return parts[0], parts[1], np.where(np.isfinite(bounds), np.abs(single), 0.0), bounds


def within_limits(arm: Arm, q: Array) -> np.ndarray:
    """Rows whose values keep the limits; those that followers allow, up to rounding."""
    slack = np.where(arm.leads, 4 * EPS * (1 + np.abs(q)), 0.0)
    return ((q >= arm.lower - slack) & (q <= arm.upper + slack)).all(axis=1)


def solves(request: Any, q: Array) -> np.ndarray:
    """Rows of joint values that solve their target beyond doubt, by our own account."""
    arm = request.arm
    finite = np.isfinite(q).all(axis=1) & _finite(request)
    q = np.where(finite[:, None], q, 0.0)
    position, orientation, single, bounds = measured(request, arm.fk(q))
    slip, turn_slip = arm.rounding(q)
    slip = slip + 8 * EPS * np.linalg.norm(request.poses[:, :3, 3], axis=1)
    slips = np.stack([slip] * 3 + [turn_slip] * 3, axis=1)
    with np.errstate(invalid="ignore"):
        near = position <= request.position_tolerance * (1 - 1e-9) - slip
        near &= orientation <= _wanted_turn(request) * (1 - 1e-9) - turn_slip
        near &= (single <= bounds * (1 - 1e-9) - slips).all(axis=1)
    return finite & near & within_limits(arm, q)


def answers(request: Any, result: Any, most: int | None = 3) -> list[Fault]:
    """Return what is wrong with the answers of one call of `ik`: `most` rows of each kind."""
    arm, q = request.arm, np.asarray(result.q)
    status, success = np.asarray(result.status), np.asarray(result.success)
    faults: list[Fault] = []

    def report(kind: str, wrong: np.ndarray, text: Any) -> None:
        faults.extend(Fault(kind, int(row), text(row)) for row in np.flatnonzero(wrong)[:most])

    starts = request.starts()
    bad = ~_finite(request)
    given_bad = bad if starts is None else bad | ~np.isfinite(starts).all(axis=1)
    needed = _finite(request, all_parts=False)
    certain = ~needed if starts is None else ~needed | ~np.isfinite(starts).all(axis=1)
    unknown = certain & (status != Status.BAD_INPUT)
    report("bad input not told", unknown, lambda i: f"status {Status(status[i]).name}")
    # Numbers that no arm has may be refused as well, by one stated range.
    sane = np.abs(_points(request)).max(axis=1, initial=0) < 1e12 * max(arm.scale, 1)
    invented = (status == Status.BAD_INPUT) & ~given_bad & sane
    report("bad input invented", invented, lambda i: f"target {request.targets[i].tolist()}")

    nan = ~np.isfinite(q).all(axis=1)
    report("not a number", nan, lambda i: f"q {q[i].tolist()}, {Status(status[i]).name}")
    lost = np.isnan(result.position_error) | np.isnan(result.orientation_error)
    report("not a number", lost, lambda i: f"errors NaN, {Status(status[i]).name}")
    unlike = success != (status == Status.CONVERGED)
    report("success and status differ", unlike, lambda i: f"{success[i]}, {status[i]}")

    usable = ~nan & ~given_bad
    left = usable & ~within_limits(arm, np.where(nan[:, None], 0.0, q))
    report(
        "limits left",
        left,
        lambda i: f"q {q[i].tolist()}, limits {arm.lower.tolist()} to {arm.upper.tolist()}",
    )

    seen = np.flatnonzero(usable)
    looked_at = replace(request, poses=request.poses[seen])
    reached = arm.fk(q[seen])
    position, orientation, single, bounds = measured(looked_at, reached)
    slip, turn_slip = arm.rounding(q[seen])
    slip = slip + 8 * EPS * np.linalg.norm(request.poses[seen, :3, 3], axis=1)
    slips = np.stack([slip] * 3 + [turn_slip] * 3, axis=1)
    near, near_turn = request.position_tolerance, _wanted_turn(request)
    holds = (position <= near) & (orientation <= near_turn) & (single <= bounds).all(axis=1)
    clear = (position <= near * (1 - 1e-9) - slip) & (
        (orientation <= near_turn * (1 - 1e-9) - turn_slip) | (orientation == 0)
    )
    clear &= ((single <= bounds * (1 - 1e-9) - slips) | (single == 0)).all(axis=1)
    breaks = (position > near * (1 + 1e-9) + slip) | (
        orientation > near_turn * (1 + 1e-9) + turn_slip
    )
    breaks |= (single > bounds * (1 + 1e-9) + slips).any(axis=1)

    def told(i: int) -> str:
        at = int(np.searchsorted(seen, i))
        return (
            f"{Status(status[i]).name}; errors {position[at]:.3e} m, {orientation[at]:.3e} rad, "
            f"told {result.position_error[i]:.3e} m, {result.orientation_error[i]:.3e} rad; "
            f"tolerances {near:.3g} m, {near_turn:.3g} rad"
        )

    def rows(flags: np.ndarray) -> np.ndarray:
        wide = np.zeros(len(q), bool)
        wide[seen[flags]] = True
        return wide

    report("false success", rows(breaks & success[seen]), told)
    inside = within_limits(arm, q[seen])
    report("solution not claimed", rows(clear & inside & ~success[seen] & holds), told)

    provable = request.reachable & usable
    tight = np.zeros(len(q), bool)
    tight[seen] = (near > 4 * slip) & (near_turn > 4 * turn_slip)
    tight[seen] &= (bounds > 4 * slips).all(axis=1)
    false_proof = provable & tight & (status == Status.OUT_OF_REACH)
    report(
        "false proof",
        false_proof,
        lambda i: f"reached by q {request.made_from[i].tolist()}",
    )

    # What is told may be off by rounding, never by what matters beside the tolerances.
    with np.errstate(invalid="ignore"):
        off = np.abs(result.position_error[seen] - position)
        off = off > 1e-6 * position + 1e-3 * min(near, 1e-3 * arm.scale) + 16 * slip
        skewed = np.abs(result.orientation_error[seen] - orientation)
        skewed = skewed > 1e-6 * orientation + 1e-3 * min(near_turn, 1e-3) + 16 * turn_slip
    # Of bad input, and of distances that overflow, infinity is told.
    told_finite = (status[seen] != Status.BAD_INPUT) & (position < 1e150)
    # Near half a turn the way back has no direction that is known, of a part of it neither.
    back = looked_at.poses[:, :3, :3] @ np.swapaxes(reached[:, :3, :3], 1, 2)
    known = (orientation < 3.1) & ~(np.linalg.norm(rotation_vectors(back), axis=1) >= 3.1)
    report("error told wrong", rows((off | skewed) & told_finite & known), told)
    far, told_far = _far_turns(request, q, success, starts)
    report("turn further than need be", far, told_far)
    return faults


def _wanted_turn(request: Any) -> float:
    """Return the orientation's tolerance, infinite where it is told and not asked for."""
    return np.inf if request.task_name == "position-first" else request.orientation_tolerance


def _far_turns(
    request: Any, q: Array, success: np.ndarray, starts: Array | None
) -> tuple[np.ndarray, Any]:
    """Solved rows with a joint a whole turn further from the start, or the middle, than need be.

    The middle is that of the limits; zero, or what is nearest to it, where one of them is missing.
    """
    arm = request.arm
    # Closed forms that choose by the limits take the turn nearest to their middle.
    if starts is None or getattr(request.solver, "choose", "nearest") != "nearest":
        with np.errstate(invalid="ignore"):
            middle = (arm.lower + arm.upper) / 2
        middle = np.clip(np.where(np.isfinite(middle), middle, 0.0), arm.lower, arm.upper)
        starts = np.broadcast_to(middle, q.shape)
    # A start out of the limits counts as the limit; one of a free joint beyond 1e4 rad, where
    # sines lose digits, is brought back by whole turns.
    starts = np.clip(starts, arm.lower, arm.upper)
    far_out = arm.turns & (np.abs(starts) > 1e4)
    with np.errstate(invalid="ignore"):
        starts = np.where(far_out, starts - TURN * np.round(starts / TURN), starts)
    # So is one whose last digits count beside a narrow tolerance of a large arm; how far that goes
    # is the solver's to say, who counts the ways of slides as well.
    slides = sum(joint.kind == "prismatic" for joint in arm.joints)
    lever = 2 * (1 + slides) * arm.length + np.linalg.norm(
        np.nan_to_num(request.poses[:, :3, 3]), axis=1
    )
    bounds = np.full(6, np.inf) if request.bounds is None else request.bounds
    place, turn = np.min(bounds[:3]), np.min(bounds[3:])
    tolerance = np.minimum(
        min(place, request.position_tolerance) / lever, min(turn, request.orientation_tolerance)
    )
    coarse = arm.turns & (np.abs(starts) > (tolerance / (64 * EPS))[:, None])
    # A turn of a joint that others follow is another posture.
    may_turn = arm.turns & ~arm.leads & success[:, None] & np.isfinite(starts) & ~coarse
    # Half a turn away on either side is as near, and the last digits say nothing.
    slack = 1e-6 * (1 + np.abs(q) + np.abs(starts))
    far = np.zeros(q.shape, bool)
    for turn in (-TURN, TURN):
        other = q + turn
        nearer = np.abs(other - starts) < np.abs(q - starts) - slack
        far |= nearer & (other >= arm.lower + slack) & (other <= arm.upper - slack) & may_turn

    def told(row: int) -> str:
        joint = int(np.flatnonzero(far[row])[0])
        value, start = float(q[row, joint]), float(starts[row, joint])
        return (
            f"joint {joint}: {value!r}, a turn from it is nearer to {start!r} and within "
            f"{float(arm.lower[joint])!r} to {float(arm.upper[joint])!r}"
        )

    return far.any(axis=1), told


def branches(request: Any, result: Any) -> list[Fault]:
    """Return what is wrong with the answers of one call of `ik_all`."""
    arm = request.arm
    q, valid = np.asarray(result.q), np.asarray(result.valid)
    status = np.asarray(result.status)
    faults: list[Fault] = []
    row, branch = np.nonzero(valid)
    found = q[row, branch]
    if not np.isfinite(found).all():
        faults.append(Fault("not a number", int(row[0]), "a valid branch"))
        return faults
    position, orientation = errors(None, "pose", arm.fk(found), request.poses[row])
    slip, turn_slip = arm.rounding(found)
    slip = slip + 8 * EPS * np.linalg.norm(request.poses[row, :3, 3], axis=1)
    wrong = (position > request.position_tolerance * (1 + 1e-9) + slip) | (
        orientation > request.orientation_tolerance * (1 + 1e-9) + turn_slip
    )
    faults += [
        Fault(
            "false success", int(row[i]), f"branch: {position[i]:.3e} m, {orientation[i]:.3e} rad"
        )
        for i in np.flatnonzero(wrong)[:3]
    ]
    outside = ~within_limits(arm, found)
    faults += [
        Fault("limits left", int(row[i]), f"branch {found[i].tolist()}")
        for i in np.flatnonzero(outside)[:3]
    ]
    # A joint that turns freely in a branch is told in the status.
    solved = np.isin(status, (Status.CONVERGED, Status.SINGULAR_FAMILY))
    unlike = solved != valid.any(axis=1)
    faults += [
        Fault("success and status differ", int(i), f"{status[i]}, {valid[i].tolist()}")
        for i in np.flatnonzero(unlike)[:3]
    ]
    starts = request.starts()
    usable = _finite(request)
    if starts is not None:
        usable &= np.isfinite(starts).all(axis=1)
    at = arm.rounding(request.made_from)
    tight = (request.position_tolerance > 4 * at[0]) & (request.orientation_tolerance > 4 * at[1])
    false_proof = request.reachable & usable & tight & (status == Status.OUT_OF_REACH)
    faults += [
        Fault("false proof", int(i), f"reached by q {request.made_from[i].tolist()}")
        for i in np.flatnonzero(false_proof)[:3]
    ]
    return faults


def same(first: Any, second: Any, fields: tuple[str, ...] = FIELDS) -> np.ndarray:
    """Rows of two results, each (m, ...), that have the same bits."""
    equal: np.ndarray | None = None
    for name in fields:
        one, other = (_bits(getattr(result, name)) for result in (first, second))
        agrees = (one == other).reshape(len(one), -1).all(axis=1)
        equal = agrees if equal is None else equal & agrees
    assert equal is not None
    return equal


def _bits(values: Any) -> np.ndarray:
    array = np.ascontiguousarray(values)
    return array.view(np.uint8).reshape(*array.shape, array.itemsize)


def _points(request: Any) -> Array:
    return np.nan_to_num(request.poses[:, :3, 3])


def _finite(request: Any, all_parts: bool = True) -> np.ndarray:
    """Rows of finite numbers: in the whole target, or in the parts that the task is about."""
    targets = request.targets
    turns_matter = request.task_name in ("pose", "masked") or (
        request.task_name == "axis" and request.task.direction is None
    )
    turns_matter |= request.task_name == "position-first"
    if not all_parts and targets.ndim == 3 and not turns_matter:
        targets = targets[:, :3, 3]
    return np.isfinite(targets).reshape(request.rows, -1).all(axis=1)
