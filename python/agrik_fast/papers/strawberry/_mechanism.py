"""Figures 1 and 3 of the strawberry paper: the mechanism's links, and its energy on the way."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..._checks import FloatArray
from ...arms import StrawberryArm
from ...plots import GREY, PAGE_WIDTH, PALETTE, figure, styled
from .._output import save, write_csv
from ._figures import joint_points
from ._published import FIGURE_TARGET, Column

LINK, SLIDE, TIP = PALETTE[0], PALETTE[2], PALETTE[1]
METHODS: dict[str, Column] = {"NCOS": "ncos", "SSAS": "ssas", "AS": "as"}


class Terms(NamedTuple):
    """What the energy index is made of, mJ.

    Attributes
    ----------
    method : str
        NCOS, SSAS or AS.
    friction_s10, friction_s21, friction_s32 : float, mJ
        Friction of each slide on its way from home, (22).
    lowered : float, mJ
        Potential energy that both links lose with slide s32.
    pitched, rolled : float, mJ
        What the turns by theta and by theta and beta win back; negative or zero.
    total : float, mJ
        The sum: the energy index.
    """

    method: str
    friction_s10: float
    friction_s21: float
    friction_s32: float
    lowered: float
    pitched: float
    rolled: float
    total: float


def energy_terms(arm: StrawberryArm, target: FloatArray = FIGURE_TARGET) -> list[Terms]:
    """Return the terms of (21) and (22) for each method of the paper."""
    p = arm.parameters
    l2, l3, mu, m2, m3, g = (
        float(np.asarray(p[name])) for name in ("l2", "l3", "friction", "mass2", "mass3", "gravity")
    )
    rows = []
    for name, method in METHODS.items():
        q = arm.solve(target, method).q
        travel = q[:3] - arm.reset_pose[:3]
        ct, cb = float(np.cos(q[3])), float(np.cos(q[4]))
        parts = [
            *(mu * travel).tolist(),
            (m2 + m3) * g * float(travel[2]),
            -(m2 / 2 + m3) * g * l2 * (1 - ct),
            -m3 * g * l3 / 2 * (1 - cb * ct),
        ]
        s10, s21, s32, lowered, pitched, rolled = (1000 * part for part in parts)
        rows.append(Terms(name, s10, s21, s32, lowered, pitched, rolled, 1000 * sum(parts)))
    return rows


@styled
def figure1(directory: Path) -> list[Path]:
    """Draw the mechanism's frames and links DE, EF and FP from two sides."""
    arm = StrawberryArm()
    q = np.array([0.30, 0.45, 0.18, -0.45, 0.6])
    d, e, p = 1000 * joint_points(arm, q)
    f = (e + p) / 2  # the paper gives EF + FP alone
    drawing = figure(PAGE_WIDTH, 3.0)
    front, side = drawing.subplots(1, 2, sharey=True)
    top = d[2] + 1000 * q[2]
    for axes, k, name in ((front, 0, "x"), (side, 1, "y")):
        axes.plot([0, d[k]], [top, top], color=SLIDE, lw=3)
        axes.plot([d[k], d[k]], [top, d[2]], color=SLIDE, lw=3)
        axes.plot(*np.array([d, e, f, p])[:, [k, 2]].T, "-o", color=LINK, lw=3, ms=5)
        for point, letter in ((d, "D"), (e, "E"), (f, "F"), (p, "P")):
            shift = {"E": (8, 2), "F": (-14, -12)}.get(letter, (8, -6))
            place = (point[k], point[2])
            axes.annotate(letter, place, xytext=shift, textcoords="offset points")
        axes.annotate("s32", (d[k], (top + d[2]) / 2), xytext=(-26, 0), textcoords="offset points")
        for vector, letter in (((110, 0), name), ((0, 110), "z")):
            end = (vector[0], top + vector[1])
            _arrow(axes, (0, top), end)
            shift = (6, -3) if letter == "z" else (-4, -14)
            axes.annotate(letter, end, xytext=shift, textcoords="offset points")
        axes.plot(0, top, "o", color="black", ms=4)
        axes.annotate("O", (0, top), xytext=(4, -14), textcoords="offset points")
        axes.set_xlabel(f"{name} [mm]")
        axes.set_xlim(-40, 640)
        axes.set_ylim(p[2] - 50, top + 140)
        axes.set_aspect("equal")
    front.annotate("s21", (d[0] / 2, top), xytext=(0, 6), textcoords="offset points")
    side.annotate("l1 − dy, s10", (d[1] / 2, top), xytext=(-20, 6), textcoords="offset points")
    front.annotate("θ", (d[0], d[2]), xytext=(-4, -20), textcoords="offset points", color=TIP)
    side.annotate("β", (e[1], e[2]), xytext=(-13, -1), textcoords="offset points", color=TIP)
    side.annotate("ψ about FP", (p[1], p[2]), xytext=(20, -6), textcoords="offset points")
    front.set_ylabel("z [mm]")
    words = (
        ("slides", SLIDE),
        ("links DE (l2) and EF + FP (l3); F, which the paper leaves open, in the middle", LINK),
    )
    for text, color in words:
        front.plot([], [], color=color, lw=3, label=text)
    drawing.legend(*front.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return save(drawing, directory, "figure1")


@styled
def figure3(directory: Path) -> list[Path]:
    """Draw the arm before and after, and what its energy index is made of."""
    arm = StrawberryArm()
    q = arm.solve(FIGURE_TARGET, "ncos").q
    home = arm.reset_pose.copy()
    home[:2] = q[:2]  # shown above the place where it goes down
    drawing = figure(PAGE_WIDTH, 3.9)
    pose, parts = drawing.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.5)})
    for values, color, label in ((home, GREY, "before"), (q, LINK, "after")):
        d, e, p = 1000 * joint_points(arm, values)
        pose.plot(*np.array([d, e, p])[:, [0, 2]].T, "-o", color=color, lw=3, label=label)
        for start, end, name in ((d, e, "m2 g"), (e, p, "m3 g")):
            x, _, z = (start + end) / 2
            _arrow(pose, (x, z), (x, z - 45))
            words = {"textcoords": "offset points", "ha": "right"}
            pose.annotate(name, (x, z - 45), xytext=(-5, 0), **words)
    travel = 1000 * (q[2] - home[2])
    start, end = 1000 * joint_points(arm, home)[0], 1000 * joint_points(arm, q)[0]
    x = start[0] + 70
    pose.annotate("", (x, end[2]), (x, start[2]), arrowprops={"arrowstyle": "<->", "color": SLIDE})
    pose.text(x + 6, (start[2] + end[2]) / 2, f"{travel:.0f} mm", va="center", color=SLIDE)
    pose.set_xlim(start[0] - 100, start[0] + 180)
    pose.set_ylim(end[2] - 190, start[2] + 20)
    pose.set_xlabel("x [mm]")
    pose.set_ylabel("z [mm]")
    pose.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    rows = energy_terms(arm)
    words = {
        "friction_s10": "friction, s10",
        "friction_s21": "friction, s21",
        "friction_s32": "friction, s32",
        "lowered": "weight, lowered by s32",
        "pitched": "weight, lifted by θ",
        "rolled": "weight, lifted by θ and β",
    }
    place = np.arange(len(rows))
    up, down = np.zeros(len(rows)), np.zeros(len(rows))
    for (field, label), color in zip(words.items(), PALETTE, strict=False):
        values = np.array([getattr(row, field) for row in rows])
        base = np.where(values >= 0, up, down)
        parts.bar(place, values, 0.6, bottom=base, label=label, color=color)
        up += np.maximum(values, 0)
        down += np.minimum(values, 0)
    for k, row in enumerate(rows):
        parts.text(k, up[k] + 100, f"{row.total:.0f}", ha="center")
    parts.axhline(0, color="black", lw=0.8)
    parts.set_xticks(place, [row.method for row in rows])
    parts.set_ylabel("energy index [mJ]")
    parts.set_ylim(top=1.12 * float(up.max()))
    drawing.legend(*parts.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    table = [(row.method, *(f"{value:.3f}" for value in row[1:])) for row in rows]
    return [
        write_csv(directory / "figure3.csv", Terms._fields, table),
        *save(drawing, directory, "figure3"),
    ]


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.2})
