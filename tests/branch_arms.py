"""Arms by their axes, as robots: those of the reference file, and random ones."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from agrik_fast import Robot

Array = NDArray[np.float64]
REFERENCE = Path(__file__).parent / "data" / "branches" / "reference.json"


def reference() -> dict[str, Any]:
    """Return the reference file: arms, targets and all their branches."""
    data: dict[str, Any] = json.loads(REFERENCE.read_text())
    return data


def rpy(matrix: Array) -> str:
    """Return a rotation as the angles of a URDF."""
    pitch = np.arctan2(-matrix[2, 0], np.hypot(matrix[0, 0], matrix[1, 0]))
    if abs(np.cos(pitch)) < 1e-9:
        return f"{float(np.arctan2(-matrix[1, 2], matrix[1, 1]))!r} {float(pitch)!r} 0"
    angles = (
        float(np.arctan2(matrix[2, 1], matrix[2, 2])),
        float(pitch),
        float(np.arctan2(matrix[1, 0], matrix[0, 0])),
    )
    return " ".join(map(repr, angles))


def robot(
    axes: Array,
    points: Array,
    tool: Array,
    limit: float | Array = 7.0,
    name: str = "arm",
    slide: tuple[ArrayLike, float, float] | None = None,
) -> Robot:
    """Return the arm whose joints turn about lines of the base frame at q = 0.

    `limit` is one number for -limit to limit, or rows of lower and upper ones; `slide` is the
    direction and the limits of a slide before them.
    """
    axes, points, tool = (np.asarray(x, dtype=float) for x in (axes, points, tool))
    limits = np.broadcast_to(np.asarray(limit, dtype=float), (len(axes), 2)).copy()
    if np.ndim(limit) == 0:
        limits[:, 0] *= -1.0
    rows = [f'<robot name="{name}"><link name="l0"/>']
    if slide is not None:
        along = " ".join(repr(float(x)) for x in np.asarray(slide[0], dtype=float))
        rows[0] = (
            f'<robot name="{name}"><link name="base"/><link name="l0"/>'
            '<joint name="slide" type="prismatic"><parent link="base"/><child link="l0"/>'
            f'<axis xyz="{along}"/><limit lower="{slide[1]!r}" upper="{slide[2]!r}" effort="1" '
            'velocity="1"/></joint>'
        )
    before = np.zeros(3)
    for i, (axis, point) in enumerate(zip(axes, points, strict=True), start=1):
        here = " ".join(repr(float(x)) for x in point - before)
        turn = " ".join(repr(float(x)) for x in axis)
        low, high = (repr(float(x)) for x in limits[i - 1])
        rows.append(
            f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/>'
            f'<child link="l{i}"/><origin xyz="{here}"/><axis xyz="{turn}"/>'
            f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/></joint>'
        )
        before = point
    here = " ".join(repr(float(x)) for x in tool[:3, 3] - before)
    last = len(axes)
    rows.append(
        f'<link name="tool"/><joint name="end" type="fixed"><parent link="l{last}"/>'
        f'<child link="tool"/><origin xyz="{here}" rpy="{rpy(tool[:3, :3])}"/></joint></robot>'
    )
    return Robot.from_urdf("".join(rows))


def of_reference(arm: dict[str, Any], limit: float | Array = 7.0) -> Robot:
    """Return an arm of the reference file."""
    return robot(arm["axes"], arm["points"], np.array(arm["tool"]), limit)


def apart(a: Array, b: Array) -> Array:
    """Return how far angles are apart, whole turns aside."""
    return np.abs((a - b + np.pi) % (2.0 * np.pi) - np.pi)


def matched(found: Array, wanted: Array) -> tuple[Array, Array]:
    """Return how far each wanted and each found posture is from the nearest other one, rad."""
    far = apart(found[:, None], wanted[None]).max(axis=2)
    return far.min(axis=0), far.min(axis=1)


def holds(branches: Any, q: Array, tolerance: float = 1e-5) -> NDArray[np.bool_]:
    """Tell for which targets the posture that made them is among the branches."""
    far = apart(branches.q, q[:, None]).max(axis=2)
    return np.asarray((far < tolerance) & branches.reached).any(axis=1)


def read_off(fk: Callable[[Array], ArrayLike]) -> Robot:
    """Return the arm of six joints that a forward kinematics belongs to."""
    home = np.asarray(fk(np.zeros(6)))
    axes, points = [], []
    for joint in range(6):
        quarter = np.zeros(6)
        quarter[joint] = np.pi / 2
        moved = np.asarray(fk(quarter)) @ np.linalg.inv(home)
        skew = 0.5 * (moved[:3, :3] - moved[:3, :3].T)
        axis = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        axes.append(axis / np.linalg.norm(axis))
        points.append(np.linalg.lstsq(np.eye(3) - moved[:3, :3], moved[:3, 3], rcond=1e-9)[0])
    return robot(np.array(axes), np.array(points), home)
