"""Pictures of crops and of arms in them; they need Matplotlib."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from .._bodies import Box, Capsule, Convex, Cover, Sphere
from .._checks import FloatArray
from ..collision import Scene
from ..errors import AgrikError
from ..robot import Robot
from ._decisions import Status
from ._evaluate import Evaluation
from ._station import moved_along

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
STATUS_COLOURS = {
    Status.OK: "#1b7837",
    Status.APPROACH_BLOCKED: "#d73027",
    Status.NO_COLLISION_FREE: "#fc8d59",
    Status.OUT_OF_REACH: "#878787",
    Status.JOINT_LIMITS: "#4575b4",
    Status.BAD_INPUT: "#000000",
    Status.TIME_LIMIT: "#762a83",
}
# The corners of a box that each of its six faces joins.
_CORNERS = np.array(list(product((-1, 1), repeat=3)), dtype=float)
_FACES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
MOST_POINTS = 4000
"""Points of a crop that a picture in space shows."""


def figure(width: float, height: float) -> Figure:
    """Return an empty figure (inches) that belongs to no window."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise AgrikError("pictures need Matplotlib; install agrik_fast[papers]") from None
    return Figure(figsize=(width, height), layout="constrained")


def box_faces(centre: FloatArray, rotation: FloatArray, half: FloatArray) -> list[FloatArray]:
    """Return the six faces of a box, each four corners, m."""
    corners = centre + (_CORNERS * half) @ rotation.T
    return [corners[face] for face in _FACES]


def draw_boxes(axes: Any, faces: list[FloatArray], colour: str, alpha: float) -> None:
    """Add faces to axes in space."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(
        Poly3DCollection(
            faces, facecolors=colour, edgecolors="#40404080", linewidths=0.5, alpha=alpha
        )
    )


def draw_scene(axes: Any, scene: Scene, skip: Iterable[str] = ()) -> None:
    """Add the objects of a scene to axes in space, but for those of some kinds."""
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


def body_frames(robot: Robot, q: FloatArray) -> list[tuple[Any, FloatArray]]:
    """Return each body that moves with the pose of its frame, shape (4, 4), m."""
    links = robot.fk_links(q)
    frames = robot.compiled_bodies().frames
    return [
        (body, links[frame - 1])
        for body, frame in zip(robot.bodies, frames, strict=True)
        if frame > 0
    ]


def draw_arm(axes: Any, robot: Robot, q: FloatArray, colour: str = ARM, alpha: float = 0.6) -> None:
    """Add the bodies of an arm at a posture to axes in space."""
    for body, pose in body_frames(robot, q):
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
    """Set limits, equal scales, labels and the view of axes in space."""
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_zlim(low[2], high[2])
    axes.set_box_aspect([b - a for a, b in zip(low, high, strict=True)])
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.set_zlabel("z, m")
    elevation, azimuth = view
    axes.view_init(elevation, azimuth)


def status_pictures(found: Evaluation) -> dict[str, Figure]:
    """Return pictures of an evaluation by name: shares, the row, and leaves in the way."""
    out = {"shares": _shares(found), "row": _row(found)}
    if found.leaves():
        out["blockers"] = _blockers(found)
    first = np.flatnonzero(found.decisions.ok)
    if len(first):
        out["posture"] = posture_picture(found, int(first[0]))
    return out


def _shares(found: Evaluation) -> Figure:
    drawing = figure(6, 3.2)
    axes = drawing.add_subplot()
    of = found.decisions.shares()
    names = list(of)[::-1]
    axes.barh(names, [100 * of[name] for name in names], color=[_colour(n) for n in names])
    for k, name in enumerate(names):
        axes.text(100 * of[name] + 1, k, f"{100 * of[name]:.1f} %", va="center")
    axes.set_xlim(0, 115)
    axes.set_xlabel(f"share of {len(found.decisions)} fruits, %")
    axes.set_title(f"{100 * found.share:.1f} % can be picked")
    return drawing


def _colour(name: str) -> str:
    return STATUS_COLOURS[Status[name]]


def _row(found: Evaluation) -> Figure:
    drawing = figure(9, 4.5)
    axes = drawing.add_subplot()
    points = np.array([target.point for target in found.scene.targets.values()])
    for one in found.scene.objects:
        if len(one.spheres):
            axes.scatter(
                one.spheres[:, 1], one.spheres[:, 2], s=2, color="#c7e9c0", linewidths=0, zorder=0
            )
        for row in one.capsules:
            axes.plot(row[[1, 4]], row[[2, 5]], color="#d9d9d9", linewidth=1, zorder=0)
    for status, colour in STATUS_COLOURS.items():
        rows = found.decisions.status == status
        if rows.any():
            axes.scatter(
                points[rows, 1],
                points[rows, 2],
                s=30 if len(points) < 200 else 10,
                color=colour,
                label=f"{status.name} ({int(rows.sum())})",
            )
    axes.set_xlabel("y, m, along the row")
    axes.set_ylabel("z, m")
    axes.set_xlim(points[:, 1].min() - 0.3, points[:, 1].max() + 0.3)
    axes.set_ylim(min(0.3, points[:, 2].min() - 0.1), points[:, 2].max() + 0.4)
    axes.legend(loc="upper right", fontsize=8)
    axes.set_title("what became of each fruit, seen from the arm")
    return drawing


def _blockers(found: Evaluation) -> Figure:
    worst = found.leaves()[:20][::-1]
    drawing = figure(6, 1.2 + 0.25 * len(worst))
    axes = drawing.add_subplot()
    axes.barh([name for name, _ in worst], [count for _, count in worst], color="#d73027")
    axes.set_xlabel("fruits that it blocks")
    axes.set_title("leaves in the way")
    return drawing


def posture_picture(found: Evaluation, row: int) -> Figure:
    """Return a picture in space of the arm at one posture, with what is near."""
    one = found.decisions[row]
    point = np.array(found.scene.targets[one.name].point)
    drawing = figure(7, 6.5)
    axes = drawing.add_subplot(projection="3d")
    low, high = point - np.array([0.9, 0.7, 0.8]), point + np.array([0.3, 0.7, 0.6])
    draw_scene(axes, near(found.scene, low, high), skip=("ground",))
    draw_arm(axes, moved_along(found.robot, float(found.along[row])), one.q)
    axes.scatter(*point, color="black", marker="x", s=40)
    frame_space(axes, low.tolist(), high.tolist(), (20, -110))
    axes.set_title(
        f"{one.name}: {1e3 * one.distance:.0f} mm from the crop, "
        f"approach {np.degrees(one.psi):.1f} deg"
    )
    return drawing


def near(scene: Scene, low: FloatArray, high: FloatArray) -> Scene:
    """Return the objects of a scene of which some point is within limits."""

    def inside(rows: FloatArray) -> bool:
        return bool(((rows > low) & (rows < high)).all(axis=1).any())

    kept = []
    for one in scene.objects:
        capsules = one.capsules[:, :6].reshape(-1, 3)
        steps = np.linspace(0, 1, 9)[:, None, None]
        along = (one.capsules[:, :3] * (1 - steps) + one.capsules[:, 3:6] * steps).reshape(-1, 3)
        parts = [one.spheres[:, :3], capsules, along, one.boxes[:, :3]]
        if one.kind != "ground" and any(len(part) and inside(part) for part in parts):
            kept.append(one)
    return Scene(kept)
