"""A sphere's outline is a circular cone of rays: how one is found among other points.

For unit rays r_i on the outline, ``r_i . w = 1`` with w = a / cos(alpha): a the axis, alpha the
half angle. That is linear, and exact for every perspective and distortion, where a circle in the
picture is not. Three rays give w; RANSAC takes those with most others on their cone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, float_array
from ..errors import ArgumentError

__all__ = ["Cone", "cone_of_outline"]

MOST_POINTS = 120
_TRIPLES = 48
_REFITS = 4
# Lengths of w = 1 / cos(alpha): from a degree to 42 degrees.
_SMALLEST, _LARGEST = 1.0001, 1.35
# Multiplications of a matrix product that linear algebra does on one thread.
_ONE_THREAD = 250_000


def product(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return ``one @ other``, in pieces so small that no other thread is woken for them.

    The threads of OpenBLAS wait for one another by spinning: for products of this size that is
    several times the work.
    """
    rows = max(1, _ONE_THREAD // max(1, other.size))
    out = np.empty((len(one), other.shape[1]))
    for begin in range(0, len(one), rows):
        np.matmul(one[begin : begin + rows], other, out=out[begin : begin + rows])
    return out


def along(rays: FloatArray, axis: FloatArray) -> FloatArray:
    """Return how far rays (..., 3) go along an axis (3,); on one thread, as `product` is."""
    return np.asarray(np.einsum("...j,j->...", rays, axis))


@dataclass(frozen=True)
class Cone:
    """A circular cone of rays.

    Attributes
    ----------
    axis : ndarray, shape (3,)
        Unit vector towards the sphere's centre.
    alpha : float, rad
        Half angle.

    Examples
    --------
    >>> from agrik_fast.vision import Cone
    >>> cone = Cone(axis=np.array([0.0, 0.0, 1.0]), alpha=0.1)
    >>> cone.alpha
    0.1
    """

    axis: FloatArray
    alpha: float

    def off(self, rays: FloatArray) -> FloatArray:
        """Return by how much rays are outside, rad; negative inside.

        Examples
        --------
        >>> from agrik_fast.vision import Cone
        >>> cone = Cone(axis=np.array([0.0, 0.0, 1.0]), alpha=0.1)
        >>> cone.off(np.array([[0.0, 0.0, 1.0]])).round(6).tolist()
        [-0.1]
        """
        return np.asarray(np.arccos(np.clip(along(rays, self.axis), -1, 1)) - self.alpha)


def cone_of_outline(rays: ArrayLike) -> Cone:
    """Return the cone that fits rays on a sphere's outline, all of them.

    Parameters
    ----------
    rays : array_like, shape (n, 3)
        Unit vectors, n >= 3.

    Raises
    ------
    ArgumentError
        Fewer than three, or all in one plane.

    Examples
    --------
    >>> import numpy as np
    >>> from agrik_fast.vision import cone_of_outline
    >>> turn = np.linspace(0, 6, 9)
    >>> rim = np.c_[0.1 * np.cos(turn), 0.1 * np.sin(turn), np.full(9, np.sqrt(0.99))]
    >>> round(float(np.sin(cone_of_outline(rim).alpha)), 12)
    0.1
    """
    r = float_array("rays", rays)
    if r.ndim != 2 or r.shape[1] != 3 or len(r) < 3 or not np.isfinite(r).all():
        raise ArgumentError("rays", f"shape {r.shape}", "finite unit vectors, shape (n >= 3, 3)")
    cone = fitted(r)
    if cone is None:
        raise ArgumentError("rays", "rays of no cone", "rays on the outline of a sphere")
    return cone


def fitted(rays: FloatArray) -> Cone | None:
    """Return the cone of least squares, or None where there is none."""
    # About their mean: rays of a narrow cone are nearly parallel, and the plain normal
    # equations would lose half of the digits.
    mean = rays.mean(axis=0)
    _, sizes, ways = np.linalg.svd(rays - mean, full_matrices=False)
    if sizes[1] < 1e-9:
        return None
    normal = ways[2]
    along = float(mean @ normal)
    if abs(along) < 1e-9:
        return None
    length = 1 / abs(along)
    if not length >= 1:
        return None
    return Cone(normal * math.copysign(1, along), math.acos(1 / length))


@lru_cache(maxsize=256)
def _triples(count: int) -> NDArray[np.intp]:
    """Return the numbers of three points each: half of them far apart, half near."""
    rng = np.random.default_rng(20)
    start = rng.random(_TRIPLES)
    half = _TRIPLES // 2
    steps = np.concatenate(
        [rng.uniform(1 / 6, 1 / 2, (half, 2)), rng.uniform(1 / 16, 1 / 6, (_TRIPLES - half, 2))]
    )
    places = np.stack([start, start + steps[:, 0], start + steps.sum(axis=1)], axis=1)
    return np.asarray((places % 1.0 * count).astype(np.intp))


def cones_of_triples(
    rays: FloatArray, triples: NDArray[np.intp], narrowest: float, widest: float
) -> tuple[FloatArray, FloatArray]:
    """Return the axes and half angles of the cones through three rays each, where there is one."""
    p, q, r = (rays[index] for index in triples.T)
    # Cramer's rule for the three equations of every triple.
    normal = np.cross(p, q) + np.cross(q, r) + np.cross(r, p)
    volume = np.einsum("ij,ij->i", p, np.cross(q, r))
    with np.errstate(divide="ignore", invalid="ignore"):
        w = normal / volume[:, None]
        length = np.sqrt(np.einsum("ij,ij->i", w, w))
        alpha = np.arccos(1 / length)
        sound = (length > _SMALLEST) & (length < _LARGEST)
        sound &= (alpha >= narrowest) & (alpha <= widest)
    return w[sound] / length[sound][:, None], alpha[sound]


def best_cone(
    rays: FloatArray, tolerance: float, narrowest: float = 0.0, widest: float = math.inf
) -> tuple[Cone, NDArray[np.bool_]] | None:
    """Return the cone with most rays on it, and which they are.

    Parameters
    ----------
    rays : ndarray, shape (n, 3)
        In the outline's order.
    tolerance : float, rad
        How far a ray on the cone may be off it.
    narrowest, widest : float, rad
        Half angles that are looked for.
    """
    if len(rays) < 6:
        return None
    few = rays
    if len(rays) > MOST_POINTS:
        few = rays[np.linspace(0, len(rays) - 1, MOST_POINTS).astype(np.intp)]
    axes, alpha = cones_of_triples(few, _triples(len(few)), narrowest, widest)
    if not len(alpha):
        return None
    off = np.abs(np.arccos(np.clip(product(axes, few.T), -1, 1)) - alpha[:, None])
    best = int((off < tolerance).sum(axis=1).argmax())
    cone = Cone(axes[best], float(alpha[best]))
    on = np.abs(cone.off(rays)) < tolerance
    for _ in range(_REFITS):
        if on.sum() < 5:
            return None
        better = fitted(rays[on])
        if better is None or not narrowest <= better.alpha <= widest:
            break
        cone = better
        on = np.abs(cone.off(rays)) < tolerance
    return cone, on
