"""Median and largest of any number of errors, in memory that does not grow with them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Bins whose ends are 1 % apart, over all errors a tolerance can let pass; what is smaller or
# larger counts in the first or the last one.
_RATIO = 1.01
_SMALLEST = 1e-24
_LARGEST = 1e6
_BINS = int(np.ceil(np.log(_LARGEST / _SMALLEST) / np.log(_RATIO)))


class Spread:
    """A histogram of errors over equal steps of their logarithm.

    The median is within 1 % of the true one; the largest error is exact.
    """

    def __init__(self) -> None:
        self._counts = np.zeros(_BINS, dtype=np.int64)
        self._zeros = 0
        self._least = np.inf
        self._most = -np.inf

    def add(self, errors: NDArray[np.float64]) -> None:
        """Count errors, all finite and none negative."""
        if not len(errors):
            return
        self._least = min(self._least, float(errors.min()))
        self._most = max(self._most, float(errors.max()))
        positive = errors[errors > 0.0]
        self._zeros += len(errors) - len(positive)
        steps = np.log(positive / _SMALLEST) / np.log(_RATIO)
        bins = np.clip(steps, 0, _BINS - 1).astype(np.int64)
        self._counts += np.bincount(bins, minlength=_BINS)

    def median(self) -> float:
        """Return the median; NaN if nothing was counted."""
        total = self._zeros + int(self._counts.sum())
        if not total:
            return float("nan")
        return (self._ranked((total - 1) // 2) + self._ranked(total // 2)) / 2.0

    def largest(self) -> float:
        """Return the largest error; NaN if nothing was counted."""
        return self._most if self._most >= 0.0 else float("nan")

    def _ranked(self, rank: int) -> float:
        """Return the error that `rank` others come before, from the middle of its bin."""
        if rank < self._zeros:
            return 0.0
        at = int(np.searchsorted(np.cumsum(self._counts), rank - self._zeros, side="right"))
        middle = _SMALLEST * _RATIO ** (at + 0.5)
        return float(np.clip(middle, self._least, self._most))
