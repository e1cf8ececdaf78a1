"""Figures of the strawberry paper: the plant from above and the mechanism in its poses."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np

from ..._checks import FloatArray
from ...arms import StrawberryArm
from ...plots import GREY, PAGE_WIDTH, PALETTE, figure, label
from .._output import save
from ._published import (
    SPHERE_CENTRE,
    SPHERE_RADIUS,
    TABLE4_COLUMNS,
    TABLE4_TARGETS,
    Column,
    targets,
)

NAMES = {"as": "AS", "ssas": "SSAS", "ncos": "NCOS", "exact": "exact minimum"}
QUADRANT_COLORS = (PALETTE[2], PALETTE[1], PALETTE[0], PALETTE[3])
RAIL, ACROSS, DOWN, LINKS, TARGET = GREY, PALETTE[0], PALETTE[1], "#222222", PALETTE[1]
PLANT, BED = PALETTE[2], GREY


# Where a number has neighbours on the side towards the middle: px to the right, and up.
_BESIDE = {7: (-6, 5), 9: (6, 5), 8: (-6, -5), 10: (6, -5), 11: (6, -4), 12: (-6, -4), 14: (6, 6)}


def figure2(directory: Path) -> list[Path]:
    """Draw the circle that the plant covers, from above, with the targets of table 3."""
    drawing = figure(5.2, 5.0)
    axes = drawing.add_subplot()
    points = 1000 * targets()
    x, y = 1000 * SPHERE_CENTRE[:2]
    angle = np.linspace(0, 2 * np.pi, 181)
    radius = 1000 * SPHERE_RADIUS
    axes.plot(x + radius * np.cos(angle), y + radius * np.sin(angle), color="#444444")
    axes.axhline(y, color="#999999", linewidth=0.6)
    axes.axvline(x, color="#999999", linewidth=0.6)
    axes.plot(x, y, "+", color="#444444")
    for quadrant in range(4):
        own = slice(5 * quadrant, 5 * quadrant + 5)
        color = QUADRANT_COLORS[quadrant]
        axes.plot(points[own, 0], points[own, 1], "o", color=color, label=f"Q{quadrant + 1}")
    for number, (px, py, _) in enumerate(points, 1):
        # Towards the middle, where neither the circle nor most neighbours are.
        right, up = _BESIDE.get(number, (-6 if px > x else 6, 0))
        axes.annotate(
            str(number),
            (px, py),
            xytext=(right, up),
            textcoords="offset points",
            ha="left" if right > 0 else "right",
            va="center",
        )
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.legend(loc="lower left", bbox_to_anchor=(1.0, 0.0), title="quadrant")
    axes.set_title("Figure 2: the plant from above, targets of table 3")
    return save(drawing, directory, "figure2")


def joint_points(arm: StrawberryArm, q: FloatArray) -> FloatArray:
    """Return pitch axis, roll axis and tool point, shape (3, 3), m."""
    l2, l3 = (float(np.asarray(arm.parameters[name])) for name in ("l2", "l3"))
    theta, beta = q[3:]
    down = np.array([-np.sin(theta), 0.0, -np.cos(theta)])
    tip = arm.fk(q)
    roll = tip - l3 * (np.cos(beta) * down + np.array([0.0, np.sin(beta), 0.0]))
    return np.array([roll - l2 * down, roll, tip])


def draw_pose(axes: Any, arm: StrawberryArm, q: FloatArray, target: FloatArray) -> None:
    """Draw slides, arm, plant sphere and bed in a 3D axes, mm."""
    points = 1000 * joint_points(arm, q)
    low, high = 1000 * arm.lower, 1000 * arm.upper
    pitch = points[0]
    rail_z = pitch[2] + 1000 * float(q[2])
    # Slides: y (s10) on both sides, x (s21) across, z (s32) down.
    y_rail = pitch[1] - 1000 * float(q[0]) + np.array([low[0], high[0]])
    x_rail = pitch[0] - 1000 * float(q[1]) + np.array([low[1], high[1]])
    for x in x_rail:
        axes.plot([x, x], y_rail, [rail_z, rail_z], color=RAIL, linewidth=2)
    axes.plot(x_rail, [pitch[1]] * 2, [rail_z, rail_z], color=ACROSS, linewidth=3)
    axes.plot([pitch[0]] * 2, [pitch[1]] * 2, [rail_z, pitch[2]], color=DOWN, linewidth=3)
    axes.plot(*points.T, "-o", color=LINKS, linewidth=2.5, markersize=4)
    axes.plot(*(1000 * target), "x", color=TARGET, markersize=7)
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
    cx, cy, cz = 1000 * SPHERE_CENTRE
    radius = 1000 * SPHERE_RADIUS
    axes.plot_surface(
        cx + radius * np.cos(u) * np.sin(v),
        cy + radius * np.sin(u) * np.sin(v),
        cz + radius * np.cos(v),
        color=PLANT,
        alpha=0.25,
        linewidth=0,
    )
    _draw_bed(axes, cy, cz)
    spans = [(0, 950), (0, 850), (-650, 50)]
    for set_limits, span in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), spans, strict=True):
        set_limits(*span)
    # Seen from its end this axis is short: more numbers would run into each other.
    axes.set_yticks([0, 400, 800])
    axes.set_box_aspect([high - low for low, high in spans], zoom=1.2)
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.set_zlabel("z [mm]")
    axes.view_init(elev=18, azim=-62)


def _draw_bed(axes: Any, middle: float, top: float) -> None:
    """Draw a raised bed, a trapezium drawn along x; its size is our assumption."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    ends = []
    for x in (80.0, 900.0):
        section = [(-150, -250), (150, -250), (100, -100), (-100, -100)]
        ends.append([(x, middle + y, top + z) for y, z in section])
    sides = [[ends[0][i], ends[0][j], ends[1][j], ends[1][i]] for i, j in ((1, 2), (2, 3), (3, 0))]
    bed = Poly3DCollection(ends + sides, facecolor=BED, edgecolor="#6b6b6b", alpha=0.25)
    axes.add_collection3d(bed)


def _title(arm: StrawberryArm, q: FloatArray, method: str) -> str:
    s10, s21, s32 = 1000 * q[:3]
    theta, beta = np.degrees(q[3:])
    return (
        f"{NAMES[method]}: {1000 * float(arm.energy(q)):.1f} mJ\n"
        f"s10 {s10:.1f}, s21 {s21:.1f}, s32 {s32:.1f} mm, θ {theta:.2f}°, β {beta:.2f}°"
    )


def _legend() -> list[Any]:
    """Return what the colours of `draw_pose` stand for."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    lines = [("slide s10 (y), two rails", RAIL), ("slide s21 (x)", ACROSS)]
    lines.append(("slide s32 (z)", DOWN))
    handles: list[Any] = [Line2D([], [], color=c, linewidth=3, label=name) for name, c in lines]
    handles.append(Line2D([], [], color=LINKS, marker="o", markersize=4, label="arm (θ, β)"))
    cross = Line2D([], [], color=TARGET, marker="x", linestyle="none", label="target")
    handles += [cross, Patch(facecolor=PLANT, alpha=0.4, label="plant")]
    return [*handles, Patch(facecolor=BED, alpha=0.4, label="bed (size assumed)")]


def pose(
    directory: Path, name: str, target: FloatArray, method: Column, arm: StrawberryArm
) -> list[Path]:
    """Draw the mechanism as a method places it for one target."""
    drawing = figure(PAGE_WIDTH, 4.6)
    axes = drawing.add_subplot(projection="3d")
    q = arm.solve(target, method).q
    draw_pose(axes, arm, q, target)
    number = name.removeprefix("figure")
    what = f"Figure {number}" if number != name else "Not in the paper"
    drawing.suptitle(f"{what}. {_title(arm, q, method)}")
    drawing.legend(handles=_legend(), loc="outside lower center", ncols=4)
    return save(drawing, directory, name)


def table4(directory: Path, arm: StrawberryArm) -> list[Path]:
    """Draw the poses of table 4: two targets by every method."""
    # Seen from the front and from the side: four small boxes in perspective cannot be read.
    drawing = figure(PAGE_WIDTH, 6.6)
    panels = drawing.subplots(2, 2, sharex="col", sharey="row")
    for row, target in zip(panels, TABLE4_TARGETS, strict=True):
        for axes, across in zip(row, (0, 1), strict=True):
            _draw_side(axes, arm, target, across)
            axes.set_xlabel(label("xy"[across], "mm"))
            axes.tick_params(labelbottom=True)
        row[0].set_ylabel(label("z", "mm"))
        x, y, z = 1000 * target
        lines = [f"target ({x:.0f}, {y:.0f}, {z:.1f}) mm"]
        lines += [
            f"{NAMES[method]}: {1000 * float(arm.energy(arm.solve(target, method).q)):.0f} mJ"
            for method in TABLE4_COLUMNS
        ]
        row[1].text(
            1.03, 0.5, "\n\n".join(lines), transform=row[1].transAxes, va="center", ha="left"
        )
    panels[0, 0].set_title("from the front")
    panels[0, 1].set_title("from the side")
    handles, names = panels[0, 0].get_legend_handles_labels()
    drawing.legend(handles, names, loc="outside lower center", ncols=3)
    return save(drawing, directory, "table4")


# The exact minimum lies under the NCOS: the first is the widest.
_METHOD_LOOKS = {
    "exact": (PALETTE[5], "-", 6.0),
    "ncos": (PALETTE[0], "-", 2.0),
    "as": (PALETTE[1], "-", 2.0),
    "ssas": (PALETTE[2], "--", 2.0),
}


def _draw_side(axes: Any, arm: StrawberryArm, target: FloatArray, across: int) -> None:
    """Draw slide and arm by every method, mm, from the front (`across` 0) or the side (1)."""
    from matplotlib.patches import Circle

    seen = [across, 2]
    x, z = (1000 * SPHERE_CENTRE[seen]).tolist()
    plant = Circle((x, z), 1000 * SPHERE_RADIUS, color=PLANT, alpha=0.25, label="plant")
    axes.add_patch(plant)
    for method, (color, style, width) in _METHOD_LOOKS.items():
        points = 1000 * joint_points(arm, arm.solve(target, cast("Column", method)).q)[:, seen]
        slide = points[0] + np.array([[0.0, 60.0], [0.0, 0.0]])
        axes.plot(*slide.T, style, color=color, linewidth=width + 2, alpha=0.5)
        axes.plot(*points.T, style, color=color, linewidth=width, label=NAMES[method])
        axes.plot(*points.T, "o", color=color, markersize=width + 3)
    axes.plot(*(1000 * target[seen]), "x", color="black", markersize=8, label="target")
    axes.plot([], [], color=GREY, linewidth=4, alpha=0.5, label="end of slide s32")
    axes.set_aspect("equal")
