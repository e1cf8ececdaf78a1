"""Targets from a file, solved in pieces, results to a file."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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
from ..robot import Robot
from ..tasks import Axis
from ._one_row_a_branch import as_rows
from ._pipeline import Pipeline, Solve
from ._progress import Progress, Silent
from ._summary import Summary

# Rows that are written in one go, fewer where ids are long; a Parquet file gets a row group
# of them.
WRITE_ROWS = 65_536
WRITE_ID_BYTES = 32 << 20
Vector = tuple[float, float, float]
TASKS = ("position", "pose", "axis")


@dataclass(frozen=True)
class SolveRequest:
    """What `solve_file` is asked for.

    Attributes
    ----------
    robot : str
        Bundled name or path.
    targets, output : Path
        Files, whose kinds follow from their suffixes.
    task : {"position", "pose", "axis"}, optional
        None: pose if the targets have orientations.
    solver : str
        A solver's name, see `Robot.ik`.
    position_tolerance : float, m
        Largest distance between tool point and target; above 0.
    orientation_tolerance : float, rad
        Largest angle between tool and target orientation; above 0.
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
    all_branches : bool
        One row for each branch of a target that `Robot.ik_all` finds within the limits, in
        place of the answer of a solver.
    """

    robot: str
    targets: Path
    output: Path
    task: str | None = None
    solver: str = "lm"
    position_tolerance: float = 1e-6
    orientation_tolerance: float = 1e-6
    tool_axis: Vector = (0.0, 0.0, 1.0)
    direction: Vector | None = None
    seed: int = 0
    threads: int | None = None
    force: bool = False
    all_branches: bool = False


def choose_task(request: SolveRequest, reader: TargetReader) -> tuple[str, str | Axis]:
    """Return the task's name and what `Robot.ik` gets for it.

    Raises
    ------
    ArgumentError
        For an unknown task, or one that needs orientations the targets do not have.
    """
    name = request.task or ("pose" if reader.is_pose else "position")
    if name not in TASKS:
        raise UnknownNameError("task", name, TASKS)
    if name == "pose" and not reader.is_pose:
        raise ArgumentError("task", "targets without orientation", "orientations for a pose task")
    if name != "axis":
        if request.direction is not None:
            raise ArgumentError("direction", f"task '{name}'", "task 'axis'")
        return name, name
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
    for name, value in (
        ("position_tolerance", request.position_tolerance),
        ("orientation_tolerance", request.orientation_tolerance),
    ):
        if not (np.isfinite(value) and value > 0.0):
            raise ArgumentError(name, repr(value), "a positive number")
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
            for targets, piece in pieces:
                summary.add(piece)
                progress.advance(targets)
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


def _solver(robot: Robot, task: str | Axis, request: SolveRequest) -> Solve:
    def solve(targets: NDArray[np.float64], first_index: int, ids: NDArray[Any]) -> ResultChunk:
        result = robot.ik(
            targets,
            task=task,
            solver=request.solver,
            seed=request.seed,
            threads=request.threads,
            position_tolerance=request.position_tolerance,
            orientation_tolerance=request.orientation_tolerance,
            first_index=first_index,
        )
        return ResultChunk(
            ids=ids,
            q=result.q,
            status=result.status,
            success=result.success,
            position_error=result.position_error,
            orientation_error=result.orientation_error,
            iterations=result.iterations,
            restarts=result.restarts,
        )

    def branches(targets: NDArray[np.float64], first_index: int, ids: NDArray[Any]) -> ResultChunk:
        found = robot.ik_all(
            targets,
            task=task,
            threads=request.threads,
            position_tolerance=request.position_tolerance,
            orientation_tolerance=request.orientation_tolerance,
        )
        return as_rows(robot, task, targets, found, ids)

    return branches if request.all_branches else solve


def _metadata(request: SolveRequest, robot: Robot, task: str) -> dict[str, str]:
    values = {
        "version": __version__,
        "robot": robot.name,
        "targets": request.targets.name,
        "task": task,
        "solver": "all branches" if request.all_branches else request.solver,
        "position_tolerance_m": repr(request.position_tolerance),
        "orientation_tolerance_rad": repr(request.orientation_tolerance),
        "seed": str(request.seed),
    }
    if task == "axis":
        values["tool_axis"] = _words(request.tool_axis)
        where = request.direction
        values["direction"] = "the targets' own" if where is None else _words(where)
    return values


def _words(vector: Vector) -> str:
    return ",".join(map(repr, vector))


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
