"""Gripper and cutter as two bodies, and whether the cut goes through the stalk."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, finite_array, real_number, shown
from ..collision import Body, Box, CollisionRules, Scene, Sphere
from ..errors import ArgumentError
from ..robot import Robot
from ._decisions import Decisions
from ._station import loaded

__all__ = ["Cut", "Cutter", "cuts", "with_cutter"]

GRIPPER, CUTTER = "gripper", "cutter"
FRUIT = "fruit"
"""Kind of the object of a target that is not cut."""


@dataclass(frozen=True)
class Cutter:
    """Where a gripper's cutter cuts, and what it makes up for.

    The paper prints no dimension of its end effector; these are assumed. The grip point lies
    60 mm below the fruit's top, so the cut is 10 mm above it, for stalks that lean to the stem;
    the bundled gripper ends 104 mm above the grip point.

    Parameters
    ----------
    point : (x, y, z), m
        The middle of the cut in the tool frame, whose x axis points down while the arm picks.
    reach : float, m
        How far from it the stalk may be, 0 or more: half the opening of the blades.
    height : float, m
        The topmost part of the gripper's box that is the cutter, above 0.

    Examples
    --------
    >>> from agrik_fast.harvest import Cutter
    >>> Cutter().reach
    0.01
    """

    point: tuple[float, float, float] = (-0.07, 0.0, 0.0)
    reach: float = 0.01
    height: float = 0.04

    def __post_init__(self) -> None:
        x, y, z = finite_array("point", self.point, (3,)).tolist()
        object.__setattr__(self, "point", (x, y, z))
        object.__setattr__(self, "reach", real_number("reach", self.reach, 0.0, unit="m"))
        height = real_number("height", self.height, 0.0, unit="m")
        if height == 0.0:
            raise ArgumentError("height", "0", "a number above 0, m")
        object.__setattr__(self, "height", height)


@dataclass(frozen=True, eq=False)
class Cut:
    """Where the cut of each decision is, beside the stalk.

    Attributes
    ----------
    distance : ndarray, shape (n,), m
        From the middle of the cut to the surface of the stalk, 0 inside of it; infinite where
        there is no posture, or where the target has no stalk.
    ok : ndarray of bool, shape (n,)
        The stalk is within the cutter's reach.

    Examples
    --------
    >>> from agrik_fast.harvest import Cut
    >>> cut = Cut(distance=np.array([0.0, 0.02]), ok=np.array([True, False]))
    >>> cut.ok.mean().item()
    0.5
    """

    distance: FloatArray
    ok: NDArray[np.bool_]


def with_cutter(robot: Robot | str = "cucumber", cutter: Cutter | None = None) -> Robot:
    """Return a robot whose gripper's box is two bodies: the gripper, and the cutter above it.

    Together they fill the same room, so decisions stay as they are; what comes near the cutter
    is told from what comes near the gripper.

    Parameters
    ----------
    robot : Robot or str, default "cucumber"
        An arm with a box named "gripper".
    cutter : Cutter, optional

    Returns
    -------
    Robot

    Raises
    ------
    ArgumentError
        No box of that name, or one that is no higher than the cutter.

    Examples
    --------
    >>> from agrik_fast import harvest
    >>> [body.name for body in harvest.with_cutter().bodies][-2:]
    ['gripper', 'cutter']
    """
    arm = loaded(robot)
    of = _checked(cutter)
    bodies = []
    for body in arm.bodies:
        if body.name == GRIPPER and isinstance(body.shape, Box):
            bodies += _cut_in_two(body, body.shape, of.height)
        else:
            bodies.append(body)
    if len(bodies) == len(arm.bodies):
        received = f"{arm.name!r} with the bodies {[body.name for body in arm.bodies]}"
        raise ArgumentError("robot", received, f"a robot with a box named {GRIPPER!r}")
    return arm.with_bodies(bodies, _shared(arm.collision_rules))


def _cut_in_two(body: Body, box: Box, height: float) -> list[Body]:
    """Return the lower part of a box along its x axis, which points down, and the upper one."""
    x, y, z = box.half
    if height >= 2 * x:
        raise ArgumentError("height", f"{height} m", f"less than the gripper's {2 * x} m")
    along = np.asarray(box.rotation)[:, 0]
    centre = np.asarray(box.centre)
    below, above = (
        replace(box, centre=tuple((centre + shift * along).tolist()), half=(half, y, z))
        for shift, half in ((0.5 * height, x - 0.5 * height), (0.5 * height - x, 0.5 * height))
    )
    return [replace(body, shape=below), replace(body, name=CUTTER, shape=above)]


def _shared(rules: CollisionRules) -> CollisionRules:
    """Return rules that say of the cutter what they say of the gripper."""

    def both(pairs: tuple[tuple[str, str], ...]) -> tuple[tuple[str, str], ...]:
        more = [
            tuple(CUTTER if name == GRIPPER else name for name in pair)
            for pair in pairs
            if GRIPPER in pair
        ]
        return (*pairs, *more)  # type: ignore[arg-type]

    touch = rules.may_touch_target
    return CollisionRules(
        may_touch_target=(*touch, CUTTER) if GRIPPER in touch else touch,
        static_skip=both(rules.static_skip),
        pairs=None if rules.pairs is None else both(rules.pairs),
        exclude=both(rules.exclude),
    )


def cuts(
    robot: Robot | str, scene: Scene, decisions: Decisions, cutter: Cutter | None = None
) -> Cut:
    """Check that the cut of each decision goes through the stalk of its fruit.

    The stalk is what belongs to the target and is no fruit.

    Parameters
    ----------
    robot : Robot or str
        The arm of the decisions.
    scene : Scene
        Their scene, with their targets.
    decisions : Decisions
    cutter : Cutter, optional

    Returns
    -------
    Cut

    Raises
    ------
    ArgumentError
        Something else than decisions; another robot or scene than theirs.

    Examples
    --------
    >>> from agrik_fast import harvest
    >>> scene = harvest.example_scene()
    >>> found = harvest.plan("cucumber", scene, ["C1", "C4"])
    >>> harvest.cuts("cucumber", scene, found).ok
    array([ True,  True])
    """
    arm = loaded(robot)
    of = _checked(cutter)
    if not isinstance(scene, Scene):
        raise ArgumentError("scene", shown(scene), "a Scene")
    if not isinstance(decisions, Decisions):
        raise ArgumentError("decisions", shown(decisions), "what harvest.plan has returned")
    if decisions.q.shape[1:] != (arm.dof,):
        received = f"postures of {decisions.q.shape[-1]} values for an arm of {arm.dof}"
        raise ArgumentError("decisions", received, "those of this robot")
    return cut_distances(arm, scene, decisions, np.zeros(len(decisions)), of)


def cut_distances(
    arm: Robot, scene: Scene, decisions: Decisions, along: FloatArray, cutter: Cutter
) -> Cut:
    """Return where the cuts are with the vehicle `along` (n,) (m) the row for each decision."""
    stalks = {name: _stalk(scene, name) for name in decisions.names}
    known = {name: None for names in stalks.values() for name in names}
    distance = np.full(len(decisions), np.inf)
    rows = np.flatnonzero(decisions.found)
    rows = rows[[bool(stalks[decisions.names[k]]) for k in rows]]
    if len(rows):
        points = (arm.fk(decisions.q[rows]) @ [*cutter.point, 1.0])[:, :3]
        points[:, 1] += along[rows]
        everything, probe = Scene([scene[name] for name in known]), _probe(points)
        found = everything.distances(probe, points)
        names = everything.names
        nearest = [names[k] for k in found.nearest[:, 0]]
        for k, name, near, point in zip(rows, nearest, found.distance[:, 0], points, strict=True):
            own = stalks[decisions.names[k]]
            if name not in own:
                near = Scene([scene[one] for one in own]).clearance(probe, point)
            distance[k] = max(0.0, float(near))
    return Cut(distance, distance <= cutter.reach)


def _probe(points: FloatArray) -> Robot:
    """Return an arm whose joint values are the place of a sphere of no size."""
    most = float(np.abs(points).max()) + 1.0
    links = "".join(f'<link name="l{k}"/>' for k in range(4))
    joints = "".join(
        f'<joint name="{name}" type="prismatic"><parent link="l{k}"/><child link="l{k + 1}"/>'
        f'<axis xyz="{axis}"/><limit lower="{-most}" upper="{most}" effort="1" velocity="1"/>'
        "</joint>"
        for k, (name, axis) in enumerate(zip("xyz", ("1 0 0", "0 1 0", "0 0 1"), strict=True))
    )
    gantry = Robot.from_urdf(f'<robot name="probe">{links}{joints}</robot>')
    return gantry.with_bodies([Body("cut", "tool", Sphere((0.0, 0.0, 0.0), 0.0))])


def _stalk(scene: Scene, target: str) -> list[str]:
    """Return the objects of a target that are no fruit."""
    if target not in scene.targets:
        raise ArgumentError("scene", f"no target {target!r}", "the scene of the decisions")
    return [name for name in scene.targets[target].objects if scene[name].kind != FRUIT]


def _checked(cutter: Cutter | None) -> Cutter:
    if cutter is None:
        return Cutter()
    if not isinstance(cutter, Cutter):
        raise ArgumentError("cutter", shown(cutter), "harvest.Cutter")
    return cutter
