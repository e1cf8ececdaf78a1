"""Lines and arcs of the tool, and ways through postures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, float_array, real_number, truth_value
from .._rotations import from_axis_angle, transforms
from ..errors import ArgumentError
from ._joint_path import JointPath

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..tasks import Task
    from ._path import Path

# Below this a way has no length, m and rad.
_NOTHING = 1e-12
# Postures of a path at most.
_MOST = 1_000_000


class Lines:
    """The part of `Robot` that makes paths."""

    __slots__ = ()

    if TYPE_CHECKING:
        fk: Callable[[ArrayLike], FloatArray]
        follow: Callable[..., Path]

        @property
        def dof(self) -> int: ...
        @property
        def joint_names(self) -> tuple[str, ...]: ...
        @property
        def lower(self) -> FloatArray: ...
        @property
        def upper(self) -> FloatArray: ...
        @property
        def velocity_limits(self) -> FloatArray: ...

    def joint_path(
        self, waypoints: ArrayLike, *, blend: float = 0.0, smooth: bool = False
    ) -> JointPath:
        """Return a way through postures, straight in the joint values between them.

        Parameters
        ----------
        waypoints : array_like, shape (n, dof), rad or m
            Joint values, within the limits.
        blend : float, default 0
            How much of the shorter neighbouring segment each corner is rounded on, 0 to 0.5.
            At 0 the arm rests at every posture and the way is exactly the straight one.
        smooth : bool, default False
            One smooth curve through all postures instead: cubic splines.

        Returns
        -------
        JointPath
            For `agrik_fast.motion.time_law`.

        Raises
        ------
        ArgumentError
            A wrong shape, numbers that are not finite or outside of the limits, a `blend` out
            of its range, or one together with `smooth`.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> arm = ik.Robot.load("ur5")
        >>> arm.joint_path([arm.home, arm.home + 0.3, arm.home], blend=0.3)
        JointPath(3 postures, with corners)
        """
        q = float_array("waypoints", waypoints)
        if q.ndim != 2 or q.shape[1] != self.dof or not len(q):
            raise ArgumentError("waypoints", f"shape {q.shape}", f"shape (n, {self.dof}), n >= 1")
        if not np.isfinite(q).all():
            raise ArgumentError("waypoints", "NaN or infinity", "finite numbers")
        outside = (q < self.lower) | (q > self.upper)
        if outside.any():
            row, joint = (int(k) for k in np.argwhere(outside)[0])
            got = f"{q[row, joint]:g} for joint {self.joint_names[joint]!r}"
            expected = f"values within its limits, {self.lower[joint]:g} to {self.upper[joint]:g}"
            raise ArgumentError(f"waypoints[{row}]", got, expected)
        share = real_number("blend", blend, 0.0, 0.5)
        if truth_value("smooth", smooth) and share:
            raise ArgumentError("blend", f"{share:g} with smooth=True", "one of the two")
        q = q.copy()
        # Joints of which nobody knows how fast they are count as if all were alike.
        fastest = self.velocity_limits
        fastest = fastest if np.isfinite(fastest).all() else np.ones(self.dof)
        lengths = np.abs(np.diff(q, axis=0) / fastest).max(axis=1)
        return JointPath(q, lengths, None if smooth else _blends(lengths, share))

    def line(
        self,
        start: ArrayLike,
        end: ArrayLike,
        *,
        step: float = 5e-3,
        turn: float = 0.02,
        task: Task | str | None = None,
        max_joint_step: ArrayLike = 0.1,
    ) -> JointPath:
        """Return the way on which the tool goes straight from a posture to a pose.

        The tool point goes on a straight line, its orientation turns evenly about one axis;
        the postures are those of `follow`, joined by one smooth curve.

        Parameters
        ----------
        start : array_like, shape (dof,), rad or m
            Where the arm stands, within the limits.
        end : array_like, shape (4, 4) or (3,)
            Pose of the tool at the end, or its point: the orientation stays, m.
        step : float, default 5e-3, m
            Largest way of the tool point from one posture to the next.
        turn : float, default 0.02, rad
            Largest turn of the tool from one posture to the next.
        task : Task or str, optional
            As in `ik`; for arms of fewer than six joints, whose tool cannot keep every
            orientation. Default: the pose.
        max_joint_step : float or array_like, default 0.1, rad or m
            Largest change of a joint from one posture to the next; a larger one is a jump, at
            which the path ends.

        Returns
        -------
        JointPath
            `success` is False where the line cannot be followed to its end; `status` says why.

        Raises
        ------
        ArgumentError
            A wrong shape or number; a `start` outside of the limits.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> arm = ik.Robot.load("panda")
        >>> start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
        >>> path = arm.line(start, arm.fk(start)[:3, 3] + [0.0, 0.1, 0.0])
        >>> path.success, round(float(path.lengths.sum()), 9)
        (True, 0.1)
        """
        q, begin, goal = self._ends(start, end)
        way = goal[:3, 3] - begin[:3, 3]
        axis = _turn(begin, goal)
        count = _count(float(np.linalg.norm(way)), step, axis, turn)
        share = np.linspace(0.0, 1.0, count + 1)[1:]
        points = begin[:3, 3] + share[:, None] * way
        poses = transforms(points, begin[:3, :3] @ from_axis_angle(share[:, None] * axis))
        length = float(np.linalg.norm(way)) or float(np.linalg.norm(axis))
        return self._followed(q, poses, np.full(count, length / count), task, max_joint_step)

    def arc(
        self,
        start: ArrayLike,
        via: ArrayLike,
        end: ArrayLike,
        *,
        step: float = 5e-3,
        turn: float = 0.02,
        task: Task | str | None = None,
        max_joint_step: ArrayLike = 0.1,
    ) -> JointPath:
        """Return the way on which the tool point goes on a circle through two more points.

        Parameters
        ----------
        start : array_like, shape (dof,), rad or m
            Where the arm stands, within the limits.
        via : array_like, shape (3,), m
            A point that the tool point passes.
        end : array_like, shape (4, 4) or (3,)
            Pose of the tool at the end, or its point: the orientation stays, m. It turns
            evenly with the way on the circle.
        step, turn, task, max_joint_step : optional
            As for `line`.

        Returns
        -------
        JointPath
            `success` is False where the arc cannot be followed to its end.

        Raises
        ------
        ArgumentError
            A wrong shape or number; three points on one line.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> arm = ik.Robot.load("panda")
        >>> start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
        >>> point = arm.fk(start)[:3, 3]
        >>> path = arm.arc(start, point + [0.0, 0.05, 0.05], point + [0.0, 0.1, 0.0])
        >>> path.success, round(float(path.lengths.sum() / 0.05), 6)
        (True, 3.141593)
        """
        q, begin, goal = self._ends(start, end)
        middle = finite_array("via", via, (3,))
        centre, normal, angle = _circle(begin[:3, 3], middle, goal[:3, 3])
        axis = _turn(begin, goal)
        out = begin[:3, 3] - centre
        length = float(np.linalg.norm(out)) * angle
        # A chord is shorter than its arc by little only while the angle is small.
        count = max(_count(length, step, axis, turn), math.ceil(angle / 0.2))
        share = np.linspace(0.0, 1.0, count + 1)[1:]
        points = centre + from_axis_angle(share[:, None] * angle * normal) @ out
        poses = transforms(points, begin[:3, :3] @ from_axis_angle(share[:, None] * axis))
        poses[-1] = goal
        return self._followed(q, poses, np.full(count, length / count), task, max_joint_step)

    def _ends(self, start: ArrayLike, end: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        q = finite_array("start", start, (self.dof,))
        outside = (q < self.lower) | (q > self.upper)
        if outside.any():
            joint = int(np.argmax(outside))
            expected = f"a value within its limits, {self.lower[joint]:g} to {self.upper[joint]:g}"
            got = f"{q[joint]:g} for joint {self.joint_names[joint]!r}"
            raise ArgumentError("start", got, expected)
        begin = self.fk(q)
        given = float_array("end", end)
        if given.shape not in ((4, 4), (3,)):
            raise ArgumentError("end", f"shape {given.shape}", "shape (4, 4) or (3,)")
        if not np.isfinite(given).all():
            raise ArgumentError("end", "NaN or infinity", "finite numbers")
        if given.shape == (4, 4):
            return q, begin, given
        goal = begin.copy()
        goal[:3, 3] = given
        return q, begin, goal

    def _followed(
        self,
        start: FloatArray,
        poses: FloatArray,
        lengths: FloatArray,
        task: Task | str | None,
        max_joint_step: ArrayLike,
    ) -> JointPath:
        points = isinstance(task, str) and task == "position"
        targets = poses[:, :3, 3] if points else poses
        found = self.follow(targets, start, max_joint_step, task)
        bad = ~found.success | found.discontinuity | found.too_fast
        reached = int(np.argmax(bad)) if bad.any() else len(bad)
        return JointPath(
            np.vstack([start, found.q[:reached]]),
            lengths[:reached],
            None,
            of_tool=True,
            success=not bad.any(),
            status=found.status,
            discontinuity=found.discontinuity,
        )


def _blends(lengths: FloatArray, share: float) -> FloatArray:
    """Return how far each corner is rounded; not at the ends."""
    blends = np.zeros(len(lengths) + 1)
    if len(lengths) > 1:
        blends[1:-1] = share * np.minimum(lengths[:-1], lengths[1:])
    return blends


def _turn(begin: FloatArray, goal: FloatArray) -> FloatArray:
    """Return the rotation vector from one orientation to another, in the first's own frame."""
    from .. import rotations  # takes longer to load than a first answer may

    return rotations.axis_angle_of(begin[:3, :3].T @ rotations.rotation_of(goal))


def _count(length: float, step: float, axis: FloatArray, turn: float) -> int:
    steps = length / real_number("step", step, 0.0, open_low=True, unit="m")
    angle = float(np.linalg.norm(axis))
    steps = max(steps, angle / real_number("turn", turn, 0.0, open_low=True, unit="rad"))
    if length < _NOTHING and angle < _NOTHING:
        raise ArgumentError("end", "where the tool stands already", "another pose")
    if steps > _MOST:
        raise ArgumentError("step", f"{step:g}, {steps:.3g} postures", f"at most {_MOST} postures")
    return max(4, math.ceil(steps - 1e-9))


def _circle(a: FloatArray, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return centre, axis and angle of the arc from a through b to c."""
    u, v = b - a, c - a
    normal = np.cross(u, v)
    square = float(normal @ normal)
    if square <= (1e-9 * float(np.linalg.norm(u)) * float(np.linalg.norm(v))) ** 2:
        raise ArgumentError("via", "a point on the line through both ends", "a point beside it")
    to_centre = np.cross((u @ u) * v - (v @ v) * u, normal) / (2 * square)
    normal = normal / math.sqrt(square)
    out, end = -to_centre, v - to_centre
    angle = math.atan2(float(np.cross(out, end) @ normal), float(out @ end)) % (2 * math.pi)
    return a + to_centre, normal, angle
