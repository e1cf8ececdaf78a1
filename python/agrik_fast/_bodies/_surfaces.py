"""Triangles that show shapes: what pictures and viewers draw."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from ..errors import MissingExtraError
from ._shapes import BodyShape, Box, Capsule, Convex, Cover, HalfSpace, Sphere

Triangles = tuple[FloatArray, NDArray[np.int32]]
"""Corners, shape (k, 3), m, and the three corners of each triangle, shape (m, 3)."""

_AROUND = 20
# The square that stands for the endless plane of a half-space, m.
_PLANE = 4.0


def surface(shape: BodyShape | HalfSpace, sides: int = _AROUND) -> Triangles:
    """Return triangles that show a shape.

    Parameters
    ----------
    shape : Sphere, Capsule, Box, Cover, Convex or HalfSpace
        A cover is shown as its box, a half-space as a square of 4 m, a rounded box as a box that
        is larger by its radius.
    sides : int, default 20
        Corners of what is round.

    Returns
    -------
    vertices : ndarray, shape (k, 3), m
    faces : ndarray of int, shape (m, 3)
        Seen from outside, their corners turn to the left.

    Raises
    ------
    MissingExtraError
        The hull of points needs SciPy.
    """
    match shape:
        case Sphere():
            return _rounded(np.array(shape.centre), np.array(shape.centre), shape.radius, sides)
        case Capsule():
            return _rounded(np.array(shape.a), np.array(shape.b), shape.radius, sides)
        case Box():
            half = np.array(shape.half) + shape.radius
            return box(np.array(shape.centre), half, np.array(shape.rotation))
        case Cover():
            return box(np.array(shape.centre), np.array(shape.half), np.array(shape.rotation))
        case Convex():
            return _hull(np.array(shape.vertices), shape.radius)
        case HalfSpace():
            return _plane(np.array(shape.normal), shape.offset)


def box(centre: FloatArray, half: FloatArray, rotation: FloatArray) -> Triangles:
    """Return the triangles of a box."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [part for a, b, c, d in squares for part in ((a, b, c), (a, c, d))]
    return centre + (signs * half) @ rotation.T, np.array(faces, dtype=np.int32)


def cylinder(a: FloatArray, b: FloatArray, radius: float) -> Triangles:
    """Return the triangles of a cylinder between two points."""
    _, side, third = _frame(b - a)
    angles = np.linspace(0.0, 2 * np.pi, _AROUND, endpoint=False)
    ring = radius * (np.outer(np.cos(angles), side) + np.outer(np.sin(angles), third))
    vertices = np.concatenate([a + ring, b + ring, [a], [b]])
    now = np.arange(_AROUND)
    following = (now + 1) % _AROUND
    low, high = np.full(_AROUND, 2 * _AROUND), np.full(_AROUND, 2 * _AROUND + 1)
    faces = np.concatenate(
        [
            np.stack([now, following, following + _AROUND], axis=1),
            np.stack([now, following + _AROUND, now + _AROUND], axis=1),
            np.stack([low, following, now], axis=1),
            np.stack([high, now + _AROUND, following + _AROUND], axis=1),
        ]
    )
    return vertices, faces.astype(np.int32)


def _frame(direction: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return right-handed unit vectors, the first along a direction, or along z for none."""
    length = float(np.linalg.norm(direction))
    along = direction / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    side = np.cross(np.eye(3)[int(np.argmin(np.abs(along)))], along)
    side /= np.linalg.norm(side)
    return along, side, np.cross(along, side)


def _rounded(a: FloatArray, b: FloatArray, radius: float, sides: int) -> Triangles:
    along, side, third = _frame(b - a)
    angles = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    ring = np.outer(np.cos(angles), side) + np.outer(np.sin(angles), third)
    half = max(2, sides // 5)
    lifts = [(a, lift) for lift in np.linspace(-np.pi / 2, 0.0, half + 1)]
    lifts += [(b, lift) for lift in np.linspace(0.0, np.pi / 2, half + 1)]
    rows = [end + radius * (np.sin(u) * along + np.cos(u) * ring) for end, u in lifts]
    now = np.arange(sides)
    following = (now + 1) % sides
    faces = []
    for level in range(len(rows) - 1):
        low, high = level * sides, (level + 1) * sides
        faces.append(np.stack([low + now, low + following, high + following], axis=1))
        faces.append(np.stack([low + now, high + following, high + now], axis=1))
    return np.concatenate(rows), np.concatenate(faces).astype(np.int32)


def _hull(points: FloatArray, radius: float) -> Triangles:
    try:
        from scipy.spatial import ConvexHull, QhullError
    except ImportError:
        raise MissingExtraError("the surface of a convex hull", "meshes") from None
    if radius > 0.0:
        ball, _ = _rounded(np.zeros(3), np.zeros(3), radius, 8)
        points = (points[:, None] + ball[None]).reshape(-1, 3)
    try:
        found = ConvexHull(points)
    except QhullError:
        # Flat ones have no inside; a hair's breadth gives them one.
        size = max(float(np.ptp(points, axis=0).max()), 1e-3)
        return _hull(points, 1e-3 * size)
    faces = found.simplices.copy()
    corners = points[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normal, found.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    used, faces = np.unique(faces, return_inverse=True)
    return points[used], faces.reshape(-1, 3).astype(np.int32)


def _plane(normal: FloatArray, offset: float) -> Triangles:
    _, side, third = _frame(normal)
    middle = normal * offset
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    vertices = [middle + _PLANE / 2 * (x * side + y * third) for x, y in corners]
    return np.array(vertices), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
