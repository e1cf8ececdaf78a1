"""Tuning: finds the gains of a feedback solver for a robot.

A particle swarm or CMA-ES, run in the compiled core, lowers the mean cost over training
goals: a tenth of a point per hundred steps; for a goal that is missed ten points and
twenty per metre that is left. The gains found are then tried on goals that the search
has not seen.
"""

from __future__ import annotations

import dataclasses
import json
import os
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ._checks import FloatArray, whole_number
from ._feedback import IkPid, StateSpace, StaticGain, matrix_of
from ._native import Tuner, __version__
from .errors import ArgumentError, GainFileError, UnknownNameError
from .gain_file import GainFile, SuccessTable, TrainingTable
from .goals import joint_uniform
from .robot import Robot

__all__ = ["Report", "Tuning", "template", "tune"]

TEST_SEED = 1
"""Seed of the goals kept apart from the training."""
TEST_GOALS = 1000
LAW = "joint values uniform in the limits (SplitMix64)"
SOLVERS = ("state-space", "static-gain", "ik-pid")
_POPULATION = {"pso": 40, "cma": 24}
_SIGMA = {"pso": 0.3, "cma": 0.25}
_DEGREE = float(np.pi / 180)
_CENTIMETRE = 0.01
# Lengths that the published IK-PID gains belong to: the HydroLek's reach, m.
_PID_REACH_M = 1.49
CHECKPOINT_PERIOD_S = 2.0

Gains = StateSpace | StaticGain | IkPid


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """What to tune and how.

    Parameters
    ----------
    solver : {"state-space", "static-gain", "ik-pid"}
        Whose gains.
    shape : {"input", "diagonal", "full"}
        State space only. Free are: B of the joints that move the tool, with A zero; the
        diagonal of A, and B; all of A, B and C.
    method : {"pso", "cma"}
        Particle swarm, or CMA-ES.
    start : {"zero", "middle"}
        Where every attempt starts.
    goals : int
        Training goals.
    evaluations : int
        Gain sets to judge in a run, rounded up to whole generations.
    runs : int
        Searches from other random numbers, of which the one of least cost is kept: now
        and then one ends in a poor valley.
    population : int, optional
        Gain sets a generation; 40 (pso), 24 (cma).
    sigma : float, optional
        Deviation of the first generation; 0.3 (pso), 0.25 (cma).
    seed : int
        Seed of the search and, plus 100, of the training goals.
    max_iterations : int
        Steps of an attempt.
    tolerance : float
        Distance that counts as reached, m.
    threads : int, optional
        Number of threads.
    """

    solver: str = "state-space"
    shape: str = "input"
    method: str = "pso"
    start: str = "zero"
    goals: int = 3000
    evaluations: int = 4840
    runs: int = 3
    population: int | None = None
    sigma: float | None = None
    seed: int = 0
    max_iterations: int = 400
    tolerance: float = 1e-3
    threads: int | None = None

    def __post_init__(self) -> None:
        if self.solver not in SOLVERS:
            raise UnknownNameError("solver", self.solver, SOLVERS)
        if self.method not in _POPULATION:
            raise UnknownNameError("method", self.method, _POPULATION)
        if self.start not in ("zero", "middle"):
            raise UnknownNameError("start", self.start, ("zero", "middle"))
        whole_number("goals", self.goals, 1)
        whole_number("evaluations", self.evaluations, 1)
        whole_number("runs", self.runs, 1)
        whole_number("seed", self.seed, 0, 2**32)

    def identity(self, robot: Robot) -> dict[str, Any]:
        """Return what two runs must share for one to go on where the other stopped."""
        fields = dataclasses.asdict(self)
        for name in ("evaluations", "threads"):
            del fields[name]
        chain = [robot.lower.tolist(), robot.upper.tolist(), robot.fk(np.zeros(robot.dof)).tolist()]
        return {"robot": robot.name, "geometry": chain, "version": __version__} | fields


@dataclass(frozen=True, kw_only=True)
class Report:
    """How far a search has come."""

    evaluations: int
    """Gain sets judged."""
    wanted: int
    """Gain sets to be judged."""
    cost: float
    """Mean cost of the best."""


def template(robot: Robot, tuning: Tuning) -> Gains:
    """Return the gains that a search starts from.

    Half the pseudo-inverse in the middle of the limits, as a matrix or as the settled gain
    of a state space; for IK-PID the published gains, scaled by the robot's reach.
    """
    common: dict[str, Any] = {
        "start": tuning.start,
        "max_iterations": 1000,
        "max_restarts": 0,
        "robot": robot.name,
    }
    if tuning.solver == "ik-pid":
        share = _PID_REACH_M / robot.reach_radius
        return IkPid(kp=0.012 * share, ki=1.3e-8 * share, kd=0.08 * share, **common)
    lower = np.where(np.isfinite(robot.lower), robot.lower, 0.0)
    upper = np.where(np.isfinite(robot.upper), robot.upper, 0.0)
    jacobian = robot.jacobian(0.5 * (lower + upper))[:3]
    units = np.where([kind == "prismatic" for kind in robot.joint_types], _CENTIMETRE, _DEGREE)
    gain = 0.5 * np.linalg.pinv(jacobian, rcond=1e-2) * _CENTIMETRE / units[:, None]
    common |= {"length_unit_m": _CENTIMETRE, "angle_unit_rad": _DEGREE}
    if tuning.solver == "static-gain":
        return StaticGain(K=matrix_of("K", gain), **common)
    # The signs are the published ones. Inputs of at most one (and a half) leave the search
    # room to grow them: larger ones were seen to end in poorer sets.
    pole = 0.0 if tuning.shape == "input" else -0.5
    output = -float(np.abs(gain).max())
    eye = np.eye(robot.dof)
    inputs = gain * (1 - pole) / output
    matrices = {"A": pole * eye, "B": inputs, "C": output * eye}
    common |= {name: matrix_of(name, m) for name, m in matrices.items()}
    return StateSpace(**common)


def tune(
    robot: Robot,
    tuning: Tuning,
    *,
    checkpoint: Path | None = None,
    resume: bool = False,
    report: Callable[[Report], None] | None = None,
) -> GainFile:
    """Search gains and try them on goals of their own.

    Parameters
    ----------
    robot : Robot
        The arm.
    tuning : Tuning
        What to tune and how.
    checkpoint : Path, optional
        File that keeps what the search knows, every few seconds, so that a run that was
        killed can go on; removed when the search is done.
    resume : bool
        Go on from the checkpoint.
    report : callable, optional
        Called after every generation.

    Returns
    -------
    GainFile
        The gains with their training and their success on other goals.

    Raises
    ------
    ArgumentError
        A value out of its range.
    GainFileError
        The checkpoint is another run's or damaged, or exists already without `resume`.
    """
    start_from = template(robot, tuning)
    training_seed = 100 + tuning.seed
    goals = joint_uniform(robot, tuning.goals, training_seed)

    def search(run: int) -> Tuner:
        return Tuner(
            robot._chain,
            start_from,
            goals,
            tuning.shape,
            tuning.method,
            tuning.population or _POPULATION[tuning.method],
            tuning.sigma or _SIGMA[tuning.method],
            tuning.runs * tuning.seed + run,
            tuning.start,
            tuning.max_iterations,
            tuning.tolerance,
            tuning.threads,
        )

    progress = _Progress(identity=tuning.identity(robot))
    tuner = search(0)
    if checkpoint is not None:
        state = _prepare(checkpoint, progress, resume)
        if state is not None:
            tuner = search(progress.run)
            _restore(checkpoint, tuner, state)
    saved = time.monotonic()
    while True:
        while tuner.evaluations < tuning.evaluations:
            tuner.advance()
            if report is not None:
                report(
                    Report(
                        evaluations=progress.evaluations + tuner.evaluations,
                        wanted=tuning.runs * tuning.evaluations,
                        cost=min(progress.cost, tuner.cost),
                    )
                )
            if checkpoint is not None and time.monotonic() - saved > CHECKPOINT_PERIOD_S:
                _save(checkpoint, progress, tuner.state())
                saved = time.monotonic()
        progress.end_run(tuner)
        if progress.run >= tuning.runs:
            break
        tuner = search(progress.run)
    best = progress.best
    cost, solved, _ = tuner.score(best)
    gains = _with_gains(start_from, tuner.gains(best))
    training = TrainingTable(
        origin=f"{tuning.method}, {tuner.dimension} parameters",
        law=LAW,
        seed=training_seed,
        goals=tuning.goals,
        evaluations=progress.evaluations,
        cost=cost,
        solved=solved,
    )
    content = _content(gains, robot, tuning, training)
    if checkpoint is not None:
        checkpoint.unlink(missing_ok=True)
    return content


def _with_gains(start_from: Gains, gains: dict[str, Any]) -> Gains:
    if isinstance(start_from, IkPid):
        # The core counts in rad per m.
        unit = start_from.angle_unit_rad / start_from.length_unit_m
        gains = {name: value / unit for name, value in gains.items()}
    return dataclasses.replace(start_from, **gains)


def _content(gains: Gains, robot: Robot, tuning: Tuning, training: TrainingTable) -> GainFile:
    names = {"state-space": "ABC", "static-gain": "K", "ik-pid": ("kp", "ki", "kd")}[gains.name]
    numbers = {name: getattr(gains, name) for name in names}
    rows = {
        name: [list(row) for row in value] if isinstance(value, tuple) else value
        for name, value in numbers.items()
    }
    return GainFile.model_validate(
        {
            "solver": gains.name,
            "robot": robot.name,
            "start": tuning.start,
            "units": {"length": "mm" if gains.name == "ik-pid" else "cm", "angle": "deg"},
            "gains": rows,
            "training": training.model_dump(exclude_none=True),
            "success": _success(gains, robot, tuning).model_dump(exclude_none=True),
        }
    )


def _success(gains: Gains, robot: Robot, tuning: Tuning) -> SuccessTable:
    goals = joint_uniform(robot, TEST_GOALS, TEST_SEED)
    answer = robot.ik(
        goals, solver=gains, position_tolerance=tuning.tolerance, threads=tuning.threads
    )
    solved = int(answer.success.sum())
    mean = float(answer.iterations[answer.success].mean()) if solved else None
    return SuccessTable(
        law=LAW,
        seed=TEST_SEED,
        goals=TEST_GOALS,
        solved=solved,
        tolerance_m=tuning.tolerance,
        max_iterations=gains.max_iterations,
        mean_iterations=mean,
    )


@dataclass
class _Progress:
    """What is known of the runs that have ended."""

    identity: dict[str, Any]
    run: int = 0
    evaluations: int = 0
    cost: float = float("inf")
    best: FloatArray = field(default_factory=lambda: np.zeros(0))

    def end_run(self, tuner: Tuner) -> None:
        self.run += 1
        self.evaluations += tuner.evaluations
        if tuner.cost < self.cost or self.best.size == 0:
            self.cost = tuner.cost
            self.best = tuner.best


def _prepare(path: Path, progress: _Progress, resume: bool) -> FloatArray | None:
    """Take up the stored progress; returns the state of the run that had not ended."""
    if not resume:
        if path.exists():
            message = "is the checkpoint of a run that did not end; resume it or remove it"
            raise GainFileError(str(path), message)
        return None
    if not path.exists():
        raise GainFileError(str(path), "no such checkpoint to resume")
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            other = json.loads(str(stored["identity"]))
            state: FloatArray = stored["state"]
            best: FloatArray = stored["best"]
            run, evaluations = (int(x) for x in stored["counts"])
            cost = float(stored["cost"])
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise GainFileError(str(path), f"is no whole checkpoint: {error}") from None
    wanted = json.loads(json.dumps(progress.identity))
    for key, value in wanted.items():
        if other.get(key) != value:
            message = f"belongs to another run: {key} {other.get(key)!r}, not {value!r}"
            raise GainFileError(str(path), message)
    progress.run, progress.evaluations = run, evaluations
    progress.cost, progress.best = cost, best
    return state


def _restore(path: Path, tuner: Tuner, state: FloatArray) -> None:
    try:
        tuner.restore(state)
    except ArgumentError as error:
        raise GainFileError(str(path), str(error)) from None


def _save(path: Path, progress: _Progress, state: FloatArray) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}.partial")
    with temporary.open("wb") as stream:
        np.savez(
            stream,
            identity=np.array(json.dumps(progress.identity)),
            counts=np.array([progress.run, progress.evaluations]),
            cost=np.array(progress.cost),
            best=progress.best,
            state=state,
        )
    temporary.replace(path)
