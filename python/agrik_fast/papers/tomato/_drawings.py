"""Figures 2 to 6 of the tomato paper, drawn anew from the arm's own numbers."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..._checks import FloatArray
from ...arms import HOME, TomatoArm
from ...plots import GREY, PAGE_WIDTH, PALETTE, figure, styled
from .._output import save
from ._torques import Stretched, stretched

LINKS, AIM, ANGLES = PALETTE[0], PALETTE[1], PALETTE[2]
TARGET = np.array([0.19, 0.08, 0.12])
"""Target of figures 3 to 5, m; the paper names none."""


@styled
def figure2(directory: Path) -> list[Path]:
    """Draw the pose in which the torques are calculated, with what pulls at it."""
    drawing = figure(PAGE_WIDTH, 2.9)
    axes = drawing.subplots()
    found: Stretched = stretched()
    l1, l2 = found.l1, found.l2
    axes.plot([0, l1, l1 + l2], [0, 0, 0], "-", lw=4, color=LINKS)
    axes.plot([0, l1], [0, 0], "o", ms=10, color="white", mec=LINKS, mew=2)
    for x, length, name in (
        (l1 / 2, 0.5, f"G1 = {found.link1:.3f} N"),
        (l1, 0.85, f"Gm = {found.motor:.3f} N"),
        (l1 + l2 / 2, 0.5, f"G2 = {found.link2:.3f} N"),
        (l1 + l2, 0.85, f"Go = {found.payload:.3f} N"),
    ):
        _arrow(axes, (x, 0), (x, -0.06 * length), AIM)
        axes.text(x, -0.06 * length - 0.004, name, ha="center", va="top", color=AIM)
    for x, name, torque in ((0.0, "J1: M1", found.shoulder), (l1, "J2: M2", found.elbow)):
        axes.text(x, 0.014, f"{name} = {torque:.3f} N m", ha="center", color=ANGLES)
    for start, end, name in ((0.0, l1, "l1"), (l1, l1 + l2, "l2")):
        axes.annotate(
            "", (start, 0.042), (end, 0.042), arrowprops={"arrowstyle": "<->", "color": GREY}
        )
        label = f"{name} = {end - start:.2f} m"
        axes.text((start + end) / 2, 0.045, label, ha="center", color=GREY)
    axes.set_xlim(-0.07, l1 + l2 + 0.05)
    axes.set_ylim(-0.075, 0.058)
    axes.set_xlabel("distance from the shoulder [m]")
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    return save(drawing, directory, "figure2")


@styled
def figure3(directory: Path) -> list[Path]:
    """Draw the triangle of shoulder, elbow and target in space."""
    arm = TomatoArm()
    q = arm.solve(TARGET).q
    a, b, c = _joints(arm, q)
    drawing = figure(PAGE_WIDTH, 4.6)
    axes = drawing.add_subplot(projection="3d")
    axes.plot(*np.array([a, b, c]).T, "-o", lw=3, color=LINKS, label="links l1 (AB) and l2 (BC)")
    axes.plot(*np.array([a, c]).T, "--", color=GREY, label="AC, from the shoulder to the target")
    foot = c * [1, 1, 0]
    axes.plot(*np.array([a, foot, c]).T, ":", color=GREY, label="its distance and height z")
    turn = np.linspace(0, q[2], 30)
    axes.plot(0.1 * np.cos(turn), 0.1 * np.sin(turn), 0 * turn, color=ANGLES, label="pan φ3")
    axes.plot(*c, "*", ms=12, color=AIM, label="target")
    for point, name in ((a, "A (J1)"), (b, "B (J2)"), (c, "C")):
        axes.text(*(point + np.array([0.0, 0.012, 0.012])), name)
    axes.set_xlim(0, 0.24)
    axes.set_ylim(-0.06, 0.18)
    axes.set_zlim(0, 0.24)
    axes.set_box_aspect((1, 1, 1), zoom=0.9)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_zlabel("z [m]")
    axes.locator_params(nbins=5)
    axes.view_init(elev=20, azim=-60)
    drawing.legend(loc="outside lower center", ncols=2)
    return save(drawing, directory, "figure3")


@styled
def figure4(directory: Path) -> list[Path]:
    """Draw the same triangle in the plane that the pan chooses, with its angles."""
    arm = TomatoArm()
    q = arm.solve(TARGET).q
    rho, z = float(np.hypot(*TARGET[:2])), float(TARGET[2])
    phi1, phi2 = float(q[0]), float(q[1])
    b = arm.l1 * np.array([np.cos(phi1), np.sin(phi1)])
    drawing = figure(PAGE_WIDTH, 4.4)
    axes = drawing.subplots()
    axes.plot([0, b[0], rho], [0, b[1], z], "-o", lw=3, color=LINKS, label="links l1 and l2")
    axes.plot([0, rho], [0, z], "--", color=GREY, label="AC")
    axes.plot([rho, rho, 0], [z, 0, 0], ":", color=GREY)
    axes.plot(rho, z, "*", ms=12, color=AIM, label="target")
    lift = float(np.arctan2(z, rho))
    elbow = float(np.pi + phi2)
    beyond = 1.4 * b
    axes.plot([b[0], beyond[0]], [b[1], beyond[1]], ":", color=LINKS)
    _arc(axes, (0, 0), 0.05, 0.0, phi1, "φ1", 0.18)
    _arc(axes, (0, 0), 0.085, lift, phi1, "α", 0.5)
    _arc(axes, tuple(b), 0.03, phi1 + np.pi, phi1 + np.pi + elbow, "Θ", 0.5)
    _arc(axes, tuple(b), 0.04, phi1, phi1 + phi2, "φ2", 0.5)
    for (x, y), name, align in (((0, 0), "A", "right"), (b, "B", "right"), ((rho, z), "C", "left")):
        axes.text(x + (-0.008 if align == "right" else 0.008), y + 0.006, name, ha=align)
    axes.text(rho + 0.005, z / 2, "z")
    axes.text(rho / 2, -0.012, "distance x of (5), (6): √(X² + Y²)", ha="center", va="top")
    axes.set_aspect("equal")
    axes.set_xlim(-0.03, 0.27)
    axes.set_ylim(-0.035, 0.24)
    axes.set_xlabel("distance from the pan axis [m]")
    axes.set_ylabel("height [m]")
    axes.legend(loc="upper right")
    return save(drawing, directory, "figure4")


@styled
def figure5(directory: Path) -> list[Path]:
    """Draw where an iterative method starts, and on which way it goes to the target."""
    arm = TomatoArm()
    drawing = figure(PAGE_WIDTH, 3.8)
    side, above = drawing.subplots(1, 2)
    start = _joints(arm, np.array(HOME))
    ways = [arm.fk(HOME)]
    q = np.array(HOME)
    for _ in range(400):
        # One step at a time: the loop of figure 6.
        q = arm.iterate(TARGET, "inverse", q0=q, gain=0.05, max_iterations=1).q
        ways.append(arm.fk(q))
    way, end = np.array(ways), _joints(arm, q)
    flat = [(np.hypot(p[:, 0], p[:, 1]), p[:, 2]) for p in (start, end, way)]
    top = [(p[:, 0], p[:, 1]) for p in (start, end, way)]
    for axes, views in ((side, flat), (above, top)):
        axes.plot(*views[0], "-o", lw=3, color=GREY)
        axes.plot(*views[1], "-o", lw=3, color=LINKS)
        axes.plot(*views[2], "-", lw=1, color=ANGLES)
    words = ("starting pose: J1, J2, end-effector e", "at the target", "way of the end-effector")
    for line, label in zip(side.lines, words, strict=True):
        line.set_label(label)
    side.plot(np.hypot(*TARGET[:2]), TARGET[2], "*", ms=12, color=AIM, label="target")
    above.plot(*TARGET[:2], "*", ms=12, color=AIM)
    side.set_xlabel("distance from the pan axis [m]")
    side.set_ylabel("height [m]")
    above.set_xlabel("x [m]")
    above.set_ylabel("y [m]")
    for axes in (side, above):
        axes.set_aspect("equal", adjustable="datalim")
    drawing.legend(loc="outside lower center", ncols=2)
    return save(drawing, directory, "figure5")


@styled
def figure6(directory: Path) -> list[Path]:
    """Draw the loop of the iterative methods as `TomatoArm.iterate` runs it."""
    drawing = figure(PAGE_WIDTH, 4.4)
    axes = drawing.subplots()
    boxes = (
        (5.4, "start: joint values φ, target t", "round"),
        (4.5, "end-effector e(φ) by (10) to (12)", "square"),
        (3.6, "distance |t − e| ≤ tolerance?", "question"),
        (2.7, "Δe: a share, or a length, of t − e", "square"),
        (1.8, "ΔΦ = J⁻¹ Δe (14), α Jᵀ Δe (15) or J⁺ Δe (16)", "square"),
        (0.9, "φ ← φ + ΔΦ; as many steps as allowed?", "question"),
    )
    styles = {"round": "round,pad=0.5", "square": "square,pad=0.4", "question": "round4,pad=0.5"}
    colors = {"round": "#e8e8e8", "square": "#d6e8f3", "question": "#f9e3d3"}
    for y, text, kind in boxes:
        frame = {"boxstyle": styles[kind], "facecolor": colors[kind], "edgecolor": GREY}
        axes.text(3.0, y, text, ha="center", va="center", bbox=frame)
    for upper, lower in pairwise(boxes):
        _arrow(axes, (3.0, upper[0] - 0.2), (3.0, lower[0] + 0.2), "black")
    axes.text(3.08, 3.16, "no")
    ends = ((3.6, 4.0, "ok: reached", "yes"), (0.9, 4.35, "cap: not reached", "yes"))
    for y, x, text, answer in ends:
        frame = {"boxstyle": "round,pad=0.5", "facecolor": "#e8e8e8", "edgecolor": GREY}
        axes.text(5.8, y, text, ha="center", va="center", bbox=frame)
        _arrow(axes, (x, y), (5.1, y), "black")
        axes.text((x + 5.1) / 2, y + 0.08, answer, ha="center")
    stuck = "singular, stalled, diverged:\nno step, or one beyond all bounds"
    axes.text(
        5.75,
        1.8,
        stuck,
        ha="center",
        va="center",
        bbox={"boxstyle": "round,pad=0.5", "facecolor": "#e8e8e8", "edgecolor": GREY},
    )
    _arrow(axes, (4.4, 1.8), (4.62, 1.8), "black")
    axes.plot([1.62, 0.6, 0.6], [0.9, 0.9, 4.5], color="black", lw=1)
    _arrow(axes, (0.6, 4.5), (1.9, 4.5), "black")
    axes.text(0.95, 0.98, "no", ha="center")
    axes.set_xlim(0.2, 7.0)
    axes.set_ylim(0.4, 5.8)
    axes.axis("off")
    return save(drawing, directory, "figure6")


def _joints(arm: TomatoArm, q: FloatArray) -> FloatArray:
    """Return shoulder, elbow and tool point, shape (3, 3), m."""
    reach, height = arm.l1 * np.cos(q[0]), arm.l1 * np.sin(q[0])
    elbow = [reach * np.cos(q[2]), reach * np.sin(q[2]), height]
    return np.array([np.zeros(3), elbow, arm.fk(q)])


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float], color: str) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.2})


def _arc(
    axes: Any,
    centre: Any,
    radius: float,
    low: float,
    high: float,
    name: str,
    share: float,
) -> None:
    """Draw an angle with its name outside."""
    turn = np.linspace(low, high, 40)
    x, y = centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn)
    axes.plot(x, y, color=ANGLES)
    at = low + share * (high - low)
    far = radius + 0.011
    axes.text(
        centre[0] + far * np.cos(at),
        centre[1] + far * np.sin(at),
        name,
        color=ANGLES,
        ha="center",
        va="center",
    )
