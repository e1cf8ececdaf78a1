"""What can go wrong between a program and a rig."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..errors import AgrikError, Fault

__all__ = [
    "CalibrationError",
    "ClearanceError",
    "CommandRefusedError",
    "LinkError",
    "OutOfReachError",
    "RigError",
    "RigFaultError",
    "SimulatorError",
    "WrongDeviceError",
]


class RigError(AgrikError):
    """Base class of the errors of drivers.

    Examples
    --------
    >>> from agrik_fast.drivers import LinkError, RigError
    >>> issubclass(LinkError, RigError)
    True
    """


class LinkError(RigError):
    """The line is dead: no port, or no answer.

    Parameters
    ----------
    port : str
        Name of the port.
    reason : str
        What happened.

    Attributes
    ----------
    port, reason
        The parameters.

    Examples
    --------
    >>> from agrik_fast.drivers import LinkError, StrawberryRig
    >>> try:
    ...     StrawberryRig("/dev/no_such_port").connect()
    ... except LinkError as error:
    ...     print(error.port)
    /dev/no_such_port
    """

    port: str
    reason: str

    def __init__(self, port: str, reason: str) -> None:
        self.port = port
        self.reason = reason
        super().__init__(f"{port}: {reason}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.port, self.reason)


class WrongDeviceError(LinkError):
    """Something answers that is not the rig: other device, protocol version or board.

    Examples
    --------
    >>> from agrik_fast.drivers import Simulator, StrawberryRig, WrongDeviceError
    >>> try:
    ...     StrawberryRig(Simulator("tomato")).connect()
    ... except WrongDeviceError as error:
    ...     print(error.port)
    simulated
    """


class SimulatorError(RigError):
    """The simulated rig cannot be started, or ended.

    Examples
    --------
    >>> from agrik_fast.drivers import RigError, SimulatorError
    >>> issubclass(SimulatorError, RigError)
    True
    """


class CommandRefusedError(RigError):
    """The board refuses a command.

    Parameters
    ----------
    command : str
        What was asked.
    code : str
        The board's answer, a name of the protocol: ``out_of_limits``, ``not_homed``, ...

    Attributes
    ----------
    command, code
        The parameters.

    Examples
    --------
    >>> from agrik_fast.drivers import CommandRefusedError
    >>> error = CommandRefusedError("move", "not_homed")
    >>> error.command, error.code
    ('move', 'not_homed')
    """

    command: str
    code: str

    def __init__(self, command: str, code: str) -> None:
        self.command = command
        self.code = code
        super().__init__(f"the board refuses {command}: {code.replace('_', ' ')}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.command, self.code)


class RigFaultError(RigError):
    """The board stopped its motors; nothing moves before `clear`.

    Parameters
    ----------
    fault : str
        Name of the fault: ``stall``, ``link_timeout``, ``estop``, ...
    axis : str, optional
        Axis that it is about.

    Attributes
    ----------
    fault, axis
        The parameters.

    Examples
    --------
    >>> from agrik_fast.drivers import RigFaultError
    >>> error = RigFaultError("stall", "s10")
    >>> error.fault, error.axis
    ('stall', 's10')
    """

    fault: str
    axis: str | None

    def __init__(self, fault: str, axis: str | None = None) -> None:
        self.fault = fault
        self.axis = axis
        where = f" of axis {axis}" if axis else ""
        what = fault.replace("_", " ")
        super().__init__(f"the board reports {what}{where}; motors are off until it is cleared")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.fault, self.axis)


class ClearanceError(RigError, ValueError):
    """A way would touch something.

    Parameters
    ----------
    part, obstacle : str
        The pair: a part of the arm, and what it would touch.
    step : str
        On which step of the way.
    depth : float, m
        How far one would be in the other.

    Attributes
    ----------
    part, obstacle, step, depth
        The parameters.

    Examples
    --------
    >>> from agrik_fast.drivers import ClearanceError
    >>> error = ClearanceError("gripper", "bed", "z down", 0.004)
    >>> error.part, error.obstacle
    ('gripper', 'bed')
    """

    part: str
    obstacle: str
    step: str
    depth: float

    def __init__(self, part: str, obstacle: str, step: str, depth: float) -> None:
        self.part = part
        self.obstacle = obstacle
        self.step = step
        self.depth = depth
        super().__init__(
            f"{part} and {obstacle} would touch ({1000 * depth:.1f} mm deep) on the step {step}"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.part, self.obstacle, self.step, self.depth)


class OutOfReachError(RigError, ValueError):
    """No joint values bring the tool point to a target.

    Parameters
    ----------
    target : sequence of float, m
        The target.
    reason : str
        What is lacking.

    Attributes
    ----------
    target, reason
        The parameters.

    Examples
    --------
    >>> from agrik_fast.drivers import OutOfReachError, StrawberryRig
    >>> try:
    ...     StrawberryRig("loop://").solve([0.426, 2.0, -0.33])
    ... except OutOfReachError as error:
    ...     print(error.target)
    (0.426, 2.0, -0.33)
    """

    target: tuple[float, ...]
    reason: str

    def __init__(self, target: Iterable[float], reason: str) -> None:
        self.target = tuple(float(value) for value in target)
        self.reason = reason
        shown = ", ".join(f"{1000 * value:.1f}" for value in self.target)
        super().__init__(f"the target ({shown}) mm is out of reach: {reason}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.target, self.reason)


class CalibrationError(RigError, ValueError):
    """A calibration file cannot be used; carries every fault found in it.

    Parameters
    ----------
    file : str
        Name of the file.
    faults : iterable of (place, message)
        The faults.

    Attributes
    ----------
    file : str
        Name of the file.
    faults : tuple of Fault
        The faults.

    Examples
    --------
    >>> from agrik_fast.drivers import Calibration, CalibrationError
    >>> try:
    ...     Calibration.parse(b"rig = 1", "mine.toml")
    ... except CalibrationError as error:
    ...     print(len(error.faults) >= 1)
    True
    """

    file: str
    faults: tuple[Fault, ...]

    def __init__(self, file: str, faults: Iterable[tuple[str, str]]) -> None:
        self.file = file
        self.faults = tuple(Fault(place, message) for place, message in faults)
        count = len(self.faults)
        head = f"{file}: {count} fault{'' if count == 1 else 's'}"
        super().__init__("\n".join([head, *(f"  {fault}" for fault in self.faults)]))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.file, self.faults)
