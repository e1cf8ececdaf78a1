"""What became of a target, in words that a person reads beside the picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._checks import FloatArray
from ..result import Status

# Relative to a joint's range: as near as this to a limit is at it.
_AT_LIMIT = 1e-6
_WORDS = {
    Status.OUT_OF_REACH: "UNREACHABLE",
    Status.NOT_FOUND: "ITERATION_CAP",
    Status.IN_COLLISION: "COLLISION",
    Status.JOINT_LIMITS: "LIMIT",
}


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of a target.

    Attributes
    ----------
    reached : bool
        A posture was found that holds.
    status : Status
        As `Robot.ik` gave it.
    q : ndarray, shape (n,), rad or m
        The posture, or the nearest one found.
    seconds : float, s
        What the call took.
    iterations : int
    position_error, orientation_error : float, m, rad
    pair : tuple of str
        What is nearest to what, where collisions count; empty names for nothing.
    clearance : float, m
        How near; infinite where nothing is.
    headline : str
        One line on it.
    """

    reached: bool
    status: Status
    q: FloatArray
    seconds: float
    iterations: int
    position_error: float
    orientation_error: float
    pair: tuple[str, str]
    clearance: float
    headline: str

    @property
    def hits(self) -> bool:
        """Whether the posture hits something."""
        return self.clearance <= 0.0

    @property
    def good(self) -> bool:
        """Reached, and free of collisions."""
        return self.reached and not self.hits

    @property
    def nearness(self) -> str:
        """What is said of collisions; empty where nothing is near, or nothing is known."""
        if not self.pair[0] or not np.isfinite(self.clearance):
            return ""
        first, second = self.pair
        if self.hits:
            return f"COLLISION: {first} hits {second}"
        return f"clearance {1000 * self.clearance:.0f} mm: {first} and {second}"


def length(metres: float) -> str:
    """Return a length in words, in a unit that suits it."""
    if metres >= 1.0:
        return f"{metres:.2f} m"
    if metres >= 1e-2:
        return f"{100 * metres:.1f} cm"
    if metres >= 1e-4:
        return f"{1000 * metres:.1f} mm"
    return f"{metres:.0e} m" if metres else "0 m"


def joints_at_limits(
    names: Sequence[str], q: FloatArray, lower: FloatArray, upper: FloatArray
) -> list[tuple[str, str]]:
    """Return the joints that are at a limit, each with "lower" or "upper"."""
    found = []
    for name, value, low, high in zip(names, q, lower, upper, strict=True):
        if not (np.isfinite(low) and np.isfinite(high)):
            continue
        if value - low <= _AT_LIMIT * (high - low):
            found.append((name, "lower"))
        elif high - value <= _AT_LIMIT * (high - low):
            found.append((name, "upper"))
    return found


def headline(
    status: Status,
    *,
    seconds: float,
    iterations: int,
    position_error: float,
    orientation_error: float,
    at_limits: Sequence[tuple[str, str]],
    pair: tuple[str, str],
    beyond: float,
) -> str:
    """Return one line on what became of a target.

    Parameters
    ----------
    status : Status
    seconds : float, s
    iterations : int
    position_error, orientation_error : float, m, rad
        Of the nearest posture.
    at_limits : sequence of (joint, end)
        Joints that are at a limit there.
    pair : (str, str)
        What is nearest to what.
    beyond : float, m
        How far the target is out of the ball that the arm can reach; 0 or less inside.
    """
    if status == Status.CONVERGED:
        steps = f"{iterations} iteration{'' if iterations == 1 else 's'}"
        return f"CONVERGED  {1000 * seconds:.1f} ms  {steps}  {length(position_error)}"
    if status == Status.OUT_OF_REACH and beyond > 0.0:
        return f"UNREACHABLE: {length(position_error)} beyond reach"
    if status == Status.IN_COLLISION:
        return f"COLLISION: {pair[0]} hits {pair[1]} in every posture found"
    parts = [length(position_error)] if position_error > 1e-6 or orientation_error <= 1e-6 else []
    if orientation_error > 1e-6:
        parts.append(f"{np.degrees(orientation_error):.1f}°")
    off = f"nearest posture {' and '.join(parts)} away"
    if at_limits and status in (Status.NOT_FOUND, Status.OUT_OF_REACH, Status.JOINT_LIMITS):
        names = " and ".join(f"{name} at its {end} limit" for name, end in at_limits[:2])
        return f"LIMIT: {names}, {off}"
    word = _WORDS.get(status, status.name)
    if status == Status.NOT_FOUND:
        return f"{word}: {off} after {iterations} iterations"
    return f"{word}: {off}"
