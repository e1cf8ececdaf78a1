"""What is searched for and how: the searches of a run, one after the other."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._checks import FloatArray, matrix, real_number, whole_number, word
from .._native import Tuner, __version__
from ..errors import ArgumentError
from ..robot import Robot
from ..solvers import IkPid, StateSpace, StaticGain
from .goals import joint_uniform, joint_uniform_poses, joint_uniform_q

SOLVERS = ("state-space", "static-gain", "ik-pid")
TASKS = ("position", "pose")
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
# Length that a radian counts as where none is asked for, as a share of the reach.
_ROTATION_SHARE = 0.3
# The refinement: goals for one of a search, and the deviation it begins with.
_MORE_GOALS = 4
_REFINEMENT_SIGMA = 0.05
VALIDATION_GOALS = 10_000
# Streams of goals are apart from each other, and from that of the tests, for any seed.
TRAINING_SEED = 100
_REFINEMENT_SEED = 2**40
VALIDATION_SEED = 2**48

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
    task : {"position", "pose"}
        What the gains are for: tool points, or whole poses.
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
    orientation_tolerance : float
        Angle that counts as reached, rad; for poses.
    rotation_length : float, optional
        Poses: length that one radian of orientation error counts as, m; 0.3 times the
        robot's reach if not given. Not for IK-PID, which counts as all solvers do by
        default.
    threads : int, optional
        Number of threads.

    Examples
    --------
    >>> from agrik_fast.tuning import Tuning
    >>> Tuning(solver="static-gain", goals=500).method
    'pso'
    """

    solver: str = "state-space"
    shape: str = "input"
    method: str = "pso"
    start: str = "zero"
    task: str = "position"
    goals: int = 3000
    evaluations: int = 4840
    runs: int = 3
    refinement: int = 2400
    population: int | None = None
    sigma: float | None = None
    seed: int = 0
    max_iterations: int = 400
    tolerance: float = 1e-3
    orientation_tolerance: float = 1e-2
    rotation_length: float | None = None
    threads: int | None = None

    def __post_init__(self) -> None:
        word("solver", self.solver, SOLVERS)
        word("shape", self.shape, SHAPES)
        word("method", self.method, _POPULATION)
        word("start", self.start, ("zero", "middle"))
        word("task", self.task, TASKS)
        angle = self.orientation_tolerance
        real_number("orientation_tolerance", angle, 0, math.pi, open_low=True, unit="rad")
        if self.rotation_length is not None:
            real_number("rotation_length", self.rotation_length, 0, open_low=True, unit="m")
            if self.task != "pose" or self.solver == "ik-pid":
                expected = 'None but for task "pose" with matrices of gains'
                raise ArgumentError("rotation_length", repr(self.rotation_length), expected)
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

        Examples
        --------
        >>> from agrik_fast.tuning import Tuning
        >>> Tuning.usual("ik-pid").method, Tuning.usual("ik-pid", goals=100).goals
        ('cma', 100)
        """
        word("solver", solver, SOLVERS)
        return cls(solver=solver, **(_USUAL.get(solver, {}) | fields))

    def identity(self, robot: Robot) -> dict[str, Any]:
        """Return what two runs must share for one to go on where the other stopped."""
        fields = dataclasses.asdict(self)
        del fields["threads"]
        # Where the tool is in some postures tells the geometry, whatever it is made of.
        postures = np.vstack([np.zeros(robot.dof), joint_uniform_q(robot, 4, 0)])
        chain = [robot.lower.tolist(), robot.upper.tolist(), robot.fk(postures).tolist()]
        return {"robot": robot.name, "geometry": chain, "version": __version__} | fields


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A search on the way: from where, over which numbers, on which goals."""

    shape: str
    method: str
    from_best: bool
    evaluations: int
    sigma: float
    seed: int
    goals: int
    goal_seed: int

    def population(self, tuning: Tuning) -> int:
        return tuning.population or _POPULATION[self.method]

    def tuner(self, robot: Robot, tuning: Tuning, start_from: Gains) -> Tuner:
        return Tuner(
            robot._chain,
            start_from,
            goals_of(robot, tuning, self.goals, self.goal_seed),
            self.shape,
            self.method,
            self.population(tuning),
            self.sigma,
            self.seed,
            tuning.start,
            tuning.max_iterations,
            tuning.tolerance,
            tuning.orientation_tolerance,
            tuning.threads,
        )


def goals_of(robot: Robot, tuning: Tuning, count: int, seed: int) -> FloatArray:
    """Return tool points, shape (count, 3), or poses, shape (count, 4, 4)."""
    drawn = joint_uniform_poses if tuning.task == "pose" else joint_uniform
    return drawn(robot, count, seed)


def legs_of(tuning: Tuning) -> list[Leg]:
    """Return the searches: of B alone and its refinement, then of the shape wanted."""
    narrow = "input" if tuning.solver == "state-space" else tuning.shape
    search = Leg(
        shape=narrow,
        method=tuning.method,
        from_best=False,
        evaluations=tuning.evaluations,
        sigma=tuning.sigma or _SIGMA[tuning.method],
        seed=0,
        goals=tuning.goals,
        goal_seed=TRAINING_SEED + tuning.seed,
    )
    refinement = Leg(
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

    Examples
    --------
    >>> from agrik_fast.tuning import Tuning, template
    >>> np.shape(template(ik.Robot.load("hydrolek"), Tuning(solver="static-gain")).K)
    (6, 3)
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
    length = None
    if tuning.task == "pose":
        length = tuning.rotation_length or _ROTATION_SHARE * robot.reach_radius
    common["rotation_length_m"] = length
    gain = robot._chain.frozen_gain(length) * _CENTIMETRE / units[:, None]
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
