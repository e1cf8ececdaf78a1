"""Targets from a file, solved in pieces, results to a file."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .._native import __version__
from ..errors import ArgumentError, UnknownNameError
from ..io import (
    ResultChunk,
    ResultFileError,
    ResultLayout,
    TargetReader,
    check_result_path,
    open_results,
    read_targets,
)
from ..result import IkResult
from ..robot import Robot
from ..tasks import Axis, PositionFirst
from ._pipeline import Pipeline, Solve
from ._progress import Progress, Silent
from ._summary import Summary

# Rows that are written in one go, fewer where ids are long; a Parquet file gets a row group
# of them.
WRITE_ROWS = 65_536
WRITE_ID_BYTES = 32 << 20
Vector = tuple[float, float, float]
TASKS = ("position", "pose", "axis", "position-first")


@dataclass(frozen=True)
class SolveRequest:
    """What `solve_file` is asked for.

    Attributes
    ----------
    robot : str
        Bundled name or path.
    targets, output : Path
        Files, whose kinds follow from their suffixes.
    task : {"position", "pose", "axis", "position-first"}, optional
        None: pose if the targets have orientations.
    solver : str
        A solver's name, see `Robot.ik`.
    position_tolerance : float or tuple of 3 float, m
        Largest distance between tool point and target, or along each axis; above 0, as for
        `Robot.ik`.
    orientation_tolerance : float or tuple of 3 float, rad
        Largest angle between tool and target orientation, or about each axis; above 0.
    tolerance_frame : {"base", "tool"}, optional
        Whose axes these are; None: the base's.
    tool_axis : tuple of 3 float
        Axis task: the axis, in the tool frame.
    direction : tuple of 3 float, optional
        Axis task: where it points, in the base frame; None: along the targets' own tool axis.
    seed : int
        Seed of the restarts.
    threads : int, optional
        Number of threads, as for `Robot.ik`.
    force : bool
        Replace an existing result.
    """

    robot: str
    targets: Path
    output: Path
    task: str | None = None
    solver: str = "lm"
    position_tolerance: float | Vector = 1e-6
    orientation_tolerance: float | Vector = 1e-6
    tolerance_frame: Literal["base", "tool"] | None = None
    tool_axis: Vector = (0.0, 0.0, 1.0)
    direction: Vector | None = None
    seed: int = 0
    threads: int | None = None
    force: bool = False


def choose_task(
    request: SolveRequest, reader: TargetReader
) -> tuple[str, str | Axis | PositionFirst]:
    """Return the task's name and what `Robot.ik` gets for it.

    Raises
    ------
    ArgumentError
        For an unknown task, or one that needs orientations the targets do not have.
    """
    name = request.task or ("pose" if reader.is_pose else "position")
    if name not in TASKS:
        raise UnknownNameError("task", name, TASKS)
    if name in ("pose", "position-first") and not reader.is_pose:
        expected = f"orientations for a {name} task"
        raise ArgumentError("task", "targets without orientation", expected)
    if name != "axis":
        if request.direction is not None:
            raise ArgumentError("direction", f"task '{name}'", "task 'axis'")
        return name, PositionFirst() if name == PositionFirst.name else name
    if request.direction is None and not reader.is_pose:
        raise ArgumentError("direction", "nothing", "one, as the targets are points")
    return name, Axis(tool_axis=request.tool_axis, direction=request.direction)


def solve_file(request: SolveRequest, progress: Progress | None = None) -> Summary:
    """Solve every target of a file and write the results.

    Reading, solving and writing overlap, in memory that does not grow with the file (but for
    NPZ results, which are one archive of whole arrays, and NPY results with text ids). Results
    do not depend on the pieces, because the solver is told each piece's first index.

    Parameters
    ----------
    request : SolveRequest
    progress : Progress, optional
        Silent by default.

    Returns
    -------
    Summary

    Raises
    ------
    AgrikError
        For bad arguments and files; nothing is written then, nor after Ctrl-C.
    """
    started = time.perf_counter()
    progress = Silent() if progress is None else progress
    check_result_path(request.output)
    _check_tolerances(request)
    robot = Robot.load(request.robot)
    reader = read_targets(request.targets)
    if request.output.exists() and request.output.samefile(request.targets):
        raise ResultFileError(request.output, "is the target file, expected another name")
    task_name, task = choose_task(request, reader)
    summary = Summary(robot.name, task_name, with_orientation=task_name != "position")
    layout = ResultLayout(
        ResultLayout.joint_names(robot.joint_names, robot.joint_types),
        reader.has_text_ids,
        _metadata(request, robot, task_name),
    )
    work = Pipeline(reader.chunks(), _solver(robot, task, request))
    with open_results(request.output, layout, force=request.force) as writer, progress:
        progress.start(f"{robot.name}, {task_name} task", reader.count)
        if reader.ignored:
            progress.note(f"not used: {', '.join(reader.ignored)}")
        waiting: list[ResultChunk] = []
        with contextlib.closing(work.pieces()) as pieces:
            for piece in pieces:
                summary.add(piece)
                progress.advance(len(piece))
                if waiting and _id_bytes([*waiting, piece]) > WRITE_ID_BYTES:
                    writer.write(_joined(waiting))
                    waiting.clear()
                waiting.append(piece)
                if sum(map(len, waiting)) >= WRITE_ROWS:
                    writer.write(_joined(waiting))
                    waiting.clear()
        if waiting:
            writer.write(_joined(waiting))
    summary.solve_s = work.solve_s
    summary.total_s = time.perf_counter() - started
    return summary


def _check_tolerances(request: SolveRequest) -> None:
    """Refuse what `Robot.ik` would refuse, before a file is read."""
    for name in ("position_tolerance", "orientation_tolerance"):
        given = getattr(request, name)
        each = given if isinstance(given, tuple) else (given,)
        free = len(each) == 3
        if len(each) not in (1, 3) or not all(
            value > 0.0 and (free or np.isfinite(value)) for value in each
        ):
            expected = "a positive number, or three of which inf frees an axis"
            raise ArgumentError(name, repr(given), expected)
    frame: object = request.tolerance_frame
    if frame not in (None, "base", "tool"):
        raise ArgumentError("tolerance_frame", repr(frame), "'base' or 'tool'")


def _solver(robot: Robot, task: str | Axis | PositionFirst, request: SolveRequest) -> Solve:
    def solve(targets: NDArray[np.float64], first_index: int) -> IkResult:
        return robot.ik(
            targets,
            task=task,
            solver=request.solver,
            seed=request.seed,
            threads=request.threads,
            position_tolerance=request.position_tolerance,
            orientation_tolerance=request.orientation_tolerance,
            tolerance_frame=request.tolerance_frame,
            first_index=first_index,
        )

    return solve


def _metadata(request: SolveRequest, robot: Robot, task: str) -> dict[str, str]:
    values = {
        "version": __version__,
        "robot": robot.name,
        "targets": request.targets.name,
        "task": task,
        "solver": request.solver,
        "position_tolerance_m": _words(request.position_tolerance),
        "orientation_tolerance_rad": _words(request.orientation_tolerance),
        "seed": str(request.seed),
    }
    if request.tolerance_frame is not None:
        values["tolerance_frame"] = request.tolerance_frame
    if task == "axis":
        values["tool_axis"] = _words(request.tool_axis)
        where = request.direction
        values["direction"] = "the targets' own" if where is None else _words(where)
    return values


def _words(numbers: float | Vector) -> str:
    return ",".join(map(repr, numbers)) if isinstance(numbers, tuple) else repr(numbers)


def _id_bytes(pieces: list[ResultChunk]) -> int:
    """Return the bytes of the pieces' ids once they are joined, all as wide as the widest."""
    return sum(map(len, pieces)) * max(piece.ids.dtype.itemsize for piece in pieces)


def _joined(pieces: list[ResultChunk]) -> ResultChunk:
    if len(pieces) == 1:
        return pieces[0]
    names = ResultChunk.__dataclass_fields__
    return ResultChunk(
        **{name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in names}
    )
