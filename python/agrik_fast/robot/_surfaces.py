"""What an arm looks like: triangles that stand still in its frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .. import _bodies
from .._checks import FloatArray
from ..errors import ArgumentError

if TYPE_CHECKING:
    from . import Robot

__all__ = ["LOOKS", "Look", "Surface"]

Look: TypeAlias = Literal["auto", "chain", "bodies", "visuals"]
LOOKS: tuple[Look, ...] = ("auto", "chain", "bodies", "visuals")
"""What an arm may be shown as."""

# Of the reach; with bounds, m.
_THICKNESS = 0.016
_THINNEST, _THICKEST = 0.003, 0.03
# How far a joint without limits on a slide is taken to go, m.
_FREE_SLIDE = 0.5
# What a joint is moved by to see what it does, rad or m.
_PROBE = 0.3
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles that stand still in one frame of an arm.

    Attributes
    ----------
    name : str
        What it shows: the name of a joint, a body, a link, or of a part of the end effector.
    frame : int
        0 for the base, k for ``link_names[k - 1]``.
    vertices : ndarray, shape (k, 3), m
        Corners, in that frame.
    faces : ndarray of int, shape (m, 3)
        The corners of each triangle.
    role : str
        "base", "link", "joint", "rail", "carriage", "finger", "body" or "visual".
    colour : tuple of 3 float, optional
        Red, green and blue, 0 to 1, where the robot's description says it.
    opens : tuple of 3 float, m
        Way that a finger goes, in the frame, when the hand opens.

    Examples
    --------
    >>> arm = ik.Robot.load("panda")
    >>> arm.surfaces()[0].role
    'base'
    """

    name: str
    frame: int
    vertices: FloatArray
    faces: NDArray[np.int32]
    role: str
    colour: tuple[float, float, float] | None = None
    opens: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def placed(self, frames: FloatArray, opening: float = 0.0) -> FloatArray:
        """Return the corners in the base frame, shape (k, 3), m.

        Parameters
        ----------
        frames : ndarray, shape (links + 1, 4, 4), m
            From `frames_of`.
        opening : float, default 0
            0 for a closed hand, 1 for an open one.

        Examples
        --------
        >>> arm = ik.Robot.load("panda")
        >>> one = arm.surfaces("bodies")[0]
        >>> one.placed(arm.frames_of(arm.home)).shape == one.vertices.shape
        True
        """
        pose = frames[self.frame]
        corners = self.vertices + opening * np.array(self.opens)
        placed: FloatArray = corners @ pose[:3, :3].T + pose[:3, 3]
        return placed


def frames_of(robot: Robot, q: FloatArray) -> FloatArray:
    """Return the base and all link frames, shape (..., links + 1, 4, 4), m."""
    links = robot.fk_links(q)
    base = np.broadcast_to(robot.base, (*links.shape[:-3], 1, 4, 4))
    return np.concatenate([base, links], axis=-3)


def surfaces(robot: Robot, show: Look) -> tuple[Surface, ...]:
    """Return what shows an arm; `Robot.surfaces` documents it."""
    if show == "auto":
        show = "visuals" if robot.has_visuals else "chain"
    if show == "bodies":
        if not robot.bodies:
            expected = "an arm with bodies (see `Robot.with_bodies`), or another look"
            raise ArgumentError("show", f"'bodies' of {robot.name!r}, which has none", expected)
        return tuple(
            Surface(body.name, robot.frame_number(body.frame), *_bodies.surface(body.shape), "body")
            for body in robot.bodies
        )
    if show == "visuals":
        if not robot.has_visuals:
            received = f"'visuals' of {robot.name!r}, which is no URDF with <visual> geometry"
            raise ArgumentError("show", received, "another look")
        return tuple(
            Surface(one.link, one.frame, one.vertices, one.faces, "visual", one.colour)
            for one in robot.visuals()
        )
    return tuple(_chain(robot))


# ---- the chain as solids -----------------------------------------------------------------------


class _Axis(NamedTuple):
    """A joint that moves: its line, or direction, in the frame before it."""

    name: str
    frame: int
    prismatic: bool
    point: FloatArray
    direction: FloatArray
    variable: int


def _axes(robot: Robot, q: FloatArray) -> list[_Axis]:
    """Return the joints that move, from the base on; seen in what they do to the frames."""
    here = frames_of(robot, q)
    inner = np.linalg.inv(here[:-1]) @ here[1:]
    found = []
    for variable, name in enumerate(robot.joint_names):
        moved = q.copy()
        moved[variable] += _PROBE
        there = frames_of(robot, moved)
        steps = np.linalg.inv(there[:-1]) @ there[1:] @ np.linalg.inv(inner)
        for number, step in enumerate(steps):
            turn, shift = step[:3, :3], step[:3, 3]
            spin = np.array(
                [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
            )
            size = float(np.linalg.norm(spin))
            if size > _SAME:
                # The point of the axis that is nearest to the frame's origin.
                point = np.linalg.lstsq(np.eye(3) - turn, shift, rcond=1e-9)[0]
                found.append(_Axis(name, number + 1, False, point, spin / size, variable))
            elif (length := float(np.linalg.norm(shift))) > _SAME:
                found.append(
                    _Axis(name, number + 1, True, inner[number][:3, 3], shift / length, variable)
                )
    return sorted(found, key=lambda axis: axis.frame)


def _chain(robot: Robot) -> Iterator[Surface]:
    """Yield cylinders for links and joints that turn, rails with carriages for slides."""
    q = robot.home
    frames = frames_of(robot, q)
    thick = float(np.clip(_THICKNESS * robot.reach_radius, _THINNEST, _THICKEST))
    at, at_frame = frames[0][:3, 3], 0
    for axis in _axes(robot, q):
        before = frames[axis.frame - 1]
        direction = before[:3, :3] @ axis.direction
        if axis.prismatic:
            low, high = _rail(robot, axis, q, frames)
            anchor = _nearest(at, low, high)
            place = frames[axis.frame][:3, 3]
        else:
            anchor = place = _on_axis(axis, frames, at)
        if at_frame == 0 and not axis.prismatic:
            foot = _bodies.cylinder(at, at + 1.5 * thick * _up(anchor - at), 2.5 * thick)
            yield _fixed("base", 0, frames, foot, "base")
        if np.linalg.norm(anchor - at) > thick / 2:
            yield _fixed(axis.name, at_frame, frames, _bodies.cylinder(at, anchor, thick), "link")
        if axis.prismatic:
            rail = _beam(low, high, direction, 0.8 * thick, 1.4 * thick)
            yield _fixed(axis.name, axis.frame - 1, frames, rail, "rail")
            carriage = _beam(
                place - 2 * thick * direction,
                place + 2 * thick * direction,
                direction,
                1.8 * thick,
                1.8 * thick,
            )
            yield _fixed(axis.name, axis.frame, frames, carriage, "carriage")
        else:
            ends = (place - 2 * thick * direction, place + 2 * thick * direction)
            yield _fixed(
                axis.name, axis.frame, frames, _bodies.cylinder(*ends, 1.6 * thick), "joint"
            )
        at, at_frame = place, axis.frame
    tip = frames[-1][:3, 3]
    if np.linalg.norm(tip - at) > thick / 2:
        yield _fixed("tool", at_frame, frames, _bodies.cylinder(at, tip, 0.8 * thick), "link")
    yield from _hand(robot, len(frames) - 1, thick)


def _rail(
    robot: Robot, axis: _Axis, q: FloatArray, frames: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where the slide's own frame is at its limits, as the arm stands otherwise."""
    low, high = float(robot.lower[axis.variable]), float(robot.upper[axis.variable])
    middle = float(q[axis.variable])
    ends = []
    for value, free in ((low, middle - _FREE_SLIDE), (high, middle + _FREE_SLIDE)):
        moved = q.copy()
        moved[axis.variable] = value if np.isfinite(value) else free
        there = frames_of(robot, moved)
        inner = np.linalg.inv(there[axis.frame - 1]) @ there[axis.frame]
        before = frames[axis.frame - 1]
        ends.append(before[:3, :3] @ inner[:3, 3] + before[:3, 3])
    return ends[0], ends[1]


def _on_axis(axis: _Axis, frames: FloatArray, at: FloatArray) -> FloatArray:
    """Return the point of an axis at which its joint is shown."""
    before = frames[axis.frame - 1]
    direction = before[:3, :3] @ axis.direction
    point = before[:3, :3] @ axis.point + before[:3, 3]

    def nearest(to: FloatArray) -> FloatArray:
        foot: FloatArray = point + direction * float((to - point) @ direction)
        return foot

    # Frames stand on their joint's axis (URDF, modified DH) or on the next one's (standard DH).
    for origin in (frames[axis.frame][:3, 3], before[:3, 3]):
        foot = nearest(origin)
        if np.linalg.norm(foot - origin) < 1e-5:
            return foot
    return nearest(at)


def _nearest(to: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    way = high - low
    length = float(way @ way)
    share = 0.0 if length == 0.0 else float(np.clip((to - low) @ way / length, 0.0, 1.0))
    return low + share * way


def _up(way: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(way))
    return way / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])


def _beam(
    a: FloatArray, b: FloatArray, direction: FloatArray, wide: float, high: float
) -> _bodies.Triangles:
    side = np.cross(np.eye(3)[int(np.argmin(np.abs(direction)))], direction)
    side /= np.linalg.norm(side)
    rotation = np.stack([direction, side, np.cross(direction, side)], axis=1)
    half = np.array([float(np.linalg.norm(b - a)) / 2, wide, high])
    return _bodies.box((a + b) / 2, half, rotation)


def _fixed(
    name: str, frame: int, frames: FloatArray, triangles: _bodies.Triangles, role: str
) -> Surface:
    """Return triangles that are given in the base frame as they stand in a frame of the arm."""
    vertices, faces = triangles
    pose = frames[frame]
    return Surface(name, frame, (vertices - pose[:3, 3]) @ pose[:3, :3], faces, role)


def _hand(robot: Robot, frame: int, thick: float) -> Iterator[Surface]:
    """Yield the parts that the end effector's servo moves: fingers side by side, a cutter."""
    hand = robot.end_effector
    if hand is None:
        return
    long, gap = 6 * thick, 1.2 * thick
    for number, name in enumerate(hand.moves):
        side = (1.0, -1.0, 0.0)[min(number, 2)]
        lift = 0.0 if number < 2 else 1.6 * thick
        centre = np.array([lift, side * gap / 2, -long / 2])
        half = np.array([0.5 * thick, 0.3 * thick, long / 2])
        opens = (0.0, side * 1.5 * thick, 0.0) if number < 2 else (thick, 0.0, 0.0)
        yield Surface(name, frame, *_bodies.box(centre, half, np.eye(3)), "finger", None, opens)
