"""The least move of a platform, by translation and yaw, that brings a target in reach."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._checks import FloatArray

PROVEN_M = 1e-3
"""No move costs less than what is found by more than this, m."""

COARSE_M = 1e-4
"""How much shorter translations may be than those that pieces of yaw are judged by, m."""

FINE_M = 1e-8
"""The same for the answer's own translation, m."""

_PIECES = 64
_ROUNDS = 60
_SECTIONS = 24
_GOLDEN = (5**0.5 - 1) / 2
Shift = Callable[[FloatArray, float], FloatArray]


def least_moves(shift_of: Shift, targets: FloatArray, weight: float) -> FloatArray:
    """Return the least weighted moves for targets, shape (..., 3), m.

    Parameters
    ----------
    shift_of : callable
        Gives translations (n, 3) for targets (n, 3), of which none is shorter by more than
        its second argument (m); NaN where none helps. The shortest lengths must change by no
        more than the targets move, as distances to a set do.
    targets : ndarray, shape (..., 3), m
        Points in the base frame.
    weight : float, m
        What a radian of yaw costs.

    Returns
    -------
    ndarray, shape (..., 4)
        x, y, z (m) and yaw (rad); NaN where no move helps.
    """
    moves = [_least(shift_of, target, weight) for target in targets.reshape(-1, 3)]
    return np.array(moves).reshape(*targets.shape[:-1], 4)


def turned(target: FloatArray, yaw: FloatArray) -> FloatArray:
    """Return a target, shape (3,), as bases that have turned by yaws (n,) see it, (n, 3)."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y, z = target
    return np.stack([c * x + s * y, c * y - s * x, np.full_like(c, z)], axis=-1)


def _least(shift_of: Shift, target: FloatArray, weight: float) -> FloatArray:
    """Branch and bound over the yaw, then a finer look about the best."""
    best: FloatArray = np.full(4, np.nan)
    if not np.isfinite(target).all():
        return best
    radius = float(np.hypot(target[0], target[1]))
    least = np.inf

    def tried(yaw: FloatArray, within: float) -> FloatArray:
        """Return how long the shifts at some yaws are; keep the cheapest move."""
        nonlocal best, least
        shifts = shift_of(turned(target, yaw), within)
        lengths: FloatArray = np.sqrt((shifts * shifts).sum(axis=1))
        costs = np.hypot(lengths, weight * yaw)
        if np.isfinite(costs).any():
            i = int(np.nanargmin(costs))
            if costs[i] < least:
                least, best = float(costs[i]), np.array([*shifts[i], yaw[i]])
        return lengths

    if tried(np.zeros(1), FINE_M)[0] == 0.0 or not np.isfinite(least):
        # In reach as it is; or never, as a turn leaves the height alone.
        return best
    half = np.pi / _PIECES
    middles = np.asarray(half * (2 * np.arange(_PIECES) + 1) - np.pi, dtype=np.float64)
    for _ in range(_ROUNDS):
        lengths = tried(middles, COARSE_M) - COARSE_M
        # The target moves by no more than `radius * half` within a piece.
        nearest = np.maximum(np.abs(middles) - half, 0.0)
        bounds = np.hypot(np.maximum(lengths - radius * half, 0.0), weight * nearest)
        left = middles[bounds < least - PROVEN_M]
        if not len(left):
            break
        half /= 2
        middles = np.concatenate([left - half, left + half]).astype(np.float64)
    # Downhill from the best, by the golden section.
    low, high = best[3] - 2 * half, best[3] + 2 * half
    for _ in range(_SECTIONS):
        inner = np.array([high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)])
        one, two = np.hypot(tried(inner, FINE_M), weight * inner)
        low, high = (low, inner[1]) if one <= two else (inner[0], high)
    return best
