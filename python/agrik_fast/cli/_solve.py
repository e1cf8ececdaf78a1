"""The command ``agrik-fast solve``: its words, and errors in the same words."""

from __future__ import annotations

import math
from typing import Literal

from ..errors import ArgumentError, UnknownNameError
from ..jobs import Progress, SolveRequest, Summary, solve_file

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

# What the fields of `SolveRequest` are called on the command line.
_OPTIONS = {
    "task": "--task",
    "position_tolerance": "--tol",
    "orientation_tolerance": "--tol-rad",
    "tolerance_frame": "--tol-frame",
    "direction": "--direction",
}


def parse_axis(option: str, text: str) -> tuple[float, float, float]:
    """Return the vector that "x", "-z" or "0,0.6,0.8" names.

    Raises
    ------
    ArgumentError
        For other texts and for a vector that is zero or not finite.
    """
    name = text.strip().lower()
    sign = -1.0 if name.startswith("-") else 1.0
    if name.lstrip("+-") in AXES and len(name) <= 2:
        x, y, z = AXES[name[-1]]
        return (sign * x + 0.0, sign * y + 0.0, sign * z + 0.0)
    try:
        x, y, z = (float(part) for part in name.split(","))
    except ValueError:
        raise ArgumentError(option, repr(text), "x, y, z, -x, -y, -z or three numbers") from None
    if not all(map(math.isfinite, (x, y, z))) or not any((x, y, z)):
        raise ArgumentError(option, repr(text), "a finite vector that is not zero")
    return (x, y, z)


def parse_tolerance(option: str, text: str) -> float | tuple[float, float, float]:
    """Return the number that "1e-3" names, or the three of "1e-3,1e-3,inf".

    Raises
    ------
    ArgumentError
        For other texts.
    """
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        return numbers[0]
    if len(numbers) != 3:
        raise ArgumentError(option, repr(text), "one number, or three with commas between them")
    x, y, z = numbers
    return (x, y, z)


def parse_frame(text: str | None) -> Literal["base", "tool"] | None:
    """Return the frame of that name.

    Raises
    ------
    ArgumentError
        For other texts.
    """
    if text is None:
        return None
    if text == "base":
        return "base"
    if text == "tool":
        return "tool"
    raise ArgumentError("--tol-frame", repr(text), "base or tool")


def solve_words(request: SolveRequest, progress: Progress) -> Summary:
    """Solve a file; an error names the option that its cause was given by."""
    try:
        return solve_file(request, progress)
    except UnknownNameError:
        raise
    except ArgumentError as error:
        option = _OPTIONS.get(error.argument, error.argument)
        raise ArgumentError(option, error.received, error.expected) from None
