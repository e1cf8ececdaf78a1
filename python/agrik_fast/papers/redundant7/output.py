"""Tables as CSV and Markdown, figures as PNG and SVG."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import AgrikError
from .experiments import Repeated, SinglePoint, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GOOD, BAD = "#2a7f62", "#b5462f"


def table(folder: Path, name: str, content: Table) -> list[Path]:
    """Write a table; return its files."""
    as_csv, as_text = folder / f"{name}.csv", folder / f"{name}.md"
    with as_csv.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(content.columns)
        writer.writerows(content.rows)
    lines = [
        f"**{content.title}**",
        "",
        _row(content.columns),
        _row(("---",) * len(content.columns)),
    ]
    lines += [_row(row) for row in content.rows]
    as_text.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return [as_csv, as_text]


def _row(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"


def _figure(width: float, height: float) -> Figure:
    """Return an empty figure that belongs to no window."""
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ModuleNotFoundError as error:
        message = "figures need matplotlib: pip install 'agrik_fast[papers]'"
        raise AgrikError(message) from error
    # The same drawing has the same bytes, whoever makes it.
    mpl.rcParams["svg.hashsalt"] = "agrik_fast"
    return Figure(figsize=(width, height), layout="constrained")


def _save(figure: Figure, folder: Path, name: str) -> list[Path]:
    files = [folder / f"{name}.png", folder / f"{name}.svg"]
    figure.savefig(files[0], dpi=150)
    figure.savefig(files[1], metadata={"Date": None})
    return files


def convergence(folder: Path, content: SinglePoint) -> list[Path]:
    """Draw the best cost by generation (figure 3)."""
    figure = _figure(6, 4)
    axes = figure.subplots()
    axes.semilogy(content.costs, color=GOOD, label="one run")
    axes.semilogy(content.median, "--", color="gray", label="median of 30 runs")
    axes.axvline(80, color=BAD, linewidth=0.8, label="convergence as published")
    axes.set_xlabel("generation")
    axes.set_ylabel("best cost [mm + 100 rad]")
    axes.legend()
    return _save(figure, folder, "figure3")


def thirty(folder: Path, content: Repeated) -> list[Path]:
    """Draw the costs of the first 30 runs (figure 4)."""
    figure = _figure(6, 4)
    axes = figure.subplots()
    run = np.arange(1, 31)
    costs, good = content.costs[:30], content.success[:30]
    axes.semilogy(run, costs, color="lightgray", zorder=1)
    axes.semilogy(run[good], costs[good], "o", color=GOOD, label="succeeded")
    axes.semilogy(run[~good], costs[~good], "x", color=BAD, label="stuck")
    axes.axhline(1.27e-6, color="gray", linewidth=0.8, linestyle="--", label="published mean")
    axes.set_xlabel("run")
    axes.set_ylabel("cost after 200 generations")
    axes.legend()
    return _save(figure, folder, "figure4")


def histogram(folder: Path, content: Repeated) -> list[Path]:
    """Draw how often which cost was reached, failures included."""
    figure = _figure(6, 4)
    axes = figure.subplots()
    costs = np.log10(np.maximum(content.costs, 1e-12))
    edges = np.linspace(costs.min(), costs.max(), 61).tolist()
    axes.hist(costs[content.success], edges, color=GOOD, label="succeeded")
    axes.hist(costs[~content.success], edges, color=BAD, label="stuck")
    axes.set_yscale("log")
    axes.set_xlabel("log10 of the cost after 200 generations")
    axes.set_ylabel("runs")
    axes.set_title(f"{content.share:.1%} of {len(costs)} runs succeed", fontsize="medium")
    axes.legend()
    return _save(figure, folder, "histogram")
