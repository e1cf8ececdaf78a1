"""Files and drawings of what the HydroLek paper leaves open: edge, singular starts, poses,
stability, further robots, and its two control loops.
"""  # noqa: D205 - the title does not fit one line

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...plots import GREY, PAGE_WIDTH, PALETTE, figure, styled
from ...result import Status
from ...robot import Robot
from ...solvers import StateSpace
from .._output import save, write_csv
from ._edge import Lost, lost_goals
from ._figures import show_dots
from ._pose import LENGTHS_M, PoseRow, success_by_weight
from ._robots import RobotRow, tuned_robots
from ._singular import DISTANCES, singularity_study
from ._stability import SETS, Stability, missed_and_reached, spectral_radius, stability

FAINT = "#c9d6de"


def write_studies(directory: Path, robot: Robot) -> list[Path]:
    """Write the studies' tables and figures; return the files."""
    turn = robot.frames["paper"][:3, :3]
    lost, goals, first = lost_goals(robot)
    header = ["method", "distance_rad", "reached", "stalled", "not_found", "of", "iterations"]
    beside = singularity_study()
    poses = success_by_weight(robot)
    return [
        write_csv(directory / "lost.csv", Lost._fields, lost),
        *_draw_lost(directory, goals @ turn.T, first),
        write_csv(directory / "near_singular.csv", header, beside),
        *_draw_singular(directory, beside),
        write_csv(directory / "pose.csv", PoseRow._fields, poses),
        *_draw_pose(directory, poses),
        write_csv(directory / "stability.csv", Stability._fields, stability(robot)),
        *_draw_stability(directory, robot, turn),
        write_csv(directory / "robots.csv", RobotRow._fields, tuned_robots()),
        *figure2(directory),
        *figure3(directory),
    ]


@styled
def _draw_lost(
    directory: Path, points: FloatArray, lost: Mapping[str, NDArray[np.bool_]]
) -> list[Path]:
    """Draw the goals that methods lose, from two sides, as figure 6."""
    drawing = figure(PAGE_WIDTH, 4.0)
    shown = {
        "pseudo-inverse": ("o", PALETTE[0], 7),
        "transpose": ("s", PALETTE[2], 5),
        "damped, 200 mm": ("D", PALETTE[4], 4),
        "IK-PID, tuned": ("x", PALETTE[1], 6),
    }
    millimetres = 1000 * points
    for axes, (u, v) in zip(drawing.subplots(1, 2), ((0, 1), (0, 2)), strict=True):
        axes.plot(millimetres[:, u], millimetres[:, v], ".", ms=1.5, color=FAINT, label="goals")
        for name, (mark, color, size) in shown.items():
            own = millimetres[lost[name]]
            axes.plot(
                own[:, u],
                own[:, v],
                mark,
                ms=size,
                mfc="none",
                color=color,
                label=f"lost by {name}: {len(own)}",
            )
        axes.set_xlabel(f"{'xyz'[u]} [mm]")
        axes.set_ylabel(f"{'xyz'[v]} [mm]")
        axes.set_aspect("equal")
    names = axes.get_legend_handles_labels()
    show_dots(drawing.legend(*names, loc="outside lower center", ncols=3))
    return save(drawing, directory, "lost")


@styled
def _draw_singular(directory: Path, rows: Sequence[Sequence[object]]) -> list[Path]:
    drawing = figure(PAGE_WIDTH, 3.4)
    axes = drawing.subplots()
    names = {
        "pseudo-inverse, closed form": "o-",
        "pseudo-inverse, SVD": "s-",
        "transpose": "^-",
        "damped, 200 mm": "D-",
        "IK-PID, published": "x--",
        "state space, 90 (PSO)": "v--",
        "Broyden from static gain": "*--",
    }
    place = np.arange(len(DISTANCES))
    for name, style in names.items():
        own = [row for row in rows if row[0] == name]
        share = [100 * float(str(row[2])) / float(str(row[5])) for row in own]
        axes.plot(place, share, style, ms=5, mfc="none", label=name)
    labels = ["0"] + [f"$10^{{{round(np.log10(x))}}}$" for x in DISTANCES[1:]]
    axes.set_xticks(place, labels)
    axes.set_xlabel("distance of the start from a singular posture [rad]")
    axes.set_ylabel("goals reached [%]")
    axes.set_ylim(-3, 103)
    drawing.legend(loc="outside lower center", ncols=3)
    return save(drawing, directory, "near_singular")


@styled
def _draw_pose(directory: Path, rows: Sequence[PoseRow]) -> list[Path]:
    drawing = figure(PAGE_WIDTH, 3.4)
    axes = drawing.subplots()
    names = list(dict.fromkeys(row.method for row in rows))
    for name, style in zip(names, ("x--", "^-", "D-", "v:", "v-", "o-"), strict=True):
        reached = [row.reached for row in rows if row.method == name]
        axes.semilogx(LENGTHS_M, reached, style, ms=5, mfc="none", label=name)
    axes.set_xlabel("length that a radian of orientation error counts as [m]")
    axes.set_ylabel("poses reached of 1,000")
    axes.set_ylim(-20, 1020)
    drawing.legend(loc="outside lower center", ncols=3)
    return save(drawing, directory, "pose")


@styled
def _draw_stability(directory: Path, robot: Robot, turn: FloatArray) -> list[Path]:
    """Draw how fast errors die out where goals are reached, and which goals are lost."""
    drawing = figure(PAGE_WIDTH, 3.6)
    panels = drawing.subplots(1, 2, sharey=True)
    for axes, name in zip(panels, ("trial (published)", "15 numbers (CMA-ES)"), strict=True):
        gains = StateSpace.load(SETS[name], as_tuned=True)
        goals, q, status = missed_and_reached(robot, gains)
        points, reached = 1000 * goals @ turn.T, status == Status.CONVERGED
        radius = spectral_radius(robot, gains, q)
        dots = axes.scatter(
            *points[reached, :2].T, c=radius[reached], s=5, cmap="viridis", vmin=0.6, vmax=1.0
        )
        stalled = status == Status.STALLED
        axes.plot(
            *points[stalled, :2].T, "o", ms=5, mfc="none", color=PALETTE[1], label="at a limit"
        )
        moving = ~reached & ~stalled
        axes.plot(*points[moving, :2].T, "x", ms=5, color=PALETTE[3], label="still moving")
        axes.set_title(f"{name}: {int(reached.sum())} of {len(goals)} reached")
        axes.set_xlabel("x [mm]")
        axes.set_aspect("equal")
    panels[0].set_ylabel("y [mm]")
    bar = drawing.colorbar(dots, ax=panels, shrink=0.8)
    bar.set_label("spectral radius of the error's system")
    handles = axes.get_legend_handles_labels()
    drawing.legend(*handles, loc="outside lower center", ncols=2, title="goals lost")
    return save(drawing, directory, "stability")


@styled
def figure2(directory: Path) -> list[Path]:
    """Draw the Jacobian transpose as a control loop."""
    return _loop(directory, "figure2", "α Jᵀ(θ)\n(11), (12)", "J is computed anew\nat every step")


@styled
def figure3(directory: Path) -> list[Path]:
    """Draw the state space as a control loop."""
    law = "G(z): x ← A x + B e,\nΔθ = C x   (14)"
    return _loop(directory, "figure3", law, "A, B, C stay\nas they are")


def _loop(directory: Path, name: str, law: str, note: str) -> list[Path]:
    """Draw error, law, sum and kinematics as a loop."""
    drawing = figure(PAGE_WIDTH, 2.2)
    drawing.set_layout_engine("none")
    axes = drawing.add_axes((0.0, 0.0, 1.0, 1.0))
    boxes = (
        (1.05, "−", "circle,pad=0.25"),
        (3.05, law, "square,pad=0.5"),
        (5.6, "sum, saturated\nθ ← θ + Δθ   (15)", "square,pad=0.5"),
        (7.8, "kinematics\ns = f(θ)   (1)", "square,pad=0.5"),
    )
    drawn = []
    for x, text, shape in boxes:
        frame = {"boxstyle": shape, "facecolor": "#d6e8f3", "edgecolor": GREY}
        drawn.append(axes.text(x, 2.0, text, ha="center", va="center", bbox=frame))
    axes.set_xlim(0, 9.3)
    axes.set_ylim(0.7, 2.5)
    # A box has its size once it is drawn, and the arrows go from edge to edge.
    drawing.canvas.draw()
    back, pad = axes.transData.inverted(), 0.5 * float(drawn[0].get_fontsize()) * drawing.dpi / 72
    words = [back.transform(each.get_window_extent().padded(pad))[:, 0].tolist() for each in drawn]
    starts = [0.1, *(right for _, right in words)]
    ends = [*(left for left, _ in words), 9.25]
    for start, end, signal in zip(starts, ends, ("goal ŝ", "error e", "Δθ", "θ", "s"), strict=True):
        _arrow(axes, (start, 2.0), (end, 2.0))
        axes.text((start + end) / 2, 2.08, signal, ha="center")
    axes.plot([8.9, 8.9, 1.05], [2.0, 0.85, 0.85], color="black", lw=1.2)
    _arrow(axes, (1.05, 0.85), (1.05, 1.8))
    axes.text(5.6, 0.9, "one step later", ha="center")
    axes.text(3.05, 1.35, note, ha="center", va="center", color=GREY)
    axes.axis("off")
    return save(drawing, directory, name)


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate(
        "",
        end,
        start,
        arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.2, "shrinkA": 0, "shrinkB": 0},
    )
