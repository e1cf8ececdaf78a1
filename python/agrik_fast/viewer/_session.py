"""What a viewer knows and does, without a window: arm, target, posture, solver, undo."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from .. import _native
from .._checks import FloatArray
from .._names import solver_names
from ..collision import Scene
from ..errors import AgrikError
from ..result import Status
from ..robot import Robot
from ..rotations import pose, rpy_of
from ..solvers import Solver
from ._sources import GivenSolver
from ._words import Outcome, headline, joints_at_limits, length

TASKS = ("pose", "position", "axis")
"""Tasks that the viewer offers."""
_UNDO = 100
_MOST_BRANCHES = 32
# Tolerances of the viewer's targets: what a picture shows, and more.
_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Branch:
    """One of the postures that reach the target."""

    q: FloatArray
    distance: float
    """From the posture that the arm has, rad and m together."""


class Session:
    """An arm, its target and what is asked of it.

    Parameters
    ----------
    robot : Robot
    source : str or path
        What it was loaded by, for scripts.
    scene : Scene, optional
    given : GivenSolver, optional
        A solver that can be chosen besides those with names.
    """

    def __init__(
        self,
        robot: Robot,
        source: str | PathLike[str],
        scene: Scene | None = None,
        given: GivenSolver | None = None,
    ) -> None:
        self.scene = scene
        self.given = given
        self.avoid = scene is not None
        self.clear = 0.0
        self.load(robot, source)

    def load(self, robot: Robot, source: str | PathLike[str]) -> None:
        """Take another arm, in a posture with room to all limits."""
        self.robot = robot
        self.source = str(source)
        self.solver = "lm"
        self.task = "pose" if robot.dof >= 6 else "axis" if robot.dof == 5 else "position"
        if robot.family.name == "unsupported" and robot.dof < 6:
            self.task = "position"
        self.opening = 0.0
        self.q = comfortable(robot, self.scene)
        self._undo: list[FloatArray] = []
        self._redo: list[FloatArray] = []
        self.target = robot.fk(self.q)
        self.outcome = self.solve()

    # -- the target ----------------------------------------------------------------------

    def aim(self, target: FloatArray, *, remember: bool = True) -> Outcome:
        """Take another target, shape (4, 4), m, and solve it."""
        if remember:
            self.remember()
        self.target = np.array(target)
        self.outcome = self.solve()
        return self.outcome

    def remember(self) -> None:
        """Keep the target for `undo`."""
        if not self._undo or not np.array_equal(self._undo[-1], self.target):
            self._undo.append(self.target.copy())
            del self._undo[:-_UNDO]
        self._redo.clear()

    def undo(self) -> bool:
        """Go back to the target before; False where there is none."""
        return self._back(self._undo, self._redo)

    def redo(self) -> bool:
        """Go to the target that `undo` left; False where there is none."""
        return self._back(self._redo, self._undo)

    def _back(self, of: list[FloatArray], to: list[FloatArray]) -> bool:
        while of:
            earlier = of.pop()
            if not np.array_equal(earlier, self.target):
                to.append(self.target.copy())
                self.aim(earlier, remember=False)
                return True
        return False

    def numbers(self) -> tuple[float, ...]:
        """Return the target as x, y, z (m), roll, pitch, yaw (deg)."""
        angles = np.degrees(rpy_of(self.target).angles)
        return (*self.target[:3, 3].tolist(), *angles.tolist())

    def aim_numbers(self, values: Sequence[float]) -> Outcome:
        """Take a target by x, y, z (m), roll, pitch, yaw (deg)."""
        return self.aim(pose(values[:3], rpy=np.radians(values[3:])))

    # -- solving -------------------------------------------------------------------------

    def solvers(self) -> tuple[str, ...]:
        """Return the names of the solvers that can be chosen."""
        return solver_names() if self.given is None else (self.given.label, *solver_names())

    @property
    def _solver(self) -> Solver | str:
        given = self.given
        return self.solver if given is None or self.solver != given.label else given.solver

    def solve(self) -> Outcome:
        """Look for a posture from the present one on; it becomes the arm's where it holds."""
        begin = time.perf_counter()
        guarded = self.avoid and self.collides_with is not None
        try:
            found = self.robot.ik(
                self.target,
                task=self.task,
                solver=self._solver,
                q0=self.q,
                scene=self.collides_with if guarded else None,
                clear=self.clear if guarded else 0.0,
                prefer="near" if guarded else "first",
                position_tolerance=_TOLERANCE,
                orientation_tolerance=_TOLERANCE,
            )
        except AgrikError as error:
            return self._refused(str(error), time.perf_counter() - begin)
        seconds = time.perf_counter() - begin
        status = Status(int(found.status))
        q = np.array(found.q)
        if found.success:
            self.q = q
        return self._told(status, q, found, seconds)

    def _refused(self, reason: str, seconds: float) -> Outcome:
        nothing = ("", "")
        line = f"{self.solver.upper()}: {reason}"
        return Outcome(
            False, Status.BAD_INPUT, self.q, seconds, 0, np.inf, np.inf, nothing, np.inf, line
        )

    def _told(self, status: Status, q: FloatArray, found: Any, seconds: float) -> Outcome:
        robot = self.robot
        clearance, pair = self.nearest(q)
        beyond = np.linalg.norm(self.target[:3, 3] - robot.reach_center) - robot.reach_radius
        error, angle = float(found.position_error), float(found.orientation_error)
        line = headline(
            status,
            seconds=seconds,
            iterations=int(found.iterations),
            position_error=error,
            orientation_error=angle,
            at_limits=joints_at_limits(robot.joint_names, q, robot.lower, robot.upper),
            pair=pair,
            beyond=float(beyond),
        )
        reached = bool(found.success)
        steps = int(found.iterations)
        return Outcome(reached, status, q, seconds, steps, error, angle, pair, clearance, line)

    @property
    def collides_with(self) -> Scene | None:
        """The scene that collisions are asked of; an empty one for the arm alone."""
        if not self.robot.bodies:
            return None
        return Scene() if self.scene is None else self.scene

    def nearest(self, q: FloatArray) -> tuple[float, tuple[str, str]]:
        """Return how near a posture comes to something, m, and what to what."""
        scene = self.collides_with
        if scene is None:
            return np.inf, ("", "")
        found = scene.distances(self.robot, q)
        least, pair = np.inf, ("", "")
        if found.distance.size and np.isfinite(found.distance.min()):
            row = int(np.argmin(found.distance))
            least = float(found.distance[row])
            pair = (found.bodies[row], str(found.object_names[row]))
        if float(found.own_distance) < least:
            first, second = found.own_names.tolist()
            least, pair = float(found.own_distance), (first, second)
        return least, pair

    def move_joints(self, q: FloatArray) -> Outcome:
        """Take joint values, rad or m; the target goes along with the tool."""
        self.remember()
        self.q = np.clip(q, self.robot.lower, self.robot.upper)
        self.target = self.robot.fk(self.q)
        self.outcome = self.solve()
        return self.outcome

    # -- branches ------------------------------------------------------------------------

    def branches(self) -> list[Branch]:
        """Return all postures that reach the target, the nearest first; none without a family."""
        robot = self.robot
        if not robot.family.branches:
            return []
        angle = robot.arm_angle(self.q) if robot.closed_form == "S-R-S" else None
        task = None if robot.dof >= 6 else self.task
        target = self.target[:3, 3] if self.task == "position" and robot.dof == 3 else self.target
        try:
            found = robot.ik_all(target, q0=self.q, arm_angle=angle, task=task)
        except AgrikError:
            return []
        postures = found.q[found.valid]
        away = np.linalg.norm(postures - self.q, axis=-1)
        order = np.argsort(away, kind="stable")[:_MOST_BRANCHES]
        return [Branch(postures[k], float(away[k])) for k in order]

    def choose(self, q: FloatArray) -> Outcome:
        """Take a posture that reaches the target, such as one of `branches`."""
        self.q = np.array(q)
        self.outcome = self.solve()
        return self.outcome

    @property
    def has_arm_angle(self) -> bool:
        """Whether the arm's elbow can be turned while the tool stands still."""
        return self.robot.closed_form == "S-R-S"

    def turn_elbow(self, degrees: float) -> Outcome:
        """Turn the elbow of an S-R-S arm, to the branch that is nearest."""
        found = self.robot.ik_all(self.target, q0=self.q, arm_angle=np.radians(degrees))
        postures = found.q[found.valid]
        if not len(postures):
            words = f"LIMIT: no posture with the elbow at {degrees:.0f}° keeps the joint limits"
            nothing = ("", "")
            return Outcome(
                False, Status.JOINT_LIMITS, self.q, 0.0, 0, 0.0, 0.0, nothing, np.inf, words
            )
        nearest = int(np.argmin(np.linalg.norm(postures - self.q, axis=-1)))
        return self.choose(postures[nearest])

    def elbow_intervals(self) -> str:
        """Return the elbow angles that the joint limits leave, in words."""
        found: list[tuple[float, float]] = []
        for rows in self.robot.arm_angle_intervals(self.target):
            found += [(float(a), float(b)) for a, b in np.degrees(rows)]
        if not found:
            return "elbow: no angle keeps the limits"
        merged = [sorted(found)[0]]
        for low, high in sorted(found)[1:]:
            if low <= merged[-1][1]:
                merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
            else:
                merged.append((low, high))
        return "elbow: " + ", ".join(f"{low:.0f}° to {high:.0f}°" for low, high in merged)

    # -- what it hands out ---------------------------------------------------------------

    def python(self) -> str:
        """Return a script of four lines that gives the same posture."""
        rows = ", ".join(str([float(x) for x in row]) for row in self.target)
        solver = repr(self.solver)
        if self.given is not None and self.solver == self.given.label:
            solver = self.given.python
        return (
            "import agrik_fast as ik\n"
            f"arm = ik.Robot.load({self.source!r})\n"
            f"result = arm.ik([{rows}], task={self.task!r}, solver={solver}, "
            f"q0={[float(x) for x in self.q]})\n"
            "print(result.success, result.q)\n"
        )

    def summary(self) -> str:
        """Return what the arm is, in one line."""
        robot = self.robot
        words = f"{robot.dof} joints, reach {length(robot.reach_radius)}"
        return f"{words}. {robot.description}" if robot.description else words


def comfortable(robot: Robot, scene: Scene | None = None) -> FloatArray:
    """Return a posture with room to all limits and to singularities, free of collisions.

    Parameters
    ----------
    robot : Robot
    scene : Scene, optional
        What it must not hit.
    """
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    postures = np.concatenate([[robot.home, (low + high) / 2], robot.random_q(300, seed=0)])
    free = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    room = np.minimum(postures - low, high - postures) / np.where(high > low, high - low, 1.0)
    margin = np.clip(2 * room[:, free], 0, 1).min(axis=1) if free.any() else np.ones(len(postures))
    jacobian = robot.jacobian(postures)
    size = np.linalg.svd(jacobian, compute_uv=False)
    ability = size[:, min(5, robot.dof - 1)] / np.maximum(size[:, 0], 1e-12)
    score = margin * ability
    if robot.bodies:
        where = Scene() if scene is None else scene
        score = np.where(where.collides(robot, postures), score - 10.0, score)
    best: FloatArray = postures[int(np.argmax(score))]
    return best


def version() -> str:
    """Return the version of the library."""
    return _native.__version__
