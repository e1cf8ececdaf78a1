"""Where the tomato paper's iterative methods fail: by the step's size, by the target's place.

The paper reports one target that the inverse did not reach, and values of alpha for which the
transpose "did not perform its task", and gives neither.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...arms import TomatoArm, TransposeStepWarning
from ...plots import PAGE_WIDTH, PALETTE, figure, styled
from .._output import save, write_csv
from ._published import PUBLISHED
from ._tables import FITS, targets

Method = Literal["inverse", "pinv", "transpose", "dls"]

ALPHAS = np.geomspace(0.5, 128.0, 33)
"""Steps of the sweep, 1/m^2 (joint values in rad)."""

SWEEP_TARGETS = 100
SWEEP_CAP = 3000
MAP_CAP = 3000
MAP_STEP = 0.008
"""Distance of neighbours in the maps, m."""

AZIMUTH = np.radians(30)
"""Of the vertical plane of the maps: the pan, which starts at 0, has to turn too."""

MAPS: Mapping[str, tuple[Method, Mapping[str, float]]] = MappingProxyType(
    {
        "inverse, full steps": ("inverse", MappingProxyType({"gain": 1.0})),
        "inverse, 0.0181 of the error a step": ("inverse", FITS["inverse"]),
        "transpose, alpha = 13.4 per m²": ("transpose", FITS["transpose"]),
        "transpose, alpha = 25 per m²": ("transpose", MappingProxyType({"alpha": 25.0})),
    }
)
"""Methods whose lost targets are mapped, with their settings."""


class Sweep(NamedTuple):
    """What a fixed step of the transpose reaches.

    Attributes
    ----------
    alpha : float, 1/m^2
        The step, for lengths in m and angles in rad.
    reached : float
        Share of the targets that are reached.
    below_bound : float
        Share of the targets whose stability bound is above the step.
    iterations : float
        Mean over the targets reached; NaN where there are none.
    """

    alpha: float
    reached: float
    below_bound: float
    iterations: float


class Map(NamedTuple):
    """What a method makes of the targets of a vertical plane.

    Attributes
    ----------
    points : ndarray, shape (n, 2), m
        Distance from the pan axis, negative behind it, and height; all within reach.
    reached : ndarray, shape (n,)
        The method reaches the target.
    front : ndarray, shape (n,)
        The servos' limits allow the target.
    """

    points: FloatArray
    reached: NDArray[np.bool_]
    front: NDArray[np.bool_]

    @property
    def lost(self) -> float:
        """Share of the targets within the servos' limits that the method loses."""
        return float(1 - self.reached[self.front].mean())


def sweep() -> list[Sweep]:
    """Return what each step of `ALPHAS` reaches of 100 random targets."""
    arm, points = TomatoArm(), targets(SWEEP_TARGETS, seed=1)
    bounds = arm.transpose_bound(arm.branches(points).q[:, 0])
    rows = []
    for alpha in ALPHAS.tolist():
        ended = _iterate(arm, points, "transpose", {"alpha": alpha}, SWEEP_CAP)
        good = ended.success
        mean = float(ended.iterations[good].mean()) if good.any() else float("nan")
        rows.append(Sweep(alpha, float(good.mean()), float((bounds > alpha).mean()), mean))
    return rows


def lost_targets(name: str) -> Map:
    """Return what a method of `MAPS` makes of the targets of a plane."""
    method, settings = MAPS[name]
    arm = TomatoArm()
    side = np.arange(-0.32, 0.32 + MAP_STEP / 2, MAP_STEP)
    rho, z = (grid.ravel() for grid in np.meshgrid(side, side))
    inside = np.hypot(rho, z) < arm.l1 + arm.l2 - 1e-9
    rho, z = rho[inside], z[inside]
    points = np.stack([rho * np.cos(AZIMUTH), rho * np.sin(AZIMUTH), z], axis=-1)
    ended = _iterate(arm, points, method, settings, MAP_CAP)
    return Map(np.stack([rho, z], axis=-1), ended.success, arm.solve(points).success)


def _iterate(
    arm: TomatoArm, points: FloatArray, method: Method, settings: Mapping[str, float], cap: int
) -> Any:
    options: dict[str, Any] = dict(settings)
    with warnings.catch_warnings():
        # That the step is too long is what is looked at.
        warnings.simplefilter("ignore", TransposeStepWarning)
        return arm.iterate(points, method, max_iterations=cap, **options)


def write_lost(directory: Path) -> list[Path]:
    """Write the sweep, the shares of lost targets and both figures; return the files."""
    rows = sweep()
    maps = {name: lost_targets(name) for name in MAPS}
    header = ["alpha_per_m2", "alpha_per_dm2", "alpha_per_cm2"]
    header += ["reached_share", "below_bound_share", "mean_iterations"]
    lines = [
        (
            *(f"{row.alpha / unit:.4g}" for unit in (1, 1e2, 1e4)),
            f"{row.reached:.2f}",
            f"{row.below_bound:.2f}",
            "" if np.isnan(row.iterations) else f"{row.iterations:.1f}",
        )
        for row in rows
    ]
    shares = [
        (name, int(each.front.sum()), int((each.front & ~each.reached).sum()), f"{each.lost:.4f}")
        for name, each in maps.items()
    ]
    return [
        write_csv(directory / "alpha.csv", header, lines),
        write_csv(directory / "lost.csv", ["method", "targets", "lost", "lost_share"], shares),
        *_draw_sweep(directory, rows),
        *_draw_maps(directory, maps),
    ]


@styled
def _draw_sweep(directory: Path, rows: list[Sweep]) -> list[Path]:
    drawing = figure(PAGE_WIDTH, 3.0)
    share, count = drawing.subplots(1, 2)
    alpha = [row.alpha for row in rows]
    share.semilogx(alpha, [100 * row.reached for row in rows], "o-", ms=3, label="reached")
    share.semilogx(
        alpha,
        [100 * row.below_bound for row in rows],
        "--",
        color=PALETTE[1],
        label="stable by the bound",
    )
    share.axvspan(alpha[0], 1.0, color=PALETTE[2], alpha=0.15, label="0 to 1, lengths in m")
    share.set_ylabel("targets [%]")
    share.legend(loc="lower left")
    count.loglog(alpha, [row.iterations for row in rows], "o-", ms=3, label="mean")
    paper = PUBLISHED["transpose"].iterations
    count.axhline(paper, color=PALETTE[1], linestyle="--", label=f"published, {paper}")
    count.set_ylabel("iterations")
    count.legend()
    for axes in (share, count):
        axes.set_xlabel("alpha [1/m², joint values in rad]")
    return save(drawing, directory, "alpha")


@styled
def _draw_maps(directory: Path, maps: Mapping[str, Map]) -> list[Path]:
    drawing = figure(PAGE_WIDTH, 6.4)
    for axes, (name, each) in zip(drawing.subplots(2, 2).ravel(), maps.items(), strict=True):
        x, z = each.points.T
        kinds = (
            (each.reached & each.front, "#bcd9ea", "reached"),
            (each.reached & ~each.front, "#e8e8e8", "reached, beyond the servos' limits"),
            (~each.reached & ~each.front, "#f3c9ae", "lost, beyond the servos' limits"),
            (~each.reached & each.front, PALETTE[1], "lost"),
        )
        for chosen, color, label in kinds:
            axes.plot(x[chosen], z[chosen], "s", ms=2.6, mew=0, color=color, label=label)
        axes.set_title(f"{name}:\n{100 * each.lost:.1f} % lost within the servos' limits")
        axes.set_aspect("equal")
        axes.set_xlabel("distance from the pan axis [m]")
        axes.set_ylabel("height [m]")
    handles, labels = axes.get_legend_handles_labels()
    drawing.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=2.5)
    return save(drawing, directory, "lost")
