"""The main job: targets from a file, solved in pieces, results to a file."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ..errors import ArgumentError, UnknownNameError
from ..io import ResultChunk, ResultLayout, TargetChunk, TargetReader, open_results, read_targets
from ..io.errors import ResultFileError
from ..io.results import check_result_path
from ..robot import Robot
from ..tasks import Axis
from .progress import Progress, Silent
from .summary import Summary

# A piece is what one call of the solver gets: long enough to keep every core busy, short
# enough that the bar moves. Rows per file chunk bound the memory.
PIECE_S = 0.2
FIRST_PIECE = 64
LARGEST_PIECE = 65_536
WRITE_ROWS = 65_536
QUEUED_PIECES = 4
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

    Reading and solving run beside writing; results do not depend on the pieces, because the
    solver is told each piece's first index.

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
    work = _Worker(robot, reader, task, request)
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
    names = ResultChunk.__dataclass_fields__
    return ResultChunk(
        **{name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in names}
    )


class _Worker:
    """Reads and solves in a thread of its own.

    The main thread then only waits, so Ctrl-C is answered at once however long the solver
    stays in compiled code; the thread is a daemon and does not keep the process alive.
    """

    def __init__(
        self, robot: Robot, reader: TargetReader, task: str | Axis, request: SolveRequest
    ) -> None:
        self._robot = robot
        self._reader = reader
        self._task = task
        self._request = request
        self._done: queue.Queue[ResultChunk | BaseException | None] = queue.Queue(QUEUED_PIECES)
        self._stop = threading.Event()
        self._size = FIRST_PIECE
        self.solve_s = 0.0

    def pieces(self) -> Generator[ResultChunk]:
        """Yield the results in order."""
        threading.Thread(target=self._run, name="agrik-fast-solve", daemon=True).start()
        try:
            while True:
                try:
                    # With a time-out, because a bare get() ignores Ctrl-C on Windows.
                    item = self._done.get(timeout=0.25)
                except queue.Empty:
                    continue
                if item is None:
                    return
                if isinstance(item, BaseException):
                    raise item
                yield item
        finally:
            self._stop.set()

    def _run(self) -> None:
        try:
            for chunk in self._reader.chunks():
                for piece in self._solve(chunk):
                    self._put(piece)
                    if self._stop.is_set():
                        return
            self._put(None)
        except BaseException as error:
            self._put(error)

    def _put(self, item: ResultChunk | BaseException | None) -> None:
        while not self._stop.is_set():
            try:
                self._done.put(item, timeout=0.25)
            except queue.Full:
                continue
            return

    def _solve(self, chunk: TargetChunk) -> Iterator[ResultChunk]:
        targets = chunk.targets
        at = 0
        while at < len(targets):
            part = slice(at, at + self._size)
            started = time.perf_counter()
            piece = self._ik(targets[part], chunk.ids[part], chunk.first + at)
            took = time.perf_counter() - started
            self.solve_s += took
            at += len(piece)
            fit = int(len(piece) * PIECE_S / max(took, 1e-6))
            self._size = max(1, min(fit, 8 * self._size, LARGEST_PIECE))
            yield piece

    def _ik(self, targets: NDArray[np.float64], ids: NDArray[Any], first: int) -> ResultChunk:
        request = self._request
        result = self._robot.ik(
            targets,
            task=self._task,
            solver=request.solver,
            seed=request.seed,
            threads=request.threads,
            position_tolerance=request.position_tolerance,
            orientation_tolerance=request.orientation_tolerance,
            first_index=first,
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
