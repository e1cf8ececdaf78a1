"""What ``agrik-fast info`` prints."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..robot import Robot


def list_robots() -> str:
    """Return the bundled robots, one a line, with their descriptions."""
    names = Robot.names()
    width = max(map(len, names))
    return "\n".join(f"{name.ljust(width)}  {Robot.load(name).description}" for name in names)


def describe(name_or_path: str) -> str:
    """Return a robot's joints, limits, reach, DH rows, frames and source as text.

    Raises
    ------
    AgrikError
        For an unknown name or a faulty file.
    """
    robot = Robot.load(name_or_path)
    blocks = [
        f"{robot.name}: {robot.description}" if robot.description else robot.name,
        _joints(robot),
        _reach(robot),
    ]
    if robot.dh is not None:
        blocks.append(_dh(robot))
    if robot.end_effector is not None:
        hand = robot.end_effector
        blocks.append(f"End effector\n  servo {hand.servo} moves {', '.join(hand.moves)}")
    if robot.frames:
        blocks.append(_frames(robot))
    if robot.source:
        lines = [f"  {key}: {value}" for key, value in robot.source.items() if value]
        blocks.append("\n".join(["Source", *lines]))
    if robot.provenance:
        blocks.append(_provenance(robot))
    return "\n\n".join(blocks)


def _table(title: str, rows: Sequence[Sequence[str]]) -> str:
    """Return a title and rows in columns, the first one left-aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(
            cell.ljust(width) if k == 0 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
    return "\n".join([title, *(f"  {line}" for line in lines)])


def _joints(robot: Robot) -> str:
    rows = [["name", "type", "lower", "upper", "unit", "in degrees"]]
    limits = zip(robot.joint_names, robot.joint_types, robot.lower, robot.upper, strict=True)
    for name, kind, low, high in limits:
        if kind == "prismatic":
            rows.append([name, kind, f"{low:.4f}", f"{high:.4f}", "m", ""])
        elif math.isinf(low) or math.isinf(high):
            rows.append([name, kind, "-", "-", "rad", "any"])
        else:
            degrees = f"{math.degrees(low):.2f} .. {math.degrees(high):.2f}"
            rows.append([name, kind, f"{low:.4f}", f"{high:.4f}", "rad", degrees])
    return _table(f"Joints ({robot.dof})", rows)


def _reach(robot: Robot) -> str:
    x, y, z = (f"{low:.4f} .. {high:.4f}" for low, high in np.asarray(robot.reach_box).T.tolist())
    centre = ", ".join(f"{value:.4f}" for value in robot.reach_center)
    return "\n".join(
        [
            "Reach of the tool point, base frame (proven bounds)",
            f"  within {robot.reach_radius:.4f} m of ({centre}) m",
            f"  x {x} m, y {y} m, z {z} m",
        ]
    )


def _dh(robot: Robot) -> str:
    heading = ["row", "type", "a m", "alpha deg", "d m", "theta deg"]
    rows = [
        [
            row.name,
            row.type,
            f"{row.a:.5f}",
            f"{math.degrees(row.alpha):.3f}",
            f"{row.d:.5f}",
            f"{math.degrees(row.theta):.3f}",
        ]
        for row in robot.dh or ()
    ]
    title = f"Denavit-Hartenberg rows ({robot.convention}); a joint's value is added to theta or d"
    return _table(title, [heading, *rows])


def _frames(robot: Robot) -> str:
    lines = ["Named frames (transform from the base frame: rotation rows, then translation m)"]
    for name, pose in robot.frames.items():
        turn = " ".join(f"[{' '.join(f'{value:g}' for value in row)}]" for row in pose[:3, :3])
        shift = " ".join(f"{value:g}" for value in pose[:3, 3])
        lines.append(f"  {name}: {turn} | {shift}")
    return "\n".join(lines)


def _provenance(robot: Robot) -> str:
    marks = [f"  {mark} = {meaning}" for mark, meaning in robot.provenance_marks.items()]
    items = [f"  {number}: {origin}" for number, origin in robot.provenance.items()]
    return "\n".join(["Where the numbers are from", *marks, *items])
