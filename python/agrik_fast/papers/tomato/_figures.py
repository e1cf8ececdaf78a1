"""Figures of the tomato paper: the errors of figure 8 and the arm's branches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..._checks import FloatArray
from ...arms import TomatoArm
from ...plots import PAGE_WIDTH, PALETTE, figure
from .._output import save
from ._published import PUBLISHED


def figure8(directory: Path, draws: Mapping[str, FloatArray]) -> list[Path]:
    """Draw the position errors of `monte_carlo` beside the published ones."""
    drawing = figure(PAGE_WIDTH, 3.4)
    bars, spread = drawing.subplots(1, 2)
    place = np.arange(len(draws))
    means = [float(values.mean()) for values in draws.values()]
    bars.bar(place - 0.2, means, 0.4, label="Monte Carlo mean", color=PALETTE[2])
    paper = [PUBLISHED[method].error_percent for method in draws]
    bars.bar(
        place + 0.2,
        np.nan_to_num(paper),
        0.4,
        label="published (transpose: maximum)",
        color="#c9c9c9",
    )
    bars.set_ylim(0.0, 3.3)  # room for the legend
    for at, value in zip(place, paper, strict=True):
        if math.isnan(value):
            bars.text(at + 0.2, 0.05, "not given", rotation=90, ha="center")
    bars.set_xticks(place, list(draws))
    bars.set_ylabel("position error [% of distance]")
    bars.legend()
    # The same edges for all: what differs is the draws, not where bins begin.
    edges = np.linspace(0.0, max(float(values.max()) for values in draws.values()), 51)
    for (method, values), style in zip(draws.items(), ("-", "-", "--", "-"), strict=True):
        spread.hist(values, bins=edges, histtype="step", linestyle=style, label=method)
    spread.set_xlabel("position error [% of distance]")
    spread.set_ylabel("draws")
    spread.legend()
    drawing.suptitle("Figure 8: error sizes are assumed, so this shows plausibility")
    return save(drawing, directory, "figure8")


def arm(directory: Path) -> list[Path]:
    """Draw all branches of one target."""
    from matplotlib.ticker import MultipleLocator

    drawing = figure(6.4, 5.6)
    axes = drawing.add_subplot(projection="3d")
    branches = TomatoArm(lower=[-math.pi] * 3, upper=[math.pi] * 3)
    target = np.array([0.19, 0.06, 0.10])
    styles = {"up": "-", "down": "-", "up_flip": ":", "down_flip": ":"}
    for (name, style), q in zip(styles.items(), branches.branches(target).q, strict=True):
        c, s = np.cos(q[2]), np.sin(q[2])
        r, z = branches.l1 * np.cos(q[0]), branches.l1 * np.sin(q[0])
        points = np.array([[0.0, 0.0, 0.0], [r * c, r * s, z], branches.fk(q)])
        # A flipped arm lies on another one: dotted, with larger and empty marks.
        marks = {"marker": "s", "markersize": 9, "fillstyle": "none"} if style == ":" else {}
        axes.plot(*points.T, style, **{"marker": "o", **marks}, label=name)
    axes.plot(*target, "*", color=PALETTE[1], markersize=12, label="target")
    axes.plot([0, 0], [0, 0], [-0.1, 0], color="#555555", linewidth=5, label="pan axis")
    axes.set_xlim(-0.1, 0.25)
    axes.set_ylim(-0.15, 0.2)
    axes.set_zlim(-0.1, 0.25)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MultipleLocator(0.1))
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_zlabel("z [m]")
    drawing.legend(loc="outside lower center", ncols=6)
    axes.set_title(
        "All branches of one target: with the pan half a turn round\n"
        "the same elbow points are reached by other angles (dotted)",
    )
    return save(drawing, directory, "arm")
