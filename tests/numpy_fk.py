"""A second forward kinematics, in plain NumPy, written apart from the library.

Tests and the main job check the library's answers with it, so it shares no code
with `agrik_fast`: it reads a robot's TOML rows itself and multiplies 4x4
matrices in physical order. Slow and plain on purpose.
"""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Matrix = NDArray[np.float64]

ROBOTS = Path(__file__).resolve().parent.parent / "python" / "agrik_fast" / "robot" / "bundled"

_TO_SI = {"m": 1.0, "mm": 1e-3, "rad": 1.0, "deg": np.pi / 180.0}


@functools.cache
def load(name: str) -> dict[str, Any]:
    """Read the TOML of a bundled robot as plain dictionaries."""
    with (ROBOTS / f"{name}.toml").open("rb") as file:
        return tomllib.load(file)


def si(table: Mapping[str, Any], key: str, default: Any = 0.0) -> Any:
    """Return the number(s) under `key`_m, _mm, _rad or _deg in metres or radians."""
    for unit, factor in _TO_SI.items():
        if f"{key}_{unit}" in table:
            return np.asarray(table[f"{key}_{unit}"], dtype=float) * factor
    return np.asarray(default, dtype=float)


def rotation_about(axis: ArrayLike, angle: ArrayLike) -> Matrix:
    """Rotation by `angle` (...,) rad about `axis` (3,): shape (..., 4, 4)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.asarray(angle, dtype=float)[..., None, None]
    result = np.zeros((*angle.shape[:-2], 4, 4))
    result[..., :3, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    result[..., 3, 3] = 1.0
    return result


def translation(offset: ArrayLike) -> Matrix:
    """Translation by `offset` (..., 3) m: shape (..., 4, 4)."""
    offset = np.asarray(offset, dtype=float)
    result = np.zeros((*offset.shape[:-1], 4, 4))
    result[...] = np.eye(4)
    result[..., :3, 3] = offset
    return result


def transform(table: Mapping[str, Any] | None) -> Matrix:
    """Return a base, tool, frame or joint-origin table as a 4x4 matrix."""
    if table is None:
        return np.eye(4)
    result = translation(si(table, "xyz", np.zeros(3)))
    if "rotation" in table:
        turn = np.eye(4)
        turn[:3, :3] = table["rotation"]
        return result @ turn
    roll, pitch, yaw = si(table, "rpy", np.zeros(3))
    return (
        result
        @ rotation_about([0, 0, 1], yaw)
        @ rotation_about([0, 1, 0], pitch)
        @ rotation_about([1, 0, 0], roll)
    )


def _rows(robot: Mapping[str, Any]) -> Sequence[Mapping[str, Any]]:
    return robot["dh"] if "dh" in robot else robot["joint"]


def variable_names(robot: Mapping[str, Any] | str) -> list[str]:
    """Names of the joint variables in the order of q."""
    robot = load(robot) if isinstance(robot, str) else robot
    if "q_order" in robot:
        return list(robot["q_order"])
    return [r["name"] for r in _rows(robot) if r["type"] != "fixed" and "mimic" not in r]


def limits(robot: Mapping[str, Any] | str) -> Matrix:
    """Limits of the joint variables, shape (n, 2), rad or m; +-inf if continuous."""
    robot = load(robot) if isinstance(robot, str) else robot
    rows = {row["name"]: row for row in _rows(robot)}
    names = variable_names(robot)
    return np.array([[si(rows[n], "lower", -np.inf), si(rows[n], "upper", np.inf)] for n in names])


def fk(robot: Mapping[str, Any] | str, q: ArrayLike) -> Matrix:
    """Tool pose of a robot.

    Parameters
    ----------
    robot : mapping or str
        The robot file's content as nested dictionaries, or a bundled robot's name.
    q : array_like, shape (..., n), rad or m
        Joint values in the file's order of q.

    Returns
    -------
    ndarray, shape (..., 4, 4)
        Tool in the frame the base transform leads to; lengths in m.
    """
    return frames(robot, q)[-1]


def frames(robot: Mapping[str, Any] | str, q: ArrayLike) -> list[Matrix]:
    """Poses of the base, of the frame of each row and of the tool, each (..., 4, 4)."""
    robot = load(robot) if isinstance(robot, str) else robot
    q = np.asarray(q, dtype=float)
    column = {name: index for index, name in enumerate(variable_names(robot))}
    found = [np.broadcast_to(transform(robot.get("base")), (*q.shape[:-1], 4, 4))]
    for row in _rows(robot):
        if row["type"] == "fixed":
            value = np.zeros(q.shape[:-1])
        elif "mimic" in row:
            rule = row["mimic"]
            source = q[..., column[rule["joint"]]]
            value = rule.get("multiplier", 1.0) * source + si(rule, "offset")
        else:
            value = q[..., column[row["name"]]]
        found.append(found[-1] @ (_dh(robot, row, value) if "dh" in robot else _joint(row, value)))
    return [*found, found[-1] @ transform(robot.get("tool"))]


def _dh(robot: Mapping[str, Any], row: Mapping[str, Any], value: Matrix) -> Matrix:
    slides = row["type"] == "prismatic"
    theta = si(row, "theta") + (0.0 if slides else value)
    d = si(row, "d") + (value if slides else 0.0)
    theta, d = np.broadcast_to(theta, value.shape), np.broadcast_to(d, value.shape)
    along_z = np.stack([np.zeros_like(d), np.zeros_like(d), d], axis=-1)
    about_z = rotation_about([0, 0, 1], theta) @ translation(along_z)
    about_x = rotation_about([1, 0, 0], si(row, "alpha")) @ translation([si(row, "a"), 0, 0])
    if robot.get("convention", "standard") == "modified":
        return about_x @ about_z
    return about_z @ about_x


def _joint(row: Mapping[str, Any], value: Matrix) -> Matrix:
    if row["type"] == "fixed":
        return np.broadcast_to(transform(row), (*value.shape, 4, 4))
    if row["type"] == "prismatic":
        axis = np.asarray(row["axis"], dtype=float)
        return transform(row) @ translation(value[..., None] * axis / np.linalg.norm(axis))
    return transform(row) @ rotation_about(row["axis"], value)


def pose_error(pose: Matrix, target: Matrix) -> tuple[Matrix, Matrix]:
    """Distance (m) and rotation angle (rad) between poses (..., 4, 4).

    The angle is accurate near 0 and near pi: it comes from atan2 of the sine
    (skew part) and the cosine (trace).
    """
    distance = np.linalg.norm(pose[..., :3, 3] - target[..., :3, 3], axis=-1)
    turn = np.swapaxes(pose[..., :3, :3], -1, -2) @ target[..., :3, :3]
    skew = np.stack(
        [
            turn[..., 2, 1] - turn[..., 1, 2],
            turn[..., 0, 2] - turn[..., 2, 0],
            turn[..., 1, 0] - turn[..., 0, 1],
        ],
        axis=-1,
    )
    sine = np.linalg.norm(skew, axis=-1) / 2
    cosine = (np.trace(turn, axis1=-2, axis2=-1) - 1) / 2
    return distance, np.arctan2(sine, cosine)
