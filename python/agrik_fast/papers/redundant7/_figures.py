"""Figures of the paper on redundant7."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..._checks import FloatArray
from ...plots import GREY, PAGE_WIDTH, PALETTE, figure, styled
from .._output import save
from ._published import PUBLISHED_COST, PUBLISHED_MEAN, PUBLISHED_Q
from ._tables import Repeated, SinglePoint, arm, target

GOOD, BAD = PALETTE[2], PALETTE[1]


def convergence(folder: Path, content: SinglePoint) -> list[Path]:
    """Draw the best cost by generation (figure 3)."""
    drawing = figure(6, 4)
    axes = drawing.subplots()
    axes.semilogy(content.costs, color=GOOD, label="one run")
    axes.semilogy(content.median, "--", color="gray", label="median of 30 runs")
    axes.axvline(80, color=BAD, linewidth=0.8, label="convergence as published")
    axes.plot([200], [PUBLISHED_COST], "D", color=BAD, label="published cost, 6.65e-6")
    axes.set_xlabel("generation")
    axes.set_ylabel("best cost [mm + 100 rad]")
    axes.legend()
    return save(drawing, folder, "figure3")


def thirty(folder: Path, content: Repeated) -> list[Path]:
    """Draw the costs of the first 30 runs (figure 4)."""
    drawing = figure(6, 4)
    axes = drawing.subplots()
    run = np.arange(1, 31)
    costs, good = content.costs[:30], content.success[:30]
    axes.semilogy(run, costs, color="lightgray", zorder=1)
    axes.semilogy(run[good], costs[good], "o", color=GOOD, label="succeeded")
    axes.semilogy(run[~good], costs[~good], "x", color=BAD, label="stuck")
    axes.axhline(
        PUBLISHED_MEAN, color="gray", linewidth=0.8, linestyle="--", label="published mean"
    )
    axes.set_xlabel("run")
    axes.set_ylabel("cost after 200 generations [mm + 100 rad]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return save(drawing, folder, "figure4")


def histogram(folder: Path, content: Repeated) -> list[Path]:
    """Draw how often which cost was reached, failures included."""
    drawing = figure(6, 4)
    axes = drawing.subplots()
    costs = np.log10(np.maximum(content.costs, 1e-12))
    edges = np.linspace(costs.min(), costs.max(), 61).tolist()
    axes.hist(costs[content.success], edges, color=GOOD, label="succeeded")
    axes.hist(costs[~content.success], edges, color=BAD, label="stuck")
    axes.set_yscale("log")
    axes.set_xlabel("log10 of the cost after 200 generations [mm + 100 rad]")
    axes.set_ylabel("runs")
    axes.set_title(f"{content.share:.1%} of {len(costs)} runs succeed")
    axes.legend()
    return save(drawing, folder, "histogram")


@styled
def postures(folder: Path, q: FloatArray) -> list[Path]:
    """Draw the arm at the published joint values and at ours (for figures 1 and 2)."""
    drawing = figure(PAGE_WIDTH, 4.3)
    axes: Any = drawing.add_subplot(projection="3d")
    goal = target()
    cases: tuple[tuple[str, ArrayLike, str, str], ...] = (
        ("published joint values, Table I", PUBLISHED_Q, PALETTE[1], "s--"),
        ("ours", q, PALETTE[0], "o-"),
    )
    for label, values, color, style in cases:
        links = arm().fk_links(values)
        line = np.concatenate([np.zeros((1, 3)), links[:, :3, 3]])
        axes.plot(*line.T, style, color=color, lw=2.5, ms=5, label=label)
        _tool_axis(axes, links[-1], color)
    axes.plot(*goal[:3, 3], "*", ms=13, color=PALETTE[2], label="target")
    _tool_axis(axes, goal, PALETTE[2])
    axes.plot([0, 0], [0, 0], [0, 0], "s", ms=8, color=GREY, label="base")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_box_aspect((1, 1, 1), zoom=0.9)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_zlabel("z [m]")
    axes.locator_params(nbins=5)
    axes.view_init(elev=22, azim=-35)
    drawing.legend(loc="outside lower center", ncols=4, title="thin lines: axis z of the tool")
    return save(drawing, folder, "postures")


def _tool_axis(axes: Any, pose: FloatArray, color: str) -> None:
    """Draw the tool's z axis."""
    end = pose[:3, 3] + 0.12 * pose[:3, 2]
    axes.plot(*np.array([pose[:3, 3], end]).T, color=color, lw=1)
