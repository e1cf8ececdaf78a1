"""The time columns of table 3: ours measured, the paper's summed up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arms import StrawberryArm
from .._output import best_seconds
from ._published import COLUMNS, Column, published, targets


def times_ns(arm: StrawberryArm) -> dict[Column, list[float]]:
    """Return the time of each target of table 3, ns, by method.

    Of the closed forms in a batch of the same target, of NCOS alone.
    """
    found: dict[Column, list[float]] = {column: [] for column in COLUMNS}
    for point in targets():
        many = np.tile(point, (4000, 1))
        for column in COLUMNS:
            batch, repeats = (point[None], 2) if column == "ncos" else (many, 5)
            seconds = best_seconds(lambda: arm.solve(batch, column), repeats)  # noqa: B023
            found[column].append(1e9 * seconds / len(batch))
    return found


class Times(NamedTuple):
    """A time column of table 3: mean and standard deviation over the targets.

    Attributes
    ----------
    column : str
        ncos, ssas, as or exact.
    published_s, published_sd_s : float, s
        The paper's; NaN for "exact".
    ours_s, ours_sd_s : float, s
        Ours.
    published_reduction, reduction : float, percent
        Mean time saved against NCOS; 0 for itself.
    """

    column: Column
    published_s: float
    published_sd_s: float
    ours_s: float
    ours_sd_s: float
    published_reduction: float
    reduction: float


def time_columns(times: dict[Column, list[float]]) -> list[Times]:
    """Return mean, standard deviation and reduction of each time column.

    Parameters
    ----------
    times : dict
        Times of the targets by method, ns, as `times_ns` measures them.
    """
    rows = published()
    slowest = np.array(times["ncos"])
    found = []
    for column in COLUMNS:
        own = np.array(times[column]) / 1e9
        paper = [row.get(f"t_{column.upper()}", math.nan) for row in rows]
        saved = 0.0 if column == "ncos" else math.nan
        printed = float(np.mean([row.get(f"dt_{column.upper()}_pct", saved) for row in rows]))
        found.append(
            Times(
                column,
                float(np.mean(paper)),
                float(np.std(paper, ddof=1)),
                float(own.mean()),
                float(own.std(ddof=1)),
                printed,
                float(np.mean(100 * (1 - 1e9 * own / slowest))),
            )
        )
    return found


def time_report(times: Sequence[Times]) -> list[str]:
    """Return the time columns in Markdown."""
    lines = [
        "# Time columns of table 3",
        "",
        "| column | paper, ms | ours, ms | saved against NCOS, paper | ours |",
        "|---|---|---|---|---|",
    ]
    for row in times:
        paper = f"{1e3 * row.published_s:.1f} ± {1e3 * row.published_sd_s:.3g}"
        saved = f"{row.published_reduction:.2f} %"
        lines.append(
            f"| {row.column} | {'' if math.isnan(row.published_s) else paper} "
            f"| {1e3 * row.ours_s:.3g} ± {1e3 * row.ours_sd_s:.2g} "
            f"| {'' if math.isnan(row.published_reduction) else saved} | {row.reduction:.4f} % |"
        )
    return [*lines, "", "Mean and standard deviation over the 20 targets."]
