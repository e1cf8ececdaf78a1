"""Make the parts of the documentation that come from the code: pictures and tables."""

import math
from pathlib import Path

import matplotlib as mpl
import numpy as np

import agrik_fast as ik
from agrik_fast.papers import redundant7, strawberry, tomato

mpl.use("Agg")
# The same drawing has the same bytes, whoever makes it.
mpl.rcParams["svg.hashsalt"] = "agrik_fast"

from matplotlib import pyplot as plt  # noqa: E402 - after the choice of the backend

FIELD_ROBOTS = ("strawberry", "cucumber", "hydrolek", "tomato", "redundant7")
SAMPLES = 4000


def draw_reach(file: Path) -> None:
    """Draw where the tool points of random joint vectors lie, seen from the side."""
    figure, axes = plt.subplots(1, len(FIELD_ROBOTS), figsize=(15, 3.6), layout="constrained")
    for axis, name in zip(axes, FIELD_ROBOTS, strict=True):
        arm = ik.Robot.load(name)
        points = arm.fk(arm.random_q(SAMPLES, seed=0))[:, :3, 3]
        axis.plot(points[:, 0], points[:, 2], ".", markersize=1, color="#2a7f62", rasterized=True)
        axis.set_title(name)
        axis.set_xlabel("x [m]")
        axis.set_aspect("equal", adjustable="datalim")
    axes[0].set_ylabel("z [m]")
    figure.savefig(file, dpi=120, metadata={"Date": None})
    plt.close(figure)


def draw_arm_angles(file: Path) -> None:
    """Draw the arm angles that the limits allow for one pose of redundant7, by branch."""
    arm = ik.Robot.load("redundant7")
    pose = arm.fk([2.2, -1.3, 1.1, 1.4, -0.9, 1.2, 0.5])
    figure, axis = plt.subplots(figsize=(8, 3), layout="constrained")
    for branch, intervals in enumerate(arm.arm_angle_intervals(pose)):
        for low, high in np.degrees(intervals):
            # The last interval may go through half a turn.
            for left in (low, low - 360):
                axis.barh(branch, high - low, left=left, height=0.6, color="#2a7f62")
    axis.set_xlim(-180, 180)
    axis.set_xticks(range(-180, 181, 60))
    axis.set_xlabel("arm angle [degrees]")
    axis.set_ylabel("branch")
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def describe(name: str) -> str:
    """Return the description of a robot and the table of its joints, as Markdown."""
    arm = ik.Robot.load(name)
    lines = [f"{arm.description}.", "", "| joint | kind | lower | upper |", "|---|---|---|---|"]
    for joint, kind, low, high in zip(
        arm.joint_names, arm.joint_types, arm.lower, arm.upper, strict=True
    ):
        if kind == "prismatic":
            limits = f"{low:.3f} m", f"{high:.3f} m"
        elif np.isfinite([low, high]).all():
            limits = f"{math.degrees(low):.2f}°", f"{math.degrees(high):.2f}°"
        else:
            limits = "none", "none"
        lines.append(f"| `{joint}` | {kind} | {limits[0]} | {limits[1]} |")
    lines += ["", f"No point farther than {arm.reach_radius:.3f} m from the centre of its reach."]
    return "\n".join(lines) + "\n"


def main(folder: Path) -> None:
    """Write everything into `folder`."""
    folder.mkdir(exist_ok=True)
    draw_reach(folder / "reach.svg")
    draw_arm_angles(folder / "arm_angles.svg")
    strawberry.reproduce(folder / "papers" / "strawberry")
    tomato.reproduce(folder / "papers" / "tomato")
    redundant7.reproduce(folder / "papers" / "redundant7", repeats=200)
    for name in ik.Robot.names():
        (folder / f"{name}.md").write_text(describe(name), encoding="utf-8")
