"""SplitMix64: a random stream that is the same everywhere and can be entered anywhere.

Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._checks import FloatArray

_MASK = 2**64 - 1
_GAMMA = 0x9E3779B97F4A7C15


def uniform(seed: int, first: int, count: int) -> FloatArray:
    """Return numbers of a stream, in [0, 1) with 53 random bits.

    Parameters
    ----------
    seed : int
        0 to 2**64 - 1.
    first : int
        Index of the first number within the stream, >= 0.
    count : int
        How many, >= 0.

    Returns
    -------
    ndarray, shape (count,)
    """
    start = np.uint64((seed + (first + 1) * _GAMMA) & _MASK)
    z: NDArray[np.uint64] = np.arange(count, dtype=np.uint64) * np.uint64(_GAMMA) + start
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z ^= z >> np.uint64(31)
    return (z >> np.uint64(11)).astype(np.float64) * 2.0**-53
