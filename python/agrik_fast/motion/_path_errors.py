"""Errors along a whole path: what stays of its clearance, how probably it stays free."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, real_number
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import JointPath, Path, Robot
from ._case import Case, phi, ratio
from ._errors import Errors
from ._play import followed, moved_last
from ._risks import Risks, risks
from ._trajectory import Trajectory

__all__ = ["PathSensitivity", "path_sensitivity"]

# Postures that a path is looked at in, at most.
_MOST = 100_000
# First number of intervals of a motion.
_FIRST = 32


@dataclass(frozen=True, eq=False)
class PathSensitivity:
    """What errors do to an arm on its way through a scene.

    The way is looked at in intervals; of each the middle posture is asked, and what the bodies
    can move within the interval, by the levers of the joints, is taken off their clearance.
    So `clearance` is never more than the true one.

    Attributes
    ----------
    q : ndarray, shape (m, dof), rad or m
        The middle of each interval.
    segment : ndarray of int, shape (m,)
        The segment that each belongs to: from waypoint to waypoint, or the whole motion.
    bodies : tuple of n str
        The bodies of the arm that move.
    clearance : ndarray, shape (m, n), m
        Certified clearance of each body from the scene on each interval; infinite where
        nothing is near, 0 or less where it is not proven free.
    deviation : ndarray, shape (m, n), m
        Standard deviation of the clearance, to first order, at the middle.
    guaranteed : ndarray, shape (m, n), m
        What is left of the clearance if no error is larger than its standard deviation.
    risks : Risks
        All that may be met on each segment, the most probable first: the interval counts at
        which it is, as the same errors hold all along.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> scene = Scene([SceneObject.of("ball", Sphere([0.9, 0.0, 0.5], 0.05))])
    >>> arm = Robot.load("panda")
    >>> start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    >>> found = motion.path_sensitivity(arm, scene, [start, start + 0.1])
    >>> bool(found.free > 0.99)
    True
    """

    q: FloatArray
    segment: NDArray[np.int64]
    bodies: tuple[str, ...]
    clearance: FloatArray
    deviation: FloatArray
    guaranteed: FloatArray
    risks: Risks

    @property
    def certified(self) -> float:
        """Clearance that is kept all along the path, m; not above 0 where it is not proven."""
        return float(self.clearance.min(initial=np.inf))

    @property
    def is_guaranteed(self) -> bool:
        """The path stays free whatever the errors, up to their standard deviations."""
        return bool((self.guaranteed > 0).all())

    @property
    def segment_free(self) -> FloatArray:
        """Least probability that nothing is met on each segment, shape (segments,)."""
        return np.asarray(np.maximum(0.0, 1.0 - self.risks.failures(self._segments)))

    @property
    def free(self) -> float:
        """Least probability that nothing is met on the whole path: the union over `risks`.

        It holds for any correlation, with each probability to first order.
        """
        return max(0.0, 1.0 - float(self.risks.failures(self._segments).sum()))

    @property
    def free_of_nearest(self) -> float:
        """The same if each body could meet the object nearest to it alone.

        With `clearance` as it is: where something is at risk `risks` looks more finely.
        """
        worst = np.full((self._segments, len(self.bodies)), np.inf)
        # The same errors hold all along: of a body its worst interval counts.
        np.minimum.at(worst, self.segment, ratio(self.clearance, self.deviation))
        return max(0.0, 1.0 - float(phi(-worst).sum()))

    @property
    def nearest(self) -> float:
        """Probability of the body and interval most at risk: an upper bound to first order.

        The bound is that of the certified clearance, which may be less than the true one.
        """
        return float(phi(ratio(self.clearance, self.deviation)).min(initial=1.0))

    @property
    def _segments(self) -> int:
        return int(self.segment.max(initial=-1)) + 1


def path_sensitivity(
    arm: Robot,
    scene: Scene,
    path: ArrayLike | JointPath | Path | Trajectory,
    errors: Errors | None = None,
    *,
    moving: ArrayLike | None = None,
    resolution: float = 2e-3,
) -> PathSensitivity:
    """Work out how errors show along a path.

    Parameters
    ----------
    arm : Robot
        An arm with bodies.
    scene : Scene
        What its exemptions and its target's touch zone let touch does not count.
    path : array_like, shape (n, dof), JointPath, Path or Trajectory
        Waypoints, rad or m, straight in the joint values between them (rounded corners and
        smooth curves are then not looked at); or a motion as it is.
    errors : Errors, optional
        Default: `Errors()`.
    moving : array_like, shape (dof,), optional
        The direction in which each joint moved before the path: its sign counts, 0 where it is
        not known. Play is then followed along the path: a joint stands half its play behind, and
        where it turns round it stays until the play is taken up. Default: directions are not
        known anywhere, and play counts as even.
    resolution : float, default 2e-3, m
        What the bodies move within half an interval at most, and so what the certified
        clearance may be less than the true one.

    Returns
    -------
    PathSensitivity

    Raises
    ------
    ArgumentError
        A wrong shape, numbers that are not finite, an arm without bodies; a path that would
        have to be looked at in more than 100,000 postures.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Box, Scene, SceneObject
    >>> scene = Scene([SceneObject.of("box", Box([0.45, 0.55, 0.35], [0.1, 0.1, 0.1]))])
    >>> arm = Robot.load("panda")
    >>> start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    >>> found = motion.path_sensitivity(arm, scene, [start, start + 0.2])
    >>> bool(found.certified <= scene.clearance(arm, start))
    True
    """
    case = Case(arm, scene, errors)
    fine = real_number("resolution", resolution, 0.0, open_low=True, unit="m")
    signs = moved_last(case, moving)
    if isinstance(path, Trajectory):
        middles, reach, segment, ends = _of_motion(case, path, fine)
        start = path.at(np.zeros(1))[0][0]
    else:
        given = path.q if isinstance(path, JointPath | Path) else path
        waypoints = arm.joint_path(given).q
        middles, reach, segment, ends = _of_waypoints(case, waypoints, fine)
        start = waypoints[0]
    play = None
    # A motion is not straight, nor is where joints stand that are behind.
    known = signs is not None and case.errors.backlash > 0
    straight = not known and not isinstance(path, Trajectory)
    half = ends - middles if straight else None
    if signs is not None:
        middles, reach, play = followed(case, middles, reach, ends, start, signs)
    found = case.at(middles, reach, play)
    moves = case.frames > 0
    return PathSensitivity(
        middles,
        segment,
        tuple(name for name, moved in zip(case.names, moves, strict=True) if moved),
        found.clearance[:, moves],
        found.deviation[:, moves],
        found.guaranteed[:, moves],
        risks(case, middles, found, reach=reach, play=play, segment=segment, half=half),
    )


_Intervals = tuple[FloatArray, FloatArray, NDArray[np.int64], FloatArray]


def _of_waypoints(case: Case, waypoints: FloatArray, fine: float) -> _Intervals:
    """Return middles, half widths, segments and ends of intervals of straight segments."""
    if len(waypoints) == 1:
        return waypoints, np.zeros_like(waypoints), np.zeros(1, dtype=np.int64), waypoints
    middles, reach, segment, ends = [], [], [], []
    total = 0
    for k, (a, b) in enumerate(itertools.pairwise(waypoints)):
        half = 0.5 * np.abs(b - a)
        moved = float(case.motion((0.5 * (a + b))[None], half[None]).max(initial=0.0))
        count = max(1, int(np.ceil(min(moved / fine, 2.0 * _MOST))))
        total += count
        _check_count(total)
        shares = (np.arange(count) + 0.5) / count
        middles.append(a + shares[:, None] * (b - a))
        reach.append(np.broadcast_to(half / count, (count, len(a))))
        segment.append(np.full(count, k, dtype=np.int64))
        ends.append(a + ((np.arange(count) + 1) / count)[:, None] * (b - a))
    parts = (middles, reach, segment, ends)
    return tuple(np.concatenate(part) for part in parts)  # type: ignore[return-value]


def _of_motion(case: Case, trajectory: Trajectory, fine: float) -> _Intervals:
    """Return middles, half widths, segments and ends of intervals of a motion: one segment."""
    if trajectory.joint_names != case.arm.joint_names:
        expected = f"one of the joints {', '.join(case.arm.joint_names)}"
        raise ArgumentError("path", "a motion of other joints", expected)
    count = _FIRST
    limits = trajectory.acceleration_limits
    # Only joints that do not move have none.
    most = np.where(np.isfinite(limits), limits, 0.0)
    while True:
        half = 0.5 * trajectory.duration / count
        times = (2 * np.arange(count) + 1) * half
        middles, velocities, _ = trajectory.at(times)
        # No joint gets faster by more than its acceleration's limit times the half width.
        reach = np.abs(velocities) * half + 0.5 * most * half**2
        moved = float(case.motion(middles, reach).max(initial=0.0))
        if moved <= fine:
            ends = trajectory.at(times + half)[0]
            return middles, reach, np.zeros(count, dtype=np.int64), ends
        count *= 2
        _check_count(count)


def _check_count(count: int) -> None:
    if count > _MOST:
        got = "one that asks for more postures"
        raise ArgumentError("resolution", got, f"one that {_MOST} postures are enough for")
