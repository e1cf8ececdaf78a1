"""A serial arm in plain NumPy: forward kinematics, errors and limits, apart from the library.

Every constant part of the chain is a 4x4 matrix, and a joint turns about or slides along one axis
behind it. Angles are handed to sine and cosine as they are, never added to an offset first, so that
a joint at 1e16 rad is where its double says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
UNLIMITED = 1e4
"""Limits of this and beyond, rad, mean by the documentation that a joint turns freely."""


@dataclass(frozen=True)
class Joint:
    """One joint that moves; `before` leads to it from the joint before (m)."""

    name: str
    kind: str
    """"revolute", "continuous" or "prismatic"."""
    before: Array
    axis: Array
    lower: float = -np.inf
    upper: float = np.inf
    mimic: tuple[str, float, float] | None = None
    """Name of the joint that it follows, multiplier and offset."""


@dataclass(frozen=True)
class Arm:
    """Joints from base to tool, and the constant transform from the last joint to the tool."""

    name: str
    joints: tuple[Joint, ...]
    end: Array
    code: str = ""
    """Python that builds the same arm with the library, as `arm`."""
    kind: str = ""
    """What kind of arm it is, for tables."""
    scale: float = 1.0
    """A typical length, m."""
    order: tuple[str, ...] = ()
    """Names of the variables where they are not in physical order."""

    @cached_property
    def variables(self) -> tuple[Joint, ...]:
        """The joints that have a value of their own, in the order of q."""
        own = {joint.name: joint for joint in self.joints if joint.mimic is None}
        return tuple(own[name] for name in self.order) if self.order else tuple(own.values())

    @property
    def dof(self) -> int:
        return len(self.variables)

    @cached_property
    def _range(self) -> tuple[Array, Array]:
        low = np.array([joint.lower for joint in self.variables])
        high = np.array([joint.upper for joint in self.variables])
        free = self.turns & (low <= -UNLIMITED) & (high >= UNLIMITED)
        low, high = np.where(free, -np.inf, low), np.where(free, np.inf, high)
        index = {joint.name: i for i, joint in enumerate(self.variables)}
        for joint in self.joints:
            if joint.mimic is not None and joint.mimic[1] != 0:
                source, multiplier, offset = joint.mimic
                ends = sorted(((end - offset) / multiplier) for end in (joint.lower, joint.upper))
                low[index[source]] = max(low[index[source]], ends[0])
                high[index[source]] = min(high[index[source]], ends[1])
        return low, high

    @property
    def lower(self) -> Array:
        """Smallest values, shape (dof,), those that followers allow; -inf where free."""
        return self._range[0]

    @property
    def upper(self) -> Array:
        """Largest values, shape (dof,)."""
        return self._range[1]

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """Which variables turn, rather than slide."""
        return np.array([joint.kind != "prismatic" for joint in self.variables])

    @cached_property
    def leads(self) -> NDArray[np.bool_]:
        """Which variables others follow: a whole turn of theirs is not the same posture."""
        followed = {joint.mimic[0] for joint in self.joints if joint.mimic is not None}
        return np.array([joint.name in followed for joint in self.variables])

    @cached_property
    def length(self) -> float:
        """Sum of the constant lengths, m: no point is further but by slides."""
        parts = [joint.before[:3, 3] for joint in self.joints] + [self.end[:3, 3]]
        return float(sum(np.linalg.norm(part) for part in parts))

    @property
    def widest(self) -> float:
        """The largest finite limit that a file gives a joint that turns, rad."""
        ends = [end for j in self.joints if j.kind == "revolute" for end in (j.lower, j.upper)]
        return max([abs(end) for end in ends if np.isfinite(end)], default=0.0)

    def with_tool(self, tool: Array | None) -> Arm:
        """Return the arm with a frame behind its tool."""
        return self if tool is None else replace(self, end=self.end @ tool)

    def ordered(self, names: Sequence[str]) -> Arm:
        """Return the arm with its variables in another order: that of a robot's `joint_names`."""
        own = sorted(joint.name for joint in self.joints if joint.mimic is None)
        if sorted(names) != own:
            raise ValueError(f"variables are {own}, not {sorted(names)}")
        return replace(self, order=tuple(names))

    def values(self, q: Array) -> list[Array]:
        """Return the value of every joint, followers too, each of shape q.shape[:-1]."""
        column = {joint.name: q[..., i] for i, joint in enumerate(self.variables)}
        found = []
        for joint in self.joints:
            if joint.mimic is None:
                found.append(column[joint.name])
            else:
                source, multiplier, offset = joint.mimic
                found.append(multiplier * column[source] + offset)
        return found

    def fk(self, q: ArrayLike) -> Array:
        """Tool poses, shape (m, 4, 4), m, of joint values, shape (m, dof)."""
        q = np.asarray(q, float)
        turn = np.broadcast_to(np.eye(3), (len(q), 3, 3))
        point = np.zeros((len(q), 3))
        for joint, value in zip(self.joints, self.values(q), strict=True):
            point = point + turn @ joint.before[:3, 3]
            turn = turn @ joint.before[:3, :3]
            if joint.kind == "prismatic":
                point = point + (turn @ joint.axis) * value[:, None]
            else:
                turn = turn @ rotations(joint.axis, value)
        pose = np.zeros((len(q), 4, 4))
        pose[:, :3, 3] = point + turn @ self.end[:3, 3]
        pose[:, :3, :3] = turn @ self.end[:3, :3]
        pose[:, 3, 3] = 1.0
        return pose

    def rounding(self, q: Array) -> tuple[Array, Array]:
        """What two right computations of `fk` may differ by: m and rad, each of shape (m,)."""
        values = self.values(q)
        slides = np.zeros(len(q))
        angles = np.zeros(len(q))
        for joint, value in zip(self.joints, values, strict=True):
            if joint.kind == "prismatic":
                slides += np.abs(value)
            if joint.mimic is not None:
                # The product and the sum are rounded before they become an angle or a length.
                size = np.abs(value) + abs(joint.mimic[2])
                angles += size if joint.kind != "prismatic" else 0.0
                slides += size if joint.kind == "prismatic" else 0.0
        steps = len(self.joints) + 2
        turn = 8 * EPS * (steps + angles)
        return (self.length + slides) * turn, turn


def rotations(axis: Array, angle: Array) -> Array:
    """Rotations by `angle` (m,) rad about the unit vector `axis` (3,): shape (m, 3, 3)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    # 1 - cos a as 2 sin^2 (a / 2) keeps the digits of small angles.
    sine, half = np.sin(angle), np.sin(angle / 2)
    versed = 2 * half * half
    return np.eye(3) + sine[:, None, None] * cross + versed[:, None, None] * (cross @ cross)


def rotation(axis: ArrayLike, angle: float) -> Array:
    """One rotation, shape (3, 3)."""
    return rotations(unit(axis), np.array([angle]))[0]


def unit(vector: ArrayLike) -> Array:
    """A vector of length 1."""
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


def transform(turn: ArrayLike | None = None, point: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """A rigid transform of a rotation (3, 3) and a point (3,) in m."""
    result = np.eye(4)
    if turn is not None:
        result[:3, :3] = turn
    result[:3, 3] = point
    return result


def from_rpy(rpy: ArrayLike) -> Array:
    """Rotation by roll, pitch, yaw (rad) as a URDF means them: about fixed x, y, z."""
    roll, pitch, yaw = np.asarray(rpy, float)
    about_y = rotation((0, 1, 0), pitch)
    return rotation((0, 0, 1), yaw) @ about_y @ rotation((1, 0, 0), roll)


def to_rpy(turn: Array) -> tuple[float, float, float]:
    """Roll, pitch, yaw (rad) of a rotation; with roll alone where pitch is a right angle."""
    level = float(np.hypot(turn[0, 0], turn[1, 0]))
    pitch = float(np.arctan2(-turn[2, 0], level))
    if level < 1e-12:
        return float(np.arctan2(np.sign(pitch) * turn[0, 1], turn[1, 1])), pitch, 0.0
    roll = float(np.arctan2(turn[2, 1], turn[2, 2]))
    return roll, pitch, float(np.arctan2(turn[1, 0], turn[0, 0]))


def random_rotation(rng: np.random.Generator) -> Array:
    """A rotation drawn evenly."""
    w, x, y, z = unit(rng.normal(size=4))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotation_vectors(turn: Array) -> Array:
    """Rotation vectors (m, 3), rad, of rotations (m, 3, 3), exact near 0 and up to pi."""
    skew = np.stack(
        [
            turn[:, 2, 1] - turn[:, 1, 2],
            turn[:, 0, 2] - turn[:, 2, 0],
            turn[:, 1, 0] - turn[:, 0, 1],
        ],
        axis=-1,
    )
    sine = np.linalg.norm(skew, axis=-1) / 2
    cosine = (np.trace(turn, axis1=-2, axis2=-1) - 1) / 2
    angle = np.arctan2(sine, cosine)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_skew = skew * (angle / (2 * sine))[:, None]
    # Near pi the skew part vanishes; the axis is then the longest column of (R + 1) / 2.
    columns = (np.swapaxes(turn, -1, -2) + turn) / 2 - cosine[:, None, None] * np.eye(3)
    longest = np.argmax(np.linalg.norm(columns, axis=-2), axis=-1)
    axis = np.take_along_axis(columns, longest[:, None, None], axis=-1)[:, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    sign = np.where((axis * skew).sum(-1) < 0, -1.0, 1.0)
    by_axis = axis * (sign * angle)[:, None]
    vectors = np.where((cosine < -0.9)[:, None], by_axis, by_skew)
    return np.where((angle > 0)[:, None], vectors, 0.0)


def axis_angles(first: Array, second: Array) -> Array:
    """Angles (m,) rad between unit vectors (m, 3), exact near 0 and pi."""
    sine = np.linalg.norm(np.cross(first, second), axis=-1)
    return np.arctan2(sine, (first * second).sum(-1))
