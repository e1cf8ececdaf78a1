"""Made by tools/make_messages.py of firmware/messages.toml: change that, not this."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar

VERSION = 1
BAUD = 115200
PAYLOAD_MAX = 44
TIMEOUT_MS = 500
OFF_MS = 5000
WATCHDOG_MS = 250


class Board(IntEnum):
    """The kind of a board."""

    MEGA2560 = 1
    MEGA8 = 2


class State(IntEnum):
    """What a board is doing."""

    NOT_HOMED = 0
    IDLE = 1
    HOMING = 2
    MOVING = 3
    FAULT = 4
    ESTOP = 5


class Fault(IntEnum):
    """Why a board stopped."""

    NONE = 0
    LINK_TIMEOUT = 1
    STALL = 2
    FOLLOWING = 3
    LIMIT_SWITCH = 4
    SWITCH_NOT_FOUND = 5
    SWITCH_STUCK = 6
    ESTOP = 7
    WATCHDOG = 8
    ENCODER = 9


class Code(IntEnum):
    """A board's answer to a command."""

    OK = 0
    UNKNOWN = 1
    MALFORMED = 2
    WRONG_STATE = 3
    OUT_OF_LIMITS = 4
    NOT_HOMED = 5
    NOT_CONFIGURED = 6


class Reset(IntEnum):
    """What started a board."""

    POWER_ON = 0
    EXTERNAL = 1
    BROWN_OUT = 2
    WATCHDOG = 3


class Flags(IntEnum):
    """Bits of `Servos.flags`."""

    ENABLE = 1
    NEAR = 2


class Type(IntEnum):
    """What a frame says."""

    HELLO = 0x00
    PING = 0x01
    STATUS = 0x02
    MOVE = 0x10
    SERVO = 0x11
    STOP = 0x12
    HOME = 0x13
    CLEAR = 0x14
    CONFIGURE = 0x15
    HANG = 0x20
    SERVOS = 0x21
    IDENTITY = 0x80
    PONG = 0x81
    REPORT = 0x82
    ACK = 0x90


@dataclass(frozen=True, slots=True)
class Move:
    """Payload of `Type.MOVE`."""

    axis: int
    target: int
    speed: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<BiH")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(self.axis, self.target, self.speed)

    @classmethod
    def unpack(cls, payload: bytes) -> Move:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(values[0], values[1], values[2])


@dataclass(frozen=True, slots=True)
class Servo:
    """Payload of `Type.SERVO`."""

    index: int
    ticks: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<BH")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(self.index, self.ticks)

    @classmethod
    def unpack(cls, payload: bytes) -> Servo:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(values[0], values[1])


@dataclass(frozen=True, slots=True)
class Home:
    """Payload of `Type.HOME`."""

    mask: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<B")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(self.mask)

    @classmethod
    def unpack(cls, payload: bytes) -> Home:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(values[0])


@dataclass(frozen=True, slots=True)
class Configure:
    """Payload of `Type.CONFIGURE`."""

    axis: int
    lower: int
    upper: int
    acceleration: int
    fast: int
    slow: int
    clearance: int
    following: int
    settle: int
    kp: int
    ki: int
    kd: int
    kv: int
    friction: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<BiiHHHHHHHHHHH")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(
            self.axis,
            self.lower,
            self.upper,
            self.acceleration,
            self.fast,
            self.slow,
            self.clearance,
            self.following,
            self.settle,
            self.kp,
            self.ki,
            self.kd,
            self.kv,
            self.friction,
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Configure:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(
            values[0],
            values[1],
            values[2],
            values[3],
            values[4],
            values[5],
            values[6],
            values[7],
            values[8],
            values[9],
            values[10],
            values[11],
            values[12],
            values[13],
        )


@dataclass(frozen=True, slots=True)
class Servos:
    """Payload of `Type.SERVOS`."""

    flags: int
    shoulder: int
    elbow: int
    pan: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<BHHH")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(self.flags, self.shoulder, self.elbow, self.pan)

    @classmethod
    def unpack(cls, payload: bytes) -> Servos:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(values[0], values[1], values[2], values[3])


@dataclass(frozen=True, slots=True)
class Identity:
    """Payload of `Type.IDENTITY`."""

    version: int
    board: int
    build: bytes
    reset: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<BB8sB")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(self.version, self.board, self.build, self.reset)

    @classmethod
    def unpack(cls, payload: bytes) -> Identity:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(values[0], values[1], values[2], values[3])


@dataclass(frozen=True, slots=True)
class Report:
    """Payload of `Type.REPORT`."""

    state: int
    fault: int
    fault_axis: int
    switches: int
    homed: int
    busy: int
    lost_ticks: int
    position: tuple[int, int, int]
    output: tuple[int, int, int]
    servo: tuple[int, int, int, int]
    crc_errors: int
    frame_errors: int
    overruns: int
    skips: int
    clock: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<BBBBBBH3i3h4HHHBBI")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(
            self.state,
            self.fault,
            self.fault_axis,
            self.switches,
            self.homed,
            self.busy,
            self.lost_ticks,
            *self.position,
            *self.output,
            *self.servo,
            self.crc_errors,
            self.frame_errors,
            self.overruns,
            self.skips,
            self.clock,
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Report:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(
            values[0],
            values[1],
            values[2],
            values[3],
            values[4],
            values[5],
            values[6],
            values[7:10],
            values[10:13],
            values[13:17],
            values[17],
            values[18],
            values[19],
            values[20],
            values[21],
        )


@dataclass(frozen=True, slots=True)
class Ack:
    """Payload of `Type.ACK`."""

    code: int

    FORM: ClassVar[struct.Struct] = struct.Struct("<B")

    def pack(self) -> bytes:
        """Return the payload."""
        return self.FORM.pack(self.code)

    @classmethod
    def unpack(cls, payload: bytes) -> Ack:
        """Read a payload; `struct.error` for one of another length."""
        values = cls.FORM.unpack(payload)
        return cls(values[0])


REPLIES = {
    Type.HELLO: Type.IDENTITY,
    Type.PING: Type.PONG,
    Type.STATUS: Type.REPORT,
    Type.MOVE: Type.ACK,
    Type.SERVO: Type.ACK,
    Type.STOP: Type.ACK,
    Type.HOME: Type.ACK,
    Type.CLEAR: Type.ACK,
    Type.CONFIGURE: Type.ACK,
    Type.HANG: Type.ACK,
    Type.SERVOS: Type.ACK,
}
"""The type of the answer to each request."""
