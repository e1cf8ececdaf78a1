"""The part of a closed form's result that is the record of all solvers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._native import IkResult


@dataclass(frozen=True, slots=True)
class Record:
    """Answers of a closed form: the record that all solvers share, and more.

    Attributes
    ----------
    record : IkResult
        What `Robot.ik` would return; its fields are properties of this class too.
    """

    record: IkResult

    @property
    def q(self) -> NDArray[np.float64]:
        """Joint values, shape (..., n), rad or m."""
        return self.record.q

    @property
    def success(self) -> NDArray[np.bool_]:
        """True where the target is reached within the limits, shape (...)."""
        return self.record.success

    @property
    def status(self) -> NDArray[np.uint8]:
        """Codes of `agrik_fast.Status`, shape (...)."""
        return self.record.status

    @property
    def position_error(self) -> NDArray[np.float64]:
        """Distance of the tool point from the target, shape (...), m; infinite for bad input."""
        return self.record.position_error

    @property
    def orientation_error(self) -> NDArray[np.float64]:
        """Zero, as these arms reach points; infinite for bad input; shape (...), rad."""
        return self.record.orientation_error

    @property
    def iterations(self) -> NDArray[np.uint32]:
        """Steps taken, shape (...); 0 for a closed form."""
        return self.record.iterations

    @property
    def restarts(self) -> NDArray[np.uint32]:
        """Attempts after the first, shape (...)."""
        return self.record.restarts
