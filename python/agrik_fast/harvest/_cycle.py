"""The whole way of a fruit: to it, off the plant, and into the crate, every piece proven free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .. import motion
from .._checks import FloatArray
from ..collision import Body, BodyShape, Box, Capsule, Convex, Scene, SceneObject, Sphere
from ..errors import ArgumentError
from ..robot import Robot
from ._decisions import Decision
from ._plan import plan
from ._settings import Settings
from ._station import loaded

__all__ = ["Cycle", "Leg", "cycle"]


@dataclass(frozen=True, eq=False)
class Leg:
    """One part of a cycle.

    Attributes
    ----------
    name : {"approach", "retreat", "to_crate"}
    arm : Robot
        The arm, with the fruit once it is held.
    scene : Scene
        What stands round it, without the fruit once it is held.
    path : ndarray, shape (n, dof), rad or m
        Waypoints, between which it is straight in joint space.
    clearance : ndarray, shape (n - 1,), m
        Distance that is kept on each piece.

    Examples
    --------
    >>> from agrik_fast.harvest import Leg
    >>> Leg("approach", ik.Robot.load("cucumber"), ik.Scene([]), np.zeros((2, 7)), np.zeros(1)).name
    'approach'
    """

    name: str
    arm: Robot
    scene: Scene
    path: FloatArray
    clearance: FloatArray


@dataclass(frozen=True, eq=False)
class Cycle:
    """The way of a fruit, as far as it was found.

    Attributes
    ----------
    decision : Decision
        The posture, and the way into it.
    legs : tuple of Leg
        Approach, retreat with the fruit, way to the crate. The gripper closes between the
        first two. Each begins where the one before ends.
    status : motion.PathStatus
        OK where all legs are there; else why the next one is not.

    Examples
    --------
    >>> from agrik_fast import harvest
    >>> arm = ik.Robot.load("cucumber")
    >>> found = harvest.cycle(arm, harvest.example_scene(), "C4", arm.home)
    >>> found.ok, found.status.name
    (True, 'OK')
    """

    decision: Decision
    legs: tuple[Leg, ...]
    status: motion.PathStatus

    @property
    def ok(self) -> bool:
        """All legs are there."""
        return self.status == motion.PathStatus.OK


def cycle(
    robot: Robot | str,
    scene: Scene,
    target: str,
    crate: ArrayLike,
    *,
    start: ArrayLike | None = None,
    settings: Settings | None = None,
    path_settings: motion.Settings | None = None,
) -> Cycle:
    """Plan how a fruit is picked: approach, retreat with the fruit, way to the crate.

    Once it is held, the first object of the target is a body of the arm like others, and all
    objects of the target are gone from the scene. The retreat goes back on the last piece of
    the approach, or on the line of the tool that the approach ended with, if that is free with
    the fruit too; otherwise another way is looked for.

    Parameters
    ----------
    robot, scene, settings, path_settings
        As for `plan`.
    target : str
        A target of the scene, with an object that is the fruit.
    crate : array_like, shape (7,), m and rad, or (m, 7)
        Postures in which the fruit is laid down, the best first.
    start : array_like, shape (7,), m and rad, optional
        Where the arm starts. Default: `Robot.home`.

    Returns
    -------
    Cycle

    Raises
    ------
    ArgumentError, UnknownNameError
        As `plan`; a target without objects.

    Examples
    --------
    >>> from agrik_fast import Robot, harvest
    >>> arm = Robot.load("cucumber")
    >>> found = harvest.cycle(arm, harvest.example_scene(), "C4", arm.home)
    >>> [leg.name for leg in found.legs]
    ['approach', 'retreat', 'to_crate']
    """
    arm = loaded(robot)
    found = plan(
        arm, scene, [target], settings=settings, path=True, start=start,
        path_settings=path_settings,
    )[0]  # fmt: skip
    way = found.path
    if way is None or not way.ok:
        status = motion.PathStatus.NO_PATH_FOUND if way is None else way.status
        return Cycle(found, (), status)
    objects = scene.targets[target].objects
    if not objects:
        raise ArgumentError("target", f"{target!r} without objects", "one that has its fruit")
    legs = [Leg("approach", arm, scene.aiming_at(target), way.path, way.clearance)]
    at = way.path[-1]
    holding = arm.attach(_held(scene[objects[0]], arm.fk(at)), name="fruit")
    cleared = scene.aiming_at(None).without(*objects)
    options = motion.Settings() if path_settings is None else path_settings
    back = _back(way)
    checked = motion.check(
        holding, back, cleared, clear=options.clear, own_clear=options.own_clear,
        cap=max(options.cap, options.clear),
    )  # fmt: skip
    if checked.safe:
        legs.append(Leg("retreat", holding, cleared, back, checked.clearance))
    else:
        other = motion.plan(holding, at, back[-1], cleared, settings=options)
        if not other.ok:
            return Cycle(found, tuple(legs), other.status)
        legs.append(Leg("retreat", holding, cleared, other.path, other.clearance))
    last = motion.plan(holding, legs[-1].path[-1], crate, cleared, settings=options)
    if last.ok:
        legs.append(Leg("to_crate", holding, cleared, last.path, last.clearance))
    return Cycle(found, tuple(legs), last.status)


def _back(way: motion.Plan) -> FloatArray:
    """Return the last piece of an approach the other way round, or the line that it ends with."""
    if not way.how.startswith("retreat"):
        return np.ascontiguousarray(way.path[-2:][::-1])
    # A line has pieces of one length of the tool; the way to it is another matter.
    steps = np.linalg.norm(np.diff(way.path, axis=0), axis=1)
    line = len(steps)
    while line > 0 and steps[line - 1] <= 2.5 * steps[-1] + 0.05:
        line -= 1
    return np.ascontiguousarray(way.path[line:][::-1])


def _held(fruit: SceneObject, pose: FloatArray) -> list[Body]:
    """Return the solids of a fruit as bodies of the tool that holds it at a pose."""
    turn, at = pose[:3, :3], pose[:3, 3]

    def inner(point: ArrayLike) -> tuple[float, float, float]:
        x, y, z = (turn.T @ (np.asarray(point) - at)).tolist()
        return x, y, z

    shapes: list[BodyShape] = [Sphere(inner(row[:3]), row[3]) for row in fruit.spheres]
    shapes += [Capsule(inner(row[:3]), inner(row[3:6]), row[6]) for row in fruit.capsules]
    for row in fruit.boxes:
        turned = turn.T @ row[6:15].reshape(3, 3)
        shapes.append(Box(inner(row[:3]), tuple(row[3:6].tolist()), turned, row[15]))
    shapes += [Convex(tuple(inner(p) for p in points), radius) for points, radius in fruit.hulls]
    return [Body(f"fruit{k}", "tool", shape) for k, shape in enumerate(shapes)]
