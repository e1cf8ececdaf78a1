"""What stands in the way of a path: the fewest removable objects without which there is one."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from numpy.typing import ArrayLike

from .. import _native
from .._checks import finite_array
from ..collision import Scene
from ..robot import Robot
from ._check import checked_arm, scene_of
from ._goals import Prefer, postures
from ._plan import Plan
from ._settings import Settings, checked_settings

__all__ = ["Fewest", "PathBlockers", "blockers"]


class Fewest(IntEnum):
    """What is known of the number of objects that stand in the way.

    Examples
    --------
    >>> from agrik_fast.motion import Fewest
    >>> [each.name for each in Fewest]
    ['PROVEN', 'SEARCHED', 'STOPPED']
    """

    PROVEN = 0
    """It is proven that no smaller set opens a path to the goals."""
    SEARCHED = 1
    """No path was found without any smaller set, with the effort allowed; that is no proof."""
    STOPPED = 2
    """The effort was spent before all smaller sets were ruled out."""


@dataclass(frozen=True, eq=False)
class PathBlockers:
    """The fewest removable objects without which a path is found.

    Attributes
    ----------
    names : tuple of str
        Their names; none where there is a path as things are.
    fewest : Fewest
        What is known of their number.
    at_least : int
        With fewer no path was found; their number, unless `fewest` is ``STOPPED``.
    path : Plan
        The path without them; its `clearance` is that from all that stays.
    plans, checks : int
        Plans that were made, and questions that they asked.

    Examples
    --------
    >>> from agrik_fast.motion import blockers
    >>> arm = ik.Robot.load("panda")
    >>> start, goal = [-1, 0, 0, -1.5, 0, 1.5, 0], [1, 0, 0, -1.5, 0, 1.5, 0]
    >>> blockers(arm, start, goal, ik.Scene([])).names
    ()
    """

    names: tuple[str, ...]
    fewest: Fewest
    at_least: int
    path: Plan
    plans: int
    checks: int


def blockers(
    arm: Robot,
    start: ArrayLike,
    goals: ArrayLike,
    scene: Scene | None = None,
    *,
    settings: Settings | None = None,
    prefer: Prefer | None = None,
) -> PathBlockers | None:
    """Name the fewest removable objects without which a path is found.

    Sets of objects are not tried one after the other. What each path meets that was found with
    some of them gone is kept, and so are *cores*: objects of which one at least has to go, as no
    path was found with all of these in their places and everything else gone. The fewest objects
    of which every core has one are tried next: either there is a path, and no set is smaller, or
    they give a new core.

    Parameters
    ----------
    arm, start, goals, scene, settings, prefer
        As for `plan`. All plans together may ask eight times ``settings.max_checks`` questions.

    Returns
    -------
    PathBlockers or None
        None where no path is found without all of them.

    Raises
    ------
    ArgumentError
        As `plan`.

    Notes
    -----
    Which obstacles to remove for a path is the minimum constraint removal problem of Hauser,
    "The minimum constraint removal problem with three robotics applications", International
    Journal of Robotics Research 33 (2014); least sets that meet all of some sets, found as more
    and more of these are known, are the implicit hitting sets of Moreno-Centeno and Karp,
    Operations Research 61 (2013).

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> arm = Robot.load("panda")
    >>> start, goal = [-1, 0, 0, -1.5, 0, 1.5, 0], [1, 0, 0, -1.5, 0, 1.5, 0]
    >>> at = arm.fk(goal)[:3, 3]
    >>> leaf = SceneObject.of("leaf", Sphere(at, 0.03), removable=True)
    >>> found = motion.blockers(arm, start, goal, Scene([leaf]))
    >>> found.names, found.fewest.name
    (('leaf',), 'PROVEN')
    """
    dof = checked_arm(arm).dof
    options = checked_settings(settings)
    around = scene_of(scene)
    first = finite_array("start", start, (dof,))
    collider = around.collider(arm)
    rows, _ = postures(arm, goals, around, first, prefer, options.seed)
    found = _native.motion_blockers(collider, first, rows, options.as_options())
    if found is None:
        return None
    return PathBlockers(
        names=tuple(around.names[k] for k in found["objects"]),
        fewest=Fewest(found["fewest"]),
        at_least=int(found["at_least"]),
        path=Plan.from_core(collider, rows, found["path"]),
        plans=int(found["plans"]),
        checks=int(found["checks"]),
    )
