"""The search for gains, leg by leg, and the trial of what it finds."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._checks import matrix, whole_number, word
from .._native import Tuner, __version__
from ..robot import Robot
from ..solvers import IkPid, StateSpace, StaticGain
from ..solvers.gain_file import GainFile, SuccessTable, TrainingTable
from ._checkpoint import PERIOD_S, Progress, prepare, restore, save
from .goals import joint_uniform

__all__ = ["Report", "Tuning", "template", "tune"]

TEST_SEED = 1
"""Seed of the goals kept apart from the training."""
TEST_GOALS = 1000
LAW = "joint values uniform in the limits (SplitMix64)"
SOLVERS = ("state-space", "static-gain", "ik-pid")
SHAPES = ("input", "diagonal", "full")
_POPULATION = {"pso": 40, "cma": 24}
_SIGMA = {"pso": 0.3, "cma": 0.25}
_USUAL: dict[str, dict[str, Any]] = {
    "ik-pid": {"method": "cma", "goals": 600, "evaluations": 400, "refinement": 200}
}
_DEGREE = float(np.pi / 180)
_CENTIMETRE = 0.01
# Lengths that the published IK-PID gains belong to: the HydroLek's reach, m.
_PID_REACH_M = 1.49
# The refinement: goals for one of a search, and the deviation it begins with.
_MORE_GOALS = 4
_REFINEMENT_SIGMA = 0.05
_VALIDATION_GOALS = 10_000
# Streams of goals are apart from each other, and from that of the tests, for any seed.
_TRAINING_SEED = 100
_REFINEMENT_SEED = 2**40
_VALIDATION_SEED = 2**48

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
        Gain sets to judge in a search, rounded up to whole generations.
    runs : int
        Searches from other random numbers, of which the best is kept: now and then one
        ends in a poor valley. They look for B alone; a wider shape is searched once, from
        the best of them.
    refinement : int
        Gain sets to judge in the refinement of the best by CMA-ES, which trains on four
        times `goals` other goals, once for B alone and once for a wider shape; 0 for none.
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
    refinement: int = 2400
    population: int | None = None
    sigma: float | None = None
    seed: int = 0
    max_iterations: int = 400
    tolerance: float = 1e-3
    threads: int | None = None

    def __post_init__(self) -> None:
        word("solver", self.solver, SOLVERS)
        word("shape", self.shape, SHAPES)
        word("method", self.method, _POPULATION)
        word("start", self.start, ("zero", "middle"))
        whole_number("goals", self.goals, 1)
        whole_number("evaluations", self.evaluations, 1)
        whole_number("runs", self.runs, 1)
        whole_number("refinement", self.refinement, 0)
        whole_number("seed", self.seed, 0, 2**32)

    @classmethod
    def usual(cls, solver: str, **fields: Any) -> Tuning:
        """Return what to begin with for a solver.

        IK-PID has three numbers and slow steps: CMA-ES finds them with 600 goals and 400
        gain sets, on which the others would be at work for an hour.

        Parameters
        ----------
        solver : {"state-space", "static-gain", "ik-pid"}
            Whose gains.
        **fields
            Other fields that are to differ from the usual ones.
        """
        word("solver", solver, SOLVERS)
        return cls(solver=solver, **(_USUAL.get(solver, {}) | fields))

    def identity(self, robot: Robot) -> dict[str, Any]:
        """Return what two runs must share for one to go on where the other stopped."""
        fields = dataclasses.asdict(self)
        del fields["threads"]
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
    """Mean cost of the best of the present search, on its own goals."""


@dataclass(frozen=True, kw_only=True)
class _Leg:
    """A search on the way: from where, over which numbers, on which goals."""

    shape: str
    method: str
    from_best: bool
    evaluations: int
    sigma: float
    seed: int
    goals: int
    goal_seed: int

    def tuner(self, robot: Robot, tuning: Tuning, start_from: Gains) -> Tuner:
        return Tuner(
            robot._chain,
            start_from,
            joint_uniform(robot, self.goals, self.goal_seed),
            self.shape,
            self.method,
            tuning.population or _POPULATION[self.method],
            self.sigma,
            self.seed,
            tuning.start,
            tuning.max_iterations,
            tuning.tolerance,
            tuning.threads,
        )


def _legs(tuning: Tuning) -> list[_Leg]:
    """Return the searches: of B alone and its refinement, then of the shape wanted."""
    narrow = "input" if tuning.solver == "state-space" else tuning.shape
    search = _Leg(
        shape=narrow,
        method=tuning.method,
        from_best=False,
        evaluations=tuning.evaluations,
        sigma=tuning.sigma or _SIGMA[tuning.method],
        seed=0,
        goals=tuning.goals,
        goal_seed=_TRAINING_SEED + tuning.seed,
    )
    refinement = _Leg(
        shape=narrow,
        method="cma",
        from_best=True,
        evaluations=tuning.refinement,
        sigma=_REFINEMENT_SIGMA,
        seed=0,
        goals=_MORE_GOALS * tuning.goals,
        goal_seed=_REFINEMENT_SEED + tuning.seed,
    )
    legs = [search] * tuning.runs + [refinement]
    if narrow != tuning.shape:
        wide = dataclasses.replace(search, from_best=True)
        legs += [dataclasses.replace(leg, shape=tuning.shape) for leg in (wide, refinement)]
    # Each has random numbers of its own.
    first = len(legs) * tuning.seed
    numbered = [dataclasses.replace(leg, seed=first + i) for i, leg in enumerate(legs)]
    return [leg for leg in numbered if leg.evaluations > 0]


def template(robot: Robot, tuning: Tuning) -> Gains:
    """Return the gains that a search starts from.

    Half a pseudo-inverse, the gain of solvers without matrices, as it is or as the settled
    gain of a state space; for IK-PID the published gains, scaled by the robot's reach.
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
    units = np.where([kind == "prismatic" for kind in robot.joint_types], _CENTIMETRE, _DEGREE)
    gain = robot._chain.frozen_gain() * _CENTIMETRE / units[:, None]
    common |= {"length_unit_m": _CENTIMETRE, "angle_unit_rad": _DEGREE}
    if tuning.solver == "static-gain":
        return StaticGain(K=matrix("K", gain), **common)
    # The signs are the published ones. Inputs of at most one leave the search room to grow
    # them: larger ones were seen to end in poorer sets.
    output = -float(np.abs(gain).max())
    eye = np.eye(robot.dof)
    matrices = {"A": 0.0 * eye, "B": gain / output, "C": output * eye}
    common |= {name: matrix(name, rows) for name, rows in matrices.items()}
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
    legs = _legs(tuning)
    progress = Progress(identity=tuning.identity(robot))
    state = None if checkpoint is None else prepare(checkpoint, progress, resume)
    saved = time.monotonic()
    while progress.leg < len(legs):
        leg = legs[progress.leg]
        best = _with_gains(start_from, progress.gains)
        tuner = leg.tuner(robot, tuning, best if leg.from_best else start_from)
        if checkpoint is not None and state is not None:
            restore(checkpoint, tuner, state)
            state = None
        while tuner.evaluations < leg.evaluations:
            tuner.advance()
            if report is not None:
                judged = progress.evaluations + tuner.evaluations
                ahead = sum(other.evaluations for other in legs[progress.leg + 1 :])
                wanted = judged + max(leg.evaluations - tuner.evaluations, 0) + ahead
                report(Report(evaluations=judged, wanted=wanted, cost=tuner.cost))
            if checkpoint is not None and time.monotonic() - saved > PERIOD_S:
                save(checkpoint, progress, tuner.state())
                saved = time.monotonic()
        found = tuner.gains(tuner.best)
        score = _score(robot, tuning, _with_gains(start_from, found), *_validation(tuning))
        progress.end_leg(tuner, found, score)
    gains = _with_gains(start_from, progress.gains)
    training_seed = _TRAINING_SEED + tuning.seed
    cost, solved, dimension = _score(robot, tuning, gains, tuning.goals, training_seed)
    validation_goals, validation_seed = _validation(tuning)
    training = TrainingTable(
        origin=f"{tuning.method}, {dimension} parameters",
        law=LAW,
        seed=training_seed,
        goals=tuning.goals,
        evaluations=progress.evaluations,
        cost=cost,
        solved=solved,
        validation_seed=validation_seed,
        validation_goals=validation_goals,
        validation_solved=progress.solved,
    )
    content = _content(gains, robot, tuning, training)
    if checkpoint is not None:
        checkpoint.unlink(missing_ok=True)
    return content


def _validation(tuning: Tuning) -> tuple[int, int]:
    """Return number and seed of the goals that the choice between gain sets is made on."""
    return _VALIDATION_GOALS, _VALIDATION_SEED + tuning.seed


def _score(
    robot: Robot, tuning: Tuning, gains: Gains, count: int, seed: int
) -> tuple[float, int, int]:
    """Return mean cost and goals reached on a stream, and how many numbers are free."""
    leg = _legs(tuning)[-1]
    leg = dataclasses.replace(leg, shape=tuning.shape, goals=count, goal_seed=seed)
    judge = leg.tuner(robot, tuning, gains)
    cost, solved, _ = judge.score(judge.best)
    return cost, solved, judge.dimension


def _with_gains(start_from: Gains, gains: dict[str, Any]) -> Gains:
    """Return the start with a tuner's gains, or as it is where there are none yet."""
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
