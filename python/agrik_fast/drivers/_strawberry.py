"""The strawberry rig: three slides, three servos, a gripper."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array, real_number, shown, truth_value, word
from ..arms import Command, StrawberryArm
from ..errors import ArgumentError
from ._calibration import Calibration
from ._clearance import Surroundings
from ._errors import OutOfReachError, RigError
from ._messages import Board, Home, Move, Report, Servo, Type
from ._rig import Progress, Rig, finite, within
from ._runs import Arrival, Run
from ._transport import Transport
from ._ways import H_EXTRA, Ways

__all__ = ["StrawberryRig"]

SLIDES, SERVOS = ("s10", "s21", "s32"), ("theta", "beta", "psi")
# Pulse to pulse, and a little to come to rest.
_SERVO_LAG_S = 0.03
# Beyond the time that a move should take.
_PATIENCE_S = 5.0
Method = Literal["exact", "as", "ssas", "ncos"]
METHODS = ("exact", "as", "ssas", "ncos")


class StrawberryRig(Rig):
    """The strawberry handling arm on an Arduino Mega 2560.

    Joint values are s10, s21, s32 (m), theta, beta, psi (rad). As a context manager it connects,
    and stops whatever moves when the block ends, by an exception or not. Threads may share it:
    motions wait for one another, `stop` and `status` do not.

    Parameters
    ----------
    port : str or Transport, default "simulated"
        What pyserial takes; ``"simulated"`` starts the firmware in a simulator, with its plant.
    calibration : str, path or Calibration, optional
        File, or what was read from it; the bundled one by default.
    surroundings : Surroundings or None, optional
        Plant and bed, of which ways must stay clear; None for an empty bench.
    timeout, tries, log
        Of the `Link`.
    progress : callable, optional
        Told where the rig is while it moves.

    Raises
    ------
    CalibrationError
        The calibration file is faulty or that of another rig.
    ArgumentError
        A number is out of its range.

    Examples
    --------
    In the simulator (``make firmware``); a port's name would do the same on a real line.

    >>> from agrik_fast.drivers import Simulator, StrawberryRig
    >>> with StrawberryRig(Simulator("strawberry")) as rig:
    ...     rig.home()
    ...     run = rig.pick(target=[0.426, 0.345, -0.3316])
    >>> run.steps[-1].axis
    'gripper'
    """

    name = "strawberry"
    board = Board.MEGA2560
    joint_names = (*SLIDES, *SERVOS)

    def __init__(
        self,
        port: str | Transport = "simulated",
        *,
        calibration: str | Path | Calibration | None = None,
        surroundings: Surroundings | None = Surroundings(),  # noqa: B008 - frozen
        timeout: float = 0.08,
        tries: int = 5,
        log: Path | str | None = None,
        progress: Progress | None = None,
    ) -> None:
        super().__init__(
            port,
            calibration=calibration,
            timeout=timeout,
            tries=tries,
            log=log,
            progress=progress,
        )
        if surroundings is not None and not isinstance(surroundings, Surroundings):
            raise ArgumentError("surroundings", shown(surroundings), "Surroundings or None")
        self.surroundings = surroundings
        self.arm = StrawberryArm()
        self._upward = [True] * 3
        self._turned: dict[str, float] = {}

    @property
    def _ways(self) -> Ways:
        return Ways(self.arm, self.surroundings)

    # ---- limits ------------------------------------------------------------------------------

    @property
    def lower(self) -> FloatArray:
        """Smallest joint values, shape (6,), m and rad: the arm's, and what servos allow."""
        return self._limits()[0]

    @property
    def upper(self) -> FloatArray:
        """Largest joint values, shape (6,), m and rad."""
        return self._limits()[1]

    def _limits(self) -> tuple[FloatArray, FloatArray]:
        quarter = math.pi / 2
        slides = [(axis.lower_mm / 1000, axis.upper_mm / 1000) for axis in self.calibration.axis]
        own = np.array([*slides, *(servo.limits for servo in self.calibration.servo)])
        low: FloatArray = np.maximum(own[:, 0], [*self.arm.lower, -quarter])
        high: FloatArray = np.minimum(own[:, 1], [*self.arm.upper, quarter])
        return low, high

    def _checked(self, argument: str, q: object) -> FloatArray:
        values = finite(argument, q, (5, 6), "m and rad")
        values = np.append(values, 0.0) if len(values) == 5 else values
        low, high = self._limits()
        for name, value, least, most in zip(self.joint_names, values, low, high, strict=True):
            within(name, value, least, most)
        return values

    def _roughly(self, argument: str, q: object) -> FloatArray:
        """Return where the arm is said to be: by encoders, it may be beyond a limit by the play."""
        values = finite(argument, q, (5, 6), "m and rad")
        low, high = self._limits()
        ends = zip(self.joint_names, values, low - 0.02, high + 0.02, strict=False)
        for name, value, least, most in ends:
            within(name, value, least, most)
        return values

    def solve(self, target: ArrayLike, method: Method = "exact") -> FloatArray:
        """Return joint values, shape (5,), m and rad, that bring the tool point to a target.

        Raises
        ------
        OutOfReachError
            The message says which slide lacks how much.
        ArgumentError
            It is no point.

        Examples
        --------
        >>> from agrik_fast.drivers import StrawberryRig
        >>> StrawberryRig("loop://").solve([0.426, 0.345, -0.3316]).shape
        (5,)
        """
        point = finite("target", target, (3,), "m")
        word("method", method, METHODS)
        found = self.arm.solve(point, method)
        if not bool(found.success):
            from ..arms import Place

            place, gap = Place(int(found.place)), 1000 * float(found.gap)
            why = "slides s21 and s32 cannot both reach it"
            if place != Place.THETA:
                why = f"slide {place.name.lower()} lacks {abs(gap):.1f} mm"
            raise OutOfReachError(point, why)
        return np.asarray(found.q)

    # ---- motions -----------------------------------------------------------------------------

    def _prepare(self) -> None:
        for index, axis in enumerate(self.calibration.axis):
            self.link.command(
                Type.CONFIGURE, axis.configure(index).pack(), f"the calibration of {axis.name}"
            )

    def home(self) -> None:
        """Find the limit switches: lift first, then servos to zero, then the other slides.

        Raises
        ------
        RigFaultError
            A switch is not found or stuck, an axis is jammed, ...

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     rig.home()
        ...     print(rig.status().homed)
        True
        """
        with self._moving():
            self._home(0b100)
            self._turn(dict.fromkeys(SERVOS, 0.0))
            self._home(0b011)

    def _home(self, mask: int) -> None:
        axes = [axis for i, axis in enumerate(self.calibration.axis) if mask >> i & 1]
        names = ", ".join(axis.name for axis in axes)
        self._command(Type.HOME, Home(mask).pack(), f"homing of {names}")
        travel = max((axis.upper_mm - axis.lower_mm) / axis.home_fast_mm_s for axis in axes)
        slow = max(8 * axis.clearance_mm / axis.home_slow_mm_s for axis in axes)
        self._wait(mask, 2 * travel + slow + _PATIENCE_S, f"homing of {names}")
        for i in range(3):
            if mask >> i & 1:
                self._upward[i] = True

    def _slide(self, values: dict[int, float]) -> list[Arrival]:
        """Move slides (m, by index) at once and wait for all."""
        clock = self.link.transport
        report, begin = self.link.report(), clock.now()
        targets, mask, longest = {}, 0, 0.0
        for i, value in values.items():
            axis, at = self.calibration.axis[i], report.position[i]
            count = axis.target(1000 * value, at)
            speed = round(axis.speed_mm_s * axis.counts_per_mm)
            what = f"a move of {axis.name} to {1000 * value:.1f} mm"
            self._command(Type.MOVE, Move(i, count, speed).pack(), what)
            if count != at:
                self._upward[i] = count > at
            targets[i] = count
            mask |= 1 << i
            longest = max(longest, abs(count - at) / speed)
        report = self._wait(mask, 2 * longest + _PATIENCE_S, "a move")
        found = []
        for i, count in targets.items():
            axis = self.calibration.axis[i]
            off = (report.position[i] - count) / axis.counts_per_mm / 1000
            found.append(Arrival(axis.name, values[i], begin, clock.now(), off))
        return found

    def _turn(self, angles: dict[str, float]) -> list[Arrival]:
        """Turn servos (rad) at once and wait as long as the furthest takes."""
        clock = self.link.transport
        begin, longest = clock.now(), 0.0
        for name, angle in angles.items():
            servo = self.calibration.servo[SERVOS.index(name)]
            ticks = servo.ticks(angle)
            what = f"a turn of {name} to {math.degrees(angle):.1f} degrees"
            self._command(Type.SERVO, Servo(servo.index, ticks).pack(), what)
            # Where it stands before its first command nobody knows.
            low, high = servo.limits
            off = abs(angle - self._turned[name]) if name in self._turned else high - low
            self._turned[name] = angle
            longest = max(longest, off / servo.rate)
        self._pause(longest + _SERVO_LAG_S)
        return [Arrival(name, angle, begin, clock.now()) for name, angle in angles.items()]

    def gripper(self, open: bool) -> Arrival:
        """Open or close the gripper and wait until that is done.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     rig.home()
        ...     print(rig.gripper(open=True).target)
        1.0
        """
        open = truth_value("open", open)  # noqa: A001
        gripper = self.calibration.gripper
        assert gripper is not None
        clock = self.link.transport
        with self._moving():
            begin = clock.now()
            ticks = round(2 * (gripper.open_us if open else gripper.closed_us))
            what = "to open the gripper" if open else "to close the gripper"
            self._command(Type.SERVO, Servo(gripper.index, ticks).pack(), what)
            self._pause(gripper.seconds)
            return Arrival("gripper", float(open), begin, clock.now())

    def move(
        self,
        q: ArrayLike | None = None,
        *,
        target: ArrayLike | None = None,
        method: Method = "exact",
    ) -> list[Arrival]:
        """Move all axes at once, to joint values or to a target.

        Parameters
        ----------
        q : array_like, shape (5,) or (6,), m and rad
            Joint values; psi is 0 where it is left out.
        target : array_like, shape (3,), m
            Instead: where the tool point is to go.
        method : {"exact", "as", "ssas", "ncos"}
            How joint values are found for a target.

        Returns
        -------
        list of Arrival
            One an axis.

        Raises
        ------
        ArgumentError, OutOfReachError
            Beyond the limits, or out of reach.
        ClearanceError
            Plant or bed are in the way: nothing moves.
        RigFaultError
            The board stopped.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     rig.home()
        ...     arrivals = rig.move([0.12, 0.12, 0.1, 0.1, 0.0])
        >>> sorted({arrival.axis for arrival in arrivals})
        ['beta', 'psi', 's10', 's21', 's32', 'theta']
        """
        values = self._goal(q, target, method)
        with self._moving():
            here = self._known("move")
            if self.surroundings:
                self.surroundings.check_way(self.arm, [here[:5], values[:5]], ["move"], [False])
            return self._go(values)

    def _go(self, values: FloatArray) -> list[Arrival]:
        angles = dict(zip(SERVOS, values[3:].tolist(), strict=True))
        slides = dict(enumerate(values[:3].tolist()))
        return [*self._slide(slides), *self._turn(angles)]

    def follow(self, path: ArrayLike) -> list[Arrival]:
        """Move along joint values, all axes at once, standing at each.

        Parameters
        ----------
        path : array_like, shape (n, 5) or (n, 6), m and rad
            Joint values.

        Returns
        -------
        list of Arrival
            One an axis and point.

        Raises
        ------
        ArgumentError, ClearanceError
            A point is beyond the limits, or something is in the way: nothing moves.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     rig.home()
        ...     arrivals = rig.follow([[0.10, 0.1, 0.1, 0.0, 0.0], [0.12, 0.1, 0.1, 0.1, 0.0]])
        >>> len(arrivals) >= 2
        True
        """
        given = float_array("path", path)
        if given.ndim != 2 or given.shape[1] not in (5, 6) or not len(given):
            raise ArgumentError("path", f"shape {given.shape}", "shape (n, 5) or (n, 6), n >= 1")
        points = [self._checked(f"path[{i}]", point) for i, point in enumerate(given)]
        with self._moving():
            here = self._known("follow")
            if self.surroundings:
                corners = [here[:5], *(point[:5] for point in points)]
                names = [f"to path[{i}]" for i in range(len(points))]
                self.surroundings.check_way(self.arm, corners, names, [False] * len(points))
            return [arrival for point in points for arrival in self._go(point)]

    def pick(
        self,
        q: ArrayLike | None = None,
        *,
        target: ArrayLike | None = None,
        method: Method = "exact",
        psi: float = 0.0,
        h_extra: float | None = None,
    ) -> Run:
        """Carry out the command sequence of remark 3: to a fruit, and close the gripper.

        Open, z to `h_extra` above its end, y, x, theta, beta, psi, z, close; one after the other.

        Parameters
        ----------
        q : array_like, shape (5,), m and rad
            Joint values.
        target : array_like, shape (3,), m
            Instead: the fruit.
        method : {"exact", "as", "ssas", "ncos"}
            How joint values are found for a target.
        psi : float, default 0.0, rad
            Turn of the gripper.
        h_extra : float, optional, m
            How far above its end the arm waits; by default 30 mm, or as much more, in steps of
            10 mm, as keeps it clear of the plant.

        Returns
        -------
        Run
            The steps and what they took.

        Raises
        ------
        ArgumentError, OutOfReachError
            Beyond the limits, or out of reach.
        ClearanceError
            The way out or the way back would touch plant or bed: nothing moves.
        RigFaultError
            The board stopped.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     rig.home()
        ...     run = rig.pick(target=[0.426, 0.345, -0.3316])
        >>> len(run.steps)
        9
        """
        values = self._goal(q, target, method)
        values[5] = real_number("psi", psi, unit="rad")
        values = self._checked("q", values)
        given = None if h_extra is None else real_number("h_extra", h_extra, 0, unit="m")
        with self._moving():
            here = self._known("pick")
            height = self._ways.height(
                lambda extra: self._ways.check(here, values, extra), given, float(values[2])
            )
            commands = self.arm.commands(values[:5], psi=float(values[5]), h_extra=height)
            begin = self.link.transport.now()
            steps = [arrival for step in commands for arrival in self._carry_out(step)]
            seconds = self.link.transport.now() - begin
            return Run(values, seconds, height, tuple(steps))

    def way_back(self, q: ArrayLike, h_extra: float = H_EXTRA) -> list[Command]:
        """Return the steps of remark 3's step 7: lift first, then back, last all the way up.

        Parameters
        ----------
        q : array_like, shape (5,) or (6,), m and rad
            Where the arm is.
        h_extra : float, default 0.03, m
            How far it is lifted first; no further than home.

        Examples
        --------
        >>> from agrik_fast.drivers import StrawberryRig
        >>> rig = StrawberryRig("loop://")
        >>> [step.axis for step in rig.way_back(rig.solve([0.426, 0.345, -0.3316]))]
        ['s32', 'psi', 'beta', 'theta', 's21', 's10', 's32']
        """
        h_extra = real_number("h_extra", h_extra, 0, unit="m")
        return self._ways.back(self._roughly("q", q), h_extra)

    def reset(self, *, h_extra: float | None = None) -> Run:
        """Bring the arm home (step 7 of remark 3): lift first, then back; the gripper stays.

        Parameters
        ----------
        h_extra : float, optional, m
            How far the arm is lifted first; by default as for `pick`.

        Raises
        ------
        ClearanceError
            The way would touch plant or bed: nothing moves.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     rig.home()
        ...     _ = rig.pick(target=[0.426, 0.345, -0.3316])
        ...     print(rig.reset().steps[0].axis)
        s32
        """
        given = None if h_extra is None else real_number("h_extra", h_extra, 0, unit="m")
        with self._moving():
            here = self._known("reset")
            height = self._ways.height(
                lambda extra: self._ways.check_back(here, extra), given, float(here[2])
            )
            begin = self.link.transport.now()
            steps = [a for step in self.way_back(here, height) for a in self._carry_out(step)]
            end = np.append(self.arm.reset_pose, 0.0)
            return Run(end, self.link.transport.now() - begin, height, tuple(steps))

    def _carry_out(self, step: Command) -> list[Arrival]:
        if step.axis == "gripper":
            return [self.gripper(step.target > 0.5)]
        if step.axis in SLIDES:
            return self._slide({SLIDES.index(step.axis): step.target})
        return self._turn({step.axis: step.target})

    def check_ways(self, here: ArrayLike, q: ArrayLike, h_extra: float) -> None:
        """See whether `pick` and the way back stay clear of plant and bed.

        Parameters
        ----------
        here, q : array_like, shape (5,) or (6,), m and rad
            Where the arm is and where it would go.
        h_extra : float, m
            How far above its end it would wait.

        Raises
        ------
        ClearanceError
            Names the pair that would touch, and the step.

        Examples
        --------
        >>> from agrik_fast.drivers import StrawberryRig
        >>> rig = StrawberryRig("loop://")
        >>> q = rig.solve([0.426, 0.345, -0.3316])
        >>> rig.check_ways([0.1, 0.1, 0.1, 0.0, 0.0], q, h_extra=0.03)
        """
        start, end = self._roughly("here", here), self._checked("q", q)
        self._ways.check(start, end, real_number("h_extra", h_extra, 0, unit="m"))

    # ---- where it is -------------------------------------------------------------------------

    def _goal(self, q: ArrayLike | None, target: ArrayLike | None, method: Method) -> FloatArray:
        if (q is None) == (target is None):
            raise ArgumentError("q, target", "both" if q is not None else "neither", "one of them")
        word("method", method, METHODS)
        if target is not None:
            return self._checked("target", self.solve(target, method))
        return self._checked("q", q)

    def _known(self, what: str) -> FloatArray:
        """Return where the arm is; servos as commanded."""
        status = self._status(self._watch())
        if not status.homed:
            raise RigError(f"the strawberry rig is not homed: `home` before `{what}`")
        q = status.q.copy()
        for i, name in enumerate(SERVOS, 3):
            q[i] = self._turned.get(name, 0.0)
        return q

    def _q(self, report: Report) -> FloatArray:
        q = np.full(6, np.nan)
        for i, axis in enumerate(self.calibration.axis):
            if report.homed >> i & 1:
                q[i] = axis.value_mm(report.position[i], self._upward[i]) / 1000
        for i, servo in enumerate(self.calibration.servo, 3):
            if ticks := report.servo[servo.index]:
                q[i] = servo.angle(ticks)
        return q
