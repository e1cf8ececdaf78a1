"""Corners of a path, rounded as far as the curves are proven free."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import real_number
from ..collision import Scene
from ..robot import JointPath, Robot
from ._check import checked_arm, corner_ends, options_of, scene_of, waypoints

__all__ = ["rounded"]

# Halvings of a corner before it is left as it is.
_HALVINGS = 5


def rounded(
    arm: Robot,
    path: ArrayLike | Any,
    scene: Scene | None = None,
    *,
    blend: float = 0.5,
    clear: float = 0.0,
    own_clear: float | None = None,
    threads: int | None = None,
) -> JointPath:
    """Round the corners of a path, so that the arm need not rest at every waypoint.

    A corner is rounded on as much of the neighbouring segments as is proven: all postures of
    the triangle between where the curve leaves the one segment, the corner, and where it comes
    to the next are free, and with them every curve inside. Where that fails half as much is
    tried, five times; then the arm rests there. The segments themselves are for `check`.

    Parameters
    ----------
    arm : Robot
        An arm with bodies.
    path : array_like, shape (n, dof), or something with such an array as ``path`` or ``q``
        Waypoints, rad or m, within the limits; what `plan` returns.
    scene : Scene, optional
        What stands round it.
    blend : float, default 0.5
        How much of the shorter neighbouring segment a corner is rounded on at most, 0 to 0.5.
    clear, own_clear, threads : optional
        As for `check`.

    Returns
    -------
    JointPath
        For `time_law`; its ``blends`` are what was proven, 0 for a rest.

    Raises
    ------
    ArgumentError
        As `check`; a `blend` out of its range, waypoints outside the limits.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> arm = Robot.load("ur5")
    >>> corner = arm.home + [0.4, 0, 0, 0, 0, 0]
    >>> way = motion.rounded(arm, [arm.home, corner, corner + [0, 0, 0.3, 0, 0, 0]])
    >>> bool(way.blends[1] > 0)
    True
    """
    share = real_number("blend", blend, 0.0, 0.5)
    q = waypoints(path, checked_arm(arm).dof)
    sharp = arm.joint_path(q)
    lengths, count = sharp.lengths, len(q)
    blends = np.zeros(count)
    options = options_of(clear, own_clear, None, 1e-5, 100_000)
    collider = scene_of(scene).collider(arm)
    open_ = np.arange(1, count - 1)
    width = np.zeros(count)
    width[1:-1] = share * np.minimum(lengths[:-1], lengths[1:])
    # Where a path turns back on itself nothing can be rounded, and nothing is gained.
    open_ = open_[width[open_] > 0] if count > 2 else np.zeros(0, dtype=np.int64)
    for _ in range(_HALVINGS + 1):
        if not len(open_):
            break
        ends = corner_ends(q, lengths, width, open_)
        free = _native.motion_corners(collider, *ends, options, threads)
        blends[open_[free]] = width[open_[free]]
        open_ = open_[~free]
        width[open_] /= 2
    return JointPath(sharp.q, lengths, blends)
