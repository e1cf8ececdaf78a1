"""Solids as coal has them, and their distances pair by pair; coal is in `make oracle` alone."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np

from agrik_fast.collision import Box, Capsule, HalfSpace, Sphere

Made = tuple[Any, Any, np.ndarray, float]
"""Our solid in its place, coal's geometry, where that is (4, 4), and the radius round it."""


def transform(where: np.ndarray) -> Any:
    return coal.Transform3s(where[:3, :3].copy(), where[:3, 3].copy())


def by_coal(one: Made, other: Made) -> float:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.gjk_max_iterations = 1000
    request.gjk_tolerance = 1e-13
    request.enable_signed_distance = False
    where = transform(one[2]), transform(other[2])
    return float(coal.distance(one[1], where[0], other[1], where[1], request, result))


def rigid(frame: np.ndarray) -> np.ndarray:
    frame = np.array(frame)
    frame[3] = 0, 0, 0, 1
    return frame


def made(shape: Any) -> Made:
    """Return coal's geometry of one of our solids, in its place."""
    where = np.eye(4)
    if isinstance(shape, Sphere):
        where[:3, 3] = shape.centre
        return shape, coal.Sphere(shape.radius), where, 0.0
    if isinstance(shape, Capsule):
        a, b = np.array(shape.a), np.array(shape.b)
        length = float(np.linalg.norm(b - a))
        along = (b - a) / length if length > 0 else np.array([0.0, 0, 1])
        side = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
        side /= np.linalg.norm(side)
        where[:3, :3] = np.stack([side, np.cross(along, side), along], axis=-1)
        where[:3, 3] = (a + b) / 2
        return shape, coal.Capsule(shape.radius, length), where, 0.0
    if isinstance(shape, HalfSpace):
        return shape, coal.Halfspace(np.array(shape.normal), shape.offset), where, 0.0
    assert isinstance(shape, Box)
    where[:3, :3], where[:3, 3] = np.array(shape.rotation), shape.centre
    return shape, coal.Box(*(2 * np.array(shape.half))), where, shape.radius
