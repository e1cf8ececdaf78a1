"""Draw what trajectories.md shows: one motion with rests, and one without."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

import agrik_fast as ik
from agrik_fast import motion
from agrik_fast.plots import GREY, PAGE_WIDTH, PALETTE

JOINTS = dict(zip(("shoulder_pan", "shoulder_lift", "elbow"), PALETTE, strict=False))
"""Joints that are drawn, by colour."""
DEGREES = (
    (0.0, -90.0, 90.0, 0.0, 0.0, 0.0),
    (50.0, -60.0, 60.0, 0.0, 0.0, 0.0),
    (100.0, -110.0, 110.0, 0.0, 0.0, 0.0),
    (160.0, -80.0, 70.0, 0.0, 0.0, 0.0),
)


def draw(file: Path, save: Callable[[plt.Figure, Path], None]) -> None:
    """Draw values, velocities and accelerations of both motions, one above the other."""
    arm = ik.Robot.load("ur5")
    waypoints = np.radians(DEGREES)
    motions = {
        "rest at waypoints": motion.time_law(arm, waypoints, rate=500.0),
        "blend=0.4": motion.time_law(arm, waypoints, blend=0.4, rate=500.0),
    }
    rows = ("joint value [°]", "velocity [°/s]", "acceleration [°/s²]")
    figure, axes = plt.subplots(
        3, 2, figsize=(PAGE_WIDTH, 5.4), sharex=True, sharey="row", layout="constrained"
    )
    longest = max(one.duration for one in motions.values())
    for column, (title, one) in zip(axes.T, motions.items(), strict=True):
        column[0].set_title(f"{title}: {one.duration:.2f} s")
        column[-1].set_xlabel("time [s]")
        for axis, block in zip(
            column, (one.positions, one.velocities, one.accelerations), strict=True
        ):
            for name, color in JOINTS.items():
                values = np.degrees(block[:, arm.joint_names.index(name)])
                axis.plot(one.times, values, color=color, label=name.replace("_", " "))
            axis.set_xlim(0, longest)
            axis.grid(color="0.9")
    for axis, word in zip(axes[:, 0], rows, strict=True):
        axis.set_ylabel(word)
    for axis, limits in zip(axes[1:], (arm.velocity_limits, arm.acceleration_limits), strict=True):
        limit = float(np.degrees(limits[0]))
        for one in axis:
            for sign in (-1, 1):
                one.axhline(sign * limit, color=GREY, linestyle="--", linewidth=0.8)
    lines, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(lines, names, loc="outside lower center", ncols=3)
    axes[1, 0].text(
        0.02 * longest,
        0.97 * np.degrees(arm.velocity_limits[0]),
        "limit",
        color="0.4",
        va="top",
    )
    save(figure, file)
