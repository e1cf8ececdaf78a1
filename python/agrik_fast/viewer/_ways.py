"""Ways that the viewer plays: lines, circles, targets in order, the picking sequence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from ..arms import Command, StrawberryArm
from ..errors import ArgumentError
from ..io import DataFileError, read_results, read_targets
from ..robot import Robot
from ._session import Session

_STEPS = 61
_EACH = 10
"""Pictures of each step of the picking sequence."""
PICKING = ("strawberry", "strawberry6")
"""Arms that have a picking sequence."""
_SLIDES = ("s10", "s21", "s32", "theta", "beta", "psi")


@dataclass(frozen=True, eq=False)
class Way:
    """Postures one after the other.

    Attributes
    ----------
    q : ndarray, shape (n, dof), rad or m
    bad : ndarray of bool, shape (n,)
        True where a target was not reached, or a joint jumped.
    opening : ndarray, shape (n,)
        How far the hand is open, 0 to 1.
    words : str
        What it is, and how it went.
    """

    q: FloatArray
    bad: NDArray[np.bool_]
    opening: FloatArray
    words: str


def line(target: FloatArray, by: Sequence[float]) -> FloatArray:
    """Return poses on a straight line from a target, shape (n, 4, 4), m."""
    poses = np.repeat(target[None], _STEPS, axis=0)
    poses[:, :3, 3] += np.linspace(0.0, 1.0, _STEPS)[:, None] * np.asarray(by)
    return poses


def circle(target: FloatArray, radius: float) -> FloatArray:
    """Return poses on a circle across z that begins and ends at a target, m."""
    angles = np.linspace(0.0, 2 * np.pi, _STEPS)
    poses = np.repeat(target[None], _STEPS, axis=0)
    poses[:, 0, 3] += radius * (np.cos(angles) - 1.0)
    poses[:, 1, 3] += radius * np.sin(angles)
    return poses


def follow(session: Session, targets: FloatArray, name: str, *, free: bool = False) -> Way:
    """Have the arm follow targets, shape (n, 4, 4) or (n, 3), m.

    It begins where it stands, or anywhere (`free`).
    """
    task = session.task if targets.ndim == 3 else "position"
    path = session.robot.follow(targets, q0=None if free else session.q, task=task)
    bad = path.discontinuity | ~path.success
    words = f"{name}: {len(path.q)} poses"
    if bad.any():
        rows = np.flatnonzero(bad) + 1
        listed = ", ".join(map(str, rows[:8])) + (", ..." if len(rows) > 8 else "")
        lost, jumped = int((~path.success).sum()), int((path.discontinuity & path.success).sum())
        words += f"; {lost} not reached, {jumped} after a jump of a joint: {listed}"
    else:
        words += ", all reached without a jump"
    return Way(path.q, bad, np.full(len(path.q), session.opening), words)


def picking(session: Session, psi: float = 0.0, *, back: bool = True) -> Way:
    """Return the strawberry arm's command sequence to the target and home again.

    Raises
    ------
    ArgumentError
        The arm does not reach the target.
    """
    arm = StrawberryArm()
    found = arm.solve(session.target[:3, 3])
    if not found.success:
        place = [round(float(x), 4) for x in session.target[:3, 3]]
        raise ArgumentError("target", f"{place} m", "a point that the strawberry arm reaches")
    start = np.append(arm.reset_pose, 0.0)
    out = list(arm.commands(found.q, psi=psi))
    home = list(arm.commands(found.q, psi=psi, reset=True)) if back else []
    q, opening = postures(start, [*out, *home])
    q = q[:, : session.robot.dof]
    words = f"picking: {len(out)} steps out and {len(home)} home"
    return Way(q, np.zeros(len(q), dtype=bool), opening, words)


def postures(start: FloatArray, steps: Sequence[Command]) -> tuple[FloatArray, FloatArray]:
    """Return the postures that commands lead through, one axis after the other.

    Parameters
    ----------
    start : ndarray, shape (6,), m and rad
        s10, s21, s32, theta, beta, psi.
    steps : sequence of Command

    Returns
    -------
    q : ndarray, shape (n, 6), m and rad
    opening : ndarray, shape (n,)
        0 for a closed gripper, 1 for an open one.
    """
    q, opening = [np.array(start)], [0.0]
    for step in steps:
        shares = np.linspace(0.0, 1.0, _EACH + 1)[1:]
        before, hand = q[-1], opening[-1]
        for share in shares:
            now = before.copy()
            if step.axis == "gripper":
                opening.append(hand + share * (step.target - hand))
            else:
                place = _SLIDES.index(step.axis)
                now[place] += share * (step.target - now[place])
                opening.append(hand)
            q.append(now)
    return np.array(q), np.array(opening)


def read_way(robot: Robot, path: Path) -> Way | FloatArray:
    """Read a file of results as postures, or one of targets as what is to be followed.

    Parameters
    ----------
    robot : Robot
    path : path
        A result file of ``agrik-fast solve`` for this arm, or a target file.

    Raises
    ------
    TargetFileError, ArgumentError
        It can be read as neither, or is that of another arm.
    """
    try:
        layout, chunk = read_results(path)
    except DataFileError:
        return read_targets(path).read_all().targets
    names = tuple(column.rsplit("_", 1)[0] for column in layout.joint_columns)
    if names != robot.joint_names:
        received = f"{path.name} for joints {', '.join(names)}"
        raise ArgumentError("path", received, f"joints {', '.join(robot.joint_names)}")
    q = np.array(chunk.q)
    bad = ~np.asarray(chunk.success)
    words = f"{path.name}: {len(q)} postures, {int(bad.sum())} not reached"
    return Way(q, bad, np.zeros(len(q)), words)
