"""Arms, scenes and solvers that are given as they are, by name or as files."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from .._checks import word
from .._names import solver_names
from .._native import check_solver
from ..collision import Scene
from ..robot import Robot
from ..solvers import Solver, load_gains

_GAIN_FILES = (".toml", ".json")


def load(robot: Robot | str | PathLike[str]) -> tuple[Robot, str]:
    """Return an arm, and what it is loaded by."""
    if isinstance(robot, Robot):
        return robot, robot.name
    return Robot.load(robot), str(robot)


def load_scene(scene: Scene | str | PathLike[str] | None) -> Scene | None:
    """Return a scene of a file, or as it is."""
    if scene is None or isinstance(scene, Scene):
        return scene
    return Scene.load(scene)


@dataclass(frozen=True)
class GivenSolver:
    """A solver that is more than a name: with gains or options of its own."""

    label: str
    """What it is called in a list, and in words."""
    solver: Solver
    python: str
    """What makes it, in a script where the library is ``ik``."""


def load_solver(solver: Solver | str | PathLike[str]) -> GivenSolver | str:
    """Return a solver of a gain file, or as it is; a name stays a name.

    Raises
    ------
    AgrikError
        No solver, an unknown name, a faulty file.
    """
    if not isinstance(solver, str | PathLike):
        check_solver(solver)
        return GivenSolver(type(solver).__name__, solver, f"ik.solvers.{solver!r}")
    file = Path(solver)
    if file.suffix.lower() not in _GAIN_FILES:
        return word("solver", solver, solver_names())
    gains = load_gains(file, as_tuned=False)
    python = f"ik.solvers.load_gains({str(file)!r}, as_tuned=False)"
    return GivenSolver(file.name, gains, python)
