"""Which spheres an outline of several shows: all candidates first, then those that explain it.

A cone drawn over two fruits takes a piece of each, and may take more points than either has. So
none is believed because it was drawn first: of many candidates those are chosen which together
explain most of the outline, each at a price. The price is a share of the whole circle, so that
large ones have to explain more, and what of the outline lies deep inside, where a fruit is all red.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from ._cone import Cone, cones_of_triples, fitted, product

__all__ = ["Outline", "spheres_of"]

# An outline is thinned to so many points while candidates are compared.
_MOST_POINTS = 200
# Pieces of the outline through whose ends and middle candidates go: so many, and their lengths as
# shares of it; and so many triples over wider parts, for a fruit that another one cuts in two.
_STARTS, _PIECES, _WIDE = 32, (0.05, 0.09, 0.14, 0.2, 0.3, 0.45), 64
_KEPT = 40
# Pixels off a cone at which a point tells nothing for it, in the rounds of refinement.
_NEAR_PX = (3.0, 2.2, 1.8)
# An outline runs along a circle, its red side inwards: cosine of the angle between their normals.
_ALONG = 0.7
_INSIDE_PX = 3.0
# The price of a candidate: shares of the whole outline, of its circle, and of the outline that is
# deep inside it, as where a leaf lies before a fruit.
_EACH, _CIRCLE, _INSIDE = 0.04, 0.2, 0.25
# Pixels of an outline for one of length, when they touch by corners.
_STEPS = 0.9
_ALIKE = 0.8
# A point that is told so little is left; so large a share of them is looked at again.
_UNTOLD, _LEFT_OVER = 0.05, 0.04
_MOST_CHOSEN = 8
_EXCHANGES = 4
_REFITS = 4
# Pixels from all other circles at which a point is one's alone; with fewer such, all count.
_ALONE_PX, _FEWEST_ALONE = 5.0, 8


@dataclass(frozen=True)
class Outline:
    """Points of a blob's outline.

    Attributes
    ----------
    rays : ndarray, shape (n, 3)
        Unit vectors, in order.
    outward : ndarray, shape (n, 3)
        Unit vectors across the outline, away from the blob.
    """

    rays: FloatArray
    outward: FloatArray

    def of(self, which: NDArray[np.intp]) -> Outline:
        """Return some of the points."""
        return Outline(self.rays[which], self.outward[which])


@dataclass(frozen=True)
class _Candidates:
    axes: FloatArray
    alpha: FloatArray

    def of(self, which: NDArray[np.intp] | NDArray[np.bool_]) -> _Candidates:
        return _Candidates(self.axes[which], self.alpha[which])

    def and_(self, *others: _Candidates) -> _Candidates:
        every = (self, *others)
        return _Candidates(
            np.concatenate([each.axes for each in every]),
            np.concatenate([each.alpha for each in every]),
        )

    def off(self, outline: Outline) -> FloatArray:
        """Return by how much points are outside, rad, to first order, shape (k, n)."""
        cosine = product(self.axes, outline.rays.T)
        return np.asarray((np.cos(self.alpha)[:, None] - cosine) / np.sin(self.alpha)[:, None])

    def along(self, outline: Outline) -> NDArray[np.bool_]:
        """Whether the outline runs along the circle, shape (k, n)."""
        cosine = product(self.axes, outline.outward.T)
        return np.asarray(cosine < -_ALONG * np.sin(self.alpha)[:, None])

    def told(self, outline: Outline, near: float) -> FloatArray:
        """Return how well every candidate explains every point, 0 to 1, shape (k, n)."""
        off = self.off(outline) / near
        return np.where(self.along(outline), np.maximum(1 - off * off, 0), 0)


@lru_cache(maxsize=256)
def _triples(count: int) -> NDArray[np.intp]:
    start = np.tile(np.arange(_STARTS) / _STARTS, len(_PIECES))
    length = np.repeat(_PIECES, _STARTS)
    near = np.stack([start, start + length / 2, start + length], axis=1)
    rng = np.random.default_rng(21)
    steps = rng.uniform(1 / 8, 1 / 2, (_WIDE, 2))
    first = rng.random(_WIDE)
    wide = np.stack([first, first + steps[:, 0], first + steps.sum(axis=1)], axis=1)
    return np.asarray((np.concatenate([near, wide]) % 1.0 * count).astype(np.intp))


def spheres_of(
    outline: Outline, focal: float, on_cone: float, narrowest: float, widest: float
) -> list[Cone]:
    """Return the cones that together explain an outline best, those of most points first.

    Parameters
    ----------
    outline : Outline
        Of one blob.
    focal : float, pixels
        Focal length.
    on_cone : float, rad
        How far a ray on a cone may be off it.
    narrowest, widest : float, rad
        Half angles that are looked for.
    """
    count = len(outline.rays)
    thin = min(count, _MOST_POINTS)
    few = outline.of(np.linspace(0, count - 1, thin).astype(np.intp))
    looked = _Search(few, focal, narrowest, widest, thin / count)
    found = looked.candidates(few)
    told = found.told(few, _NEAR_PX[-1] / focal)
    chosen = _chosen(told, looked.price(found))
    # Short pieces far apart, of a fruit between others, are rarely drawn together before the
    # rest is known.
    left = np.nonzero(told[chosen].max(axis=0, initial=0) < _UNTOLD)[0]
    if len(left) >= max(_LEFT_OVER * thin, 6):
        found = found.of(np.array(chosen, np.intp)).and_(looked.candidates(few.of(left)), found)
        told = found.told(few, _NEAR_PX[-1] / focal)
        chosen = _chosen(told, looked.price(found))
    best = found.of(np.array(chosen, np.intp))
    return _settled(best, outline, focal, on_cone, (narrowest, widest))


@dataclass(frozen=True)
class _Search:
    """An outline, thinned, and what is looked for in it."""

    outline: Outline
    focal: float
    narrowest: float
    widest: float
    thinned: float

    def candidates(self, part: Outline) -> _Candidates:
        """Return candidates through triples of some of the points, refined by all of them."""
        axes, alpha = cones_of_triples(
            part.rays, _triples(len(part.rays)), self.narrowest, self.widest
        )
        found = _Candidates(axes, alpha)
        for number, near in enumerate(_NEAR_PX):
            told = found.told(self.outline, near / self.focal)
            if number == 0:
                kept = _unlike(told, self.price(found))
                found, told = found.of(kept), told[kept]
            found = self._refitted(found, told)
        return found

    def price(self, found: _Candidates) -> FloatArray:
        """Return how many points candidates have to explain before they are worth it."""
        circle = 2 * math.pi * self.focal * np.tan(found.alpha) * _STEPS * self.thinned
        inside = (found.off(self.outline) < -_INSIDE_PX / self.focal).sum(axis=1)
        return np.asarray(_EACH * len(self.outline.rays) + _CIRCLE * circle + _INSIDE * inside)

    def _refitted(self, found: _Candidates, told: FloatArray) -> _Candidates:
        """Return the candidates' cones of least squares, weighted by what they explain."""
        middle = self.outline.rays.mean(axis=0)
        rays = self.outline.rays - middle
        weight = np.maximum(told.sum(axis=1), 1e-9)[:, None]
        mean = product(told, rays) / weight
        squares = (rays[:, :, None] * rays[:, None, :]).reshape(-1, 9)
        spread = (product(told, squares) / weight).reshape(-1, 3, 3)
        spread -= mean[:, :, None] * mean[:, None, :]
        normal = np.linalg.eigh(spread)[1][:, :, 0]
        along = np.einsum("ij,ij->i", normal, mean + middle)
        axes = normal * np.copysign(1.0, along)[:, None]
        alpha = np.arccos(np.minimum(np.abs(along), 1.0))
        sound = ((told > 0).sum(axis=1) >= 5) & (alpha > 1e-3)
        sound &= (alpha >= self.narrowest) & (alpha <= self.widest) & (alpha < math.pi / 4)
        return _Candidates(axes, alpha).of(sound)


def _unlike(told: FloatArray, price: FloatArray) -> NDArray[np.intp]:
    """Return the best candidates, without those that explain the same points as a better one."""
    worth = told.sum(axis=1) - price
    shared = product(told, told.T)
    own = np.maximum(np.diag(shared), 1e-9)
    alike = shared > _ALIKE * np.maximum(own[:, None], own[None, :])
    kept: list[int] = []
    while len(kept) < min(_KEPT, len(worth)):
        best = int(worth.argmax())
        if not math.isfinite(worth[best]):
            break
        kept.append(best)
        worth[alike[best]] = -math.inf
        worth[best] = -math.inf
    return np.array(kept, np.intp)


def _chosen(told: FloatArray, price: FloatArray) -> list[int]:
    """Return the candidates that explain most beyond their price, together."""

    def worth(chosen: list[int]) -> float:
        if not chosen:
            return 0.0
        return float(told[chosen].max(axis=0).sum() - price[chosen].sum())

    def completed(chosen: list[int], without: int | None) -> list[int]:
        chosen = list(chosen)
        known = told[chosen].max(axis=0) if chosen else np.zeros(told.shape[1])
        while len(chosen) < min(_MOST_CHOSEN, len(told)):
            gain = np.maximum(told - known, 0).sum(axis=1) - price
            if without is not None:
                gain[without] = -math.inf
            best = int(gain.argmax())
            if gain[best] <= 0:
                break
            chosen.append(best)
            known = np.maximum(known, told[best])
        return chosen

    best = completed([], None)
    most = worth(best)
    # The first one may stand for two: each is tried without.
    for _ in range(_EXCHANGES):
        before = most
        for each in list(best):
            if each not in best:
                continue
            other = completed([k for k in best if k != each], each)
            if worth(other) > most + 1e-9:
                best, most = other, worth(other)
        if most <= before:
            break
    return best


def _settled(
    found: _Candidates, outline: Outline, focal: float, on_cone: float, ends: tuple[float, float]
) -> list[Cone]:
    """Return cones fitted to the points that are of one alone, those of most points first."""
    for _ in range(_REFITS):
        if not len(found.alpha):
            return []
        every = np.abs(found.off(outline))
        off = np.where(found.along(outline), every, math.inf)
        nearest = off.argmin(axis=0)
        # Where two meet, gaps in the red are closed: the outline is neither's there.
        near = every < _ALONE_PX / focal
        cones, sizes = [], []
        for k in range(len(found.alpha)):
            own = (nearest == k) & (off[k] < on_cone)
            alone = own & (near.sum(axis=0) - near[k] == 0)
            on = alone if alone.sum() >= _FEWEST_ALONE else own
            cone = fitted(outline.rays[on]) if on.sum() >= 5 else None
            if cone is not None and ends[0] <= cone.alpha <= ends[1]:
                cones.append(cone)
                sizes.append(int(own.sum()))
        order = np.argsort(-np.array(sizes, int), kind="stable")
        cones = [cones[k] for k in order]
        found = _Candidates(
            np.array([each.axis for each in cones]).reshape(-1, 3),
            np.array([each.alpha for each in cones], float),
        )
    return cones
