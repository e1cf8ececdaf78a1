"""The task of a job, from what was asked and what the targets have."""

from __future__ import annotations

from typing import Protocol

from ..errors import ArgumentError, UnknownNameError
from ..tasks import Axis

Vector = tuple[float, float, float]
TASKS = ("position", "pose", "axis")


class Asked(Protocol):
    """What `SolveRequest` and `SolveJob` have in common."""

    @property
    def task(self) -> str | None: ...
    @property
    def position_tolerance(self) -> float: ...
    @property
    def orientation_tolerance(self) -> float: ...
    @property
    def tool_axis(self) -> Vector: ...
    @property
    def direction(self) -> Vector | None: ...
    @property
    def seed(self) -> int: ...


def choose_task(asked: Asked, *, is_pose: bool) -> tuple[str, str | Axis]:
    """Return the task's name and what `Robot.ik` gets for it.

    Raises
    ------
    ArgumentError
        For an unknown task, or one that needs orientations the targets do not have.
    """
    name = asked.task or ("pose" if is_pose else "position")
    if name not in TASKS:
        raise UnknownNameError("task", name, TASKS)
    if name == "pose" and not is_pose:
        raise ArgumentError("task", "targets without orientation", "orientations for a pose task")
    if name != "axis":
        if asked.direction is not None:
            raise ArgumentError("direction", f"task '{name}'", "task 'axis'")
        return name, name
    if asked.direction is None and not is_pose:
        raise ArgumentError("direction", "nothing", "one, as the targets are points")
    return name, Axis(tool_axis=asked.tool_axis, direction=asked.direction)


def task_words(asked: Asked, task: str) -> dict[str, str]:
    """Return how results are made, as the metadata of their files has it."""
    values = {
        "position_tolerance_m": repr(asked.position_tolerance),
        "orientation_tolerance_rad": repr(asked.orientation_tolerance),
        "seed": str(asked.seed),
    }
    if task == "axis":
        values["tool_axis"] = _words(asked.tool_axis)
        where = asked.direction
        values["direction"] = "the targets' own" if where is None else _words(where)
    return values


def _words(vector: Vector) -> str:
    return ",".join(map(repr, vector))
