"""A whole crop: which share of it can be picked, why not the rest, and which leaves block it."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, float_array, shown, truth_value
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import Robot
from ._cutter import Cut, Cutter, cut_distances
from ._decisions import Decisions, Status
from ._plan import Blockers, checked_settings, named
from ._settings import Distance, Settings
from ._station import Crop

__all__ = ["Evaluation", "evaluate"]

RUN = 200
"""Targets between two calls of `progress`."""
BLOCKED = (int(Status.APPROACH_BLOCKED), int(Status.NO_COLLISION_FREE))


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What `evaluate` found of a crop.

    Attributes
    ----------
    robot : Robot
    scene : Scene
    settings : Settings
    distance : str
        "exact" or "tree".
    decisions : Decisions
        One a target.
    blockers : dict of str to Blockers or None
        For targets that are blocked: what is in the way; None where no removal helps. Empty
        where it was not asked for.
    along : ndarray, shape (n,), m
        How far along the row the vehicle stood for each target.
    cut : Cut
        Whether the cut goes through the stalk, with the usual `Cutter`.
    seconds : float
        Time that the decisions and the blockers took, s.

    Examples
    --------
    >>> found = ik.harvest.evaluate(ik.harvest.example_scene())
    >>> len(found.decisions.names) == len(found.along)
    True
    """

    robot: Robot
    scene: Scene
    settings: Settings
    distance: str
    decisions: Decisions
    blockers: dict[str, Blockers | None]
    along: FloatArray
    cut: Cut
    seconds: float

    @property
    def share(self) -> float:
        """Share of the targets that can be picked, 0 to 1."""
        return float(self.decisions.ok.mean())

    def shares(self) -> dict[str, float]:
        """Share of the targets that can be picked, are blocked, and have no posture at all.

        Returns
        -------
        dict
            "ok"; "blocked" (`Status.APPROACH_BLOCKED` and `Status.NO_COLLISION_FREE`), "none"
            (out of reach or of the limits), and "other". They add up to 1.

        Examples
        --------
        >>> found = ik.harvest.evaluate(ik.harvest.example_scene())
        >>> round(sum(found.shares().values()), 12)
        1.0
        """
        of = self.decisions.shares()
        ok = of.get("OK", 0.0)
        blocked = of.get("APPROACH_BLOCKED", 0.0) + of.get("NO_COLLISION_FREE", 0.0)
        none = of.get("OUT_OF_REACH", 0.0) + of.get("JOINT_LIMITS", 0.0)
        return {"ok": ok, "blocked": blocked, "none": none, "other": 1.0 - ok - blocked - none}

    def leaves(self) -> list[tuple[str, int]]:
        """How many targets each object blocks: names and counts, the worst first.

        Returns
        -------
        list of (str, int)
            Of the objects that smallest sets of blockers hold.

        Examples
        --------
        >>> found = ik.harvest.evaluate(ik.harvest.example_scene())
        >>> all(count >= 1 for _, count in found.leaves())
        True
        """
        counts: Counter[str] = Counter()
        for found in self.blockers.values():
            if found is not None:
                counts.update(found.names)
        return sorted(counts.items(), key=lambda item: (-item[1], item[0]))

    def rows(self) -> Iterator[dict[str, Any]]:
        """Return one record a target, lengths in mm and angles in degrees as in the paper.

        Examples
        --------
        >>> found = ik.harvest.evaluate(ik.harvest.example_scene())
        >>> len(list(found.rows())) == len(found.decisions.names)
        True
        """
        points = {name: target.point for name, target in self.scene.targets.items()}
        for k, one in enumerate(self.decisions):
            x, y, z = (1e3 * value for value in points[one.name])
            found = self.blockers.get(one.name)
            record: dict[str, Any] = {
                "target": one.name,
                "x_mm": x,
                "y_mm": y,
                "z_mm": z,
                "along_mm": 1e3 * float(self.along[k]),
                "status": one.status.name,
                "open_angles": one.open,
                "angles": one.angles,
                "attempts": len(one.attempts),
            }
            if self.decisions.columns["found"][k]:
                record |= {
                    "stage": one.stage.name.lower(),
                    "psi_deg": float(np.degrees(one.psi)),
                    "slide_mm": 1e3 * one.slide,
                    "branch": one.branch,
                    "distance_mm": 1e3 * one.distance,
                    "exact_distance_mm": 1e3 * one.exact_distance,
                    "freedom": one.freedom,
                    "score": one.score,
                    "tilt_deg": float(np.degrees(one.tilt)),
                    "shift_mm": 1e3 * one.shift,
                    "warnings": "; ".join(one.warnings),
                    "cut_ok": bool(self.cut.ok[k]),
                }
                if np.isfinite(self.cut.distance[k]):
                    record["cut_mm"] = 1e3 * float(self.cut.distance[k])
                record |= {
                    name: float(value)
                    for name, value in zip(self.robot.joint_names, one.q, strict=True)
                }
            if one.name in self.blockers:
                record["blockers"] = "none helps" if found is None else " ".join(found.names)
                if found is not None:
                    record["blockers_exact"] = found.exact
            yield record


def evaluate(
    crop: Scene,
    robot: Robot | str = "cucumber",
    *,
    settings: Settings | None = None,
    distance: Distance = "exact",
    level: int = 3,
    split: Literal["equal", "near-cubic"] = "equal",
    blockers: bool = True,
    stops: ArrayLike | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Evaluation:
    """Decide for every fruit of a crop, and say what blocks those that cannot be picked.

    The paper's first application: whether a way of growing suits a robot. A target inside an
    obstacle, which `plan` refuses, is one that cannot be picked here.

    Parameters
    ----------
    crop : Scene
        The fruits are its targets.
    robot : Robot or str, default "cucumber"
        As for `plan`.
    settings, distance, level, split
        As for `plan`.
    blockers : bool, default True
        Name the leaves in the way of each target that is blocked.
    stops : array_like, shape (k,), m, optional
        Places of the vehicle along y, from where it stands: each fruit is decided from the
        nearest. What is of kind "machine" moves with it. Default: it does not move.
    threads : int, optional
        Number of threads.
    progress : callable, optional
        Called with the number of targets that are done, and of all, now and then.

    Returns
    -------
    Evaluation

    Raises
    ------
    ArgumentError
        A crop without fruit, no stop or one that is not finite; else as `plan`.
    KeyboardInterrupt
        Ctrl-C.

    Examples
    --------
    >>> from agrik_fast import harvest
    >>> found = harvest.evaluate(harvest.example_scene())
    >>> found.decisions.shares()["OK"] == found.share
    True
    >>> found.blockers["C2"].names
    ('leaf_e',)
    """
    if not isinstance(crop, Scene):
        raise ArgumentError("crop", shown(crop), "a Scene")
    if not crop.targets:
        received = f"a scene of {len(crop)} objects without targets"
        raise ArgumentError("crop", received, "a scene with a target for each fruit")
    if progress is not None and not callable(progress):
        raise ArgumentError("progress", shown(progress), "a function of two numbers")
    checked = checked_settings(settings)
    options, wanted = checked.as_options(), truth_value("blockers", blockers)
    start = time.perf_counter()
    made = Crop(robot, crop, distance, level, split)
    chosen = made.chosen(None)
    places = _places(stops)
    order, at = _by_stop(chosen.points, places)
    crops: dict[int, Crop] = {}
    parts: list[dict[str, Any]] = []
    blocking: dict[str, Blockers | None] = {}
    for first in range(0, len(order), RUN):
        for stop, rows in _runs(order[first : first + RUN], at):
            if stop not in crops:
                place = float(places[stop])
                crops = {stop: Crop(made.robot, crop, distance, level, split, place)}
            station = crops[stop].station
            points, names = chosen.points[rows], [chosen.names[k] for k in rows]
            objects = [chosen.objects[k] for k in rows]
            part = station.plan(points, objects, names, options, False, threads)
            parts.append(part)
            if wanted:
                hit = np.flatnonzero(np.isin(part["status"], BLOCKED))
                found = station.blockers(
                    points[hit],
                    [objects[k] for k in hit],
                    [names[k] for k in hit],
                    options,
                    threads,
                )
                blocking |= {names[k]: named(one, crop) for k, one in zip(hit, found, strict=True)}
        if progress is not None:
            progress(min(first + RUN, len(order)), len(order))
    seconds = time.perf_counter() - start
    decisions = Decisions(chosen.names, _joined(parts, order))
    along = places[at]
    cut = cut_distances(made.robot, crop, decisions, along, Cutter())
    return Evaluation(made.robot, crop, checked, distance, decisions, blocking, along, cut, seconds)


def _places(stops: ArrayLike | None) -> FloatArray:
    if stops is None:
        return np.zeros(1)
    places = float_array("stops", stops)
    if places.ndim != 1 or not len(places) or not np.isfinite(places).all():
        raise ArgumentError("stops", shown(stops), "one or more finite numbers, m")
    return places


def _by_stop(points: FloatArray, places: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the targets in the order of their stops, and the stop of each."""
    places_y = np.nan_to_num(points[:, 1], posinf=0.0, neginf=0.0)
    at = np.abs(places_y[:, None] - places).argmin(axis=1)
    return np.argsort(at, kind="stable"), at


def _runs(
    rows: NDArray[np.int64], at: NDArray[np.int64]
) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Return targets that share a stop, with the stop."""
    for stop in np.unique(at[rows]):
        yield int(stop), rows[at[rows] == stop]


def _joined(parts: list[dict[str, Any]], order: NDArray[np.int64]) -> dict[str, Any]:
    """Return the columns of several runs as those of one, in the order of the targets."""
    back = np.argsort(order, kind="stable")
    joined: dict[str, Any] = {
        name: np.concatenate([part[name] for part in parts])[back]
        for name in parts[0]
        if name != "attempts"
    }
    tables, first = [], 0
    for part in parts:
        table = dict(part["attempts"])
        table["target"] = order[first + table["target"]]
        first += len(part["status"])
        tables.append(table)
    joined["attempts"] = {
        name: np.concatenate([table[name] for table in tables]) for name in tables[0]
    }
    return joined
