"""The command ``agrik-fast solve``: its words, and errors in the same words."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal, cast

from .._checks import word
from ..collision import Scene
from ..errors import AgrikError, ArgumentError, UnknownNameError
from ..jobs import Progress, SolveRequest, Summary, faults_of, solve_file
from ..robot import PREFERENCES, Prefer
from ..solvers import Solver, load_gains
from ._options import together

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

# What the fields of `SolveRequest` are called on the command line.
_OPTIONS = {
    "task": "--task",
    "position_tolerance": "--tol",
    "orientation_tolerance": "--tol-rad",
    "tolerance_frame": "--tol-frame",
    "direction": "--direction",
    "mask": "--mask",
    "q0": "--q0",
    "base_link": "--base-link",
    "tip_link": "--tip-link",
    "tool": "--tool",
    "clear": "--clear",
    "scene": "--scene",
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


def parse_solver(option: str, text: str) -> Solver | str:
    """Return the solver that a gain file holds, with its usual start, or the name as it is.

    Raises
    ------
    AgrikError
        For a faulty file.
    """
    if Path(text).suffix.lower() not in (".toml", ".json"):
        return text
    return load_gains(text, as_tuned=False)


def parse_frame(option: str, text: str) -> Literal["base", "tool"]:
    """Return the frame of that name.

    Raises
    ------
    ArgumentError
        For other texts.
    """
    if text == "base":
        return "base"
    if text == "tool":
        return "tool"
    raise ArgumentError(option, repr(text), "base or tool")


def load_scene(path: Path | None, aim: str | None) -> Scene | None:
    """Return the scene of a file, aiming at one of its targets.

    Raises
    ------
    AgrikError
        For a faulty file, a target that it does not have, and one without a file.
    """
    if path is None:
        if aim is not None:
            raise ArgumentError("--aim", repr(aim), "--scene as well")
        return None
    try:
        return Scene.load(path).aiming_at(aim)
    except UnknownNameError:
        raise
    except ArgumentError as error:
        option = "--scene" if error.argument == "path" else error.argument
        raise ArgumentError(option, error.received, error.expected) from None


def parse_preference(option: str, text: str) -> Prefer:
    """Return the name of a preference.

    Raises
    ------
    UnknownNameError
        For any other name.
    """
    return cast("Prefer", word(option, text, PREFERENCES))


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
    if len(numbers) not in (1, 3):
        raise ArgumentError(option, repr(text), "one number, or three with commas between them")
    if len(numbers) == 1:
        return numbers[0]
    x, y, z = numbers
    return (x, y, z)


def solve_words(request: SolveRequest, progress: Progress) -> Summary:
    """Solve a file; an error names the option that its cause was given by."""
    try:
        return solve_file(request, progress)
    except AgrikError as error:
        raise together([in_options(each) for each in (error, *faults_of(request))]) from None


def unused(*, solver: str | None, seed: int, all_branches: bool) -> list[str]:
    """Return what was given and is not used, a line each."""
    if not all_branches:
        return []
    why = "is not used: --all-branches asks no solver"
    given = [f"--solver {solver}"] if solver is not None else []
    return [f"{option} {why}" for option in given + ([f"--seed {seed}"] if seed else [])]


def other_faults(request: SolveRequest) -> list[AgrikError]:
    """Return what is wrong with a request beside the options that cannot be read."""
    return [in_options(each) for each in faults_of(request)]


def in_options(error: AgrikError) -> AgrikError:
    """Return an error that names the option its cause was given by."""
    if isinstance(error, UnknownNameError) or not isinstance(error, ArgumentError):
        return error
    option = _OPTIONS.get(error.argument, error.argument)
    return ArgumentError(option, error.received, error.expected)
