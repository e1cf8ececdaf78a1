"""The main job: targets from a file, solved in pieces, results to a file."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ..errors import ArgumentError, UnknownNameError
from ..io import ResultChunk, ResultLayout, TargetReader, open_results, read_targets
from ..io.errors import ResultFileError
from ..io.results import check_result_path
from ..result import IkResult
from ..robot import Robot
from ..tasks import Axis
from .pipeline import Pipeline, Solve
from .progress import Progress, Silent
from .summary import Summary

# Rows that are written in one go; a Parquet file gets a row group of them.
WRITE_ROWS = 65_536
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
TASKS = ("position", "pose", "axis")


@dataclass(frozen=True)
class SolveRequest:
    """What `agrik-fast solve` was asked for.

    Attributes
    ----------
    robot : str
        Bundled name or path.
    targets, output : Path
    task : str or None
        "position", "pose" or "axis"; None: pose if the targets have orientations.
    solver : str
    position_tolerance : float, m
    orientation_tolerance : float, rad
    tool_axis : str
        "x", "-z", ... or three numbers, in the tool frame.
    direction : str or None
        The same in the base frame.
    seed : int
    threads : int or None
    force : bool
        Replace an existing result.
    """

    robot: str
    targets: Path
    output: Path
    task: str | None = None
    solver: str = "lm"
    position_tolerance: float = 1e-6
    orientation_tolerance: float = 1e-6
    tool_axis: str = "z"
    direction: str | None = None
    seed: int = 0
    threads: int | None = None
    force: bool = False


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
    if not np.isfinite([x, y, z]).all() or not any((x, y, z)):
        raise ArgumentError(option, repr(text), "a finite vector that is not zero")
    return (x, y, z)


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
        raise ArgumentError("direction", "nothing", "--direction, as the targets are points")
    direction = None if request.direction is None else parse_axis("direction", request.direction)
    return name, Axis(tool_axis=parse_axis("tool-axis", request.tool_axis), direction=direction)


def solve_file(request: SolveRequest, progress: Progress | None = None) -> Summary:
    """Solve every target of a file and write the results.

    Reading, solving and writing overlap, in memory that does not grow with the file (but for
    NPZ, which is one archive of whole arrays, and for NPY results with text ids). Results do
    not depend on the pieces, because the solver is told each piece's first index.

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
    for option, value in (
        ("tol", request.position_tolerance),
        ("tol-rad", request.orientation_tolerance),
    ):
        if not (np.isfinite(value) and value > 0.0):
            raise ArgumentError(option, repr(value), "a positive number")
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
    def solve(targets: NDArray[np.float64], first_index: int) -> IkResult:
        return robot.ik(
            targets,
            task=task,
            solver=request.solver,
            seed=request.seed,
            threads=request.threads,
            position_tolerance=request.position_tolerance,
            orientation_tolerance=request.orientation_tolerance,
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
        "position_tolerance_m": repr(request.position_tolerance),
        "orientation_tolerance_rad": repr(request.orientation_tolerance),
        "seed": str(request.seed),
    }
    if task == "axis":
        values["tool_axis"] = request.tool_axis
        values["direction"] = request.direction or "the targets' own"
    return values


def _joined(pieces: list[ResultChunk]) -> ResultChunk:
    if len(pieces) == 1:
        return pieces[0]
    names = ResultChunk.__dataclass_fields__
    return ResultChunk(
        **{name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in names}
    )
