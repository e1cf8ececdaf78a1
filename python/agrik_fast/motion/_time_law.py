"""When an arm is where on a way: within the limits of its joints' motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, real_number, shown
from ..errors import ArgumentError
from ..robot import JointPath, Path, Robot
from ._trajectory import Trajectory, checked_rate

__all__ = ["time_law"]


def time_law(
    arm: Robot,
    path: ArrayLike | JointPath | Path,
    *,
    blend: float | None = None,
    smooth: bool | None = None,
    velocity: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    jerk: ArrayLike | None = None,
    scale: float = 1.0,
    speed: float | None = None,
    rate: float | None = 125.0,
) -> Trajectory:
    """Give a way its time, as short as the limits of the joints allow.

    Between two rests the place on the way follows stretches of at most seven phases of
    constant jerk (double S); on a straight segment between two rests that is the shortest
    time there is. The geometry is never touched: what was proven of the way holds for the
    motion. Over rounded corners and smooth curves the curvature takes its share of the
    joints' acceleration and jerk; the limits hold there too, but a quicker motion may exist.

    Parameters
    ----------
    arm : Robot
        The arm, whose `velocity_limits`, `acceleration_limits` and `jerk_limits` count.
    path : array_like, shape (n, dof), JointPath or Path
        Waypoints in joint values, rad or m, within the limits; or what `Robot.line`, `arc`,
        `joint_path` or `follow` return.
    blend, smooth : optional
        As for `Robot.joint_path`; for waypoints and paths of `follow` alone. Default: a rest
        at every waypoint of an array, one smooth curve for a path of `follow`.
    velocity, acceleration, jerk : float or array_like, shape (dof,), optional
        Limits in place of the arm's, rad or m and s. A jerk of ``inf`` is allowed: the
        acceleration then jumps.
    scale : float, default 1
        Above 0 and at most 1: the limits of velocity are taken times it, those of
        acceleration times its square, those of jerk times its cube, so that the same motion
        takes 1 / `scale` times as long.
    speed : float, m/s, optional
        Largest speed of the tool point, for paths of the tool (rad/s if it only turns).
    rate : float or None, default 125, 1/s
        Points a second, see `Trajectory.sampled`.

    Returns
    -------
    Trajectory
        From rest to rest.

    Raises
    ------
    ArgumentError
        A wrong shape or number; a path that was not followed to its end; a joint whose
        acceleration nobody limits; a `speed` for a path of the joints.

    Examples
    --------
    >>> import agrik_fast as ik
    >>> from agrik_fast import motion
    >>> arm = ik.Robot.load("ur5")
    >>> trajectory = motion.time_law(arm, [arm.home, arm.home + [0.5, 0, 0, 0, 0, 1.0]])
    >>> round(trajectory.duration, 4)
    0.9041
    """
    if not isinstance(arm, Robot):
        raise ArgumentError("arm", shown(arm), "a Robot")
    way = _way(arm, path, blend, smooth)
    factor = real_number("scale", scale, 0.0, 1.0, open_low=True)
    limited = arm.with_motion_limits(velocity, acceleration, jerk)
    limits = np.stack(
        [
            limited.velocity_limits * factor,
            limited.acceleration_limits * factor**2,
            limited.jerk_limits * factor**3,
        ]
    )
    moving = np.ptp(way.q, axis=0) > 0 if len(way.q) else np.zeros(arm.dof, dtype=bool)
    unlimited = moving & ~np.isfinite(limits[1])
    if unlimited.any():
        name = arm.joint_names[int(np.argmax(unlimited))]
        expected = "acceleration=... here, in the robot file or by Robot.with_motion_limits"
        raise ArgumentError("acceleration", f"no limit of joint {name!r}", expected)
    most = math.inf
    if speed is not None:
        most = real_number("speed", speed, 0.0, open_low=True, unit="m/s")
        if not way.of_tool:
            raise ArgumentError("speed", f"{most:g}, but a path of the joints", "Robot.line or arc")
    recipe: dict[str, Any] = {
        "waypoints": way.q,
        "lengths": way.lengths,
        "blends": way.blends,
        "limits": limits,
        "speed": most,
    }
    motion = _native.Motion(**recipe)
    return Trajectory(recipe, arm.joint_names, arm.joint_types, checked_rate(rate), motion)


def _way(
    arm: Robot, path: ArrayLike | JointPath | Path, blend: float | None, smooth: bool | None
) -> JointPath:
    if isinstance(path, JointPath):
        for argument, value in (("blend", blend), ("smooth", smooth)):
            if value is not None:
                expected = "nothing: the path says how its corners are taken"
                raise ArgumentError(argument, shown(value), expected)
        _check_reached(path.success, len(path) - 1, len(path.status))
        if path.q.ndim != 2 or path.q.shape[1] != arm.dof:
            raise ArgumentError("path", f"shape {path.q.shape}", f"shape (n, {arm.dof})")
        return path
    waypoints: ArrayLike | FloatArray
    if isinstance(path, Path):
        bad = ~path.success | path.discontinuity
        bad[:1] = ~path.success[:1]
        _check_reached(not bad.any(), int(np.argmax(bad)) if bad.any() else 0, len(bad))
        waypoints = path.q
        smooth = smooth if smooth is not None or blend is not None else True
    else:
        waypoints = path
    return arm.joint_path(waypoints, blend=blend or 0.0, smooth=bool(smooth))


def _check_reached(reached: bool, count: int, targets: int) -> None:
    if not reached:
        got = f"one that reaches {count} of its {targets} targets without a jump"
        raise ArgumentError("path", got, "a path to its end")
