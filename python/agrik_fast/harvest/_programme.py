"""The harvest posture as a non-linear programme, for any arm with bodies."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, finite_array, real_number, shown, whole_number
from ..collision import Scene, Target
from ..errors import ArgumentError
from ..robot import Robot
from ._decisions import Decision, Decisions
from ._settings import Distance, Settings
from ._station import Crop

__all__ = ["Programme", "Runs", "Terms", "Weights"]


@dataclass(frozen=True)
class Weights:
    """What the terms of the programme weigh.

    Parameters
    ----------
    position : float, default 1, 1/m
        Of equation (4), the distance of the tool point from the grip point. The paper prints
        no unit; its best costs make it metres.
    orientation : float, default 1
        Of equation (5), how far the tool's x axis is from pointing down.
    distance : float, default 1
        Of equation (6), which is 1 where anything is touched and 0 from `enough` on.
    enough : float, default 0.075, m
        Distance from the crop that is enough.

    Raises
    ------
    ArgumentError
        A number out of its range, or all weights zero.

    Examples
    --------
    >>> ik.harvest.Weights(orientation=0.1).enough
    0.075
    """

    position: float = 1.0
    orientation: float = 1.0
    distance: float = 1.0
    enough: float = 0.075

    def __post_init__(self) -> None:
        total = 0.0
        for name in ("position", "orientation", "distance"):
            total += real_number(name, getattr(self, name), 0.0)
        if total == 0:
            raise ArgumentError("weights", "all zero", "one of the weights above 0")
        real_number("enough", self.enough, 0.0, open_low=True, unit="m")


@dataclass(frozen=True, eq=False)
class Terms:
    """The cost of postures, term by term.

    Attributes
    ----------
    cost : ndarray, shape (...)
        Weighted sum, equation (3).
    position : ndarray, shape (...), m
        Equation (4).
    orientation : ndarray, shape (...), rad
        Equation (5): about the square root of two times the tilt.
    nearness : ndarray, shape (...)
        Equation (6), 0 to 1.
    distance : ndarray, shape (...), m
        Distance from the crop; 0 where bodies touch each other or a static thing.

    Examples
    --------
    >>> scene = ik.harvest.example_scene("cucumber_thin")
    >>> programme = ik.harvest.Programme("cucumber", scene, "C1")
    >>> terms = programme.terms(ik.Robot.load("cucumber").home)
    >>> bool(terms.position > 0.1)
    True
    """

    cost: FloatArray
    position: FloatArray
    orientation: FloatArray
    nearness: FloatArray
    distance: FloatArray

    def accepted(self, position: float = 1e-3, orientation: float = 1e-3) -> NDArray[np.bool_]:
        """Which postures reach the fruit and touch nothing, whatever their cost.

        Parameters
        ----------
        position : float, default 1e-3, m
            Largest position error.
        orientation : float, default 1e-3, rad
            Largest orientation term.

        Returns
        -------
        ndarray of bool, shape (...)
            With the usual weights keeping away from the crop may be cheaper than reaching the
            fruit, so a low cost alone says little.

        Examples
        --------
        >>> scene = ik.harvest.example_scene("cucumber_thin")
        >>> programme = ik.harvest.Programme("cucumber", scene, "C1")
        >>> bool(programme.terms(ik.Robot.load("cucumber").home).accepted())
        False
        """
        near = (self.position <= position) & (self.orientation <= orientation)
        return np.asarray(near & (self.distance > 0))


@dataclass(frozen=True, eq=False)
class Runs:
    """Runs of a population search, one a seed.

    Attributes
    ----------
    seeds : tuple of n int
    q : ndarray, shape (n, dof), rad and m
        Best postures.
    terms : Terms
        Their cost, shape (n,).
    generations, evaluations : ndarray of int, shape (n,)
    history : tuple of n ndarray
        Best cost of the first population and after each generation.

    Examples
    --------
    >>> scene = ik.harvest.example_scene("cucumber_thin")
    >>> programme = ik.harvest.Programme("cucumber", scene, "C1")
    >>> runs = programme.differential(range(3), generations=5)
    >>> runs.seeds, len(runs.history)
    ((0, 1, 2), 3)
    """

    seeds: tuple[int, ...]
    q: FloatArray
    terms: Terms
    generations: NDArray[np.int64]
    evaluations: NDArray[np.int64]
    history: tuple[FloatArray, ...]


def _terms(columns: dict[str, Any]) -> Terms:
    names = ("cost", "position", "orientation", "nearness", "distance")
    return Terms(*(np.asarray(columns[name]) for name in names))


class Programme:
    """The programme (1) to (6) of the cucumber paper for one target.

    Minimise the weighted sum of position error, orientation error and nearness over all joints
    within their limits. The approach angle is free: the tool's x axis is to point down.

    Parameters
    ----------
    robot : Robot or str
        Any arm with bodies.
    scene : Scene
        As for `plan`.
    target : str, Target or array_like of shape (3,), m
        What to pick.
    weights : Weights, optional
    distance, level, split
        As for `plan`.

    Raises
    ------
    ArgumentError, UnknownNameError
        As `plan`, but for the structure of the arm.

    Examples
    --------
    >>> from agrik_fast import harvest
    >>> programme = harvest.Programme("cucumber", harvest.example_scene("cucumber_thin"), "C1")
    >>> best = programme.null_space()
    >>> bool(programme.terms(best.q).cost < 1e-6)
    True
    """

    def __init__(
        self,
        robot: Robot | str,
        scene: Scene,
        target: str | Target | ArrayLike,
        *,
        weights: Weights | None = None,
        distance: Distance = "exact",
        level: int = 3,
        split: Literal["equal", "near-cubic"] = "equal",
    ) -> None:
        self._crop = Crop(robot, scene, distance, level, split)
        if isinstance(target, str):
            chosen = self._crop.chosen([target])
        elif isinstance(target, Target):
            chosen = self._crop.chosen({"target": target})
        else:
            chosen = self._crop.chosen(finite_array("target", target, (3,))[None])
        self.weights = Weights() if weights is None else weights
        if not isinstance(self.weights, Weights):
            raise ArgumentError("weights", shown(weights), "harvest.Weights")
        self._chosen = chosen
        of = self.weights
        x, y, z = chosen.points[0].tolist()
        self._native = self._crop.programme(
            (x, y, z),
            chosen.objects[0],
            [float(of.position), float(of.orientation), float(of.distance), float(of.enough)],
        )

    def terms(self, q: ArrayLike) -> Terms:
        """Return the cost of postures, term by term.

        Parameters
        ----------
        q : array_like, shape (..., dof), rad or m
            Joint values, finite.

        Returns
        -------
        Terms

        Raises
        ------
        ArgumentError
            A wrong shape, or a number that is not finite.

        Examples
        --------
        >>> scene = ik.harvest.example_scene("cucumber_thin")
        >>> programme = ik.harvest.Programme("cucumber", scene, "C1")
        >>> programme.terms(ik.Robot.load("cucumber").random_q(3, seed=1)).cost.shape
        (3,)
        """
        return _terms(self._native.terms(q))

    def genetic(
        self, seeds: int | Iterable[int] = 0, *, threads: int | None = None, **options: float
    ) -> Runs:
        """Search with a real-coded genetic algorithm, as the paper did.

        Parameters
        ----------
        seeds : int or iterable of int, default 0
            One run a seed.
        threads : int, optional
            Number of threads, a run each; answers do not depend on it.
        **options
            ``population`` (100), ``generations`` (1500), ``target_cost`` (1.5e-4, at which a
            run ends), ``stagnation`` (0: none), ``tournament`` (2), ``crossover_rate`` (0.9),
            ``crossover_index`` (10), ``mutation_rate`` (0.15 a gene), ``mutation_width`` (0.15
            of the range), ``mutation_end`` (1e-4, the share of it that is left at the end),
            ``elites`` (2). The paper does not give its own.

        Returns
        -------
        Runs

        Raises
        ------
        ArgumentError, UnknownNameError
            An option out of its range, or of an unknown name.

        Examples
        --------
        >>> scene = ik.harvest.example_scene("cucumber_thin")
        >>> programme = ik.harvest.Programme("cucumber", scene, "C1")
        >>> programme.genetic(1, generations=5).terms.cost.shape
        (1,)
        """
        return self._search("ga", seeds, threads, options)

    def differential(
        self, seeds: int | Iterable[int] = 0, *, threads: int | None = None, **options: float
    ) -> Runs:
        """Search with differential evolution, best/1/bin.

        Parameters
        ----------
        seeds, threads
            As for `genetic`.
        **options
            ``population`` (70), ``generations`` (1500), ``target_cost`` (1e-9),
            ``stagnation`` (0), ``weight`` (0.4) and ``dither`` (0.5, drawn on top of it for
            each generation), ``crossover_rate`` (0.9).

        Returns
        -------
        Runs

        Raises
        ------
        ArgumentError, UnknownNameError
            As `genetic`.

        Examples
        --------
        >>> scene = ik.harvest.example_scene("cucumber_thin")
        >>> programme = ik.harvest.Programme("cucumber", scene, "C1")
        >>> runs = programme.differential([1, 2], generations=5)
        >>> runs.q.shape
        (2, 7)
        """
        return self._search("de", seeds, threads, options)

    def _search(
        self,
        algorithm: str,
        seeds: int | Iterable[int],
        threads: int | None,
        options: dict[str, float],
    ) -> Runs:
        each = [seeds] if not isinstance(seeds, Iterable) else list(seeds)
        checked = [whole_number("seeds", seed, 0, 2**64 - 1) for seed in each]
        found = self._native.search(algorithm, checked, options, threads)
        return Runs(
            tuple(checked),
            np.asarray(found["q"]),
            _terms(found),
            np.asarray(found["generations"]),
            np.asarray(found["evaluations"]),
            tuple(found["history"]),
        )

    def null_space(self, *, angles: int = 73, slides: int = 41) -> Decision:
        """Scan approach angle, slide and branch: exact in position and orientation.

        What is left of the cost is nearness, so the posture farthest from the crop is best. For
        arms on a slide only, as `plan`.

        Parameters
        ----------
        angles, slides : int, default 73 and 41
            Places of the grid.

        Returns
        -------
        Decision

        Raises
        ------
        ArgumentError
            A robot without the structure.

        Examples
        --------
        >>> scene = ik.harvest.example_scene("cucumber_thin")
        >>> programme = ik.harvest.Programme("cucumber", scene, "C1")
        >>> best = programme.null_space(angles=19, slides=11)
        >>> bool(programme.terms(best.q).position < 1e-6)
        True
        """
        settings = Settings(
            angles=angles,
            slides=slides,
            min_distance=0.0,
            min_freedom=0.0,
            enough=self.weights.enough,
            distance_weight=1.0,
            freedom_weight=0.0,
        )
        chosen = self._chosen
        columns = self._crop.station.plan(
            chosen.points, chosen.objects, list(chosen.names), settings.as_options(), True, 1
        )
        return Decisions(chosen.names, columns)[0]
