"""Crops and arms, drawn into axes in space; they need Matplotlib."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any

import numpy as np

from .._bodies import Box, Capsule, Convex, Cover, Sphere
from .._checks import FloatArray
from ..collision import Scene
from ..robot import Robot

__all__ = ["ARM", "COLOURS", "box_faces", "draw_arm", "draw_boxes", "draw_scene", "frame_space"]

COLOURS = {
    "fruit": "#1b7837",
    "leaf": "#5aae61",
    "stem": "#8c6d31",
    "stalk": "#8c6d31",
    "pipe": "#878787",
    "wire": "#878787",
    "machine": "#bababa",
}
"""Colours of the kinds of objects."""
OTHER = "#4393c3"
ARM = "#e08214"
# The corners of a box that each of its six faces joins.
_CORNERS = np.array(list(product((-1, 1), repeat=3)), dtype=float)
_FACES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
MOST_POINTS = 4000
"""Points of a crop that a picture in space shows."""


def box_faces(centre: FloatArray, rotation: FloatArray, half: FloatArray) -> list[FloatArray]:
    """Return the six faces of a box.

    Parameters
    ----------
    centre : ndarray, shape (3,), m
    rotation : ndarray, shape (3, 3)
        Its columns are the axes of the box.
    half : ndarray, shape (3,), m
        Half lengths along them.

    Returns
    -------
    list of 6 ndarray, shape (4, 3), m
        The corners of each face, in order.

    Examples
    --------
    >>> from agrik_fast.harvest import drawing
    >>> len(drawing.box_faces(np.zeros(3), np.eye(3), np.full(3, 0.1)))
    6
    """
    corners = centre + (_CORNERS * half) @ rotation.T
    return [corners[face] for face in _FACES]


def draw_boxes(axes: Any, faces: list[FloatArray], colour: str, alpha: float) -> None:
    """Add faces to axes in space.

    Parameters
    ----------
    axes : Axes3D
    faces : list of ndarray, shape (4, 3), m
        As `box_faces` gives them.
    colour : str
    alpha : float
        0 to 1.

    Examples
    --------
    >>> import matplotlib.figure
    >>> from agrik_fast.harvest import drawing
    >>> axes = matplotlib.figure.Figure().add_subplot(projection="3d")
    >>> faces = drawing.box_faces(np.zeros(3), np.eye(3), np.full(3, 0.1))
    >>> drawing.draw_boxes(axes, faces, "#3b5ba5", 0.5)
    >>> len(axes.collections)
    1
    """
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(
        Poly3DCollection(
            faces, facecolors=colour, edgecolors="#40404080", linewidths=0.5, alpha=alpha
        )
    )


def draw_scene(axes: Any, scene: Scene, skip: Iterable[str] = ()) -> None:
    """Add the objects of a scene to axes in space.

    Parameters
    ----------
    axes : Axes3D
    scene : Scene
    skip : iterable of str, optional
        Kinds of objects that are left out.

    Examples
    --------
    >>> import matplotlib.figure
    >>> from agrik_fast.harvest import drawing
    >>> axes = matplotlib.figure.Figure().add_subplot(projection="3d")
    >>> drawing.draw_scene(axes, ik.harvest.example_scene(), skip=["machine"])
    >>> len(axes.collections) > 0
    True
    """
    left_out = set(skip)
    points: dict[str, list[FloatArray]] = {}
    for one in scene.objects:
        colour = COLOURS.get(one.kind, OTHER)
        if one.kind in left_out:
            continue
        if len(one.spheres):
            points.setdefault(colour, []).append(one.spheres[:, :3])
        for row in one.capsules:
            ends = row[:6].reshape(2, 3)
            width = max(0.6, 200 * float(row[6]))
            axes.plot(*ends.T, color=colour, linewidth=min(width, 8), solid_capstyle="round")
        for row in one.boxes:
            faces = box_faces(row[:3], row[6:15].reshape(3, 3), row[3:6])
            draw_boxes(axes, faces, colour, 0.35)
    total = sum(len(rows) for each in points.values() for rows in each)
    step = max(1, total // MOST_POINTS)
    for colour, each in points.items():
        rows = np.concatenate(each)[::step]
        axes.scatter(*rows.T, color=colour, s=14, alpha=0.75, linewidths=0, depthshade=True)


def _body_frames(robot: Robot, q: FloatArray) -> list[tuple[Any, FloatArray]]:
    """Return each body that moves with the pose of its frame, shape (4, 4), m."""
    links = robot.fk_links(q)
    frames = robot.compiled_bodies().frames
    return [
        (body, links[frame - 1])
        for body, frame in zip(robot.bodies, frames, strict=True)
        if frame > 0
    ]


def draw_arm(axes: Any, robot: Robot, q: FloatArray, colour: str = ARM, alpha: float = 0.6) -> None:
    """Add the bodies of an arm at a posture to axes in space.

    Parameters
    ----------
    axes : Axes3D
    robot : Robot
    q : ndarray, shape (n,), rad and m
    colour : str, optional
    alpha : float, default 0.6

    Examples
    --------
    >>> import matplotlib.figure
    >>> from agrik_fast.harvest import drawing
    >>> axes = matplotlib.figure.Figure().add_subplot(projection="3d")
    >>> arm = ik.Robot.load("cucumber")
    >>> drawing.draw_arm(axes, arm, arm.home)
    >>> len(axes.collections) > 0
    True
    """
    for body, pose in _body_frames(robot, q):
        shape = body.shape.box if isinstance(body.shape, Cover) else body.shape
        turn, shift = pose[:3, :3], pose[:3, 3]
        if isinstance(shape, Box):
            centre = turn @ np.array(shape.centre) + shift
            rotation = turn @ np.array(shape.rotation)
            draw_boxes(axes, box_faces(centre, rotation, np.array(shape.half)), colour, alpha)
        elif isinstance(shape, Capsule):
            ends = np.array([shape.a, shape.b]) @ turn.T + shift
            axes.plot(*ends.T, color=colour, linewidth=max(2.0, 120 * shape.radius), alpha=alpha)
        elif isinstance(shape, Sphere):
            axes.scatter(*(turn @ np.array(shape.centre) + shift), color=colour, alpha=alpha)
        elif isinstance(shape, Convex):
            corners = np.array(shape.vertices) @ turn.T + shift
            axes.scatter(*corners.T, color=colour, s=2, alpha=alpha)


def frame_space(axes: Any, low: Sequence[float], high: Sequence[float], view: Any) -> None:
    """Set limits, equal scales, labels and the view of axes in space.

    Parameters
    ----------
    axes : Axes3D
    low, high : sequence of 3 float, m
        Corners of what is shown.
    view : (float, float)
        Elevation and azimuth, deg.

    Examples
    --------
    >>> import matplotlib.figure
    >>> from agrik_fast.harvest import drawing
    >>> axes = matplotlib.figure.Figure().add_subplot(projection="3d")
    >>> drawing.frame_space(axes, (0, -1, 0), (1, 1, 2), (20, -60))
    >>> axes.elev
    20
    """
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_zlim(low[2], high[2])
    axes.set_box_aspect([b - a for a, b in zip(low, high, strict=True)])
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.set_zlabel("z, m")
    elevation, azimuth = view
    axes.view_init(elevation, azimuth)
