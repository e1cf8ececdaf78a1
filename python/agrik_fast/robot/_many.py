"""Bases of each target, and many robots in one call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array, items
from .._records import made, to_dict
from ..errors import ArgumentError

if TYPE_CHECKING:
    from ..result import IkResult
    from . import Robot

__all__ = ["ik_many", "in_base"]

_RIGID = 1e-6


def in_base(own: FloatArray, targets: ArrayLike, base: ArrayLike) -> FloatArray:
    """Return targets as an arm whose base stands at `own` sees them, if its base is at `base`."""
    goals, bases = float_array("targets", targets), float_array("base", base)
    if bases.shape[-2:] != (4, 4):
        raise ArgumentError("base", f"shape {bases.shape}", "shape (..., 4, 4)")
    turn = bases[..., :3, :3]
    off = np.abs(turn @ np.swapaxes(turn, -1, -2) - np.eye(3)).max(initial=0.0)
    straight = (bases[..., 3, :] == [0, 0, 0, 1]).all() and np.isfinite(bases).all()
    if not (straight and off < _RIGID and (np.linalg.det(turn) > 0).all()):
        raise ArgumentError("base", "a matrix that is none", "rigid transforms")
    back = np.zeros_like(bases)
    back[..., :3, :3] = np.swapaxes(turn, -1, -2)
    back[..., :3, 3] = -(back[..., :3, :3] @ bases[..., :3, 3:])[..., 0]
    back[..., 3, 3] = 1.0
    moved = own @ back
    seen: FloatArray
    try:
        if goals.shape[-2:] == (4, 4):
            seen = moved @ goals
        else:
            seen = (moved[..., :3, :3] @ goals[..., None])[..., 0] + moved[..., :3, 3]
    except ValueError:
        expected = f"a shape that goes with targets of shape {goals.shape}"
        raise ArgumentError("base", f"shape {bases.shape}", expected) from None
    return seen


def ik_many(robots: Sequence[Robot], targets: ArrayLike, **options: Any) -> IkResult:
    """Inverse kinematics of several robots with the same number of joints, in one call.

    Parameters
    ----------
    robots : sequence of m Robot
        The robots; they may differ in everything but their number of joints.
    targets : array_like, shape (m, ..., 4, 4) or (m, ..., 3)
        Targets of each robot. Or shape (n, 4, 4), (n, 3), (4, 4) or (3,): the same for all.
    **options
        As for `Robot.ik`, the same for all robots.

    Returns
    -------
    IkResult
        Leading shape (m, ...): row i is what ``robots[i].ik(targets[i], **options)`` returns.

    Raises
    ------
    ArgumentError
        No robot, robots with different numbers of joints, or as `Robot.ik`.

    Examples
    --------
    >>> import agrik_fast as ik
    >>> arms = [ik.Robot.load(name) for name in ("ur3e", "ur5e", "ur10e")]
    >>> poses = [arm.fk(arm.random_q(4, seed=1)) for arm in arms]
    >>> ik.Robot.ik_many(arms, poses).q.shape
    (3, 4, 6)
    """
    from . import Robot

    arms = items("robots", robots, "robots")
    for arm in arms:
        if not isinstance(arm, Robot):
            raise ArgumentError("robots", type(arm).__name__, "robots")
    counts = {arm.dof for arm in arms}
    if len(counts) != 1:
        received = "none" if not arms else f"robots of {sorted(counts)} joints"
        raise ArgumentError("robots", received, "robots with the same number of joints")
    goals = float_array("targets", targets)
    inner = 2 if goals.shape[-2:] == (4, 4) else 1
    if goals.ndim <= inner + 1:
        goals = np.broadcast_to(goals, (len(arms), *goals.shape))
    if len(goals) != len(arms):
        received = f"{len(goals)} rows of targets for {len(arms)} robots"
        raise ArgumentError("targets", received, "one row a robot")
    parts = [to_dict(arm.ik(one, **options)) for arm, one in zip(arms, goals, strict=True)]
    fields = {name: np.stack([part[name] for part in parts]) for name in parts[0]}
    return cast("IkResult", made("IkResult", fields))
