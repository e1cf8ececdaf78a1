"""Holding torques of the tomato pointing arm, and what its servos have to spare.

(1) to (4) of Kviesis and Osadcuks, with both links free to balance off their middle;
``docs/papers/tomato.md`` has the derivation and where the servos' data are from.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from .._checks import real_number
from ..errors import ArgumentError

__all__ = ["HD_6001HB", "HS_311", "Load", "Servo", "Torques", "holding_torques"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """A hobby servo.

    Parameters
    ----------
    name : str
        Type.
    torque : float, N m
        Stall torque at its usual voltage.
    mass : float, kg
        Mass.
    speed : float, rad/s
        Without load.
    source : str
        Where the numbers are from.

    Raises
    ------
    ArgumentError
        A number is out of its range.

    Examples
    --------
    >>> from agrik_fast.arms import Servo
    >>> Servo(name="S", torque=1.2, mass=0.06, speed=5.2, source="data sheet").torque
    1.2
    """

    name: str
    torque: float
    mass: float
    speed: float
    source: str

    def __post_init__(self) -> None:
        for name, unit in (("torque", "N m"), ("mass", "kg"), ("speed", "rad/s")):
            real_number(f"Servo.{name}", getattr(self, name), 0, open_low=True, unit=unit)


HS_311 = Servo(
    name="HS-311",
    torque=0.294,
    mass=0.043,
    speed=math.radians(60) / 0.19,
    source="3.0 kg cm and 0.19 s per 60 degrees at 4.8 V, found in a forum quote",
)
"""Pan: no gravity load."""

HD_6001HB = Servo(
    name="HD-6001HB",
    torque=0.57,
    mass=0.043,
    speed=math.radians(60) / 0.16,
    source="5.8 kg cm at 4.8 V, from memory, unverified; the speed is an assumption",
)
"""Shoulder and elbow."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Load:
    """Masses of the arm (kg) and where its links balance.

    Parameters
    ----------
    link1, link2 : float, default 0.032, kg
        Links.
    motor : float, default 0.043, kg
        Elbow servo, at the end of link 1.
    payload : float, default 0.05, kg
        What hangs on the tool point.
    balance1, balance2 : float, default 0.5
        Centre of mass of a link from its own joint, as a share of its length; negative
        with a counterweight.
    a1, a2 : float, optional, m
        The same as a distance, the a of (3), in place of the share.

    Raises
    ------
    ArgumentError
        A mass is negative, or a number is not finite.

    Examples
    --------
    >>> from agrik_fast.arms import Load
    >>> Load(payload=0.2).motor
    0.043
    """

    link1: float = 0.032
    link2: float = 0.032
    motor: float = 0.043
    payload: float = 0.05
    balance1: float = 0.5
    balance2: float = 0.5
    a1: float | None = None
    a2: float | None = None

    def __post_init__(self) -> None:
        for name in ("link1", "link2", "motor", "payload"):
            real_number(f"Load.{name}", getattr(self, name), 0, unit="kg")
        for name in ("balance1", "balance2"):
            real_number(f"Load.{name}", getattr(self, name))
        for name in ("a1", "a2"):
            if getattr(self, name) is not None:
                real_number(f"Load.{name}", getattr(self, name), unit="m")

    def centres(self, l1: float, l2: float) -> tuple[float, float]:
        """Return how far the links' centres of mass are from their own joints, m."""
        a1 = self.balance1 * l1 if self.a1 is None else self.a1
        a2 = self.balance2 * l2 if self.a2 is None else self.a2
        return a1, a2


class Torques(NamedTuple):
    """Holding torques, N m, and what the servos have to spare.

    Attributes
    ----------
    shoulder, elbow : float, N m
        Torques against gravity.
    shoulder_factor, elbow_factor : float
        Servo torque over holding torque.
    enough : bool
        Both factors reach the wanted one.

    Examples
    --------
    >>> from agrik_fast.arms import holding_torques
    >>> torques = holding_torques()
    >>> torques.enough, round(torques.shoulder_factor, 1)
    (True, 1.8)
    """

    shoulder: float
    elbow: float
    shoulder_factor: float
    elbow_factor: float
    enough: bool


def holding_torques(
    l1: float = 0.16,
    l2: float = 0.16,
    load: Load | None = None,
    *,
    phi1: float = 0.0,
    phi2: float = 0.0,
    shoulder: Servo = HD_6001HB,
    elbow: Servo = HD_6001HB,
    safety_factor: float = 1.7,
    gravity: float = 9.80665,
) -> Torques:
    """Return the torques that hold the arm, (1)-(4), and the servos' safety factors.

    The paper's (3) lets only link 1 balance elsewhere than in its middle; here both may.
    Stretched out level (the default pose) the torques are largest.

    Parameters
    ----------
    l1, l2 : float, default 0.16, m
        Link lengths.
    load : Load, optional
        Masses.
    phi1, phi2 : float, default 0.0, rad
        Pose.
    shoulder, elbow : Servo
        Servos.
    safety_factor : float, default 1.7
        Wanted ratio of servo torque to holding torque.
    gravity : float, default 9.80665, m/s^2
        Gravity.

    Returns
    -------
    Torques
        Torques and factors.

    Raises
    ------
    ArgumentError
        A wrong type, or a number out of its range.

    Examples
    --------
    >>> from agrik_fast.arms import Load, holding_torques
    >>> torques = holding_torques(load=Load(payload=0.1))
    >>> torques.shoulder > torques.elbow
    True
    """
    load = Load() if load is None else load
    for name, part, kind in (
        ("load", load, Load),
        ("shoulder", shoulder, Servo),
        ("elbow", elbow, Servo),
    ):
        if not isinstance(part, kind):
            raise ArgumentError(name, repr(part), f"a {kind.__name__}")
    for name, value in (("l1", l1), ("l2", l2), ("safety_factor", safety_factor)):
        real_number(name, value, 0, open_low=True)
    real_number("gravity", gravity, 0, unit="m/s^2")
    for name, value in (("phi1", phi1), ("phi2", phi2)):
        real_number(name, value, unit="rad")
    a1, a2 = load.centres(l1, l2)
    outer = a2 * load.link2 + l2 * load.payload
    inner = a1 * load.link1 + l1 * (load.motor + load.link2 + load.payload)
    elbow_torque = gravity * outer * math.cos(phi1 + phi2)
    shoulder_torque = gravity * inner * math.cos(phi1) + elbow_torque
    factors = [
        servo.torque / abs(torque) if torque else math.inf
        for servo, torque in ((shoulder, shoulder_torque), (elbow, elbow_torque))
    ]
    enough = min(factors) >= safety_factor
    return Torques(shoulder_torque, elbow_torque, factors[0], factors[1], enough)
