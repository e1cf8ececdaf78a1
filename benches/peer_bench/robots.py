"""The five robots of the comparison: plain NumPy kinematics, targets, success test, URDF text.

Nothing here uses agrik_fast or a peer: success is judged by this file alone. Units are metres
and radians unless a name says otherwise.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

POSE_POSITION_M = 1e-5
POSE_ANGLE_RAD = 1e-4
LIMIT_SLACK_RAD = 1e-6
TARGET_SEED = 20240601
TARGET_BLOCK = 10_000


@dataclass(frozen=True)
class BenchRobot:
    """A revolute arm in standard DH; all arrays have one entry per joint."""

    name: str
    bundled: str
    a: Array
    alpha: Array
    d: Array
    theta: Array
    lower: Array
    upper: Array

    @property
    def dof(self) -> int:
        return len(self.a)

    def fk(self, q: Array) -> Array:
        """Tool pose, shape (..., 4, 4), of joint values of shape (..., dof)."""
        q = np.asarray(q, float)
        pose = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
        for i in range(self.dof):
            row = dh_transform(q[..., i] + self.theta[i], self.d[i], self.a[i], self.alpha[i])
            pose = pose @ row
        return pose

    def inside(self, q: Array) -> npt.NDArray[np.bool_]:
        low, high = self.lower - LIMIT_SLACK_RAD, self.upper + LIMIT_SLACK_RAD
        return np.asarray(np.all((q >= low) & (q <= high), axis=-1))

    def wrapped(self, q: Array) -> Array:
        """Joint values moved by whole turns into the limits where that is possible."""
        turns = np.ceil((self.lower - 1e-9 - q) / (2 * np.pi))
        moved = q + 2 * np.pi * turns
        already = (q >= self.lower - 1e-9) & (q <= self.upper + 1e-9)
        return np.where(already | (moved > self.upper + 1e-9), q, moved)

    def random_starts(self, count: int = 4096) -> Array:
        """Restart points for peers without restarts, drawn before the clock starts."""
        rng = np.random.default_rng(0)
        return np.asarray(rng.uniform(self.lower, self.upper, (count, self.dof)))


def dh_transform(theta: Array, d: float, a: float, alpha: float) -> Array:
    """Rz(theta) Tz(d) Tx(a) Rx(alpha), shape theta.shape + (4, 4)."""
    c, s = np.cos(theta), np.sin(theta)
    ca, sa = np.cos(alpha), np.sin(alpha)
    out = np.zeros((*np.shape(theta), 4, 4))
    out[..., 0, 0], out[..., 0, 1], out[..., 0, 2], out[..., 0, 3] = c, -s * ca, s * sa, a * c
    out[..., 1, 0], out[..., 1, 1], out[..., 1, 2], out[..., 1, 3] = s, c * ca, -c * sa, a * s
    out[..., 2, 1], out[..., 2, 2], out[..., 2, 3] = sa, ca, d
    out[..., 3, 3] = 1.0
    return out


def load_robots() -> dict[str, BenchRobot]:
    """All robots of benches/data/robots.json by their short name."""
    path = Path(__file__).resolve().parent.parent / "data" / "robots.json"
    return {name: _robot(name, item) for name, item in json.loads(path.read_text()).items()}


def _robot(name: str, item: dict[str, Any]) -> BenchRobot:
    rows = item["dh_rows"]

    def column(key: str) -> Array:
        return np.array([row[key] for row in rows], float)

    def limit(key: str) -> Array:
        if f"{key}_rad" in item:
            return np.array(item[f"{key}_rad"], float)
        return np.asarray(np.radians(item[f"{key}_deg"]), float)

    return BenchRobot(
        name=name,
        bundled=item["bundled"],
        a=column("a_m"),
        alpha=np.radians(column("alpha_deg")),
        d=column("d_m"),
        theta=np.radians(column("theta_deg")),
        lower=limit("lower"),
        upper=limit("upper"),
    )


def targets(robot: BenchRobot, count: int) -> tuple[Array, Array, Array]:
    """Uniform random joint values, their poses, and independent random start values.

    Drawn in blocks of 10,000, one seed each, so that a longer run begins with the targets of a
    shorter one.
    """
    needed = -(-count // TARGET_BLOCK)
    blocks = [_target_block(robot.name, block) for block in range(needed)]
    q, pose, start = (np.concatenate(parts)[:count] for parts in zip(*blocks, strict=True))
    return q, pose, start


@cache
def _target_block(name: str, block: int) -> tuple[Array, Array, Array]:
    robot = load_robots()[name]
    rng = np.random.default_rng(TARGET_SEED + block)
    shape = (TARGET_BLOCK, robot.dof)
    q = rng.uniform(robot.lower, robot.upper, shape)
    return q, robot.fk(q), rng.uniform(robot.lower, robot.upper, shape)


def pose_errors(reached: Array, wanted: Array) -> tuple[Array, Array]:
    """Position error [m] and rotation angle [rad], exact for small and large angles."""
    position = np.linalg.norm(reached[..., :3, 3] - wanted[..., :3, 3], axis=-1)
    r = np.swapaxes(reached[..., :3, :3], -1, -2) @ wanted[..., :3, :3]
    twist = np.stack(
        [r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], -1
    )
    sine = np.linalg.norm(twist, axis=-1) / 2
    cosine = (np.trace(r, axis1=-2, axis2=-1) - 1) / 2
    return position, np.arctan2(sine, cosine)


def solved(
    robot: BenchRobot, q: Array, wanted: Array, position_only_m: float | None
) -> npt.NDArray[np.bool_]:
    """Tell where `q` reaches its target inside the limits; NaN rows are not solved."""
    finite = np.asarray(np.isfinite(q).all(axis=-1))
    q = np.where(finite[..., None], q, 0.0)
    position, angle = pose_errors(robot.fk(q), wanted)
    if position_only_m is None:
        reached = (position < POSE_POSITION_M) & (angle < POSE_ANGLE_RAD)
    else:
        # A peer that stops at exactly the tolerance is not failed by the last digit.
        reached = position < position_only_m * 1.0001
    return finite & reached & robot.inside(q)


def product_of_exponentials(robot: BenchRobot) -> tuple[Array, Array, Array]:
    """Joint axes (dof, 3), offsets between them (dof + 1, 3) and home rotation (3, 3)."""
    pose = np.eye(4)
    axes, points = [], [np.zeros(3)]
    for i in range(robot.dof):
        axes.append(pose[:3, 2].copy())
        points.append(pose[:3, 3].copy())
        pose = pose @ dh_transform(np.array(robot.theta[i]), robot.d[i], robot.a[i], robot.alpha[i])
    points.append(pose[:3, 3].copy())
    return np.array(axes), np.diff(np.array(points), axis=0), pose[:3, :3]


def urdf_text(robot: BenchRobot) -> str:
    """Write the arm as URDF from link `base` to link `ee`, every joint about its z axis."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"'
        ' ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    parts = [f'<robot name="{robot.name}">', f'<link name="base">{inertial}</link>']
    parent, tail = "base", np.eye(4)
    for i in range(robot.dof):
        origin = _origin(tail @ dh_transform(np.array(robot.theta[i]), 0.0, 0.0, 0.0))
        limit = f'lower="{robot.lower[i]:.17g}" upper="{robot.upper[i]:.17g}"'
        parts += [
            f'<link name="l{i + 1}">{inertial}</link>',
            f'<joint name="j{i + 1}" type="revolute"><parent link="{parent}"/>'
            f'<child link="l{i + 1}"/>{origin}<axis xyz="0 0 1"/>'
            f'<limit {limit} effort="100" velocity="10"/></joint>',
        ]
        parent = f"l{i + 1}"
        tail = dh_transform(np.array(0.0), robot.d[i], robot.a[i], robot.alpha[i])
    parts += [
        f'<link name="ee">{inertial}</link>',
        f'<joint name="jee" type="fixed"><parent link="{parent}"/><child link="ee"/>'
        f"{_origin(tail)}</joint>",
        "</robot>",
    ]
    return "\n".join(parts)


def _origin(transform: Array) -> str:
    r = transform[:3, :3]
    pitch = np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))
    if np.hypot(r[0, 0], r[1, 0]) < 1e-9:
        roll, yaw = 0.0, np.arctan2(-r[0, 1], r[1, 1])
    else:
        roll, yaw = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    xyz = " ".join(f"{value:.17g}" for value in transform[:3, 3])
    return f'<origin xyz="{xyz}" rpy="{roll:.17g} {pitch:.17g} {yaw:.17g}"/>'
