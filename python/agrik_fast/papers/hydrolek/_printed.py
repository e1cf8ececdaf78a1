"""What the HydroLek paper prints, carried out as printed: (2) and Algorithm I.

Plain NumPy, so that every misprint can be switched on by itself; the solvers proper are
`agrik_fast.solvers`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..._checks import FloatArray
from ...robot import Robot

DEGREE = float(np.pi / 180)


def printed_fk(
    rows: ArrayLike, q: ArrayLike, *, printed_sign: bool = True, tail: bool = False
) -> FloatArray:
    """Return the product (3) of the printed matrices (2), shape (4, 4).

    Parameters
    ----------
    rows : array_like, shape (n, 4)
        a, alpha, d and the offset of theta, as in the tables.
    q : array_like, shape (n,), rad
        Joint values.
    printed_sign : bool, default True
        Entry (2, 4) as printed, ``+sin(alpha) d``; a rotation about x has ``-sin(alpha) d``.
    tail : bool, default False
        With the last row's a and alpha, which (2) leaves out: it takes those of the row
        before.
    """
    table = np.asarray(rows, dtype=float)
    pose = np.eye(4)
    a, alpha = 0.0, 0.0
    for (next_a, next_alpha, d, offset), value in zip(table, np.asarray(q), strict=True):
        c, s = np.cos(value + offset), np.sin(value + offset)
        ca, sa = np.cos(alpha), np.sin(alpha)
        link = np.array(
            [
                [c, -s, 0.0, a],
                [s * ca, c * ca, -sa, (sa if printed_sign else -sa) * d],
                [s * sa, c * sa, ca, ca * d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
        pose = pose @ link
        a, alpha = next_a, next_alpha
    if tail:
        ca, sa = np.cos(alpha), np.sin(alpha)
        end = np.array([[1, 0, 0, a], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
        pose = pose @ end
    return pose


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """Which of Algorithm I's lines are taken as printed.

    Attributes
    ----------
    line14 : bool
        Twice the step is taken off a value that may have been saturated.
    line15 : bool
        Values above the minimum are set to the minimum.
    both_plus : bool
        The text's "both +dtheta and +dtheta".
    lines12_18 : bool
        ``f(theta + theta_i)``: the joint's value is added to the joint's value.
    no_exit : bool
        The listing has no test of the tolerance.
    """

    line14: bool = False
    line15: bool = False
    both_plus: bool = False
    lines12_18: bool = False
    no_exit: bool = False


@dataclass(frozen=True, slots=True)
class Run:
    """How Algorithm I did, goal by goal.

    Attributes
    ----------
    reached : ndarray, shape (goals,)
        The error at the end is below the tolerance.
    sweeps : ndarray, shape (goals,)
        Sweeps of all joints that were carried out.
    errors : ndarray, shape (goals,), m
        Error at the end.
    """

    reached: NDArray[np.bool_]
    sweeps: NDArray[np.int64]
    errors: FloatArray


def algorithm1(
    robot: Robot,
    goals: FloatArray,
    gains: tuple[float, float, float],
    reading: Reading | None = None,
    *,
    tolerance: float = 1e-3,
    most_sweeps: int = 200,
) -> Run:
    """Run Algorithm I on goals, shape (n, 3), m, from zero clamped into the limits.

    Parameters
    ----------
    robot : Robot
        The arm.
    goals : ndarray, shape (n, 3), m
        Tool points.
    gains : tuple of 3 float
        Kp, Ki, Kd in degrees per mm.
    reading : Reading, optional
        Which lines are taken as printed; none by default.
    tolerance : float, default 1e-3, m
        Distance that counts as reached.
    most_sweeps : int, default 200
        Cap.
    """
    reading = Reading() if reading is None else reading
    kp, ki, kd = gains
    count, low, high = len(goals), robot.lower, robot.upper
    q = np.tile(np.clip(np.zeros(robot.dof), low, high), (count, 1))

    def error_of(values: FloatArray, rows: Any) -> FloatArray:
        return np.asarray(np.linalg.norm(goals[rows] - robot.fk(values)[:, :3, 3], axis=1))

    error = error_of(q, slice(None))
    before, total = error.copy(), np.zeros(count)
    sweeps = np.zeros(count, dtype=np.int64)
    running = np.ones(count, dtype=bool) if reading.no_exit else error >= tolerance
    for _ in range(most_sweeps):
        if not running.any():
            break
        sweeps[running] += 1
        for i in reversed(range(robot.dof)):
            rows = np.flatnonzero(running)
            total[rows] += error[rows]
            change = error[rows] - before[rows]
            step = 1000 * DEGREE * (kp * error[rows] + ki * total[rows] + kd * change)
            before[rows] = error[rows]
            here = q[rows, i]
            up = np.minimum(here + step, high[i])
            if reading.both_plus:
                down = up
            else:
                down = (up - 2 * step) if reading.line14 else (here - step)
                # A negative step goes past the other limit.
                up = np.maximum(up, low[i])
                down = np.minimum(down, high[i])
                printed = reading.line15
                down = np.minimum(down, low[i]) if printed else np.maximum(down, low[i])
            best, least = here.copy(), error[rows].copy()
            for tried in (up, down):
                values = q[rows].copy()
                values[:, i] = values[:, i] + tried if reading.lines12_18 else tried
                found = error_of(values, rows)
                better = found < least
                best, least = np.where(better, tried, best), np.where(better, found, least)
            q[rows, i] = best
            # What the trial promised is not where the arm is, where it tried another value.
            error[rows] = error_of(q[rows], rows) if reading.lines12_18 else least
            if not reading.no_exit:
                running &= error >= tolerance
    return Run(error < tolerance, sweeps, error)
