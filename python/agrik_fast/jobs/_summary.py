"""The numbers of a finished batch."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..io import ResultChunk
from ..result import Status
from ._spread import Spread


@dataclass
class Summary:
    """Counts and errors of a batch, gathered chunk by chunk.

    Attributes
    ----------
    label : str
        The robot's name.
    task : str
    with_orientation : bool
        True if the task has an orientation error.
    counts : dict of Status to int
    total_s, solve_s : float
        Seconds in all, and in the solver alone.
    """

    label: str
    task: str
    with_orientation: bool
    counts: dict[Status, int] = field(default_factory=lambda: dict.fromkeys(Status, 0))
    total_s: float = 0.0
    solve_s: float = 0.0
    _position: Spread = field(default_factory=Spread, repr=False)
    _orientation: Spread = field(default_factory=Spread, repr=False)

    def add(self, chunk: ResultChunk) -> None:
        """Count a chunk; errors are those of solved rows only."""
        for status in Status:
            self.counts[status] += int(np.count_nonzero(chunk.status == status))
        self._position.add(chunk.position_error[chunk.success])
        if self.with_orientation:
            self._orientation.add(chunk.orientation_error[chunk.success])

    @property
    def rows(self) -> int:
        """Number of rows."""
        return sum(self.counts.values())

    @property
    def solved(self) -> int:
        """Number of rows within tolerance and limits."""
        return self.counts[Status.CONVERGED]

    @property
    def rate(self) -> float:
        """Rows per second of solver time."""
        return self.rows / self.solve_s if self.solve_s > 0.0 else float("nan")

    def position_error(self) -> tuple[float, float]:
        """Return median (to 1 %) and worst position error of the solved rows, m; NaN if none."""
        return self._position.median(), self._position.largest()

    def orientation_error(self) -> tuple[float, float]:
        """Return median (to 1 %) and worst angle of the solved rows, rad; NaN if none."""
        return self._orientation.median(), self._orientation.largest()
