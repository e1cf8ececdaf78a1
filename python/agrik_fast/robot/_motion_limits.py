"""How fast an arm's joints may move."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, float_array
from ..errors import ArgumentError
from ._definition import Definition

if TYPE_CHECKING:
    from collections.abc import Callable


class MotionLimits:
    """The part of `Robot` that knows velocity, acceleration and jerk limits."""

    __slots__ = ()

    if TYPE_CHECKING:
        _chain: _native.Chain
        _definition: Definition
        _with: Callable[[Definition], Self]

        @property
        def joint_names(self) -> tuple[str, ...]: ...

    @property
    def velocity_limits(self) -> FloatArray:
        """Largest speed of each joint, shape (n,), rad/s or m/s.

        ``inf`` where neither the robot file nor the URDF says one (a URDF's 0 says none);
        never NaN. `provenance` tells where a bundled arm's numbers are from.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> Robot.load("panda").velocity_limits.tolist()
        [2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]
        """
        limits: FloatArray = self._chain.motion_limits[0]
        return limits

    @property
    def acceleration_limits(self) -> FloatArray:
        """Largest acceleration and deceleration of each joint, shape (n,), rad/s^2 or m/s^2.

        ``inf`` where nobody says one, as in every URDF; never NaN.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> Robot.load("panda").acceleration_limits.tolist()
        [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]
        """
        limits: FloatArray = self._chain.motion_limits[1]
        return limits

    @property
    def jerk_limits(self) -> FloatArray:
        """Largest change of each joint's acceleration, shape (n,), rad/s^3 or m/s^3.

        ``inf`` where nobody says one, as in every URDF; never NaN.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> Robot.load("panda").jerk_limits[:2].tolist()
        [7500.0, 3750.0]
        """
        limits: FloatArray = self._chain.motion_limits[2]
        return limits

    def with_motion_limits(
        self,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        jerk: ArrayLike | None = None,
    ) -> Self:
        """Return the same robot with other limits of its joints' motion.

        Parameters
        ----------
        velocity : float or array_like, shape (n,), rad/s or m/s, optional
            Largest speeds, in the order of q; one number holds for all joints. Without it
            they stay. ``inf`` asks for nothing.
        acceleration : float or array_like, shape (n,), rad/s^2 or m/s^2, optional
            Largest accelerations and decelerations.
        jerk : float or array_like, shape (n,), rad/s^3 or m/s^3, optional
            Largest changes of the acceleration.

        Returns
        -------
        Robot
            The new robot. What joints that follow another may do still counts for the joint
            that they follow.

        Raises
        ------
        ArgumentError
            A wrong shape, a number that is not above 0, or a limit for a joint outside of the
            chain, which only moves others.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> slow = Robot.load("ur5").with_motion_limits(velocity=0.5)
        >>> slow.velocity_limits.tolist()
        [0.5, 0.5, 0.5, 0.5, 0.5, 0.5]
        """
        given = (("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk))
        known = dict(self._chain.joint_motion_limits())
        table = np.array([known.get(name, (np.inf,) * 3) for name in self.joint_names])
        for column, (argument, value) in enumerate(given):
            if value is not None:
                table[:, column] = self._per_joint(argument, value)
        on_chain = {spec["name"] for spec in self._chain.joints()}
        if missing := [name for name in self.joint_names if name not in on_chain]:
            expected = "an arm whose joints all lie on its chain"
            raise ArgumentError("robot", f"one that is moved by {missing[0]!r}", expected)
        limits = {
            name: (row[0], row[1], row[2])
            for name, row in zip(self.joint_names, table.tolist(), strict=True)
        }
        return self._with(self._definition.replaced(motion=known | limits))

    def _per_joint(self, argument: str, value: ArrayLike) -> FloatArray:
        numbers = float_array(argument, value)
        count = len(self.joint_names)
        if numbers.shape not in ((), (count,)):
            expected = f"one number or shape ({count},)"
            raise ArgumentError(argument, f"shape {numbers.shape}", expected)
        if not (numbers > 0.0).all():
            at = int(np.argmin(np.atleast_1d(numbers > 0.0)))
            got = f"{np.atleast_1d(numbers)[at]:g} for joint {self.joint_names[at]!r}"
            raise ArgumentError(argument, got, "numbers above 0, inf for no limit")
        return np.broadcast_to(numbers, (count,))
