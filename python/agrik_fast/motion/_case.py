"""An arm in a scene with errors: what they do to the tool and to the clearance of each body."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .. import _native
from .._checks import FloatArray, shown
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import Robot
from ._errors import Errors, Lengths

__all__ = ["TOGETHER", "AtPostures", "Case", "phi", "ratio"]

# Step of the central differences of points on bodies, rad and m.
_STEP = 1e-6
TOGETHER = 256
"""Postures that are worked on at a time."""


def phi(x: FloatArray) -> FloatArray:
    """Return the normal distribution function."""
    erf = np.vectorize(math.erf, otypes=[float])
    return np.asarray(0.5 * (1 + erf(np.asarray(x) / math.sqrt(2))))


def ratio(clearance: FloatArray, deviation: FloatArray) -> FloatArray:
    """Return clearances in their standard deviations; without errors they are never lost."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = clearance / deviation
    return np.where(clearance > 0, np.where(deviation > 0, found, np.inf), -np.inf)


@dataclass(frozen=True, eq=False)
class AtPostures:
    """Of m postures: distance, what of it is certified, and more, shape (m, bodies), m.

    Infinite for bodies that have nothing near.
    """

    distance: FloatArray
    clearance: FloatArray
    deviation: FloatArray
    guaranteed: FloatArray


class Case:
    """An arm in a scene, with errors."""

    def __init__(self, arm: Robot, scene: Scene, errors: Errors | None) -> None:
        if not isinstance(arm, Robot):
            raise ArgumentError("arm", shown(arm), "a Robot")
        if not isinstance(scene, Scene):
            raise ArgumentError("scene", shown(scene), "a Scene")
        self.errors = Errors() if errors is None else errors
        if not isinstance(self.errors, Errors):
            raise ArgumentError("errors", shown(errors), "Errors")
        self.arm, self.scene = arm, scene
        self.bodies = arm.compiled_bodies()
        self.names = tuple(self.bodies.names)
        self.frames = np.array(self.bodies.frames, dtype=np.int64)
        self.lengths = Lengths(arm)
        self.slides = np.array([kind == "prismatic" for kind in arm.joint_types])

    @property
    def collider(self) -> _native.Collider:
        """The arm in its scene."""
        return self.scene.collider(self.arm)

    def spread(self, play: FloatArray | None) -> FloatArray:
        """Return the standard deviations of joint values, shape (1 or m, dof), rad or m.

        `play`, shape (m, dof), rad, is that of which nothing is known; None: all of it.
        """
        if play is None:
            return self.errors.joints(self.arm)[None]
        turning = np.hypot(self.errors.joint, play / math.sqrt(12))
        return np.where(self.slides, self.errors.slide, turning)

    def levers(self, q: FloatArray, reach: FloatArray) -> FloatArray:
        """Return the levers within `reach` of postures, shape (m, dof, bodies)."""
        each = [self.bodies.levers(row, most) for row, most in zip(q, reach, strict=True)]
        return np.array(each).reshape(len(q), q.shape[1], len(self.names))

    def covariance(self, q: FloatArray, play: FloatArray | None = None) -> FloatArray:
        """Return the covariance of the tool point relative to the scene, m^2."""
        of = self.errors
        jacobian = self.arm.jacobian(q)[:3]
        directions, point = self.lengths.directions(q[None])
        x, y, z = point[0]
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        lengths = directions[0] * of.length
        covariance = (jacobian * self.spread(play)[0] ** 2) @ jacobian.T + lengths.T @ lengths
        covariance += of.vision**2 * np.eye(3) + of.camera**2 * cross @ cross.T
        return np.asarray(covariance)

    def at(
        self, q: FloatArray, reach: FloatArray | None = None, play: FloatArray | None = None
    ) -> AtPostures:
        """Return what errors do to the bodies at m postures, shape (m, dof).

        With `reach`, shape (m, dof), all postures whose joint values differ by no more than
        that are meant: clearances are less by what the bodies can move on the way to them.
        `play` is as for `spread`.
        """
        blocks = list(self._blocks(q, reach, play))
        each = (np.concatenate([getattr(one, name) for one in blocks]) for name in _FIELDS)
        return AtPostures(*each)

    def _blocks(
        self, q: FloatArray, reach: FloatArray | None, play: FloatArray | None
    ) -> Iterator[AtPostures]:
        for first in range(0, len(q), TOGETHER):
            rows = slice(first, first + TOGETHER)
            yield self._block(q[rows], *(x if x is None else x[rows] for x in (reach, play)))

    def _block(
        self, q: FloatArray, reach: FloatArray | None, play: FloatArray | None
    ) -> AtPostures:
        of, near = self.errors, self.scene.distances(self.arm, q)
        told = np.isfinite(near.distance) & (self.frames > 0)
        way = near.on_body - near.on_object
        size = np.linalg.norm(way, axis=-1, keepdims=True)
        normal = np.divide(way, size, out=np.zeros_like(way), where=size > 0)
        rates = np.einsum("mjbx,mbx->mbj", self._point_rates(q, near.on_body), normal)
        square = ((rates * self.spread(play)[:, None]) ** 2).sum(axis=-1)
        directions, _ = self.lengths.directions(q)
        moves = self.lengths.frames[None, :] <= self.frames[:, None]
        along = np.einsum("mlx,mbx->mbl", directions, normal) * moves
        square += ((along * of.length) ** 2).sum(axis=-1)
        square += (of.vision * np.linalg.norm(normal, axis=-1)) ** 2
        square += (of.camera * np.linalg.norm(np.cross(near.on_body, normal), axis=-1)) ** 2
        distance = near.distance if reach is None else near.distance - self.motion(q, reach)
        clearance = np.where(told, distance, np.inf)
        worst = self._worst(q, near.on_body, play)
        free = np.where(told, near.distance, np.inf)
        return AtPostures(free, clearance, np.sqrt(square), clearance - worst)

    def motion(self, q: FloatArray, reach: FloatArray) -> FloatArray:
        """Return how far core points of the bodies move within `reach`, shape (m, bodies), m."""
        return np.asarray(np.einsum("mjb,mj->mb", self.levers(q, reach), reach))

    def _worst(self, q: FloatArray, points: FloatArray, play: FloatArray | None) -> FloatArray:
        """Return by how much errors of no more than their sizes lessen clearances at most."""
        of = self.errors
        turning = of.joint + 0.5 * (of.backlash if play is None else play)
        joints = np.where(self.slides, of.slide, turning)
        worst = self.motion(q, np.broadcast_to(joints, q.shape))
        moved = (self.lengths.frames[None, :] <= self.frames[:, None]).sum(axis=1)
        # Three errors of the same size along three axes are off by the root of three of it.
        seen = math.sqrt(3.0) * (of.vision + of.camera * np.linalg.norm(points, axis=-1))
        return np.asarray(worst + moved * of.length + seen)

    def _point_rates(self, q: FloatArray, points: FloatArray) -> FloatArray:
        """Return how points on the bodies move with each joint, shape (m, dof, bodies, 3)."""
        frames = np.maximum(self.frames, 1) - 1
        poses = self.arm.fk_links(q)[:, frames]
        turned = np.swapaxes(poses[..., :3, :3], -1, -2)
        local = np.einsum("mbxy,mby->mbx", turned, points - poses[..., :3, 3])
        steps = _STEP * np.eye(q.shape[1])
        ends = []
        for sign in (1.0, -1.0):
            moved = self.arm.fk_links(q[:, None] + sign * steps)[:, :, frames]
            ends.append(np.einsum("mjbxy,mby->mjbx", moved[..., :3, :3], local))
            ends[-1] += moved[..., :3, 3]
        rates = (ends[0] - ends[1]) / (2 * _STEP)
        return np.asarray(rates * (self.frames > 0)[:, None])


_FIELDS = ("distance", "clearance", "deviation", "guaranteed")
