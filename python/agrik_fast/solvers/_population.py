"""Population solvers: many postures at once, better ones made out of good ones.

They need no Jacobian and look at the whole range of every joint, at the price of hundreds
of times the work of a step solver. With ``polish=True`` (the default) a short search hands
its best individuals to the default step solver, which makes up for the slow end of a
search; without it they stand as published methods do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

from .._checks import truth_value
from ._core import check_fields

__all__ = ["DifferentialEvolution", "GeneticAlgorithm"]

Boundary = Literal["median", "clamp", "reflect", "redraw"]
Orientation = Literal["rotation-vector", "euler-zyz"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferentialEvolution:
    """Differential evolution, named "de": differences of individuals as steps.

    A mutant ``best + F (a - b)`` is crossed gene by gene with an individual x and takes its
    place if it costs less. The cost of a posture is ``position_weight |dp| +
    orientation_weight |do|``, dp in m, do in rad. In the result, ``iterations`` counts
    generations, over all runs, and ``restarts`` runs after the first. Start values `q0`,
    if given, are one individual of the first population.

    Parameters
    ----------
    population : int, default 48
        Individuals; 4 to 2**20.
    generations : int, default 20
        Generations of one run; 1 to 2**32 - 1.
    mutation : {"best1", "rand1", "current-to-best1"}, default "best1"
        What a mutant starts from: the best individual, a random one, or the individual
        itself, on its way to the best.
    adaptation : {"none", "jde", "lshade"}, default "none"
        Where F and the crossover rate come from: from `weight` and `crossover`; from each
        individual, which carries its own (jDE); or from a memory of successful ones, with
        an archive, a shrinking population and a mutation of its own (L-SHADE).
    weight : float, default 0.5
        Weight F of the differences; no unit, > 0 and <= 2.
    crossover : tuple of 2 float, default (0.375, 1.125)
        Range from which the crossover rate is drawn; no unit, 0 to 2. Equal ends make it
        constant; a rate above 1 counts as 1.
    redraw : {"gene", "individual", "generation"}, default "individual"
        How often the crossover rate is drawn.
    boundary : {"median", "clamp", "reflect", "redraw"}, default "redraw"
        What becomes of a gene out of its joint's limits: the middle of the range, the
        limit, the value mirrored at the limit, or a new random one. Joints without limits
        are wrapped.
    max_restarts : int, default 20
        Runs after the first before the target is given up; 0 to 2**32 - 1.
    orientation : {"rotation-vector", "euler-zyz"}, default "rotation-vector"
        Measure of an orientation error: the angle of the rotation, or the root of the
        summed squares of the differences of the ZYZ Euler angles (pose tasks only).
    position_weight : float, default 1.0
        Cost per m; >= 0.
    orientation_weight : float or None, default None
        Cost per rad; >= 0. None: `position_weight` times 0.3 of the robot's reach in m.
    start_weight : float, default 0.0
        Cost per rad (or m) of distance from `q0`, for postures near it; >= 0. With it the
        polish keeps near `q0`, too, in the null space of the task.
    target_cost : float, default 0.0
        A run ends when its best cost is not above this; >= 0.
    stagnation : int, default 0
        A run ends after so many generations in which the best cost fell by less than a
        thousandth in all; 0 to 2**32 - 1, 0 for never.
    polish : bool, default True
        Hand the best eight individuals of a run to the default step solver.

    Raises
    ------
    ArgumentError
        A field is out of its range.
    UnknownNameError
        A word that is none of those listed; names the nearest.

    References
    ----------
    Storn and Price, "Differential evolution", Journal of Global Optimization 11, 1997.
    Brest et al., "Self-adapting control parameters in differential evolution", IEEE
    Transactions on Evolutionary Computation 10(6), 2006. Tanabe and Fukunaga, "Improving
    the search performance of SHADE using linear population size reduction", IEEE CEC 2014.

    Examples
    --------
    >>> from agrik_fast.solvers import DifferentialEvolution
    >>> DifferentialEvolution(population=100).population
    100
    >>> DifferentialEvolution.paper().boundary
    'median'
    """

    name: ClassVar[str] = "de"
    population: int = 48
    generations: int = 20
    mutation: Literal["best1", "rand1", "current-to-best1"] = "best1"
    adaptation: Literal["none", "jde", "lshade"] = "none"
    weight: float = 0.5
    crossover: tuple[float, float] = (0.375, 1.125)
    redraw: Literal["gene", "individual", "generation"] = "individual"
    boundary: Boundary = "redraw"
    max_restarts: int = 20
    orientation: Orientation = "rotation-vector"
    position_weight: float = 1.0
    orientation_weight: float | None = None
    start_weight: float = 0.0
    target_cost: float = 0.0
    stagnation: int = 0
    polish: bool = True

    def __post_init__(self) -> None:
        truth_value(f"{type(self).__name__}.polish", self.polish)
        crossover: object = self.crossover
        if isinstance(crossover, Sequence) and not isinstance(crossover, str):
            object.__setattr__(self, "crossover", tuple(crossover))
        check_fields(self)

    @classmethod
    def paper(cls) -> DifferentialEvolution:
        """Return the recipe published for the robot redundant7, in the adopted reading.

        Li et al., "Inverse Kinematics Study for Intelligent Agriculture Robot Development
        via Differential Evolution Algorithm", equations (4) to (10): best/1/bin, F = 0.5, a
        crossover rate 3/4 (0.5 + rand) drawn for every gene, genes out of range put to the
        middle, 200 generations, no polish, no restart. The population (100) and the
        weights (1 per mm, 100 per rad of ZYZ angles) are not published; these fit the
        published costs.

        Examples
        --------
        >>> recipe = ik.solvers.DifferentialEvolution.paper()
        >>> recipe.generations, recipe.population, recipe.polish
        (200, 100, False)
        """
        return cls(
            population=100,
            generations=200,
            redraw="gene",
            boundary="median",
            max_restarts=0,
            orientation="euler-zyz",
            position_weight=1000.0,
            orientation_weight=100.0,
            polish=False,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GeneticAlgorithm:
    """A real-coded genetic algorithm, named "ga".

    Parents win tournaments; pairs are crossed gene by gene (simulated binary crossover),
    genes mutate by normal deviates, the best live on. Cost, start values, restarts and
    polish are those of `DifferentialEvolution`.

    Parameters
    ----------
    population : int, default 48
        Individuals; 4 to 2**20.
    generations : int, default 20
        Generations of one run; 1 to 2**32 - 1.
    tournament : int, default 3
        Individuals that compete to become a parent; 1 to `population`.
    crossover_rate : float, default 0.9
        Share of pairs that are crossed; 0 to 1.
    crossover_index : float, default 5.0
        Distribution index of the crossover: the larger, the nearer to their parents are
        the children; no unit, >= 0.
    mutation_rate : float, default 0.2
        Chance of a gene to mutate; 0 to 1.
    mutation_width : float, default 0.1
        Standard deviation of a mutation relative to the gene's range; no unit, >= 0.
    elites : int, default 2
        Best individuals that live on unchanged; 0 to `population` - 1.
    boundary : {"median", "clamp", "reflect", "redraw"}, default "clamp"
        What becomes of a gene out of its joint's limits, as in `DifferentialEvolution`.
    max_restarts : int, default 20
        Runs after the first before the target is given up; 0 to 2**32 - 1.
    orientation : {"rotation-vector", "euler-zyz"}, default "rotation-vector"
        Measure of an orientation error.
    position_weight : float, default 1.0
        Cost per m; >= 0.
    orientation_weight : float or None, default None
        Cost per rad; >= 0. None: `position_weight` times 0.3 of the robot's reach in m.
    start_weight : float, default 0.0
        Cost per rad (or m) of distance from `q0`; >= 0.
    target_cost : float, default 0.0
        A run ends when its best cost is not above this; >= 0.
    stagnation : int, default 0
        A run ends after so many generations in which the best cost fell by less than a
        thousandth in all; 0 to 2**32 - 1, 0 for never.
    polish : bool, default True
        Hand the best eight individuals of a run to the default step solver.

    Raises
    ------
    ArgumentError
        A field is out of its range.
    UnknownNameError
        A word that is none of those listed; names the nearest.

    References
    ----------
    Deb and Agrawal, "Simulated binary crossover for continuous search space", Complex
    Systems 9, 1995.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> bool(arm.ik([0.4, 0.2, 0.3], solver=ik.solvers.GeneticAlgorithm(), seed=1).success)
    True
    """

    name: ClassVar[str] = "ga"
    population: int = 48
    generations: int = 20
    tournament: int = 3
    crossover_rate: float = 0.9
    crossover_index: float = 5.0
    mutation_rate: float = 0.2
    mutation_width: float = 0.1
    elites: int = 2
    boundary: Boundary = "clamp"
    max_restarts: int = 20
    orientation: Orientation = "rotation-vector"
    position_weight: float = 1.0
    orientation_weight: float | None = None
    start_weight: float = 0.0
    target_cost: float = 0.0
    stagnation: int = 0
    polish: bool = True

    def __post_init__(self) -> None:
        truth_value(f"{type(self).__name__}.polish", self.polish)
        check_fields(self)
