"""Calibration files: what a rig's numbers are, and where each is from.

A TOML file with ``[rig]``, ``[[axis]]``, ``[[servo]]`` and ``[gripper]``. Every number of a table
has an entry of the same name in its ``source``. A servo is measured at several pulses; the line
through them is refused where a point is more than a degree off.
"""

from __future__ import annotations

import math
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from .._files import decode, parse_toml, read_bytes, shown
from ..errors import ArgumentError
from ._errors import CalibrationError
from ._messages import Configure

__all__ = ["AxisCalibration", "Calibration", "GripperCalibration", "ServoCalibration"]

BUNDLED = ("strawberry", "tomato")
LARGEST_RESIDUAL_DEG = 1.0
"""How far a measured angle may be from the line through all of them."""
TICKS_PER_US = 2

_Positive = Annotated[FiniteFloat, Field(gt=0)]
_NotNegative = Annotated[FiniteFloat, Field(ge=0)]
_Pulse = Annotated[FiniteFloat, Field(ge=400, le=2600)]
_Name = Annotated[str, Field(min_length=1, max_length=60)]


class _Table(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    source: dict[str, str] = {}
    """Where each number is from, by its key."""

    @model_validator(mode="after")
    def _every_number_has_a_source(self) -> Self:
        numbers = {
            name
            for name, field in type(self).model_fields.items()
            if name not in ("source", "name", "kind", "index", "board", "format")
            and getattr(self, name) != field.default
        }
        missing = [name for name in numbers if not self.source.get(name, "").strip()]
        if missing:
            raise ValueError(f"no source is given for {', '.join(sorted(missing))}")
        unknown = set(self.source) - set(type(self).model_fields)
        if unknown:
            raise ValueError(f"a source for {', '.join(sorted(unknown))}, which is no key")
        return self


class RigTable(BaseModel):
    """Which rig a file is about."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    format: Literal[1]
    """Version of this form: 1."""
    name: Literal["strawberry", "tomato"]
    """The rig."""
    board: Literal["mega2560", "mega8"]
    """Its board."""


class AxisCalibration(_Table):
    """A slide: encoder, limits, speeds and control. PWM is 0 to 799.

    Examples
    --------
    >>> from agrik_fast.drivers import Calibration
    >>> axis = Calibration.load("strawberry").axis[0]
    >>> axis.name, axis.home_mm < axis.upper_mm
    ('s10', True)
    """

    name: _Name
    """The joint's."""
    counts_per_mm: _Positive
    """Encoder counts a millimetre of the carriage, four a cycle."""
    home_mm: FiniteFloat
    """The joint's value at home, mm."""
    lower_mm: FiniteFloat
    """Smallest value, mm."""
    upper_mm: FiniteFloat
    """Largest value, mm."""
    backlash_mm: _NotNegative
    """Play between motor and carriage, mm."""
    speed_mm_s: _Positive
    """Usual speed, mm/s."""
    acceleration_mm_s2: _Positive
    """Acceleration, mm/s^2."""
    home_fast_mm_s: _Positive
    """Speed towards the switch, mm/s."""
    home_slow_mm_s: _Positive
    """Speed of the second touch, mm/s."""
    clearance_mm: _Positive
    """How far home is from where the switch opens, mm."""
    following_mm: _Positive
    """Largest lag behind the command, mm."""
    settle_mm: _Positive
    """A slide this near its target has arrived, mm."""
    kp: _NotNegative
    """PWM a millimetre of lag."""
    ki: _NotNegative
    """PWM a millimetre and second of lag."""
    kd: _NotNegative
    """PWM a mm/s of lag in speed."""
    kv: _NotNegative
    """PWM a mm/s of commanded speed."""
    friction: _NotNegative
    """PWM that just keeps the slide moving."""

    @model_validator(mode="after")
    def _limits_hold_home(self) -> Self:
        if not self.lower_mm <= self.home_mm <= self.upper_mm:
            raise ValueError(
                f"home {self.home_mm:g} mm is not within {self.lower_mm:g} to {self.upper_mm:g} mm"
            )
        return self

    def counts(self, mm: float) -> int:
        """Return a length in counts.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> axis = Calibration.load("strawberry").axis[0]
        >>> axis.counts(10.0) == round(10.0 * axis.counts_per_mm)
        True
        """
        return round(mm * self.counts_per_mm)

    def target(self, value_mm: float, at: int) -> int:
        """Return the count that brings the carriage to a value, from where the motor is.

        The motor first takes up the play: on the way up it goes that much further.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> axis = Calibration.load("strawberry").axis[0]
        >>> axis.target(200.0, at=0) > axis.target(100.0, at=0)
        True
        """
        down = self.counts(value_mm - self.home_mm)
        up = down + self.counts(self.backlash_mm)
        # Within the play the carriage is where it should be already.
        return up if up > at else min(down, at)

    def value_mm(self, count: int, upward: bool) -> float:
        """Return the joint's value at a count, given which way the motor went last.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> axis = Calibration.load("strawberry").axis[0]
        >>> abs(axis.value_mm(axis.target(200.0, at=0), upward=True) - 200.0) < 0.1
        True
        """
        play = self.backlash_mm if upward else 0.0
        return self.home_mm + count / self.counts_per_mm - play

    def configure(self, index: int) -> Configure:
        """Return the message that tells a board about this axis.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> type(Calibration.load("strawberry").axis[0].configure(0)).__name__
        'Configure'
        """
        per_count = 1.0 / self.counts_per_mm
        low, high = self.lower_mm - self.home_mm, self.upper_mm - self.home_mm
        words = {
            "acceleration": self.acceleration_mm_s2 * self.counts_per_mm / 16,
            "fast": self.home_fast_mm_s * self.counts_per_mm,
            "slow": self.home_slow_mm_s * self.counts_per_mm,
            "clearance": self.clearance_mm * self.counts_per_mm,
            "following": self.following_mm * self.counts_per_mm,
            "settle": max(self.settle_mm * self.counts_per_mm, 1.0),
            "kp": self.kp * per_count * 2**8,
            "ki": self.ki * per_count / 1000 * 2**16,
            "kd": self.kd * per_count * 1000 * 2**4,
            "kv": self.kv * per_count * 1000 * 2**4,
            "friction": self.friction,
        }
        for name, value in words.items():
            if not round(value) < 1 << 16:
                raise ValueError(f"{name} is too large for the board: {value:.0f} of 65535")
        return Configure(
            axis=index,
            lower=self.counts(low),
            upper=self.counts(high) + self.counts(self.backlash_mm),
            **{name: round(value) for name, value in words.items()},
        )

    @model_validator(mode="after")
    def _fits_the_board(self) -> Self:
        self.configure(0)
        if not self.speed_mm_s * self.counts_per_mm < 1 << 16:
            raise ValueError(
                f"speed_mm_s {self.speed_mm_s:g} is more than 65535 counts/s, the board's most"
            )
        return self


class ServoCalibration(_Table):
    """A servo: measured angles at several pulses.

    Examples
    --------
    >>> from agrik_fast.drivers import Calibration
    >>> servo = Calibration.load("strawberry").servo[0]
    >>> len(servo.pulses_us) == len(servo.angles_deg)
    True
    """

    name: _Name
    """The joint's."""
    kind: _Name
    """Type of the servo."""
    index: Annotated[int, Field(ge=0, le=3)]
    """Its output of the board."""
    pulses_us: Annotated[list[_Pulse], Field(min_length=3, max_length=50)]
    """Pulses that were sent, us."""
    angles_deg: Annotated[list[FiniteFloat], Field(min_length=3, max_length=50)]
    """Angles that were measured, degrees."""
    lower_us: _Pulse
    """Shortest pulse that may be sent, us."""
    upper_us: _Pulse
    """Longest pulse, us."""
    deg_per_s: _Positive
    """Speed without load, degrees/s."""

    @cached_property
    def line(self) -> tuple[float, float]:
        """Pulse at zero, us, and us a degree: the straight line of least squares.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> middle, slope = Calibration.load("strawberry").servo[0].line
        >>> 400 < middle < 2600, slope != 0
        (True, True)
        """
        angles, pulses = np.array(self.angles_deg), np.array(self.pulses_us)
        slope = float(np.polyfit(angles, pulses, 1)[0])
        return float(pulses.mean() - slope * angles.mean()), slope

    @model_validator(mode="after")
    def _is_a_line(self) -> Self:
        if len(self.pulses_us) != len(self.angles_deg):
            raise ValueError(f"{len(self.pulses_us)} pulses, but {len(self.angles_deg)} angles")
        if len(set(self.angles_deg)) < 2 or len(set(self.pulses_us)) < 2:
            raise ValueError("needs measurements at different pulses, with different angles")
        zero, slope = self.line
        if abs(slope) < 1.0:
            raise ValueError(f"{slope:.3f} us a degree is no servo, expected 1 or more")
        off = [
            (abs((pulse - zero) / slope - angle), pulse)
            for pulse, angle in zip(self.pulses_us, self.angles_deg, strict=True)
        ]
        worst, pulse = max(off)
        if worst > LARGEST_RESIDUAL_DEG:
            raise ValueError(
                f"the angle at {pulse:g} us is {worst:.2f} degrees off the line through all of "
                f"them, at most {LARGEST_RESIDUAL_DEG:g} is allowed: measure again"
            )
        if self.lower_us >= self.upper_us:
            raise ValueError(f"lower_us {self.lower_us:g} is not below upper_us {self.upper_us:g}")
        return self

    def ticks(self, angle: float) -> int:
        """Return the pulse for an angle (rad) in the board's half microseconds.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> servo = Calibration.load("strawberry").servo[0]
        >>> isinstance(servo.ticks(0.2), int)
        True
        """
        zero, slope = self.line
        return round(TICKS_PER_US * (zero + slope * math.degrees(angle)))

    def angle(self, ticks: int) -> float:
        """Return the angle (rad) of a pulse in half microseconds.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> servo = Calibration.load("strawberry").servo[0]
        >>> abs(servo.angle(servo.ticks(0.2)) - 0.2) < 0.002
        True
        """
        zero, slope = self.line
        return math.radians((ticks / TICKS_PER_US - zero) / slope)

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest angle that the pulses allow, rad."""
        zero, slope = self.line
        ends = sorted(math.radians((us - zero) / slope) for us in (self.lower_us, self.upper_us))
        return ends[0], ends[1]

    @property
    def rate(self) -> float:
        """Speed without load, rad/s."""
        return math.radians(self.deg_per_s)


class GripperCalibration(_Table):
    """The gripper's servo: two pulses.

    Examples
    --------
    >>> from agrik_fast.drivers import Calibration
    >>> gripper = Calibration.load("strawberry").gripper
    >>> gripper.open_us != gripper.closed_us
    True
    """

    index: Annotated[int, Field(ge=0, le=3)]
    """Its output of the board."""
    open_us: _Pulse
    """Pulse that opens it, us."""
    closed_us: _Pulse
    """Pulse that closes it, us."""
    seconds: _Positive
    """How long either takes, s."""


class Calibration(BaseModel):
    """A calibration file's content.

    Examples
    --------
    >>> from agrik_fast.drivers import Calibration
    >>> rig = Calibration.load("strawberry")
    >>> [axis.name for axis in rig.axis], rig.axis[0].counts_per_mm
    (['s10', 's21', 's32'], 107.37)
    """

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    rig: RigTable
    """Which rig it is about."""
    axis: list[AxisCalibration] = []
    """Slides, in the order of the joints."""
    servo: list[ServoCalibration]
    """Servos, in the order of the joints."""
    gripper: GripperCalibration | None = None
    """The gripper, if there is one."""

    @model_validator(mode="after")
    def _is_the_rig(self) -> Self:
        axes = [axis.name for axis in self.axis]
        servos = [servo.name for servo in self.servo]
        expected = {
            "strawberry": ("mega2560", ["s10", "s21", "s32"], ["theta", "beta", "psi"], True),
            "tomato": ("mega8", [], ["shoulder", "elbow", "pan"], False),
        }[self.rig.name]
        found = (self.rig.board, axes, servos, self.gripper is not None)
        if found != expected:
            words = ("board {}, axes {}, servos {}, " + "{} gripper").format
            told = (
                words(b, ", ".join(a) or "none", ", ".join(s) or "none", "a" if g else "no")
                for b, a, s, g in (expected, found)
            )
            raise ValueError(f"a {self.rig.name} rig has {next(told)}; here are {next(told)}")
        indices = [servo.index for servo in self.servo]
        indices += [self.gripper.index] if self.gripper else []
        if len(set(indices)) != len(indices):
            raise ValueError(f"two servos have the same index: {indices}")
        return self

    @classmethod
    def load(cls, source: str | Path, rig: str | None = None) -> Self:
        """Read a calibration file.

        Parameters
        ----------
        source : str or path
            A file, or the name of a bundled one: ``"strawberry"``, ``"tomato"``.
        rig : str, optional
            The rig that it should be about.

        Raises
        ------
        CalibrationError
            With every fault of the file and its place; also if it is about another rig.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration
        >>> calibration = Calibration.load("strawberry")
        >>> [axis.name for axis in calibration.axis]
        ['s10', 's21', 's32']
        """
        if not isinstance(source, str | Path):
            raise ArgumentError("calibration", shown(source), "a file or the name of a bundled one")
        if source in BUNDLED:
            name = f"{source}.toml"
            data = (resources.files(__package__) / "bundled" / name).read_bytes()
        else:
            name = Path(source).name
            data = read_bytes(Path(source), lambda reason: CalibrationError(name, [("", reason)]))
        found = cls.parse(data, name)
        if rig is not None and found.rig.name != rig:
            fault = f"a calibration of the {found.rig.name} rig, expected one of the {rig} rig"
            raise CalibrationError(name, [("[rig], name", fault)])
        return found

    @classmethod
    def parse(cls, data: bytes, name: str) -> Self:
        """Check the content of a file; `name` is used in messages only.

        Examples
        --------
        >>> from agrik_fast.drivers import Calibration, CalibrationError
        >>> try:
        ...     Calibration.parse(b"rig = 1", "mine.toml")
        ... except CalibrationError as error:
        ...     print(error.file)
        mine.toml
        """

        def refuse(reason: str) -> CalibrationError:
            return CalibrationError(name, [("", reason)])

        raw = parse_toml(decode(data, refuse), refuse)
        try:
            return cls.model_validate(raw)
        except ValidationError as error:
            faults = [
                (_place(item["loc"]), _message(item))
                for item in error.errors(include_url=False, include_context=False)
            ]
            raise CalibrationError(name, faults) from None


def _place(loc: tuple[int | str, ...]) -> str:
    if len(loc) > 1 and isinstance(loc[1], int):
        place, keys = f"[[{loc[0]}]] row {loc[1] + 1}", loc[2:]
    elif loc:
        place, keys = f"[{loc[0]}]", loc[1:]
    else:
        return ""
    key = ".".join(str(part) for part in keys)
    return f"{place}, {key}" if key else place


def _message(item: Any) -> str:
    message = str(item["msg"]).removeprefix("Value error, ")
    if item["type"] == "missing":
        return "missing"
    if item["type"] == "extra_forbidden":
        return "unknown key"
    if item["type"] == "value_error":
        return message
    return f"{message[0].lower()}{message[1:]}, got {shown(item['input'])}"
