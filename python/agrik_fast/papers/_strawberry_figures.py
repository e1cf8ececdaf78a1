"""Figures of the strawberry paper: the plant from above and the mechanism in its poses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .._checks import FloatArray
from ..closed_form import StrawberryArm
from . import strawberry as paper
from ._output import figure, save

NAMES = {"as": "AS", "ssas": "SSAS", "ncos": "NCOS", "exact": "exact minimum"}
QUADRANT_COLORS = ("#2a7f62", "#c0532b", "#3b5ba5", "#8a4f9e")


def figure2(directory: Path) -> list[Path]:
    """Draw the circle that the plant covers, from above, with the targets of table 3."""
    drawing = figure(5.2, 5.0)
    axes = drawing.add_subplot()
    points = 1000 * paper.targets()
    x, y = 1000 * paper.SPHERE_CENTRE[:2]
    angle = np.linspace(0, 2 * np.pi, 181)
    radius = 1000 * paper.SPHERE_RADIUS
    axes.plot(x + radius * np.cos(angle), y + radius * np.sin(angle), color="#444444")
    axes.axhline(y, color="#999999", linewidth=0.6)
    axes.axvline(x, color="#999999", linewidth=0.6)
    axes.plot(x, y, "+", color="#444444")
    for quadrant in range(4):
        own = slice(5 * quadrant, 5 * quadrant + 5)
        color = QUADRANT_COLORS[quadrant]
        axes.plot(points[own, 0], points[own, 1], "o", color=color, label=f"Q{quadrant + 1}")
    for number, (px, py, _) in enumerate(points, 1):
        axes.annotate(str(number), (px, py), xytext=(4, 3), textcoords="offset points", fontsize=7)
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.legend(loc="upper right", fontsize=8)
    axes.set_title("Figure 2: plant circle from above, targets of table 3")
    return save(drawing, directory, "figure2")


def joint_points(arm: StrawberryArm, q: FloatArray) -> FloatArray:
    """Return pitch axis, roll axis and tool point, shape (3, 3), m."""
    l2, l3 = (float(np.asarray(arm.parameters[name])) for name in ("l2", "l3"))
    theta, beta = q[3:]
    down = np.array([-np.sin(theta), 0.0, -np.cos(theta)])
    tip = arm.fk(q)
    roll = tip - l3 * (np.cos(beta) * down + np.array([0.0, np.sin(beta), 0.0]))
    return np.array([roll - l2 * down, roll, tip])


def draw_pose(
    axes: Any, arm: StrawberryArm, q: FloatArray, target: FloatArray, close: bool = False
) -> None:
    """Draw slides, arm, plant sphere and bed in a 3D axes, mm; `close`: arm and plant alone."""
    points = 1000 * joint_points(arm, q)
    low, high = 1000 * arm.lower, 1000 * arm.upper
    pitch = points[0]
    rail_z = pitch[2] + 1000 * float(q[2])
    # Slides: y (s10) on both sides, x (s21) across, z (s32) down.
    y_rail = pitch[1] - 1000 * float(q[0]) + np.array([low[0], high[0]])
    x_rail = pitch[0] - 1000 * float(q[1]) + np.array([low[1], high[1]])
    if not close:
        for x in x_rail:
            axes.plot([x, x], y_rail, [rail_z, rail_z], color="#888888", linewidth=2)
        axes.plot(x_rail, [pitch[1]] * 2, [rail_z, rail_z], color="#3b5ba5", linewidth=3)
    top = min(rail_z, pitch[2] + 60) if close else rail_z
    axes.plot([pitch[0]] * 2, [pitch[1]] * 2, [top, pitch[2]], color="#c0532b", linewidth=3)
    axes.plot(*points.T, "-o", color="#222222", linewidth=2.5, markersize=4)
    axes.plot(*(1000 * target), "x", color="#d01c1c", markersize=7)
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
    cx, cy, cz = 1000 * paper.SPHERE_CENTRE
    radius = 1000 * paper.SPHERE_RADIUS
    axes.plot_surface(
        cx + radius * np.cos(u) * np.sin(v),
        cy + radius * np.sin(u) * np.sin(v),
        cz + radius * np.cos(v),
        color="#4caf50",
        alpha=0.25,
        linewidth=0,
    )
    if not close:
        _draw_bed(axes, cy, cz)
    spans = [(0, 950), (0, 850), (-650, 50)]
    if close:
        spans = [(cx - 190, cx + 190), (cy - 190, cy + 190), (cz - 120, cz + 260)]
    for set_limits, span in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), spans, strict=True):
        set_limits(*span)
    axes.set_box_aspect([high - low for low, high in spans], zoom=1.0)
    axes.set_xlabel("x [mm]", fontsize=7)
    axes.set_ylabel("y [mm]", fontsize=7)
    axes.set_zlabel("z [mm]", fontsize=7)
    axes.tick_params(labelsize=6)
    axes.view_init(elev=18, azim=-62)


def _draw_bed(axes: Any, middle: float, top: float) -> None:
    """Draw a raised bed, a trapezium drawn along x; its size is our assumption."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    ends = []
    for x in (80.0, 900.0):
        section = [(-150, -250), (150, -250), (100, -100), (-100, -100)]
        ends.append([(x, middle + y, top + z) for y, z in section])
    sides = [[ends[0][i], ends[0][j], ends[1][j], ends[1][i]] for i, j in ((1, 2), (2, 3), (3, 0))]
    bed = Poly3DCollection(ends + sides, facecolor="#8d8d8d", edgecolor="#6b6b6b", alpha=0.25)
    axes.add_collection3d(bed)


def _title(arm: StrawberryArm, q: FloatArray, method: str) -> str:
    s10, s21, s32 = 1000 * q[:3]
    theta, beta = np.degrees(q[3:])
    return (
        f"{NAMES[method]}: {1000 * float(arm.energy(q)):.1f} mJ\n"
        f"s10 {s10:.1f}, s21 {s21:.1f}, s32 {s32:.1f} mm, θ {theta:.2f}°, β {beta:.2f}°"
    )


def pose(
    directory: Path, name: str, target: FloatArray, method: paper.Column, arm: StrawberryArm
) -> list[Path]:
    """Draw the mechanism as a method places it for one target."""
    drawing = figure(6.0, 5.2)
    axes = drawing.add_subplot(projection="3d")
    q = arm.solve(target, method).q
    draw_pose(axes, arm, q, target)
    axes.set_title(_title(arm, q, method), fontsize=9)
    return save(drawing, directory, name)


def table4(directory: Path, arm: StrawberryArm) -> list[Path]:
    """Draw the poses of table 4: two targets by every method."""
    drawing = figure(15, 8.6)
    for row, target in enumerate(paper.TABLE4_TARGETS):
        for column, method in enumerate(("ncos", "as", "ssas", "exact")):
            axes = drawing.add_subplot(2, 4, 4 * row + column + 1, projection="3d")
            q = arm.solve(target, method).q  # type: ignore[arg-type]
            draw_pose(axes, arm, q, target, close=True)
            axes.set_title(_title(arm, q, method), fontsize=8)
    return save(drawing, directory, "table4")
