"""Differential inverse kinematics: joint rates that move the tool by a twist."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, float_array, frame_of, real_number, word
from ..errors import ArgumentError

if TYPE_CHECKING:
    from ..tasks import SecondAim
    from . import Robot

__all__ = ["DifferentialKinematics"]

_TASKS = ("pose", "position")


class DifferentialKinematics:
    """The part of `Robot` that finds joint rates for twists."""

    __slots__ = ()

    if TYPE_CHECKING:
        _chain: _native.Chain

        @property
        def dof(self) -> int: ...

        @property
        def lower(self) -> FloatArray: ...

        @property
        def upper(self) -> FloatArray: ...

        def with_tool(self, tool: ArrayLike) -> Robot: ...

    def velocity(
        self,
        q: ArrayLike,
        twist: ArrayLike,
        *,
        rate_hz: float = 1000.0,
        rates: ArrayLike | None = None,
        velocity_limits: ArrayLike | None = None,
        acceleration_limits: ArrayLike | None = None,
        task: Literal["pose", "position"] = "pose",
        second_aim: SecondAim | str | None = None,
        gain: float = 1.0,
        tool: ArrayLike | None = None,
        threads: int | None = None,
    ) -> FloatArray:
        """Joint rates that move the tool by a twist, for servoing.

        Of the rates that the limits allow for the next tick, those with the least error of the
        twist, a radian counted as the arm's reach; near singularities they are damped (Nakamura
        and Hanafusa 1986, eq. 24) and never exceed the limits. The freedom that is left goes to
        the second aim, or to rest.

        Parameters
        ----------
        q : array_like, shape (..., n), rad or m
            Where the arm stands.
        twist : array_like, shape (..., 6), m/s and rad/s
            Wanted velocity of the tool point and of the tool's turn, base frame. With
            ``task="position"`` also shape (..., 3).
        rate_hz : float, 1/s, default 1000
            Ticks a second. After one tick no joint is beyond a position limit; one that can
            brake is never faster than it can brake before its limit.
        rates : array_like, shape (..., n), rad/s or m/s, optional
            Present rates, from which accelerations count. Without them `acceleration_limits`
            only bound how fast a joint may approach its limit.
        velocity_limits : float or array_like, shape (n,), rad/s or m/s, optional
            Default: `velocity_limits` of the robot; ``inf`` for none.
        acceleration_limits : float or array_like, shape (n,), rad/s^2 or m/s^2, optional
            Default: `acceleration_limits` of the robot; ``inf`` for none. Where limits
            contradict one another those of acceleration hold, then those of velocity.
        task : {"pose", "position"}, default "pose"
            Whether the tool's turn counts.
        second_aim : SecondAim or {"near", "middle", "limits", "manipulability"}, optional
            As for `ik`; "near" without a posture is near the middle.
        gain : float, 1/s, default 1
            How quickly the second aim is gone after: rates are `gain` times its slope.
        tool : array_like, shape (4, 4) or (3,), optional
            As for `ik`: the twist is that of a frame this offset, m, behind the robot's tool. Each
            call makes a robot with that tool; loops make theirs once, by `with_tool`.
        threads : int, optional
            As for `ik`.

        Returns
        -------
        ndarray, shape (..., n), rad/s or m/s
            Joint rates; zeros for rows that hold NaN or infinity. The twist that they give is
            ``jacobian(q) @ rates``.

        Raises
        ------
        ArgumentError
            A wrong shape; a limit or rate that is not above 0; a tool that is no rigid transform.
        UnknownNameError
            An unknown task or second aim.

        Examples
        --------
        >>> import numpy as np
        >>> from agrik_fast import Robot
        >>> arm = Robot.load("panda")
        >>> q = [0.1, 0.2, 0.3, -1.5, 0.1, 1.8, 0.5]
        >>> rates = arm.velocity(q, [0.1, 0, 0, 0, 0, 0], second_aim="middle")
        >>> np.allclose(arm.jacobian(q) @ rates, [0.1, 0, 0, 0, 0, 0], atol=1e-5)
        True
        """
        if tool is not None:
            offset = frame_of("tool", tool)
            if offset.shape != (4, 4):
                raise ArgumentError("tool", f"shape {offset.shape}", "shape (4, 4) or (3,)")
            return self.with_tool(self._chain.tool @ offset).velocity(
                q,
                twist,
                rate_hz=rate_hz,
                rates=rates,
                velocity_limits=velocity_limits,
                acceleration_limits=acceleration_limits,
                task=task,
                second_aim=second_aim,
                gain=gain,
                threads=threads,
            )
        word("task", task, _TASKS)
        rate = real_number("rate_hz", rate_hz, 0, open_low=True)
        pull = real_number("gain", gain, 0)
        at, wanted = float_array("q", q), float_array("twist", twist)
        if at.shape[-1:] != (self.dof,):
            raise ArgumentError("q", f"shape {at.shape}", f"shape (..., {self.dof})")
        if task == "position" and wanted.shape[-1:] == (3,):
            wanted = np.concatenate([wanted, np.zeros_like(wanted)], axis=-1)
        if wanted.shape[-1:] != (6,):
            raise ArgumentError("twist", f"shape {wanted.shape}", "shape (..., 6)")
        present = None if rates is None else float_array("rates", rates)
        if present is not None and present.shape[-1:] != (self.dof,):
            raise ArgumentError("rates", f"shape {present.shape}", f"shape (..., {self.dof})")
        shapes = [at.shape[:-1], wanted.shape[:-1]]
        shapes += [] if present is None else [present.shape[:-1]]
        try:
            leading = np.broadcast_shapes(*shapes)
        except ValueError:
            raise ArgumentError(
                "twist", f"leading shapes {shapes}", "shapes that broadcast together"
            ) from None
        known = self._chain.motion_limits
        fastest = self._bound("velocity_limits", velocity_limits, known[0])
        strongest = self._bound("acceleration_limits", acceleration_limits, known[1])
        at = np.broadcast_to(at, (*leading, self.dof)).reshape(-1, self.dof)
        wanted = np.broadcast_to(wanted, (*leading, 6)).reshape(-1, 6)
        if present is not None:
            present = np.broadcast_to(present, (*leading, self.dof)).reshape(-1, self.dof)
        least, most = self._bounds(at, present, fastest, strongest, rate)
        found = self._chain.velocity(
            at, wanted, least, most, task == "pose", second_aim, pull, threads
        )
        return found.reshape(*leading, self.dof)

    def _bounds(
        self,
        q: FloatArray,
        present: FloatArray | None,
        fastest: FloatArray,
        strongest: FloatArray,
        rate: float,
    ) -> tuple[FloatArray, FloatArray]:
        """Return the least and the most rate of each joint in the next tick."""
        # Numbers stand for none: no arm moves as fast.
        none = 1e9
        with np.errstate(invalid="ignore", over="ignore"):
            room = np.maximum(self.upper - q, 0.0), np.maximum(q - self.lower, 0.0)
            # What is left after this tick has to do for braking: v / rate + v^2 / (2 a) <= room.
            braking = [
                np.where(
                    np.isfinite(strongest),
                    -strongest / rate + np.sqrt((strongest / rate) ** 2 + 2 * strongest * way),
                    np.inf,
                )
                for way in room
            ]
            most = np.minimum((self.upper - q) * rate, braking[0])
            least = np.maximum((self.lower - q) * rate, -braking[1])
            most, least = np.clip(most, -fastest, fastest), np.clip(least, -fastest, fastest)
            if present is not None:
                change = strongest / rate
                low, high = present - change, present + change
                most = np.minimum(np.maximum(most, low), high)
                least = np.minimum(np.maximum(least, low), high)
        return np.clip(least, -none, none), np.clip(most, -none, none)

    def _bound(self, argument: str, value: ArrayLike | None, known: FloatArray) -> FloatArray:
        """Return limits a joint: what was given, or what the robot has."""
        if value is None:
            return known
        given = float_array(argument, value)
        if given.shape not in ((), (self.dof,)):
            expected = f"one number or shape ({self.dof},)"
            raise ArgumentError(argument, f"shape {given.shape}", expected)
        if not (given > 0).all():
            raise ArgumentError(argument, str(given.tolist()), "numbers above 0")
        return np.broadcast_to(given, (self.dof,))
