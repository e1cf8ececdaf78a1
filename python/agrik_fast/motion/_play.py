"""Play in joints whose directions are known: where a joint stands behind where it is told.

A joint that is driven in one direction stands half its play behind; where the direction turns it
stays until all of the play is taken up. Where it stands is the play operator of hysteresis:
it stays as it is unless it would be farther off than half the play.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array
from ._case import Case

__all__ = ["Intervals", "followed", "half_play", "moved_last", "stands"]

# Rounding where a joint does not move, rad.
_NOTHING = 1e-12

Intervals = tuple[FloatArray, FloatArray, FloatArray]
"""Middles and half widths of intervals, and the play of which nothing is known, (m, dof) each."""


def half_play(case: Case) -> FloatArray:
    """Return half the play of each joint, shape (dof,), rad."""
    return np.where(case.slides, 0.0, 0.5 * case.errors.backlash)


def moved_last(case: Case, moving: ArrayLike | None) -> FloatArray | None:
    """Return the signs of the directions in which joints moved last, shape (dof,)."""
    return None if moving is None else np.sign(finite_array("moving", moving, (case.arm.dof,)))


def stands(case: Case, q: FloatArray, signs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where joints stand at a posture, and the play of which nothing is known."""
    half = half_play(case)
    return q - half * signs, np.where(signs == 0, 2 * half, 0.0)


def followed(
    case: Case,
    middles: FloatArray,
    reach: FloatArray,
    ends: FloatArray,
    start: FloatArray,
    signs: FloatArray,
) -> Intervals:
    """Return where joints stand on intervals, one after the other, that they are told.

    `ends`, shape (m, dof), is where each interval ends, `start` where the first begins, `signs`
    the directions before that. Of a joint that nothing has moved since
    its direction was unknown, play counts as even; while only a part of the play is taken up it
    stands anywhere in the rest, and the interval is wider by that.
    """
    half = half_play(case)
    known = signs != 0
    low = np.where(known, start - half * signs, start - half)
    high = np.where(known, start - half * signs, start + half)
    still = ~known & (half > 0)
    out_middles, out_reach = middles.copy(), reach.copy()
    play = np.zeros_like(middles)
    for k, (middle, width, end) in enumerate(zip(middles, reach, ends, strict=True)):
        least, most = middle - width, middle + width
        low, high = np.minimum(low, least + half), np.maximum(high, most - half)
        # A joint that is not told to move does not leave its place in the play.
        still &= (width == 0) & (np.abs(middle - start) < _NOTHING)
        places = ~still & (half > 0)
        out_middles[k] = np.where(places, 0.5 * (low + high), middle)
        out_reach[k] = np.where(places, np.maximum(0.5 * (high - low), 0.0), width)
        play[k] = np.where(still, 2 * half, 0.0)
        low, high = np.maximum(low, end - half), np.minimum(high, end + half)
    return out_middles, out_reach, play
