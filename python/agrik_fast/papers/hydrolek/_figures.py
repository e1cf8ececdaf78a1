"""Drawings of the HydroLek paper's figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...plots import BAD, GOOD, PAGE_WIDTH, PALE, figure, label
from .._output import save

# Curves that coincide stay visible: the first is the widest.
_STYLES = (("--", 3.5), ("-", 1.2), ("-.", 1.6))


def error_traces(
    directory: Path, name: str, panels: Mapping[str, Mapping[str, FloatArray]], steps: str
) -> list[Path]:
    """Error over steps, one panel a group of curves."""
    drawing = figure(PAGE_WIDTH, 2.6 * len(panels))
    for i, (title, curves) in enumerate(panels.items()):
        axes = drawing.add_subplot(len(panels), 1, i + 1)
        styles = _STYLES if len(curves) > 1 else (("-", 1.6),)
        for (style, width), (words, errors) in zip(styles, curves.items(), strict=False):
            axes.semilogy(1e3 * errors, style, linewidth=width, label=words)
        axes.axhline(1.0, color="0.7", linewidth=0.8)
        axes.annotate("1 mm", (0.0, 1.0), va="bottom", color="0.4")
        axes.set_title(title)
        axes.set_xlabel(steps)
        axes.set_ylabel("error [mm]")
        if len(curves) > 1:
            axes.legend()
    return save(drawing, directory, name)


def show_dots(legend: Any) -> None:
    """Draw the small points of clouds larger beside their name, where one alone is not seen."""
    for mark in legend.legend_handles:
        if mark.get_marker() == ".":
            mark.set_markersize(8)


def workspace(directory: Path, points: FloatArray, reached: NDArray[np.bool_]) -> list[Path]:
    """Goals in the paper frame from two sides; circles where the solver failed."""
    drawing = figure(PAGE_WIDTH, 3.8)
    for i, (u, v) in enumerate(((0, 1), (0, 2))):
        axes = drawing.add_subplot(1, 2, i + 1)
        axes.plot(1e3 * points[reached, u], 1e3 * points[reached, v], ".", ms=2, label="reached")
        missed = ~reached
        axes.plot(1e3 * points[missed, u], 1e3 * points[missed, v], "o", mfc="none", label="missed")
        axes.set_xlabel(f"{'xyz'[u]} [mm]")
        axes.set_ylabel(f"{'xyz'[v]} [mm]")
        axes.set_aspect("equal")
    names = axes.get_legend_handles_labels()
    show_dots(drawing.legend(*names, loc="outside lower center", ncols=2))
    return save(drawing, directory, "figure6")


def planar(directory: Path, cloud: FloatArray, joints: FloatArray) -> list[Path]:
    """Draw the planar arm at (5, 0) over the points it can reach."""
    drawing = figure(5.0, 4.6)
    axes = drawing.add_subplot()
    axes.plot(cloud[:, 0], cloud[:, 1], ".", color=PALE, ms=2, label="reach")
    line = np.vstack([np.zeros(2), joints])
    axes.plot(line[:, 0], line[:, 1], "-o", color=GOOD, label="arm")
    axes.plot([5.0], [0.0], "x", color=BAD, ms=10, mew=2, label="target")
    axes.set_aspect("equal")
    axes.set_xlabel(label("x", "unit of the links"))
    axes.set_ylabel(label("y", "unit of the links"))
    show_dots(drawing.legend(loc="outside lower center", ncols=3))
    return save(drawing, directory, "figure7")


def units(directory: Path, rows: Sequence[Sequence[object]]) -> list[Path]:
    """Goals reached by three published gain sets under three readings of their units."""
    drawing = figure(PAGE_WIDTH, 3.4)
    axes = drawing.add_subplot()
    labels = [f"{row[0]}\n{row[1]} start" for row in rows]
    place = np.arange(len(rows))
    for k, name in enumerate(("Kp 0.0847", "Kp 0.02", "tuned")):
        counts = [float(str(row[2 + k])) for row in rows]
        axes.bar(place + 0.26 * (k - 1), counts, width=0.24, label=name)
    for published, gains in ((960, "Kp 0.02"), (994, "tuned")):
        axes.axhline(published, color="0.4", linewidth=0.8, linestyle=":")
        axes.annotate(
            f"{gains},\npublished",
            (1.0, published),
            xycoords=("axes fraction", "data"),
            xytext=(4, 0),
            textcoords="offset points",
            va="top" if published < 970 else "bottom",
            color="0.4",
        )
    axes.set_ylim(0, 1030)
    axes.set_xticks(place, labels)
    axes.set_ylabel("goals reached of 1,000")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return save(drawing, directory, "units")
