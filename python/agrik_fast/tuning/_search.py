"""The search for gains, leg by leg, and the trial of what it finds."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._checks import FloatArray, shown
from .._native import Tuner
from ..errors import ArgumentError, GainFileError
from ..robot import Robot
from ..solvers import IkPid, gain_file
from ..solvers.gain_file import GainFile, SuccessTable, TrainingTable
from ._checkpoint import PERIOD_S, Bounds, Progress, prepare, restore, save
from ._plan import (
    TRAINING_SEED,
    VALIDATION_GOALS,
    VALIDATION_SEED,
    Gains,
    Tuning,
    goals_of,
    legs_of,
    template,
)

TEST_SEED = 1
"""Seed of the goals kept apart from the training."""
TEST_GOALS = 1000
LAW = "joint values uniform in the limits (SplitMix64)"


@dataclass(frozen=True, kw_only=True)
class Report:
    """How far a search has come.

    Examples
    --------
    >>> from agrik_fast.tuning import Report
    >>> report = Report(evaluations=40, wanted=400, cost=1.5)
    >>> f"{report.evaluations / report.wanted:.0%}"
    '10%'
    """

    evaluations: int
    """Gain sets judged."""
    wanted: int
    """Gain sets to be judged."""
    cost: float
    """Mean cost of the best of the present search, on its own goals."""
    unsaved: str = ""
    """Why the checkpoint could not be written; the search goes on all the same."""


def tune(
    robot: Robot,
    tuning: Tuning,
    *,
    checkpoint: Path | None = None,
    resume: bool = False,
    report: Callable[[Report], None] | None = None,
    store: Callable[[GainFile], None] | None = None,
) -> GainFile:
    """Search gains and try them on goals of their own.

    Parameters
    ----------
    robot : Robot
        The arm.
    tuning : Tuning
        What to tune and how.
    checkpoint : path, optional
        File that keeps what the search knows, every few seconds, so that a run that was
        killed can go on; removed when the search is done and `store` has returned.
    resume : bool
        Go on from the checkpoint.
    report : callable, optional
        Called after every generation.
    store : callable, optional
        Called with the content before the checkpoint goes, to put it in a safe place. What it
        raises is passed on; the checkpoint stays, and resuming goes on from the end.

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

    Examples
    --------
    >>> from agrik_fast.tuning import Tuning, tune
    >>> quick = Tuning(solver="static-gain", goals=50, evaluations=80, runs=1, refinement=0)
    >>> content = tune(ik.Robot.load("tomato"), quick)
    >>> content.solver, content.success.goals
    ('static-gain', 1000)
    """
    if store is not None and not callable(store):
        raise ArgumentError("store", shown(store), "a function that takes the gain file, or None")
    start_from = template(robot, tuning)
    legs = legs_of(tuning)
    progress = Progress(identity=tuning.identity(robot))
    keeper = _Keeper(checkpoint)
    state = keeper.prepare(progress, _bounds(robot, tuning, start_from), resume)
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
                report(
                    Report(
                        evaluations=judged,
                        wanted=wanted,
                        cost=tuner.cost,
                        unsaved=keeper.trouble,
                    )
                )
            keeper.keep(progress, tuner)
        found = tuner.gains(tuner.best)
        score = _score(robot, tuning, _with_gains(start_from, found), *_validation(tuning))
        progress.end_leg(tuner, found, score)
    keeper.keep(progress, None)
    gains = _with_gains(start_from, progress.gains)
    training_seed = TRAINING_SEED + tuning.seed
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
    if store is not None:
        store(content)
    if checkpoint is not None:
        checkpoint.unlink(missing_ok=True)
    return content


class _Keeper:
    """Writes the checkpoint every few seconds; a disk that refuses does not end the search."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._saved = time.monotonic()
        self.trouble = ""

    def prepare(self, progress: Progress, bounds: Bounds, resume: bool) -> FloatArray | None:
        return None if self._path is None else prepare(self._path, progress, bounds, resume)

    def keep(self, progress: Progress, tuner: Tuner | None) -> None:
        """Write if it is time: with a tuner after a while, without one at the end."""
        now = time.monotonic()
        if self._path is None or (tuner is not None and now - self._saved <= PERIOD_S):
            return
        self._saved = now
        try:
            save(self._path, progress, np.empty(0) if tuner is None else tuner.state())
        except GainFileError as error:
            self.trouble = str(error)
        else:
            self.trouble = ""


def _bounds(robot: Robot, tuning: Tuning, start_from: Gains) -> Bounds:
    """Return what a checkpoint of this run may hold."""
    low = high = 0
    evaluations = [(0, 0)]
    for leg in legs_of(tuning):
        low += leg.evaluations
        # The last generation of a search is judged as a whole.
        high += leg.evaluations + leg.population(tuning) - 1
        evaluations.append((low, high))
    leg = dataclasses.replace(legs_of(tuning)[-1], goals=1)
    tuner = leg.tuner(robot, tuning, start_from)
    shapes = {name: np.shape(value) for name, value in tuner.gains(tuner.best).items()}
    return Bounds(evaluations, _validation(tuning)[0], shapes)


def _validation(tuning: Tuning) -> tuple[int, int]:
    """Return number and seed of the goals that the choice between gain sets is made on."""
    return VALIDATION_GOALS, VALIDATION_SEED + tuning.seed


def _score(
    robot: Robot, tuning: Tuning, gains: Gains, count: int, seed: int
) -> tuple[float, int, int]:
    """Return mean cost and goals reached on a stream, and how many numbers are free."""
    leg = legs_of(tuning)[-1]
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
    units: dict[str, Any] = {"length": "mm" if gains.name == "ik-pid" else "cm", "angle": "deg"}
    if not isinstance(gains, IkPid) and gains.rotation_length_m is not None:
        units["rotation_length_m"] = gains.rotation_length_m
    return GainFile.model_validate(
        {
            "solver": gains.name,
            "robot": robot.name,
            "start": tuning.start,
            "units": units,
            "gains": rows,
            "training": training.model_dump(exclude_none=True),
            "success": trial(gains, robot, tuning).model_dump(exclude_none=True),
        }
    )


def trials(content: GainFile, robot: Robot, tuning: Tuning) -> dict[str, SuccessTable]:
    """Try tuned gains beside others with the same settings on the goals kept apart.

    Parameters
    ----------
    content : GainFile
        What `tune` returned.
    robot : Robot
        The arm.
    tuning : Tuning
        How the gains were tuned; start, steps and tolerances are those of every trial.

    Returns
    -------
    dict of SuccessTable
        "tuned"; "default", the gains that the search started from; and those of the package
        for this robot, kind of solver and task, by their names.

    Raises
    ------
    ArgumentError
        Gains that do not fit the robot.
    """
    start_from = template(robot, tuning)
    loop = {name: getattr(start_from, name) for name in ("start", "max_iterations", "max_restarts")}
    tuned = content.make()
    rivals: dict[str, Gains] = {"tuned": tuned, "default": start_from}
    for name in gain_file.bundled():
        other = gain_file.read(name)
        if (other.robot, other.solver) == (robot.name, content.solver):
            gains = other.make()
            if _error_rows(gains) == _error_rows(tuned):
                rivals[name] = gains
    return {
        name: trial(dataclasses.replace(gains, **loop), robot, tuning)
        for name, gains in rivals.items()
    }


def _error_rows(gains: Gains) -> int:
    """Return of how many rows the error is that gains take: three for positions."""
    matrix = {"state-space": "B", "static-gain": "K"}.get(gains.name)
    return 3 if matrix is None else len(getattr(gains, matrix)[0])


def trial(gains: Gains, robot: Robot, tuning: Tuning) -> SuccessTable:
    """Try gains on the goals kept apart from the training."""
    goals = goals_of(robot, tuning, TEST_GOALS, TEST_SEED)
    answer = robot.ik(
        goals,
        solver=gains,
        position_tolerance=tuning.tolerance,
        orientation_tolerance=tuning.orientation_tolerance,
        threads=tuning.threads,
    )
    solved = int(answer.success.sum())
    mean = float(answer.iterations[answer.success].mean()) if solved else None
    return SuccessTable(
        law=LAW,
        seed=TEST_SEED,
        goals=TEST_GOALS,
        solved=solved,
        tolerance_m=tuning.tolerance,
        tolerance_rad=tuning.orientation_tolerance if tuning.task == "pose" else None,
        max_iterations=gains.max_iterations,
        mean_iterations=mean,
    )
