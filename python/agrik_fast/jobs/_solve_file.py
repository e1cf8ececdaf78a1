"""Targets from a file, solved in pieces, results to a file."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from .._native import __version__
from ..errors import AgrikError, ArgumentError
from ..io import (
    Extras,
    ResultChunk,
    ResultFileError,
    ResultLayout,
    check_result_path,
    open_results,
    read_targets,
)
from ..robot import Prefer, Robot, SceneOf
from ._one_row_a_branch import as_rows
from ._pipeline import Pipeline, Solve
from ._progress import Progress, Silent
from ._robot_choice import RobotChoice
from ._summary import Summary
from ._task import (
    JobTask,
    Vector,
    check_gains,
    check_start,
    check_tolerances,
    choose_task,
    solver_words,
    task_words,
)

if TYPE_CHECKING:
    from ..solvers import Solver

# Rows that are written in one go, fewer where ids are long; a Parquet file gets a row group
# of them.
WRITE_ROWS = 65_536
WRITE_ID_BYTES = 32 << 20
# Reaches beyond which no target lies that was meant in metres.
_FAR = 30.0


@dataclass(frozen=True)
class SolveRequest:
    """What `solve_file` is asked for.

    Attributes
    ----------
    robot : str
        Bundled name or path.
    targets, output : pathlib.Path
        Files, whose kinds follow from their suffixes.
    task : {"position", "pose", "axis", "masked", "position-first"}, optional
        None: masked with a mask, else pose if the targets have orientations.
    solver : str or solver
        A solver or its name, see `Robot.ik`.
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
    base_link, tip_link, tool, frame
        The robot's links, tool and frame, as for `RobotChoice`.
    q0 : tuple of float, optional
        Start values, rad or m, of every row's first attempt.
    mask : tuple of 6 float, optional
        Weights of the errors along and about x, y, z: the task "masked", see
        `agrik_fast.tasks.Masked`.
    mask_frame : {"base", "tool"}
        Frame in which they are counted.
    scene : Scene, optional
        What answers must not hit, as for `Robot.ik`.
    scene_name : str
        What the results call the scene.
    clear : float, m
        Distance that answers keep from it.
    prefer : {"first", "near", "clearance"}
        Which of several free postures.
    all_branches : bool
        One row for each branch of a target that `Robot.ik_all` finds within the limits, in
        place of the answer of a solver.

    Examples
    --------
    >>> from pathlib import Path
    >>> from agrik_fast.jobs import SolveRequest
    >>> paths = Path("points.npy"), Path("joints.csv")
    >>> request = SolveRequest("ur5", *paths, seed=7)
    >>> request.solver, request.seed
    ('lm', 7)
    """

    robot: str
    targets: Path
    output: Path
    task: str | None = None
    solver: Solver | str = "lm"
    position_tolerance: float | Vector = 1e-6
    orientation_tolerance: float | Vector = 1e-6
    tolerance_frame: Literal["base", "tool"] | None = None
    tool_axis: Vector = (0.0, 0.0, 1.0)
    direction: Vector | None = None
    seed: int = 0
    threads: int | None = None
    force: bool = False
    scene: SceneOf | None = None
    scene_name: str = ""
    clear: float = 0.0
    prefer: Prefer = "first"
    base_link: str | None = None
    tip_link: str | None = None
    tool: tuple[float, ...] | None = None
    frame: str | None = None
    q0: tuple[float, ...] | None = None
    mask: tuple[float, ...] | None = None
    mask_frame: Literal["base", "tool"] = "base"
    all_branches: bool = False

    @property
    def choice(self) -> RobotChoice:
        """The robot."""
        return RobotChoice(self.robot, self.base_link, self.tip_link, self.tool, self.frame)


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

    Examples
    --------
    >>> from pathlib import Path
    >>> from agrik_fast.jobs import SolveRequest, solve_file
    >>> np.save("points.npy", [[0.4, 0.2, 0.3], [0.3, 0.1, 0.4]])
    >>> request = SolveRequest("ur5", Path("points.npy"), Path("joints.csv"))
    >>> summary = solve_file(request)
    >>> summary.rows, summary.solved
    (2, 2)
    """
    started = time.perf_counter()
    progress = Silent() if progress is None else progress
    check_result_path(request.output)
    check_tolerances(request)
    if not (np.isfinite(request.clear) and request.clear >= 0.0):
        raise ArgumentError("clear", repr(request.clear), "a number >= 0")
    if request.scene is None and (request.clear != 0.0 or request.prefer != "first"):
        raise ArgumentError("scene", "none", "one, since `clear` or `prefer` asks for it")
    if request.all_branches and request.scene is not None:
        raise ArgumentError("scene", "one", "none: all branches are told, whatever they hit")
    robot = request.choice.load()
    check_start(request, robot)
    reader = read_targets(request.targets)
    if request.output.exists() and request.output.samefile(request.targets):
        raise ResultFileError(request.output, "is the target file, expected another name")
    task_name, task = choose_task(request, is_pose=reader.is_pose)
    check_gains(request.solver, task_name)
    letters = _name_letters(robot, request)
    summary = Summary(robot.name, task_name, with_orientation=task_name != "position")
    layout = ResultLayout(
        ResultLayout.joint_names(robot.joint_names, robot.joint_types),
        reader.has_text_ids,
        _metadata(request, robot, task_name),
        letters,
    )
    # Of two columns of one name the result's own is kept.
    taken = layout.own_columns
    layout = replace(layout, extras=tuple(e for e in reader.extras if e.name not in taken))
    passed_on = {extra.name for extra in layout.extras}
    far = _Far(robot)
    work = Pipeline(reader.chunks(), _solver(robot, task, request, far))
    with open_results(request.output, layout, force=request.force) as writer, progress:
        progress.start(f"{robot.name}, {task_name} task", reader.count)
        for note in robot.notes:
            progress.note(note)
        if reader.ignored:
            words = [
                f"{name} (passed on)" if name in passed_on else name for name in reader.ignored
            ]
            progress.note(f"not used: {', '.join(words)}")
        waiting: list[ResultChunk] = []
        with contextlib.closing(work.pieces()) as pieces:
            for targets, piece in pieces:
                summary.add(piece)
                progress.advance(targets)
                if waiting and _id_bytes([*waiting, piece]) > WRITE_ID_BYTES:
                    writer.write(ResultChunk.joined(waiting))
                    waiting.clear()
                waiting.append(piece)
                if sum(map(len, waiting)) >= WRITE_ROWS:
                    writer.write(ResultChunk.joined(waiting))
                    waiting.clear()
        if waiting:
            writer.write(ResultChunk.joined(waiting))
        far.tell(progress)
    summary.solve_s = work.solve_s
    summary.total_s = time.perf_counter() - started
    return summary


def faults_of(request: SolveRequest) -> list[AgrikError]:
    """Return what is wrong with a request, all of it, as far as that shows without solving.

    Examples
    --------
    >>> from pathlib import Path
    >>> from agrik_fast.jobs import SolveRequest, faults_of
    >>> for fault in faults_of(SolveRequest("ur6", Path("none.csv"), Path("out.txt"))):
    ...     print(str(fault).partition(";")[0].partition(", expected")[0])
    out.txt: unknown suffix '.txt'
    unknown robot 'ur6'
    none.csv: cannot be read: no such file or directory
    """
    found: list[AgrikError] = []

    def tried(work: Callable[[], Any]) -> Any:
        try:
            return work()
        except AgrikError as error:
            found.append(error)
            return None

    tried(lambda: check_result_path(request.output))
    tried(lambda: check_tolerances(request))
    robot = tried(request.choice.load)
    reader = tried(lambda: read_targets(request.targets))
    is_pose = reader is not None and reader.is_pose
    none = np.zeros((0, 4, 4) if is_pose else (0, 3))
    task, gains_fit = None, True
    if reader is not None:
        chosen = tried(lambda: choose_task(request, is_pose=is_pose))
        if chosen is not None:
            name, task = chosen
            before = len(found)
            tried(lambda: check_gains(request.solver, name))
            gains_fit = len(found) == before
    if robot is not None:
        if gains_fit:  # else it would say the same in other words
            tried(lambda: robot.ik(none, task, request.solver))
        tried(lambda: check_start(request, robot))
    return found


class _Far:
    """Notices that all targets of a file are so far away that their unit must be another."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._least = np.inf

    def look(self, targets: NDArray[np.float64]) -> None:
        """Note the nearest of some targets, m."""
        points = targets[:, :3, 3] if targets.ndim == 3 else targets
        # A place whose distance no number holds is far.
        with np.errstate(over="ignore", invalid="ignore"):
            away = np.linalg.norm(points - self._robot.reach_center, axis=1)
        self._least = min(self._least, float(np.min(away, initial=np.inf, where=away >= 0.0)))

    def tell(self, progress: Progress) -> None:
        """Say it."""
        reach = self._robot.reach_radius
        if np.isfinite(self._least) and self._least > _FAR * reach:
            progress.note(
                f"the nearest target is {self._least:.4g} m away, the arm reaches {reach:.4g} m: "
                "are the lengths in mm, as in x_mm,y_mm,z_mm?"
            )


def _solver(robot: Robot, task: JobTask, request: SolveRequest, far: _Far) -> Solve:
    def solve(
        targets: NDArray[np.float64], first_index: int, ids: NDArray[Any], extras: Extras
    ) -> ResultChunk:
        far.look(targets)
        result = robot.ik(
            targets,
            task=task,
            solver=request.solver,
            q0=request.q0,
            seed=request.seed,
            threads=request.threads,
            position_tolerance=request.position_tolerance,
            orientation_tolerance=request.orientation_tolerance,
            tolerance_frame=request.tolerance_frame,
            first_index=first_index,
            scene=request.scene,
            clear=request.clear,
            prefer=request.prefer,
        )
        return ResultChunk.of(result, ids, extras)

    def branches(
        targets: NDArray[np.float64], first_index: int, ids: NDArray[Any], extras: Extras
    ) -> ResultChunk:
        found = robot.ik_all(
            targets,
            request.q0,
            task=task,
            threads=request.threads,
            position_tolerance=request.position_tolerance,
            orientation_tolerance=request.orientation_tolerance,
        )
        return as_rows(robot, task, targets, found, ids, extras)

    return branches if request.all_branches else solve


def _name_letters(robot: Robot, request: SolveRequest) -> int:
    """Return the letters of the longest name of a body or an object; 0 without a scene."""
    if request.scene is None:
        return 0
    collider = request.scene.collider(robot)
    return max(1, *map(len, (*collider.bodies.names, *collider.scene.names)))


def _metadata(request: SolveRequest, robot: Robot, task: str) -> dict[str, str]:
    values = {
        "version": __version__,
        "robot": robot.name,
        "targets": request.targets.name,
        "task": task,
        "solver": "all branches" if request.all_branches else solver_words(request.solver),
        **task_words(request, task),
        **request.choice.words(),
    }
    if request.scene is not None:
        values["scene"] = request.scene_name
        values["clear_m"] = repr(request.clear)
        values["prefer"] = request.prefer
    return values


def _id_bytes(pieces: list[ResultChunk]) -> int:
    """Return the bytes of the pieces' ids once they are joined, all as wide as the widest."""
    return sum(map(len, pieces)) * max(piece.ids.dtype.itemsize for piece in pieces)
