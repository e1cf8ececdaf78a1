"""A word where numbers that should be radians look like degrees."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from .._warnings import warn
from ..errors import RobotWarning

__all__ = ["warn_of_degrees"]

_TURN = 2.0 * math.pi


def warn_of_degrees(
    robot: str,
    joints: Iterable[tuple[str, str, float, float]],
    twists: Sequence[float] = (),
    offsets: Sequence[float] = (),
) -> None:
    """Warn of angles that were hardly meant in radians.

    Parameters
    ----------
    robot : str
        What the robot is called.
    joints : iterable of (name, type, lower, upper)
        Limits that are whole or half numbers beyond two turns, such as 170, look like degrees.
    twists, offsets : sequence of float, rad
        alpha and theta of DH rows; more than a turn is never needed.
    """
    said = [
        f"{word} of row {row} is {value:g} rad, more than a turn"
        for word, values in (("alpha", twists), ("theta", offsets))
        for row, value in enumerate(values)
        if abs(value) > _TURN
    ]
    said += [
        f"joint {name!r} turns from {lower:g} to {upper:g} rad"
        for name, kind, lower, upper in joints
        if kind == "revolute" and (_looks_like_degrees(lower) or _looks_like_degrees(upper))
    ]
    if said:
        more = f" (and {len(said) - 1} more like it)" if len(said) > 1 else ""
        warn(f"{robot}: {said[0]}{more}: was it meant in degrees?", RobotWarning)


def _looks_like_degrees(limit: float) -> bool:
    return math.isfinite(limit) and 2.0 * _TURN < abs(limit) <= 7200.0 and (2.0 * limit) % 1 == 0.0
