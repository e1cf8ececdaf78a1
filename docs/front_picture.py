"""The front page's picture: targets go in, joint values and a checked answer come out."""

from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from solids_picture import BLUE, GREEN, GREY, RUST, draw, frame_box, placed

import agrik_fast as ik

TARGETS = np.array(
    [[0.55, -0.30, 0.25], [0.45, 0.35, 0.55], [0.15, 0.55, 0.30], [0.95, 0.55, 0.40]]
)
COLORS = (GREEN, BLUE, "#8a6fb0", RUST)
LETTERS = "ABCD"
START = np.array([0.0, -0.4, 0.0, -2.0, 0.0, 1.8, 0.8])


def draw_front(file: Path, save: Callable[..., None]) -> None:
    """Draw the Panda at three targets of four, and what `ik` says of each."""
    arm = ik.Robot.load("panda")
    # The tool points down, turned about the vertical as the target's direction is.
    poses = np.zeros((len(TARGETS), 4, 4))
    poses[:, :3, 3], poses[:, 3, 3] = TARGETS, 1
    poses[:, :3, :3] = np.diag([1.0, -1.0, -1.0])
    found = arm.ik(poses, q0=START)
    figure = plt.figure(figsize=(11, 4.6))
    space = figure.add_axes((0.0, 0.0, 0.46, 1.0), projection="3d")
    base = placed(arm, arm.home)[:2]
    draw(space, base, GREY)
    for row in np.flatnonzero(found.success):
        draw(space, placed(arm, found.q[row])[2:], COLORS[row], 0.55)
    for row, (target, color) in enumerate(zip(TARGETS, COLORS, strict=True)):
        space.plot(*target, "o" if found.success[row] else "X", color=color, markersize=9)
        x, y, z = target
        space.text(x, y, z + 0.13, LETTERS[row], weight="bold", color=color, ha="center")
    frame_box(space, (-0.3, -0.55, 0.0), (1.05, 0.75, 1.0))
    space.set_xlabel("x [m]", fontsize=8)
    space.set_ylabel("y, z [m]", fontsize=8)
    space.view_init(22, -58)
    words = figure.add_axes((0.47, 0.0, 0.53, 1.0))
    words.set_axis_off()
    mono = {"family": "monospace", "fontsize": 9.5, "va": "center"}
    words.text(0, 0.93, "result = arm.ik(poses)", weight="bold", **{**mono, "fontsize": 12})
    for row, color in enumerate(COLORS):
        y = 0.78 - 0.2 * row
        status = ik.Status(int(found.status[row])).name
        x, y_m, z = TARGETS[row]
        words.text(0, y, LETTERS[row], color=color, weight="bold", fontsize=14, va="center")
        words.text(0.06, y, f"x {x:.2f}  y {y_m:.2f}  z {z:.2f} m", **mono)
        words.text(0.5, y, status, color=color, weight="bold", **mono)
        if found.success[row]:
            error = max(1e9 * found.position_error[row], 1.0)
            angles = "  ".join(f"{angle:.0f}°" for angle in np.degrees(found.q[row]))
            words.text(0.06, y - 0.065, f"q = {angles}", color="0.25", **mono)
            words.text(0.74, y, f"within {error:.0f} nm", color="0.25", **mono)
        else:
            left = 100 * found.position_error[row]
            words.text(
                0.06, y - 0.065, f"the nearest posture is {left:.0f} cm off", color="0.25", **mono
            )
    save(figure, file)
