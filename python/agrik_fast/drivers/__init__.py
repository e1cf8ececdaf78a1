"""Drivers of the strawberry and the tomato rig over a serial line (extra ``drivers``).

Boards, wiring and calibration are described in ``docs/hardware.md``. ``port="simulated"`` runs
the boards' own programs in a simulator, wired to a simulated plant.
"""

from ._calibration import AxisCalibration, Calibration, GripperCalibration, ServoCalibration
from ._clearance import Surroundings
from ._errors import (
    CalibrationError,
    ClearanceError,
    CommandRefusedError,
    LinkError,
    OutOfReachError,
    RigError,
    RigFaultError,
    SimulatorError,
    WrongDeviceError,
)
from ._link import Link, LinkStatistics
from ._lockstep import LockstepCamera
from ._pointing import PointingLoop, PointingStep
from ._rig import RigStatus
from ._runs import Arrival, Run
from ._simulator import Simulator
from ._strawberry import StrawberryRig
from ._tomato import TomatoRig
from ._transport import SerialTransport, Transport

__all__ = [
    "Arrival",
    "AxisCalibration",
    "Calibration",
    "CalibrationError",
    "ClearanceError",
    "CommandRefusedError",
    "GripperCalibration",
    "Link",
    "LinkError",
    "LinkStatistics",
    "LockstepCamera",
    "OutOfReachError",
    "PointingLoop",
    "PointingStep",
    "RigError",
    "RigFaultError",
    "RigStatus",
    "Run",
    "SerialTransport",
    "ServoCalibration",
    "Simulator",
    "SimulatorError",
    "StrawberryRig",
    "Surroundings",
    "TomatoRig",
    "Transport",
    "WrongDeviceError",
]
