"""What both rigs have in common: a link, a calibration, and motors that stop."""

from __future__ import annotations

import abc
import contextlib
import math
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import ClassVar, Literal, Self

import numpy as np

from .._checks import FloatArray, float_array, shown
from ..errors import ArgumentError
from ._calibration import Calibration
from ._errors import CommandRefusedError, RigError, RigFaultError
from ._link import Link, LinkStatistics, link_options
from ._messages import Board, Code, Fault, Identity, Report, State, Type
from ._simulator import Simulator
from ._transport import Transport

# Often enough for the board, which gives up after half a second of silence.
POLL_S = 0.02
_NO_AXIS = 0xFF


@dataclass(frozen=True, slots=True)
class RigStatus:
    """Where a rig is.

    Attributes
    ----------
    state : str
        not_homed, idle, homing, moving, fault or estop.
    fault : str
        none, or why the motors were stopped: stall, link_timeout, ...
    fault_axis : str or None
        Axis of the fault.
    q : ndarray, shape (n,), m and rad
        Joint values by encoders, and by pulses for servos; NaN where they are not known.
    moving : bool
        An axis is on its way.
    homed : bool
        All slides have found their switches.
    switches : tuple of str
        What is pressed: names of slides, ``estop``.
    lost_ticks, skips : int
        Control ticks that the board lost, encoder steps that cannot be.
    clock : float, s
        The board's time since it started.
    link : LinkStatistics
        What the link has seen.

    Examples
    --------
    >>> from agrik_fast.drivers import Simulator, TomatoRig
    >>> with TomatoRig(Simulator("tomato")) as rig:
    ...     status = rig.status()
    >>> status.state, status.fault
    ('idle', 'none')
    """

    state: str
    fault: str
    fault_axis: str | None
    q: FloatArray
    moving: bool
    homed: bool
    switches: tuple[str, ...]
    lost_ticks: int
    skips: int
    clock: float
    link: LinkStatistics


Progress = Callable[[RigStatus], None]
"""Told where the rig is while it moves."""


class Rig(abc.ABC):
    """A rig on a line; `StrawberryRig` and `TomatoRig` say the rest."""

    name: ClassVar[Literal["strawberry", "tomato"]]
    board: ClassVar[Board]
    joint_names: ClassVar[tuple[str, ...]]
    calibration: Calibration

    def __init__(
        self,
        port: str | Transport = "simulated",
        *,
        calibration: str | Path | Calibration | None = None,
        timeout: float = 0.08,
        tries: int = 5,
        log: Path | str | None = None,
        progress: Progress | None = None,
    ) -> None:
        for method in () if isinstance(port, str) else ("write", "read", "now", "sleep", "close"):
            if not callable(getattr(port, method, None)):
                raise ArgumentError("port", shown(port), "a port's name or a Transport")
        if isinstance(calibration, Calibration):
            if calibration.rig.name != self.name:
                found = f"that of the {calibration.rig.name} rig"
                raise ArgumentError("calibration", found, f"one of the {self.name} rig")
            self.calibration = calibration
        else:
            given = self.name if calibration is None else calibration
            self.calibration = Calibration.load(given, self.name)
        if progress is not None and not callable(progress):
            raise ArgumentError("progress", shown(progress), "a callable or None")
        self.progress = progress
        self._given = port
        self._options = link_options(timeout, tries, log)
        self._link: Link | None = None
        # Motions are one at a time; stopping is possible at any time, from any thread.
        self._motion = threading.RLock()
        self._stopped = threading.Event()
        self._depth = 0

    # ---- the line ----------------------------------------------------------------------------

    @property
    def link(self) -> Link:
        """The link.

        Raises
        ------
        RigError
            The rig is not connected.
        """
        if self._link is None:
            raise RigError(f"the {self.name} rig is not connected: call connect, or use `with`")
        return self._link

    def connect(self) -> Identity:
        """Open the port, see that the right board is there and tell it what it has to know.

        Returns
        -------
        Identity
            What the board says of itself.

        Raises
        ------
        LinkError, WrongDeviceError
            No port, nobody there, or somebody else.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> rig = StrawberryRig(Simulator("strawberry"))
        >>> rig.connect().board
        1
        >>> rig.close()
        """
        if self._link is not None:
            raise RigError(f"the {self.name} rig is connected already")
        port: str | Transport = self._given
        if port == "simulated":
            port = Simulator(self.name)
        link = Link(port, **self._options)
        try:
            identity = link.hello(self.board)
            self._link = link
            self._prepare()
        except BaseException:
            self._link = None
            link.close()
            raise
        return identity

    def _prepare(self) -> None:  # noqa: B027 - a board may have to know nothing
        """Tell the board what it has to know."""

    def close(self) -> None:
        """Stop what moves and give the port up.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> rig = StrawberryRig(Simulator("strawberry"))
        >>> rig.close()
        """
        if self._link is None:
            return
        self._stop_quietly()
        self._link.close()
        self._link = None

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    # ---- safety ------------------------------------------------------------------------------

    def stop(self) -> None:
        """Let all axes slow down and stand; a motion that waits in another thread ends.

        Raises
        ------
        LinkError
            No answer: the board stops by itself half a second later.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     rig.stop()
        ...     print(rig.status().moving)
        False
        """
        self._stopped.set()
        self.link.command(Type.STOP)

    def _stop_quietly(self) -> None:
        """Stop while something else has gone wrong already."""
        with contextlib.suppress(RigError):
            self.stop()

    def clear(self) -> None:
        """Leave a fault or an emergency stop, once its cause is gone.

        Raises
        ------
        CommandRefusedError
            The emergency stop is still pressed.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> simulator = Simulator("strawberry")
        >>> with StrawberryRig(simulator) as rig:
        ...     simulator.set("estop", 1)
        ...     simulator.run(0.1)
        ...     simulator.set("estop", 0)
        ...     rig.clear()
        ...     print(rig.status().fault)
        none
        """
        self.link.command(Type.CLEAR, what="to clear the fault")

    # ---- where it is -------------------------------------------------------------------------

    def status(self) -> RigStatus:
        """Ask the board where everything is.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator, StrawberryRig
        >>> with StrawberryRig(Simulator("strawberry")) as rig:
        ...     print(rig.status().state)
        not_homed
        """
        return self._status(self.link.report())

    def _status(self, report: Report) -> RigStatus:
        names = self.joint_names
        slides = names[:3] if self.calibration.axis else ()
        axis = names[report.fault_axis] if report.fault_axis < len(slides) else None
        pressed = [name for i, name in enumerate(slides) if report.switches >> i & 1]
        if report.switches >> 3 & 1:
            pressed.append("estop")
        return RigStatus(
            state=_name(State, report.state),
            fault=_name(Fault, report.fault),
            fault_axis=axis,
            q=self._q(report),
            moving=bool(report.busy & ~0x40),
            homed=report.homed == 7,
            switches=tuple(pressed),
            lost_ticks=report.lost_ticks,
            skips=report.skips,
            clock=report.clock / 1000,
            link=self.link.statistics,
        )

    @abc.abstractmethod
    def _q(self, report: Report) -> FloatArray:
        """Return the joint values of a report."""

    def _watch(self) -> Report:
        """Look at the board once, on the way."""
        report = self.link.report()
        status = self._status(report)
        if self.progress:
            self.progress(status)
        if report.state in (State.FAULT, State.ESTOP):
            raise RigFaultError(status.fault, status.fault_axis)
        if self._stopped.is_set():
            raise RigError("the motion was stopped")
        return report

    def _wait(self, mask: int, longest: float, what: str) -> Report:
        """Wait until no axis of `mask` is busy; what moves is stopped if that fails."""
        clock = self.link.transport
        end = clock.now() + longest
        try:
            while True:
                clock.sleep(POLL_S)
                report = self._watch()
                if not report.busy & mask:
                    return report
                if clock.now() > end:
                    raise RigError(f"{what} did not end within {longest:.1f} s")
        except BaseException:
            self._stop_quietly()
            raise

    def _pause(self, seconds: float) -> None:
        """Let a servo turn, of which the board knows nothing; look at it meanwhile."""
        clock = self.link.transport
        end = clock.now() + seconds
        try:
            while (left := end - clock.now()) > 0:
                clock.sleep(min(left, 5 * POLL_S))
                self._watch()
        except BaseException:
            self._stop_quietly()
            raise

    @contextlib.contextmanager
    def _moving(self) -> Iterator[None]:
        """Have the rig to oneself; whatever goes wrong inside, what moves is stopped."""
        with self._motion:
            # A sequence is one motion: a stop between two of its steps ends all of it.
            if self._depth == 0:
                self._stopped.clear()
            self._depth += 1
            try:
                yield
            except BaseException:
                if self._link is not None:
                    self._stop_quietly()
                raise
            finally:
                self._depth -= 1

    def _command(self, kind: Type, payload: bytes, what: str) -> None:
        """Have a motion begun; a refusal for a fault names the fault."""
        if self._stopped.is_set():
            raise RigError("the motion was stopped")
        try:
            self.link.command(kind, payload, what)
        except CommandRefusedError as error:
            if error.code == Code.WRONG_STATE.name.lower():
                status = self.status()
                if status.state in ("fault", "estop"):
                    raise RigFaultError(status.fault, status.fault_axis) from None
            raise


def _name(enum: type[State] | type[Fault], value: int) -> str:
    known = {member.value: member.name.lower() for member in enum}
    return known.get(value, f"number {value}")


def finite(argument: str, value: object, sizes: tuple[int, ...], units: str) -> FloatArray:
    """Return joint values or a target as an array of one of several lengths."""
    shapes = " or ".join(f"({size},)" for size in sizes)
    array = float_array(argument, value).copy()  # type: ignore[arg-type]
    if array.ndim != 1 or len(array) not in sizes:
        raise ArgumentError(argument, f"shape {array.shape}", f"shape {shapes}, {units}")
    if not np.isfinite(array).all():
        raise ArgumentError(argument, str(array.tolist()), f"finite numbers, {units}")
    return array


def within(name: str, value: float, low: float, high: float) -> None:
    """Refuse a joint value beyond its limits."""
    # Angles that went through a pulse and back have lost the last digits.
    if not low - 1e-9 <= value <= high + 1e-9:
        factor, unit = (
            (1000.0, "mm") if name in ("s10", "s21", "s32") else (180 / math.pi, "degrees")
        )
        received = f"{factor * value:.2f} {unit}"
        raise ArgumentError(name, received, f"{factor * low:.2f} to {factor * high:.2f} {unit}")
