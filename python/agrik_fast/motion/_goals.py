"""Goals of a plan: all postures that reach a target."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, float_array, shown, whole_number, word
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import Robot

if TYPE_CHECKING:
    from ..solvers import Solver

__all__ = ["Prefer", "goals_of", "postures"]

Prefer = Literal["near", "clearance"]
"""Which goals come first: those near the start, or those with the most clearance."""

# Postures that differ by less in every joint are one, rad or m.
_DISTINCT = 0.05
# Values of a free joint or arm angle that are looked at.
_SWEEP = 24
# Starts of a search where the branches are not known.
_STARTS = 48


def goals_of(
    arm: Robot,
    targets: ArrayLike,
    *,
    task: Literal["pose", "position"] = "pose",
    starts: int = _STARTS,
    seed: int = 0,
    solver: Solver | str = "lm",
) -> tuple[FloatArray, bool]:
    """Find all postures that reach one of some targets.

    All branches where they are known in closed form, at 24 values of a joint that is one too
    many; otherwise all that searches from random starts end in. Postures that differ by no
    more than 0.05 rad or m in any joint are one.

    Parameters
    ----------
    arm : Robot
    targets : array_like, shape (4, 4) or (k, 4, 4); (3,) or (k, 3)
        Poses of the tool in the base frame, m; points where the task is "position".
    task : {"pose", "position"}, default "pose"
        What is to be reached.
    starts : int, default 48
        Random starts of a search, for each target.
    seed : int, default 0
        Which starts are drawn.
    solver : str or solver, default "lm"
        Solver of the searches, as for `Robot.ik`.

    Returns
    -------
    q : ndarray, shape (m, dof), rad or m
        Postures within the limits.
    reached : bool
        Some target is reached, if only outside the limits.

    Raises
    ------
    ArgumentError
        A wrong shape.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> arm = Robot.load("ur5")
    >>> goals, _ = motion.goals_of(arm, arm.fk([0.1, -1, 1, 0.2, 0.4, 0]))
    >>> len(goals) >= 8
    True
    """
    if not isinstance(arm, Robot):
        raise ArgumentError("arm", shown(arm), "a Robot")
    whole_number("starts", starts, 1)
    size = (4, 4) if word("task", task, ("pose", "position")) == "pose" else (3,)
    given = float_array("targets", targets)
    if given.shape[-len(size) :] != size or given.ndim > len(size) + 1:
        expected = f"shape {size}, or rows of it"
        raise ArgumentError("targets", f"shape {given.shape}", expected)
    poses = given.reshape(-1, *size)
    found: list[FloatArray] = []
    reached = False
    for pose in poses:
        if not np.isfinite(pose).all():
            continue
        if task == "pose":
            q, within = _of_pose(arm, pose, starts, seed, solver)
        else:
            q, within = _searched(arm, pose, task, starts, seed, solver)
        reached |= within
        found.append(q)
    return _distinct(np.concatenate([np.zeros((0, arm.dof)), *found])), reached


def _of_pose(
    arm: Robot, pose: FloatArray, starts: int, seed: int, solver: Solver | str
) -> tuple[FloatArray, bool]:
    try:
        every = arm.ik_all(pose, sweep=_SWEEP)
    except ArgumentError:
        try:
            every = arm.ik_all(pose)
        except ArgumentError:
            return _searched(arm, pose, "pose", starts, seed, solver)
    return np.asarray(every.q[every.valid]), bool(every.reached.any())


def _searched(
    arm: Robot, target: FloatArray, task: str, starts: int, seed: int, solver: Solver | str
) -> tuple[FloatArray, bool]:
    """Return what searches from random starts end in."""
    first = arm.random_q(starts, seed=seed)
    many = np.broadcast_to(target, (starts, *target.shape))
    tried = arm.ik(many, task, solver=solver, q0=first, seed=seed)
    q = np.asarray(tried.q[tried.success])
    return q, len(q) > 0


def _distinct(q: FloatArray) -> FloatArray:
    kept: list[FloatArray] = []
    for row in q:
        if all(np.abs(row - other).max() > _DISTINCT for other in kept):
            kept.append(row)
    return np.array(kept).reshape(-1, q.shape[1])


def postures(
    arm: Robot, goals: ArrayLike, scene: Scene, start: FloatArray, prefer: str | None, seed: int
) -> tuple[FloatArray, str | None]:
    """Return the goals of a plan in the order of preference, and why there is none.

    Joint values stay in the order given unless `prefer` says otherwise; targets become all
    their postures, by default those near the start first.
    """
    given = float_array("goals", goals)
    dof = arm.dof
    why = None
    if _is_poses(given, dof):
        poses = given.reshape(-1, 4, 4)
        if not np.isfinite(poses).all(axis=(1, 2)).any():
            return np.zeros((0, dof)), "BAD_INPUT"
        q, reached = goals_of(arm, poses, seed=seed)
        if not len(q):
            why = "JOINT_LIMITS" if reached else "OUT_OF_REACH"
        prefer = prefer or "near"
    else:
        q = given
        if q.size == 0:
            return np.zeros((0, dof)), None
        if q.ndim == 1:
            q = q[np.newaxis]
        if q.ndim != 2 or q.shape[1] != dof:
            expected = f"joint values of shape (m, {dof}), or poses of shape (4, 4) or (k, 4, 4)"
            raise ArgumentError("goals", f"shape {given.shape}", expected)
        q = finite_array("goals", q, q.shape)
    if prefer is not None and len(q):
        word("prefer", prefer, ("near", "clearance"))
        if prefer == "near":
            rank = np.linalg.norm(q - start, axis=1)
        else:
            rank = -scene.clearance(arm, q, cap=0.2)
        q = q[np.argsort(rank, kind="stable")]
    return np.ascontiguousarray(q), why


def _is_poses(given: FloatArray, dof: int) -> bool:
    if given.ndim < 2 or given.shape[-2:] != (4, 4):
        return False
    # Rows of an arm of four joints could look the same.
    return dof != 4 or given.ndim > 2 or bool((given[3] == [0, 0, 0, 1]).all())
