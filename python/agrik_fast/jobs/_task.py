"""The task of a job, from what was asked and what the targets have."""

from __future__ import annotations

from typing import Literal, Protocol, TypeAlias

import numpy as np

from .._warnings import warn
from ..errors import ArgumentError, TargetWarning, UnknownNameError
from ..robot import Robot
from ..tasks import Axis, Masked, PositionFirst

_TURN = 2.0 * np.pi
Vector = tuple[float, float, float]
Near: TypeAlias = float | Vector
"""A tolerance: of the whole error, or axis by axis."""
JobTask: TypeAlias = str | Axis | Masked | PositionFirst
TASKS = ("position", "pose", "axis", "masked", "position-first")


class Asked(Protocol):
    """What `SolveRequest` and `SolveJob` have in common."""

    @property
    def task(self) -> str | None: ...
    @property
    def position_tolerance(self) -> Near: ...
    @property
    def orientation_tolerance(self) -> Near: ...
    @property
    def tolerance_frame(self) -> Literal["base", "tool"] | None: ...
    @property
    def tool_axis(self) -> Vector: ...
    @property
    def direction(self) -> Vector | None: ...
    @property
    def mask(self) -> tuple[float, ...] | None: ...
    @property
    def mask_frame(self) -> Literal["base", "tool"]: ...
    @property
    def q0(self) -> tuple[float, ...] | None: ...
    @property
    def seed(self) -> int: ...


def choose_task(asked: Asked, *, is_pose: bool) -> tuple[str, JobTask]:
    """Return the task's name and what `Robot.ik` gets for it.

    Raises
    ------
    ArgumentError
        For an unknown task, or one that needs orientations the targets do not have.
    """
    usual = "masked" if asked.mask is not None else "pose" if is_pose else "position"
    name = asked.task or usual
    if name not in TASKS:
        raise UnknownNameError("task", name, TASKS)
    if name in ("pose", "masked", "position-first") and not is_pose:
        expected = f"orientations for a {name} task"
        raise ArgumentError("task", "targets without orientation", expected)
    if (name == "masked") != (asked.mask is not None):
        got = "nothing" if asked.mask is None else f"task {name!r}"
        raise ArgumentError("mask", got, "six weights with the task 'masked'")
    if name != "axis" and asked.direction is not None:
        raise ArgumentError("direction", f"task '{name}'", "task 'axis'")
    if asked.mask is not None:
        return name, Masked(asked.mask, asked.mask_frame)  # type: ignore[arg-type]
    if name != "axis":
        return name, PositionFirst() if name == PositionFirst.name else name
    if asked.direction is None and not is_pose:
        raise ArgumentError("direction", "nothing", "one, as the targets are points")
    return name, Axis(tool_axis=asked.tool_axis, direction=asked.direction)


def check_gains(solver: object, task: str) -> None:
    """Refuse gains for points where whole poses are wanted, and the other way round."""
    for name in ("K", "B"):
        rows = getattr(solver, name, None)
        wanted = 3 if task == "position" else 6
        if rows is None or (columns := len(rows[0])) == wanted or columns not in (3, 6):
            continue
        kinds = {3: "points", 6: "whole poses"}
        received = f"gains for {kinds[columns]} ({name} has {columns} columns)"
        other = ", or the task 'position'" if columns == 3 else ""
        expected = f"gains for {kinds[wanted]}{other}"
        raise ArgumentError("solver", received, expected)


def check_tolerances(asked: Asked) -> None:
    """Refuse what `Robot.ik` would refuse, before a file is read."""
    for name in ("position_tolerance", "orientation_tolerance"):
        given = getattr(asked, name)
        each = given if isinstance(given, tuple) else (given,)
        free = len(each) == 3
        if len(each) not in (1, 3) or not all(
            isinstance(value, int | float) and value > 0.0 and (free or np.isfinite(value))
            for value in each
        ):
            expected = "a positive number, or three of which inf frees an axis"
            raise ArgumentError(name, repr(given), expected)
    frame: object = asked.tolerance_frame
    if frame not in (None, "base", "tool"):
        raise ArgumentError("tolerance_frame", repr(frame), "'base' or 'tool'")


def check_start(asked: Asked, robot: Robot) -> None:
    """Refuse start values of another count than the joints'; warn of what looks like degrees."""
    if asked.q0 is None:
        return
    if len(asked.q0) != robot.dof:
        count = len(asked.q0)
        received = "1 number" if count == 1 else f"{count} numbers"
        raise ArgumentError("q0", received, f"{robot.dof}, one a joint")
    for name, kind, value in zip(robot.joint_names, robot.joint_types, asked.q0, strict=True):
        if kind != "prismatic" and abs(value) > 2.0 * _TURN:
            warn(f"q0 is {value:g} rad for joint {name!r}: was it meant in degrees?", TargetWarning)
            return


def task_words(asked: Asked, task: str) -> dict[str, str]:
    """Return how results are made, as the metadata of their files has it."""
    values = {
        "position_tolerance_m": _words(asked.position_tolerance),
        "orientation_tolerance_rad": _words(asked.orientation_tolerance),
        "seed": str(asked.seed),
    }
    if asked.tolerance_frame is not None:
        values["tolerance_frame"] = asked.tolerance_frame
    if asked.q0 is not None:
        values["q0"] = _words(asked.q0)
    if asked.mask is not None:
        values["mask"] = f"{_words(asked.mask)} in the {asked.mask_frame}'s frame"
    if task == "axis":
        values["tool_axis"] = _words(asked.tool_axis)
        where = asked.direction
        values["direction"] = "the targets' own" if where is None else _words(where)
    return values


def solver_words(solver: object) -> str:
    """Return a solver as the metadata of results has it: its name, or all its settings."""
    return solver if isinstance(solver, str) else repr(solver)


def _words(numbers: float | tuple[float, ...]) -> str:
    return ",".join(map(repr, numbers)) if isinstance(numbers, tuple) else repr(numbers)
