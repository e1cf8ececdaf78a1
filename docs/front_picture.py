"""The front page's pictures: targets go in, joint values and a checked answer come out."""

import itertools
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from solids_picture import draw as draw_solids
from solids_picture import frame_box, placed

import agrik_fast as ik
from agrik_fast import viewer
from agrik_fast.plots import BAD, GREY, PALETTE, PNG_DPI

TARGETS = np.array([[0.55, -0.3, 0.25], [0.45, 0.35, 0.55], [0.15, 0.55, 0.3], [0.95, 0.55, 0.4]])
COLORS = (PALETTE[2], PALETTE[0], PALETTE[3], BAD)
LETTERS = "ABCD"
START = np.array([0.0, -0.4, 0.0, -2.0, 0.0, 1.8, 0.8])


def draw(folder: Path, save: Callable[..., None]) -> None:
    """Draw the Panda at three targets of four, and what `ik` says of each."""
    arm = ik.Robot.load("panda")
    # The tool points down.
    poses = np.zeros((len(TARGETS), 4, 4))
    poses[:, :3, 3], poses[:, 3, 3] = TARGETS, 1
    poses[:, :3, :3] = np.diag([1.0, -1.0, -1.0])
    found = arm.ik(poses, q0=START)
    draw_arm(arm, found, folder / "front_arm.png", save)
    write_page(arm, found, folder / "interactive" / "arm.html")
    draw_answers(found, folder / "front_answers.png", save)


def draw_arm(arm: ik.Robot, found: ik.IkResult, file: Path, save: Callable[..., None]) -> None:
    """Draw the arm in the postures that were found."""
    figure = plt.figure(figsize=(5.4, 4.6))
    space = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d")
    draw_solids(space, placed(arm, START)[:2], GREY)
    for row in np.flatnonzero(found.success):
        draw_solids(space, placed(arm, found.q[row])[2:], COLORS[row], 0.55)
    for row, (target, color) in enumerate(zip(TARGETS, COLORS, strict=True)):
        x, y, z = target
        space.plot(x, y, z, "o" if found.success[row] else "X", color=color, markersize=9)
        # Letters stand before the solids, which matplotlib would put in front.
        words = {"color": color, "weight": "bold", "fontsize": 14, "zorder": 1000}
        space.text(x + 0.09, y, z - 0.03, LETTERS[row], ha="center", **words)
    frame_box(space, (-0.3, -0.55, 0.0), (1.05, 0.75, 1.0))
    space.view_init(22, -58)
    save(figure, file, dpi=PNG_DPI)


def write_page(arm: ik.Robot, found: ik.IkResult, file: Path) -> None:
    """Write a page in which the arm goes from target to target and can be turned; no server."""
    stops = np.concatenate([START[None], found.q[found.success], START[None]])
    share = np.linspace(0.0, 1.0, 25, endpoint=False)[:, None]
    way = [begin + share * (end - begin) for begin, end in itertools.pairwise(stops)]
    file.parent.mkdir(exist_ok=True)
    viewer.export_html(arm, file, q=np.concatenate(way), targets=TARGETS, force=True)


def draw_answers(found: ik.IkResult, file: Path, save: Callable[..., None]) -> None:
    """Write what `ik` says of each target."""
    figure = plt.figure(figsize=(5.4, 4.6))
    words = figure.add_axes((0.02, 0.0, 0.96, 1.0))
    words.set_axis_off()
    mono = {"family": "monospace", "va": "center"}
    words.text(0, 0.93, "result = arm.ik(poses)", weight="bold", fontsize=13, **mono)
    for row, color in enumerate(COLORS):
        y = 0.78 - 0.2 * row
        x_m, y_m, z_m = TARGETS[row]
        status = ik.Status(int(found.status[row])).name
        words.text(0, y, LETTERS[row], color=color, weight="bold", fontsize=16, va="center")
        words.text(0.08, y, f"({x_m:.2f}, {y_m:.2f}, {z_m:.2f}) m", fontsize=11, **mono)
        words.text(0.62, y, status, color=color, weight="bold", fontsize=11, **mono)
        if found.success[row]:
            angles = " ".join(f"{angle:.0f}°" for angle in np.degrees(found.q[row]))
            words.text(0.08, y - 0.07, f"q = {angles}", fontsize=10, color="0.25", **mono)
        else:
            left = f"the nearest posture is {100 * found.position_error[row]:.0f} cm off"
            words.text(0.08, y - 0.07, left, fontsize=10, color="0.25", **mono)
    save(figure, file, dpi=PNG_DPI)
