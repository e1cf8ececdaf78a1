"""Decisions for fruits: whether an arm can pick them, in which posture, and what is in the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import ArrayLike

from .._checks import finite_array, shown, truth_value, word
from ..collision import Scene
from ..errors import ArgumentError
from ..motion import Fewest, Plan
from ..motion import Settings as PathSettings
from ..robot import Robot
from ._decisions import Decisions
from ._settings import Distance, Settings
from ._station import Chosen, Crop, Targets

__all__ = ["Blockers", "blockers", "plan"]


def plan(
    robot: Robot | str,
    scene: Scene,
    targets: Targets | None = None,
    *,
    settings: Settings | None = None,
    distance: Distance = "exact",
    level: int = 3,
    split: Literal["equal", "near-cubic"] = "equal",
    method: Literal["two-step", "full"] = "two-step",
    path: bool = False,
    start: ArrayLike | None = None,
    path_settings: PathSettings | None = None,
    threads: int | None = None,
) -> Decisions:
    """Decide for each target whether the arm can pick it, and in which posture.

    The two-step method of the cucumber paper for a six-axis arm with a spherical wrist on a
    slide: the approach angle is scanned with the gripper alone, then the slide with the closed
    form; all postures become rows of a table, and the best is taken by stated criteria. The
    tool comes along its z axis, its x axis down. Answers do not depend on `threads`.

    Parameters
    ----------
    robot : Robot or str
        An arm with bodies on a slide, or its name.
    scene : Scene
        The crop. Objects of kind "machine", and those that the robot's ``static_skip`` names,
        are never touched but may be near; all others keep their distance.
    targets : str, names, mapping of str to Target, or array_like of shape (n, 3), optional
        What to pick. The bodies that ``may_touch_target`` names do not mind a target's own
        objects. Default: all targets of the scene.
    settings : Settings, optional
        What is looked at, and what is preferred.
    distance : {"exact", "tree"}, default "exact"
        Between bodies and crop: as they are, or with boxes as spheres round their cells as in
        the paper, which is never farther.
    level : int, default 3
        Of the spheres: 8^level for a box, 0 to 3.
    split : {"equal", "near-cubic"}, default "equal"
        How boxes are cut into cells.
    method : {"two-step", "full"}, default "two-step"
        "full" looks at all approach angles and places of the slide, and takes the best.
    path : bool, default False
        Plan the way into the posture as well, and prove it free: goals are all admissible
        postures of the approach, then those of all others. The targets' own objects may be
        touched only within the scene's `touch_radius`; what is "machine" keeps the distance of
        the path as everything does. With the two-step method and exact distances only.
    start : array_like, shape (7,), m and rad, optional
        Where the arm starts. Default: `Robot.home`.
    path_settings : motion.Settings, optional
        What paths keep, and how they are looked for.
    threads : int, optional
        Number of threads, as for `Robot.ik`; they share the targets.

    Returns
    -------
    Decisions
        With `path`, each `Decision` has a ``path``, and ``blockers_path`` where there is a
        posture and no path: the fewest removable objects without which there is a path into a
        posture, which may be another one that they leave room for.

    Raises
    ------
    ArgumentError
        A robot without the structure (says what is missing) or without bodies, a target inside
        an obstacle, two targets of one name, a setting out of its range. A point of NaN or
        infinity is a status.
    UnknownNameError
        No target of that name; an unknown word.
    KeyboardInterrupt
        Ctrl-C.

    Examples
    --------
    >>> from agrik_fast import Robot, harvest
    >>> found = harvest.plan("cucumber", harvest.example_scene(), ["C1", "C3"])
    >>> [harvest.Status(code).name for code in found.status]
    ['OK', 'APPROACH_BLOCKED']
    >>> bool(found["C1"].distance > 0.02)
    True
    """
    crop = Crop(robot, scene, distance, level, split)
    chosen = crop.chosen(targets)
    options = checked_settings(settings).as_options()
    scan_all = word("method", method, ("two-step", "full")) == "full"
    crop.refuse_targets_inside(chosen)
    if truth_value("path", path):
        if scan_all or distance != "exact":
            said = f"method={method!r} and distance={distance!r}"
            raise ArgumentError("path", said, "the two-step method and exact distances")
        return _with_paths(crop, chosen, options, start, path_settings, threads)
    columns = crop.station.plan(
        chosen.points, chosen.objects, list(chosen.names), options, scan_all, threads
    )
    return Decisions(chosen.names, columns)


def _with_paths(
    crop: Crop,
    chosen: Chosen,
    options: dict[str, Any],
    start: ArrayLike | None,
    path_settings: PathSettings | None,
    threads: int | None,
) -> Decisions:
    """Decide for targets, and plan the ways into their postures."""
    if path_settings is None:
        path_settings = PathSettings()
    if not isinstance(path_settings, PathSettings):
        raise ArgumentError("path_settings", shown(path_settings), "motion.Settings")
    robot, scene = crop.robot, crop.scene
    first = finite_array("start", robot.home if start is None else start, (robot.dof,))
    columns = crop.station.plan_paths(
        chosen.points,
        chosen.objects,
        list(chosen.names),
        first,
        path_settings.as_options(),
        scene.touch_radius,
        options,
        True,
        threads,
    )
    collider = scene.collider(robot)
    each = zip(columns.pop("goals"), columns["paths"], strict=True)
    columns["paths"] = [Plan.from_core(collider, goals, found) for goals, found in each]
    told = columns["blockers_path"]
    columns["blockers_path"] = [
        None if found is None else tuple(scene.names[k] for k in found[0]) for found in told
    ]
    columns["blockers_fewest"] = [None if found is None else Fewest(found[1]) for found in told]
    columns["blockers_at_least"] = [None if found is None else int(found[2]) for found in told]
    return Decisions(chosen.names, columns)


@dataclass(frozen=True)
class Blockers:
    """The fewest removable objects without which a target can be picked.

    Attributes
    ----------
    names : tuple of str
        Their names; none where the target can be picked as things are.
    exact : bool
        It is proven that no smaller set does at the approaches and places of the grid; False
        where the search was broken off.
    distance, score : float
        Distance of the posture from the rest of the crop, m, no more than
        `Settings.enough`, and its score.
    psi, slide : float
        Its approach angle, rad, and place of the slide, m.

    Examples
    --------
    >>> blocked = ik.harvest.blockers("cucumber", ik.harvest.example_scene(), ["C2"])["C2"]
    >>> len(blocked.names) > 0, blocked.exact
    (True, True)
    """

    names: tuple[str, ...]
    exact: bool
    distance: float
    score: float
    psi: float
    slide: float


def blockers(
    robot: Robot | str,
    scene: Scene,
    targets: Targets | None = None,
    *,
    settings: Settings | None = None,
    distance: Distance = "exact",
    level: int = 3,
    split: Literal["equal", "near-cubic"] = "equal",
    threads: int | None = None,
) -> dict[str, Blockers | None]:
    """Name a smallest set of removable objects (leaves) in the way of each target.

    A posture is admissible as soon as all removable objects are gone that it touches or comes
    too near to; the smallest such set over all postures of the grid is the answer. Of several
    sets of that size it is the one that leaves the best score.

    Parameters
    ----------
    robot, scene, targets, settings, distance, level, split, threads
        As for `plan`.

    Returns
    -------
    dict of str to Blockers or None
        For each target; None where no removal helps.

    Raises
    ------
    ArgumentError, UnknownNameError
        As `plan`.

    Examples
    --------
    >>> from agrik_fast import harvest
    >>> found = harvest.blockers("cucumber", harvest.example_scene(), ["C2"])["C2"]
    >>> found.names, found.exact
    (('leaf_e',), True)
    """
    crop = Crop(robot, scene, distance, level, split)
    chosen = crop.chosen(targets)
    options = checked_settings(settings).as_options()
    found = crop.station.blockers(
        chosen.points, chosen.objects, list(chosen.names), options, threads
    )
    return {name: named(one, scene) for name, one in zip(chosen.names, found, strict=True)}


def named(found: tuple[list[int], bool, dict[str, Any]] | None, scene: Scene) -> Blockers | None:
    """Return what the compiled core found with the names of the objects."""
    if found is None:
        return None
    objects, exact, row = found
    distance, score, psi, slide = (
        float(row[name][0]) for name in ("distance", "score", "psi", "slide")
    )
    names = tuple(scene.names[k] for k in objects)
    return Blockers(names, exact, distance, score, psi, slide)


def checked_settings(settings: Settings | None) -> Settings:
    """Return the settings, or the usual ones."""
    if settings is None:
        return Settings()
    if not isinstance(settings, Settings):
        raise ArgumentError("settings", shown(settings), "harvest.Settings")
    return settings
