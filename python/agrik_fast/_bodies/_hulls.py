"""Convex hulls of points with few corners, and how far they reach out of what they hold.

SciPy finds the hulls; everything else here is about triangles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from ._shapes import Convex

MOST_CORNERS = 64
"""Corners of a hull that the compiled core is given; more cost time."""
# Corners that are taken at first, and before the hull is made anew.
_FIRST, _AT_ONCE = 32, 8
# Rounding of the points and of SciPy's hull, by the size of the whole.
_ROUNDING = 1e-9
_SURFACE_POINTS = 8_000
_HULL_POINTS = 1_000
_NEAR = 8


def hull_of(points: FloatArray) -> Convex:
    """Return a convex body that holds all points, with at most `MOST_CORNERS` corners.

    What the corners that were left out reach beyond the others is its radius.

    Parameters
    ----------
    points : ndarray, shape (n, 3), m
        At least one, all finite.
    """
    corners = _corners(points)
    size = float(np.ptp(points, axis=0).max())
    if len(corners) <= MOST_CORNERS:
        return Convex(_rows(corners))
    chosen = np.unique([int(k) for k in np.argmax(corners @ _directions(_FIRST).T, axis=0)])
    while True:
        left = np.setdiff1d(np.arange(len(corners)), chosen)
        away = _beyond(corners[left], corners[chosen])
        if len(chosen) >= MOST_CORNERS or away.max() <= _ROUNDING * size:
            radius = float(away.max() + _ROUNDING * size) if len(away) else 0.0
            return Convex(_rows(corners[chosen]), radius)
        room = min(_AT_ONCE, MOST_CORNERS - len(chosen))
        chosen = np.sort(np.concatenate([chosen, left[np.argsort(-away, kind="stable")[:room]]]))


def overestimate(hull: Convex, triangles: FloatArray) -> float:
    """Return how far a hull reaches out of a surface at most, m, to about 1 % of its size.

    Parameters
    ----------
    hull : Convex
        From `hull_of` of the corners.
    triangles : ndarray, shape (m, 3, 3), m
        Corners of the triangles of the surface.

    Returns
    -------
    float
        Largest distance of some thousand points of the hull of all corners from the triangles,
        and the radius by which `hull` is larger.
    """
    from scipy.spatial import cKDTree

    corners = triangles.reshape(-1, 3)
    faces = _faces(_corners(corners))
    if faces is None:
        return hull.radius
    where = _spread(faces, _HULL_POINTS)[0]
    samples, which = _spread(triangles, _SURFACE_POINTS)
    _, near = cKDTree(samples).query(where, k=min(_NEAR, len(samples)))
    near = near.reshape(len(where), -1)
    away = np.full(len(where), np.inf)
    for column in near.T:
        away = np.minimum(away, point_triangle(where, triangles[which[column]]))
    size = float(np.ptp(corners, axis=0).max())
    most = float(away.max())
    return hull.radius + (most if most > _ROUNDING * size else 0.0)


def point_triangle(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distance of points from triangles, one each, m.

    Parameters
    ----------
    points : ndarray, shape (..., 3)
    triangles : ndarray, shape (..., 3, 3)
        Corners; those without area count as edges.

    Returns
    -------
    ndarray, shape (...)
    """
    a, b, c = triangles[..., 0, :], triangles[..., 1, :], triangles[..., 2, :]
    normal = np.cross(b - a, c - a)
    area = (normal * normal).sum(-1)
    inside = area > 0.0
    for start, end in ((a, b), (b, c), (c, a)):
        inside = inside & ((np.cross(end - start, points - start) * normal).sum(-1) >= 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = np.abs(((points - a) * normal).sum(-1)) / np.sqrt(area)
    edges = np.minimum(
        np.minimum(_point_edge(points, a, b), _point_edge(points, b, c)), _point_edge(points, c, a)
    )
    return np.where(inside, height, edges)


def _point_edge(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    along = b - a
    length = (along * along).sum(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip(((points - a) * along).sum(-1) / length, 0.0, 1.0)
    share = np.where(length > 0.0, share, 0.0)
    away: FloatArray = np.linalg.norm(points - a - share[..., None] * along, axis=-1)
    return away


def _corners(points: FloatArray) -> FloatArray:
    """Return the corners of the hull of points; all of them where they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    distinct = np.unique(points, axis=0)
    if len(distinct) <= 4:
        return distinct
    try:
        kept: NDArray[np.int64] = np.sort(ConvexHull(distinct).vertices)
    except QhullError:
        return distinct
    return distinct[kept]


def _faces(corners: FloatArray) -> FloatArray | None:
    """Return the triangles of the hull of corners; None where they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        simplices: NDArray[np.int64] = ConvexHull(corners).simplices
    except (QhullError, ValueError):
        return None
    return corners[simplices]


def _beyond(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Distance of points from the hull of corners, of those that are outside of it."""
    if not len(points):
        return np.zeros(1)
    faces = _faces(corners)
    if faces is None:
        # A plane: the nearest corner is no nearer than the hull.
        away: FloatArray = np.min(np.linalg.norm(points[:, None] - corners[None], axis=-1), axis=1)
        return away
    away = np.full(len(points), np.inf)
    for face in faces:
        away = np.minimum(away, point_triangle(points, np.broadcast_to(face, (len(points), 3, 3))))
    return away


def _spread(triangles: FloatArray, count: int) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return points spread over triangles, corners included, and whose each one is."""
    edges = triangles - np.roll(triangles, 1, axis=1)
    longest = np.linalg.norm(edges, axis=-1).max(axis=1)
    area = np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=-1
    )
    step = max(float(np.sqrt(area.sum() / count)), 1e-300)
    parts = np.clip(np.ceil(longest / step), 1, 200).astype(np.int64)
    points, owner = [], []
    for n in np.unique(parts).tolist():
        mine = np.flatnonzero(parts == n)
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        kept = (i + j) <= n
        u, v = i[kept] / n, j[kept] / n
        weights = np.stack([1 - u - v, u, v], axis=-1)
        points.append(np.einsum("wk,mkx->mwx", weights, triangles[mine]).reshape(-1, 3))
        owner.append(np.repeat(mine, len(weights)))
    return np.concatenate(points), np.concatenate(owner)


def _directions(count: int) -> FloatArray:
    """Return directions spread evenly over all."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1)


def _rows(points: FloatArray) -> tuple[tuple[float, float, float], ...]:
    return tuple((x, y, z) for x, y, z in points.tolist())
