"""Two jobs that the paper's introduction names: spraying pesticide and topping cotton.

Places, sizes and tools are ours; the paper gives none.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...plots import GREY, PAGE_WIDTH, PALETTE, figure, styled
from ...robot import Robot
from ...rotations import pose
from ...tasks import Axis
from .._output import save, write_csv
from ._tables import arm

NOZZLE = pose((0.0, 0.0, 0.12))
"""Spray nozzle: 120 mm beyond the flange, spraying along the flange's z axis."""

CUTTER = pose((0.06, 0.0, 0.08))
"""Cutter: 60 mm beside the flange's axis and 80 mm beyond it."""

STAND_OFF_M = 0.25
"""From the nozzle to the canopy."""

CANOPY_X_M = 1.0
"""Distance of the canopy's face from the robot's base."""

MAX_STEP = 0.1
"""Largest joint step between neighbours of the pass, rad."""

STARTS = 40
"""Most postures that the pass is tried from."""


@dataclass(frozen=True, slots=True)
class FieldJob:
    """A job and what came of it.

    Attributes
    ----------
    name : str
        spray or topping.
    robot : Robot
        The arm.
    tool : ndarray, shape (4, 4)
        Tool in the flange's frame, m.
    points : ndarray, shape (n, 3), m
        Where the tool point has to be, in order.
    q : ndarray, shape (n, 7), rad
        Joint values.
    success : ndarray, shape (n,)
        Reached within the tolerances.
    position_error : ndarray, shape (n,), m
        Distance of the tool point.
    axis_error : ndarray, shape (n,), rad
        Angle between the nozzle's axis and its direction; 0 where the direction is free.
    largest_step : float, rad
        Largest change of a joint from one target to the next.
    """

    name: str
    robot: Robot
    tool: FloatArray
    points: FloatArray
    q: FloatArray
    success: NDArray[np.bool_]
    position_error: FloatArray
    axis_error: FloatArray
    largest_step: float


def spray_pass() -> FieldJob:
    """Spray a face of a canopy in three rows, to and fro, the nozzle at right angles to it.

    An axis task: the nozzle points along x and is free to turn about itself. The pass is
    followed in small joint steps, so that the nozzle does not swing away.
    """
    robot = arm()
    side = np.linspace(-0.30, 0.30, 31)
    rows = []
    for k, height in enumerate((0.35, 0.50, 0.65)):
        way = side if k % 2 == 0 else side[::-1]
        rows.append(np.stack([np.zeros(31), way, np.full(31, height)], axis=1))
        if k < 2:
            # Up to the next row at the end of this one.
            lift = height + 0.15 * np.arange(1, 8) / 8
            rows.append(np.stack([np.zeros(7), np.full(7, way[-1]), lift], axis=1))
    points = np.concatenate(rows) + np.array([CANOPY_X_M - STAND_OFF_M, 0.0, 0.0])
    direction = (1.0, 0.0, 0.0)
    task = Axis((0.0, 0.0, 1.0), direction)
    # From some postures a joint comes to its limit on the way; others are tried then.
    for start in robot.random_q(STARTS, seed=1):
        first = robot.ik(points[0], task=task, tool=NOZZLE, q0=start).q
        path = robot.follow(points, first, MAX_STEP, task, tool=NOZZLE)
        if path.success.all():
            break
    return _job("spray", robot, NOZZLE, points, path, np.array(direction))


def topping_points(count: int = 24, seed: int = 4) -> FloatArray:
    """Return the tops of cotton plants in two rows, in the order of the way, (count, 3), m."""
    random = np.random.default_rng(seed)
    along = np.linspace(-0.40, 0.40, count // 2)
    rows = []
    for x, way in ((0.42, along), (0.62, along[::-1])):
        spread = random.normal(0.0, 0.015, (count // 2, 2))
        height = random.uniform(0.30, 0.45, count // 2)
        rows.append(np.stack([x + spread[:, 0], way + spread[:, 1], height], axis=1))
    return np.concatenate(rows)


def cotton_topping() -> FieldJob:
    """Cut the tops of 24 cotton plants: points alone, with a cutter beside the flange's axis.

    Every cut starts from the posture of the one before; orientation is free.
    """
    robot, points = arm(), topping_points()
    start = robot.ik(points[0], tool=CUTTER).q
    found: list[Any] = []
    for point in points:
        found.append(robot.ik(point, tool=CUTTER, q0=start))
        start = found[-1].q
    q = np.array([each.q for each in found])
    reached = np.array([bool(each.success) for each in found])
    tips = robot.with_tool(CUTTER).fk(q)[:, :3, 3]
    off = np.linalg.norm(tips - points, axis=1)
    step = float(np.abs(np.diff(q, axis=0)).max())
    zero = np.zeros(len(points))
    return FieldJob("topping", robot, CUTTER, points, q, reached, off, zero, step)


def _job(
    name: str, robot: Robot, tool: FloatArray, points: FloatArray, path: Any, direction: FloatArray
) -> FieldJob:
    poses = robot.with_tool(tool).fk(path.q)
    off = np.linalg.norm(poses[:, :3, 3] - points, axis=1)
    # By the cross product: an arc cosine of nearly 1 is coarse.
    tilt = np.arcsin(np.minimum(np.linalg.norm(np.cross(poses[:, :3, 2], direction), axis=1), 1.0))
    step = float(np.abs(np.diff(path.q, axis=0)).max())
    return FieldJob(name, robot, tool, points, path.q, path.success, off, tilt, step)


def write_jobs(folder: Path) -> list[Path]:
    """Write both jobs and draw them; return the files."""
    jobs = [spray_pass(), cotton_topping()]
    files = []
    for job in jobs:
        header = ["x_m", "y_m", "z_m", *(f"q{i}_rad" for i in range(1, 8))]
        header += ["success", "position_error_m", "axis_error_rad"]
        rows = [
            (
                *(f"{x:.4f}" for x in job.points[k]),
                *(f"{x:.6f}" for x in job.q[k]),
                bool(job.success[k]),
                f"{job.position_error[k]:.1e}",
                f"{job.axis_error[k]:.1e}",
            )
            for k in range(len(job.points))
        ]
        files.append(write_csv(folder / f"{job.name}.csv", header, rows))
    return [*files, *_draw(folder, jobs)]


@styled
def _draw(folder: Path, jobs: list[FieldJob]) -> list[Path]:
    drawing = figure(PAGE_WIDTH, 3.9)
    titles = {"spray": "spray pass: nozzle towards the canopy", "topping": "cotton topping"}
    for k, job in enumerate(jobs):
        axes: Any = drawing.add_subplot(1, 2, k + 1, projection="3d")
        machine = job.robot.with_tool(job.tool)
        for row in np.linspace(0, len(job.q) - 1, 5).astype(int):
            links = machine.fk_links(job.q[row])[:, :3, 3]
            line = np.concatenate([np.zeros((1, 3)), links])
            axes.plot(*line.T, "-", color=PALETTE[0], lw=1.5, alpha=0.35 + 0.15 * (row == 0))
        axes.plot(*job.points.T, ".-" if k == 0 else ".", color=PALETTE[1], ms=3, lw=0.8)
        if k == 0:
            for point in job.points[::8]:
                axes.plot(
                    *np.array([point, point + np.array([STAND_OFF_M, 0.0, 0.0])]).T,
                    color=PALETTE[2],
                )
        else:
            for x, y, z in job.points:
                axes.plot([x, x], [y, y], [0, z], color=PALETTE[2], lw=0.8)
        axes.plot([0, 0], [0, 0], [0, 0], "s", color=GREY)
        axes.set_title(titles[job.name])
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_zlabel("z [m]")
        axes.locator_params(nbins=4)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_box_aspect((1, 1, 1), zoom=0.82)
    labels = (
        ("arm in five of its postures", PALETTE[0], "-"),
        ("tool point", PALETTE[1], ".-"),
        ("spray; plants", PALETTE[2], "-"),
    )
    handles = [
        axes.plot([], [], [], style, color=color, label=text)[0] for text, color, style in labels
    ]
    drawing.legend(handles=handles, loc="outside lower center", ncols=3)
    return save(drawing, folder, "jobs")
