"""The tomato rig: three servos whose pulses the board ramps."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array, real_number, shown, truth_value
from ..arms import Outcome, TomatoArm
from ..errors import ArgumentError
from ._calibration import Calibration
from ._errors import OutOfReachError, RigError
from ._messages import Board, Flags, Report, Servos, Type
from ._rig import Progress, Rig, RigStatus, finite, within
from ._transport import Transport

__all__ = ["TomatoRig"]

_JOINTS = ("phi1", "phi2", "phi3")
# The board's slowest ramp over a servo's whole range, and more.
_LONGEST_S = 10.0
_SERVOS_MOVING = 0x80


class _Arrested(RigError):
    """The sensor at the tip says that the surface is near."""


class TomatoRig(Rig):
    """The tomato pointing arm on an ATmega8.

    Joint values are phi1 (shoulder), phi2 (elbow) and phi3 (pan), rad. As a context manager it
    connects, and holds the arm where it is when the block ends. Threads may share it.

    Parameters
    ----------
    port : str or Transport, default "simulated"
        What pyserial takes; ``"simulated"`` starts the firmware in a simulator, with its plant.
    calibration : str, path or Calibration, optional
        File, or what was read from it; the bundled one by default.
    timeout, tries, log
        Of the `Link`.
    progress : callable, optional
        Told where the rig is while it moves.
    contact : callable, optional
        A sensor at the tip: returns the distance to what is before it (m), or True for a touch
        and False for none. It is asked whenever the rig is looked at.
    stop_at : float, default 0.01, m
        A motion ends where the sensor says this or less.

    Raises
    ------
    CalibrationError
        The calibration file is faulty or that of another rig.
    ArgumentError
        A number is out of its range.

    Examples
    --------
    In the simulator (``make firmware``); a port's name would do the same on a real line.

    >>> from agrik_fast.drivers import Simulator, TomatoRig
    >>> with TomatoRig(Simulator("tomato")) as rig:
    ...     rig.home()
    ...     print(rig.move(target=[0.2, 0.05, 0.1]).state)
    idle
    """

    name = "tomato"
    board = Board.MEGA8
    joint_names = _JOINTS

    def __init__(
        self,
        port: str | Transport = "simulated",
        *,
        calibration: str | Path | Calibration | None = None,
        timeout: float = 0.08,
        tries: int = 5,
        log: Path | str | None = None,
        progress: Progress | None = None,
        contact: Callable[[], float | bool] | None = None,
        stop_at: float = 0.01,
    ) -> None:
        super().__init__(
            port,
            calibration=calibration,
            timeout=timeout,
            tries=tries,
            log=log,
            progress=progress,
        )
        self.arm = TomatoArm()
        if contact is not None and not callable(contact):
            raise ArgumentError("contact", shown(contact), "a callable or None")
        self._contact = contact
        self._stop_at = real_number("stop_at", stop_at, 0, unit="m")
        self.arrested = False
        """Whether the sensor at the tip ended the last motion."""
        self._commanded: FloatArray | None = None
        self._horns: FloatArray | None = None

    @property
    def lower(self) -> FloatArray:
        """Smallest joint values, shape (3,), rad: the arm's, and what servos allow."""
        own = np.array([servo.limits[0] for servo in self.calibration.servo])
        return np.asarray(np.maximum(own, self.arm.lower))

    @property
    def upper(self) -> FloatArray:
        """Largest joint values, shape (3,), rad."""
        own = np.array([servo.limits[1] for servo in self.calibration.servo])
        return np.asarray(np.minimum(own, self.arm.upper))

    def _checked(self, argument: str, q: object) -> FloatArray:
        values = finite(argument, q, (3,), "rad")
        for name, value, low, high in zip(_JOINTS, values, self.lower, self.upper, strict=True):
            within(name, value, low, high)
        return values

    def solve(self, target: ArrayLike) -> FloatArray:
        """Return joint values, shape (3,), rad, that bring the tool point to a target.

        Raises
        ------
        OutOfReachError
            Too far, too near, or no branch is within the servos' limits.
        ArgumentError
            It is no point.

        Examples
        --------
        >>> from agrik_fast.drivers import TomatoRig
        >>> TomatoRig("loop://").solve([0.2, 0.05, 0.1]).shape
        (3,)
        """
        from ..arms import HOME

        point = finite("target", target, (3,), "m")
        current = HOME if self._commanded is None else self._commanded
        found = self.arm.solve(point, current=current)
        if not bool(found.success):
            why = Outcome(int(found.outcome)).name.lower().replace("_", " ")
            raise OutOfReachError(point, why)
        return np.asarray(found.q)

    def _send(self, values: FloatArray, *, near: bool, dead_band_us: float = 0.0) -> None:
        ticks = [
            servo.ticks(angle) for servo, angle in zip(self.calibration.servo, values, strict=True)
        ]
        if dead_band_us and self._horns is not None:
            for i, (servo, horn) in enumerate(
                zip(self.calibration.servo, self._horns, strict=True)
            ):
                beyond = np.sign(ticks[i] - 2 * horn) * 2 * dead_band_us
                limits = 2 * servo.lower_us, 2 * servo.upper_us
                ticks[i] = round(float(np.clip(ticks[i] + beyond, *limits)))
        flags = Flags.ENABLE | (Flags.NEAR if near else 0)
        degrees = ", ".join(f"{angle:.1f}" for angle in np.degrees(values))
        self._command(Type.SERVOS, Servos(flags, *ticks).pack(), f"a move to ({degrees}) degrees")
        self._commanded = values

    def home(self) -> None:
        """Move to the pose that the arm starts from.

        The first pulse after power comes without a ramp: the board cannot know where a servo is.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, TomatoRig
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     print(rig.status().homed)
        True
        """
        from ..arms import HOME

        self.move(np.array(HOME))

    def move(
        self,
        q: ArrayLike | None = None,
        *,
        target: ArrayLike | None = None,
        near: bool = False,
    ) -> RigStatus:
        """Move to joint values or to a target, and wait until the pulses have arrived.

        Parameters
        ----------
        q : array_like, shape (3,), rad
            Joint values.
        target : array_like, shape (3,), m
            Instead: where the tool point is to go.
        near : bool, default False
            Slowly (60 instead of 200 degrees/s), near the fruit.

        Returns
        -------
        RigStatus
            Where it is.

        Raises
        ------
        ArgumentError, OutOfReachError
            Beyond the limits, or out of reach.
        RigFaultError
            The board stopped.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, TomatoRig
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     status = rig.move(target=[0.2, 0.05, 0.1])
        >>> status.moving
        False
        """
        if (q is None) == (target is None):
            raise ArgumentError("q, target", "both" if q is not None else "neither", "one of them")
        near = truth_value("near", near)
        values = self._checked("q", q) if target is None else self.solve(target)
        with self._moving():
            self._watch()
            fresh = self._commanded is None
            self.arrested = False
            self._send(values, near=near)
            try:
                report = self._wait(_SERVOS_MOVING, _LONGEST_S, "a move")
            except _Arrested:
                self.arrested = True
                self._commanded = None
                return self._status(self.link.report())
            # The servos run behind their pulses; after power, by up to their whole range.
            servos = self.calibration.servo
            far = max(servo.limits[1] - servo.limits[0] for servo in servos) if fresh else 0.0
            self._pause(far / min(servo.rate for servo in servos) + 0.1)
            return self._status(report)

    def aim(self, q: ArrayLike, *, near: bool = False, dead_band_us: float = 0.0) -> None:
        """Send joint values and do not wait: for loops that send anew before the arm arrives.

        Parameters
        ----------
        q : array_like, shape (3,), rad
            Joint values.
        near : bool, default False
            As for `move`.
        dead_band_us : float, default 0.0, us
            Half the servos' dead band. A servo stops that far before its pulse, on the side that it
            comes from: pulses then go beyond the target by as much, and the horn ends on it.

        Raises
        ------
        ArgumentError
            Beyond the limits.
        RigError
            The board refuses, or does not answer.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, TomatoRig
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     rig.aim(rig.status().q + 0.05)
        ...     print(rig.status().moving)
        True
        """
        values = self._checked("q", q)
        band = real_number("dead_band_us", dead_band_us, 0, 50, unit="us")
        near = truth_value("near", near)
        with self._moving():
            self._send(values, near=near, dead_band_us=band)

    def watch(self, *, dead_band_us: float = 0.0) -> RigStatus:
        """Look at the board once; where horns are is kept for `aim`.

        Raises
        ------
        RigFaultError
            The board stopped.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, TomatoRig
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     print(rig.watch().state)
        idle
        """
        report = self._watch_quietly()
        pulses = np.array([report.servo[each.index] / 2 for each in self.calibration.servo])
        if self._horns is None or not pulses.all():
            self._horns = pulses if pulses.all() else None
        else:
            # A horn is drawn along by its dead band.
            self._horns = np.clip(self._horns, pulses - dead_band_us, pulses + dead_band_us)
        return self._status(report)

    def _watch_quietly(self) -> Report:
        """Look at the board; the sensor at the tip ends nothing here, its caller decides."""
        return super()._watch()

    def touching(self) -> bool:
        """Whether the sensor at the tip says that the surface is as near as `stop_at`.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, TomatoRig
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     print(rig.touching())
        False
        """
        if self._contact is None:
            return False
        said = self._contact()
        if isinstance(said, bool | np.bool_):
            return bool(said)
        return not real_number("contact", said, 0, unit="m") > self._stop_at

    def _watch(self) -> Report:
        report = self._watch_quietly()
        if self.touching():
            raise _Arrested("the sensor at the tip ended the motion")
        return report

    def follow(self, path: ArrayLike, *, rate: float = 30.0, near: bool = False) -> RigStatus:
        """Send joint values at a rate, without waiting at each; then wait for the last.

        Parameters
        ----------
        path : array_like, shape (n, 3), rad
            Joint values.
        rate : float, default 30.0, 1/s
            Points a second.
        near : bool, default False
            As for `move`.

        Raises
        ------
        ArgumentError
            A point is beyond the limits: nothing moves.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, TomatoRig
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     q = rig.status().q
        ...     status = rig.follow([q + 0.01 * k for k in range(5)])
        >>> status.q.shape
        (3,)
        """
        given = float_array("path", path)
        if given.ndim != 2 or given.shape[1] != 3 or not len(given):
            raise ArgumentError("path", f"shape {given.shape}", "shape (n, 3), n >= 1")
        rate = real_number("rate", rate, 0, 50, open_low=True, unit="1/s")
        points = [self._checked(f"path[{i}]", point) for i, point in enumerate(given)]
        with self._moving():
            clock = self.link.transport
            begin = clock.now()
            for number, point in enumerate(points):
                self._send(point, near=near)
                left = begin + (number + 1) / rate - clock.now()
                if left > 0:
                    self._pause(left)
            return self._status(self._wait(_SERVOS_MOVING, _LONGEST_S, "a path"))

    def gripper(self, open: bool) -> None:
        """Refuse: the tomato rig points, it has no gripper.

        Raises
        ------
        RigError
            Always.

        Examples
        --------
        >>> from agrik_fast.drivers import RigError, TomatoRig
        >>> try:
        ...     TomatoRig("loop://").gripper(open=True)
        ... except RigError as error:
        ...     print(type(error).__name__)
        RigError
        """
        raise RigError("the tomato rig has no gripper")

    def release(self) -> None:
        """End the pulses: the servos let go.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, TomatoRig
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     rig.release()
        """
        with self._moving():
            self.link.command(Type.SERVOS, Servos(0, 0, 0, 0).pack(), "to end the pulses")
            self._commanded = self._horns = None

    def _q(self, report: Report) -> FloatArray:
        q = np.full(3, np.nan)
        for i, servo in enumerate(self.calibration.servo):
            if ticks := report.servo[servo.index]:
                q[i] = servo.angle(ticks)
        return q
