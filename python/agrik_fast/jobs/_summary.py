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

    Examples
    --------
    >>> from agrik_fast.jobs import SolveRequest, solve_file
    >>> from pathlib import Path
    >>> np.save("points.npy", [[0.4, 0.2, 0.3], [9.0, 0.0, 0.0]])
    >>> paths = Path("points.npy"), Path("joints.csv")
    >>> summary = solve_file(SolveRequest("ur5", *paths, force=True))
    >>> {status.name: count for status, count in summary.counts.items() if count}
    {'CONVERGED': 1, 'OUT_OF_REACH': 1}
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
        """Count a chunk; errors are those of solved rows only.

        Examples
        --------
        >>> from agrik_fast.jobs import SolveRequest, Summary, solve_file
        >>> from pathlib import Path
        >>> from agrik_fast.io import read_results
        >>> np.save("points.npy", [[0.4, 0.2, 0.3]])
        >>> _ = solve_file(SolveRequest("ur5", Path("points.npy"), Path("a.csv")))
        >>> summary = Summary("ur5", "position", with_orientation=False)
        >>> summary.add(read_results("a.csv")[1])
        >>> summary.rows
        1
        """
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
        """Return median (to 1 %) and worst position error of the solved rows, m; NaN if none.

        Examples
        --------
        >>> from agrik_fast.jobs import Summary
        >>> median, worst = Summary("ur5", "pose", with_orientation=True).position_error()
        >>> bool(np.isnan(median))
        True
        """
        return self._position.median(), self._position.largest()

    def orientation_error(self) -> tuple[float, float]:
        """Return median (to 1 %) and worst angle of the solved rows, rad; NaN if none.

        Examples
        --------
        >>> from agrik_fast.jobs import Summary
        >>> median, worst = Summary("ur5", "pose", with_orientation=True).orientation_error()
        >>> bool(np.isnan(worst))
        True
        """
        return self._orientation.median(), self._orientation.largest()
