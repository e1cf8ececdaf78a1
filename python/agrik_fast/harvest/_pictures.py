"""Pictures of an evaluation: shares, the row, leaves in the way, a posture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .._checks import FloatArray
from ..collision import Scene
from ..collision.drawing import draw_scene
from ..plots import GREY, PAGE_WIDTH, PALE, PALETTE, figure, frame_space, styled
from ._decisions import Status
from ._evaluate import Evaluation
from ._station import moved_along
from .drawing import draw_arm

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STATUS_COLOURS = {
    Status.OK: PALETTE[2],
    Status.APPROACH_BLOCKED: PALETTE[1],
    Status.NO_COLLISION_FREE: PALETTE[4],
    Status.OUT_OF_REACH: GREY,
    Status.JOINT_LIMITS: PALETTE[0],
    Status.BAD_INPUT: PALETTE[6],
    Status.TIME_LIMIT: PALETTE[3],
}


@styled
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
    drawing = figure(PAGE_WIDTH, 3.2)
    axes = drawing.add_subplot()
    of = found.decisions.shares()
    names = list(of)[::-1]
    axes.barh(names, [100 * of[name] for name in names], color=[_colour(n) for n in names])
    for k, name in enumerate(names):
        axes.text(100 * of[name] + 1, k, f"{100 * of[name]:.1f} %", va="center")
    axes.set_xlim(0, 115)
    axes.set_xlabel(f"share of {len(found.decisions)} fruits [%]")
    axes.set_title(f"{100 * found.share:.1f} % can be picked")
    return drawing


def _colour(name: str) -> str:
    return STATUS_COLOURS[Status[name]]


def _row(found: Evaluation) -> Figure:
    drawing = figure(PAGE_WIDTH, 4.2)
    axes = drawing.add_subplot()
    points = np.array([target.point for target in found.scene.targets.values()])
    for one in found.scene.objects:
        if len(one.spheres):
            axes.scatter(
                one.spheres[:, 1], one.spheres[:, 2], s=2, color=PALE, linewidths=0, zorder=0
            )
        for row in one.capsules:
            axes.plot(row[[1, 4]], row[[2, 5]], color=PALE, linewidth=1, zorder=0)
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
    axes.set_xlabel("y along the row [m]")
    axes.set_ylabel("z [m]")
    axes.set_xlim(points[:, 1].min() - 0.3, points[:, 1].max() + 0.3)
    axes.set_ylim(min(0.3, points[:, 2].min() - 0.1), points[:, 2].max() + 0.4)
    axes.legend(loc="upper right")
    axes.set_title("what became of each fruit, seen from the arm")
    return drawing


def _blockers(found: Evaluation) -> Figure:
    worst = found.leaves()[:20][::-1]
    drawing = figure(PAGE_WIDTH, 1.2 + 0.25 * len(worst))
    axes = drawing.add_subplot()
    axes.barh([name for name, _ in worst], [count for _, count in worst], color=PALETTE[1])
    axes.set_xlabel("fruits that it blocks")
    axes.set_title("leaves in the way")
    return drawing


def posture_picture(found: Evaluation, row: int) -> Figure:
    """Return a picture in space of the arm at one posture, with what is near."""
    one = found.decisions[row]
    point = np.array(found.scene.targets[one.name].point)
    drawing = figure(PAGE_WIDTH, 5.6)
    axes = drawing.add_subplot(projection="3d")
    low, high = point - np.array([0.9, 0.7, 0.8]), point + np.array([0.3, 0.7, 0.6])
    draw_scene(axes, near(found.scene, low, high).objects, skip=("ground",))
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
