"""What `Robot.follow` returns: a path of postures, each the continuation of the one before."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from .._tables import Postures, joint_columns
from ..result import Status

__all__ = ["Path"]


@dataclass(frozen=True, slots=True, eq=False)
class Path(Postures):
    """Postures along a sequence of n targets.

    Parameters
    ----------
    q : ndarray, shape (n, dof), rad or m
        Joint values. Where a target was not reached the arm stays where it was.
    success : ndarray of bool, shape (n,)
        True where a final FK check met the tolerances and the limits.
    status : ndarray of uint8, shape (n,)
        Codes of `agrik_fast.Status`.
    position_error, orientation_error : ndarray, shape (n,), m, rad
        What is left to the target.
    iterations : ndarray of uint32, shape (n,)
        Steps taken.
    discontinuity : ndarray of bool, shape (n,)
        True where no continuation was found: the posture lies farther from the one before
        than a joint step and no way between the targets leads there, or the target was not
        reached at all. Never for the distance of the first row to `q0`.
    joint_step : ndarray, shape (n, dof), rad or m
        Change of each joint from the posture before; 0 in the first row without a start.
    speed : ndarray, shape (n,)
        The largest share of its step that a joint took from the posture before: above 1 where
        the path is too fast by that factor. 0 in the first row.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> q = np.full(6, 0.5)
    >>> path = arm.follow(arm.fk([q, q + 0.02]), q)
    >>> path.q.shape, bool(path.success.all()), int(path.discontinuity.sum())
    ((2, 6), True, 0)
    """

    q: FloatArray
    success: NDArray[np.bool_]
    status: NDArray[np.uint8]
    position_error: FloatArray
    orientation_error: FloatArray
    iterations: NDArray[np.uint32]
    discontinuity: NDArray[np.bool_]
    joint_step: FloatArray
    speed: FloatArray

    @property
    def too_fast(self) -> NDArray[np.bool_]:
        """Rows to which the path goes on, but faster than `max_joint_step`, shape (n,)."""
        too_fast: NDArray[np.bool_] = (self.speed > 1 + 1e-9) & ~self.discontinuity
        return too_fast

    @property
    def _rows(self) -> FloatArray:
        return self.q

    def to_dict(self) -> dict[str, Any]:
        """Return the arrays by their names.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> path = arm.follow(arm.fk([arm.home, arm.home + 0.02]), arm.home)
        >>> list(path.to_dict())[:3]
        ['q', 'success', 'status']
        """
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def _columns(self) -> dict[str, Any]:
        flat = {name: array for name, array in self.to_dict().items() if array.ndim == 1}
        words = [Status(code).name.lower() for code in self.status.tolist()]
        return {**joint_columns("q", self.q), **flat, "status": words}

    def __repr__(self) -> str:
        count = len(self.q)
        fast = self.too_fast
        said = f", too fast by {self.speed[fast].max():.3g}" if fast.any() else ""
        return (
            f"Path({count} target{'' if count == 1 else 's'}: {int(self.success.sum())} reached, "
            f"{int(self.discontinuity.sum())} discontinuities{said})"
        )
