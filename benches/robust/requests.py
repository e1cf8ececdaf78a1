"""Random requests to an arm: task, solver, targets, start values and the other options."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from agrik_fast import _native, solvers, tasks

from . import postures
from .chain import Arm, Array, random_rotation, transform, unit

BRANCHES = "ik_all"
"""Stands for `Robot.ik_all` where solvers are named."""

ROWS = {"lm": 1500, "auto": 2500, "closed_form": 2500, BRANCHES: 1500}
ROWS |= dict.fromkeys(("dls", "pinv", "pinv-closed", "broyden"), 200)
ROWS |= dict.fromkeys(("transpose", "ccd", "ik-pid", "state-space", "static-gain"), 24)
ROWS |= dict.fromkeys(("de", "ga"), 10)
"""Most rows of a call; how long a row that is not solved takes differs a thousandfold."""

MOST_DISTURBED = 200
"""Most rows of a call some of whose targets cannot be reached: those take long."""

TOLERANCES = ("position_tolerance", "orientation_tolerance")

SHARES = {"lm": 8.0, "auto": 7.0, "closed_form": 4.0, BRANCHES: 2.0}
"""How often a solver is asked, of those that are asked more than others."""


@dataclass
class Request:
    """One call and what is known of its targets."""

    arm: Arm
    """With the call's tool."""
    task: Any
    task_name: str
    solver: Any
    solver_name: str
    targets: Array
    """Poses (m, 4, 4) or points (m, 3)."""
    poses: Array
    """The same as poses (m, 4, 4)."""
    reachable: np.ndarray
    """Rows made by forward kinematics of `made_from`, which is within the limits."""
    made_from: Array
    q0: Array | None = None
    options: dict[str, Any] = field(default_factory=dict)
    """Other arguments of `ik` by name, without threads."""
    refusal: str = ""
    """Why the library may refuse this, by its documentation; empty where it may not."""

    @property
    def rows(self) -> int:
        return len(self.targets)

    @property
    def position_tolerance(self) -> float:
        """Of the whole error; infinite where an axis is free."""
        return float(np.linalg.norm(self.options.get("position_tolerance", 1e-6)))

    @property
    def orientation_tolerance(self) -> float:
        return float(np.linalg.norm(self.options.get("orientation_tolerance", 1e-6)))

    @property
    def bounds(self) -> Array | None:
        """Bounds of the errors along and about single axes, (6,), if there are any."""
        given = [self.options.get(name, 1e-6) for name in TOLERANCES]
        if not any(np.ndim(each) for each in given):
            return None
        return np.concatenate([each if np.ndim(each) else np.full(3, np.inf) for each in given])

    @property
    def frame(self) -> str:
        """Whose axes these are."""
        return str(self.options.get("tolerance_frame", getattr(self.task, "frame", "base")))

    def starts(self) -> Array | None:
        """Start values, one row a target."""
        if self.q0 is None:
            return None
        return np.broadcast_to(self.q0, (self.rows, self.arm.dof))

    def piece(self, begin: int, end: int) -> Callable[..., dict[str, Any]]:
        """Return a maker of the arguments of rows `begin` to `end` as a call of their own."""
        q0 = self.q0
        if q0 is not None and q0.ndim == 2:
            q0 = q0[begin:end]

        def arguments(**more: Any) -> dict[str, Any]:
            given = {"targets": self.targets[begin:end], "q0": q0} | self.options | more
            if self.solver_name != BRANCHES:
                first = (self.options.get("first_index", 0) + begin) % 2**64
                given |= {"task": self.task, "solver": self.solver, "first_index": first}
            return given

        return arguments


def draw(arm: Arm, family: str | None, rng: np.random.Generator) -> Request:
    """Draw a request to an arm.

    Parameters
    ----------
    arm : Arm
        The arm.
    family : str or None
        `Robot.closed_form` of the same arm: closed forms are asked of those that have one.
    rng : Generator
        Where it is drawn from.
    """
    names = [*_native.solver_names(), BRANCHES]
    if family is None and rng.random() < 0.98:
        names = [name for name in names if name not in ("closed_form", BRANCHES)]
    share = np.array([SHARES.get(name, 1.0) for name in names])
    name = names[rng.choice(len(names), p=share / share.sum())]
    task, task_name = _task(name, rng)
    tool = _tool(arm, rng) if rng.random() < 0.25 else None
    reached = arm.with_tool(tool)
    disturbed = rng.random() < 0.45
    count = _count(ROWS.get(name, 24), rng)
    count = min(count, MOST_DISTURBED) if disturbed else count
    made_from = _postures(arm, count, rng)
    poses = reached.fk(made_from)
    reachable = np.ones(count, bool)
    if disturbed:
        _disturb(reached, poses, reachable, rng)
    request = Request(
        arm=reached,
        task=task,
        task_name=task_name,
        solver=_solver(name, arm, rng),
        solver_name=name,
        targets=poses,
        poses=poses,
        reachable=reachable,
        made_from=made_from,
        q0=_starts(arm, made_from, rng),
        options=_options(name, arm, family, tool, rng),
    )
    wants_points = task_name == "position" or (task_name == "axis" and task.direction is not None)
    if wants_points and rng.random() < 0.7:
        request.targets = np.ascontiguousarray(poses[:, :3, 3])
    if task_name == "axis" and task.direction is not None:
        # A direction for the whole batch: only what happens to point there is known to be reached.
        turned = poses[:, :3, :3] @ np.array(task.tool_axis)
        reachable &= np.linalg.norm(turned - np.array(task.direction), axis=1) < 1e-12
    if rng.random() < 0.12:
        _bound_axes(request, rng)
    request.refusal = _refusal(request, family)
    return request


def _bound_axes(request: Request, rng: np.random.Generator) -> None:
    """Give tolerances axis by axis, or the task that puts the position first."""
    scale = request.arm.scale
    if request.task_name == "pose" and request.solver_name != BRANCHES and rng.random() < 0.3:
        request.task, request.task_name = tasks.PositionFirst(), "position-first"
        return
    place = rng.choice([1e-6 * scale, 1e-3, 0.05 * scale, np.inf], 3)
    turn = rng.choice([1e-6, 1e-3, 0.3, np.inf], 3)
    counted = np.asarray(getattr(request.task, "weights", np.ones(6))) > 0
    if request.task_name == "position":
        counted[3:] = False
    if not np.isfinite(np.concatenate([place, turn])[counted]).any():
        return
    kind = rng.integers(3)
    if kind != 1 and np.isfinite(place[counted[:3]]).any():
        request.options["position_tolerance"] = tuple(place.tolist())
    if kind != 0:
        request.options["orientation_tolerance"] = tuple(turn.tolist())
    if request.task_name != "masked" and rng.random() < 0.7:
        request.options["tolerance_frame"] = str(rng.choice(["base", "tool"]))


def _count(most: int, rng: np.random.Generator) -> int:
    size = rng.random()
    if size < 0.1:
        return 1
    if size < 0.3:
        return int(rng.integers(2, min(most, 40) + 1))
    return int(rng.integers(most // 2, most + 1))


def _postures(arm: Arm, count: int, rng: np.random.Generator) -> Array:
    if rng.random() < 0.5:
        kind = postures.KINDS[rng.integers(len(postures.KINDS))]
        return postures.draw(arm, kind, count, rng)
    parts = [
        postures.draw(arm, kind, len(rows), rng)
        for kind, rows in zip(
            postures.KINDS, np.array_split(np.arange(count), len(postures.KINDS)), strict=True
        )
    ]
    return rng.permutation(np.concatenate(parts))


def _disturb(arm: Arm, poses: Array, reachable: np.ndarray, rng: np.random.Generator) -> None:
    """Move some targets: a little, far away, beyond all numbers, or to no number at all."""
    count = len(poses)
    size = max(arm.length, arm.scale)
    kind = rng.choice(6, count, p=[0.5, 0.2, 0.12, 0.08, 0.05, 0.05])
    moved = kind > 0
    poses[kind == 1, :3, 3] += rng.normal(size=(np.sum(kind == 1), 3)) * size * 0.3
    turned = np.flatnonzero(kind == 2)
    for row in turned:
        poses[row, :3, :3] = random_rotation(rng)
    far = 10.0 ** rng.uniform(0.3, 8, (np.sum(kind == 3), 1))
    poses[kind == 3, :3, 3] += rng.normal(size=(np.sum(kind == 3), 3)) * size * far
    poses[kind == 4, :3, 3] *= 10.0 ** rng.uniform(150, 300, (np.sum(kind == 4), 1))
    for row in np.flatnonzero(kind == 5):
        poses[row, rng.integers(3), rng.integers(4)] = rng.choice([np.nan, np.inf, -np.inf])
    reachable &= ~moved


# ---- options -------------------------------------------------------------------------------------


def _task(solver: str, rng: np.random.Generator) -> tuple[Any, str]:
    if solver == BRANCHES or (solver in ("closed_form", "auto") and rng.random() < 0.85):
        return "pose", "pose"
    if solver == "ccd" and rng.random() < 0.9:
        return tasks.Position(), "position"
    match rng.choice(8):
        case 0 | 1:
            return "position", "position"
        case 2 | 3 | 4:
            return tasks.Pose(), "pose"
        case 5:
            return tasks.Axis(tool_axis=tuple(rng.normal(size=3).tolist())), "axis"
        case 6:
            direction = unit(rng.normal(size=3)).tolist()
            axis = np.eye(3)[rng.integers(3)].tolist()
            return tasks.Axis(tool_axis=tuple(axis), direction=tuple(direction)), "axis"
    weights = rng.choice([0.0, 1.0, 1.0, 0.3, 2.0], 6)
    if not weights.any():
        weights[0] = 1.0
    frame = "base" if rng.random() < 0.5 else "tool"
    return tasks.Masked(tuple(weights.tolist()), frame=frame), "masked"


def _solver(name: str, arm: Arm, rng: np.random.Generator) -> Any:
    """A solver's name, or an object with other options than its defaults."""
    if name == BRANCHES or rng.random() < 0.6:
        return name
    steps = {"max_iterations": int(rng.choice([1, 5, 60])), "max_restarts": int(rng.choice([0, 3]))}
    step = steps | {"max_step": float(rng.choice([0.05, 1.0, 100.0]))}
    start = steps | {"start": str(rng.choice(["sampled", "zero", "middle"]))}
    search = {
        "population": int(rng.choice([4, 20])),
        "generations": int(rng.choice([1, 10])),
        "max_restarts": int(rng.choice([0, 2])),
        "polish": bool(rng.random() < 0.5),
        "boundary": str(rng.choice(["median", "clamp", "reflect", "redraw"])),
        "orientation": str(rng.choice(["rotation-vector", "euler-zyz"])),
        "start_weight": float(rng.choice([0.0, 0.1])),
    }
    made: dict[str, Callable[[], Any]] = {
        "lm": lambda: solvers.LevenbergMarquardt(damping=float(10.0 ** rng.uniform(-3, 1)), **step),
        "dls": lambda: solvers.DampedLeastSquares(
            damping=float(10.0 ** rng.uniform(-4, 0)), **step
        ),
        "pinv": lambda: solvers.PseudoInverse(cutoff=float(10.0 ** rng.uniform(-9, -0.5)), **step),
        "pinv-closed": lambda: solvers.ClosedPseudoInverse(**step),
        "transpose": lambda: solvers.Transpose(**step),
        "ccd": lambda: solvers.CyclicCoordinateDescent(**start),
        "ik-pid": lambda: solvers.IkPid(
            kp=float(rng.normal()) * 0.05,
            order=str(rng.choice(["tip-first", "base-first"])),
            literal=bool(rng.random() < 0.3),
            incremental=bool(rng.random() < 0.7),
            **start,
        ),
        "state-space": lambda: solvers.StateSpace(**start),
        "static-gain": lambda: _static_gain(arm, start, rng),
        "broyden": lambda: solvers.Broyden(patience=int(rng.choice([1, 8])), **start),
        "de": lambda: solvers.DifferentialEvolution(
            mutation=str(rng.choice(["best1", "rand1", "current-to-best1"])),
            adaptation=str(rng.choice(["none", "jde", "lshade"])),
            **search,
        ),
        "ga": lambda: solvers.GeneticAlgorithm(elites=int(rng.integers(0, 4)), **search),
        "closed_form": lambda: solvers.ClosedForm(
            choose=str(rng.choice(["nearest", "margin", "middle"])),
            arm_angle=float(rng.uniform(-np.pi, np.pi)) if rng.random() < 0.3 else None,
        ),
    }
    if name in made and rng.random() < 0.1 and name in ("lm", "dls", "pinv"):
        inner = made[name]()
        return solvers.Plain(solver=inner, start=start["start"], max_iterations=200)
    return made[name]() if name in made else name


def _static_gain(arm: Arm, loop: dict[str, Any], rng: np.random.Generator) -> Any:
    if rng.random() < 0.5:
        return solvers.StaticGain(**loop)
    # Gains that nobody tuned: numbers may grow beyond all bounds, and no answer may be wrong.
    gain = rng.normal(size=(arm.dof, 3)) * 10.0 ** rng.uniform(-2, 6)
    return solvers.StaticGain(K=gain.tolist(), **loop)


def _tool(arm: Arm, rng: np.random.Generator) -> Array:
    far = arm.scale * float(rng.choice([0.1, 0.5, 30.0], p=[0.5, 0.35, 0.15]))
    return transform(random_rotation(rng), rng.normal(size=3) * far)


def _starts(arm: Arm, q: Array, rng: np.random.Generator) -> Array | None:
    kind = rng.random()
    if kind < 0.5:
        return None
    if kind < 0.6:
        return q[0].copy()
    if kind < 0.7:
        return q + rng.normal(size=q.shape) * np.where(arm.turns, 0.05, 0.05 * arm.scale)
    if kind < 0.78:
        return q.copy()
    if kind < 0.86:
        turns = rng.integers(-3, 4, q.shape) * (2 * np.pi)
        return q + np.where(arm.turns, turns, 0.0)
    if kind < 0.94:
        low, high = postures.bounds(arm)
        return low + (high - low) * rng.random(q.shape)
    starts = rng.normal(size=q.shape) * 10.0 ** float(rng.choice([0, 3, 6]))
    if kind > 0.97:
        starts[rng.random(len(q)) < 0.2, rng.integers(arm.dof)] = rng.choice([np.nan, np.inf])
    return starts


def _options(
    name: str, arm: Arm, family: str | None, tool: Array | None, rng: np.random.Generator
) -> dict[str, Any]:
    options: dict[str, Any] = {}
    if tool is not None:
        options["tool"] = tool
    if rng.random() < 0.35:
        choices = (1e-3, 1e-9, 1e-6 * arm.scale, 0.01 * arm.scale, 0.3 * arm.scale)
        options["position_tolerance"] = float(rng.choice(choices))
        options["orientation_tolerance"] = float(rng.choice([1e-6, 1e-9, 1e-3, 0.1, 1.0, 4.0]))
    if name == BRANCHES and family == "S-R-S" and rng.random() < 0.3:
        options["arm_angle"] = float(rng.uniform(-np.pi, np.pi))
    if name != BRANCHES:
        options["seed"] = int(rng.choice(np.array([0, 1, 7, 2**63], np.uint64)))
        if rng.random() < 0.2:
            options["first_index"] = int(rng.choice(np.array([5, 2**40, 2**64 - 3], np.uint64)))
    return options


def _refusal(request: Request, family: str | None) -> str:
    solver, task = request.solver, request.task
    name = request.solver_name
    if name in ("closed_form", BRANCHES) and family is None:
        return "the arm has no closed form"
    if name == "closed_form" and request.task_name != "pose":
        return "closed forms are for full poses"
    if name == "ccd" and (request.task_name != "position" or request.bounds is not None):
        return "ccd is for positions"
    if isinstance(solver, solvers.StaticGain) and request.bounds is not None:
        return "gains have as many columns as the task has rows"
    if isinstance(solver, solvers.StaticGain) and solver.K is not None:
        return "" if request.task_name == "position" else "three columns are for positions"
    if name in ("state-space", "static-gain", "broyden", "ik-pid") and (
        request.task_name == "axis"
        or getattr(task, "frame", "base") == "tool"
        or (request.bounds is not None and request.frame == "tool")
    ):
        return "feedback laws are for positions, poses and base-frame masks"
    searches = solvers.DifferentialEvolution | solvers.GeneticAlgorithm
    if (
        isinstance(solver, searches)
        and solver.orientation == "euler-zyz"
        and (request.task_name in ("axis", "masked") or request.bounds is not None)
    ):
        return "Euler angles are for full orientations"
    if isinstance(solver, solvers.ClosedForm) and solver.arm_angle is not None:
        return "" if family == "S-R-S" else "only S-R-S arms have an arm angle"
    return ""
