"""A way through joint values: what the time law takes."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from .._tables import Postures, joint_columns

__all__ = ["JointPath"]


@dataclass(frozen=True, slots=True, eq=False)
class JointPath(Postures):
    """Postures in a row and how to go from one to the next.

    Parameters
    ----------
    q : ndarray, shape (n, dof), rad or m
        Joint values. Only reached postures are in it: where a target of the tool was not
        reached, the path ends before it.
    lengths : ndarray, shape (n - 1,)
        Length of each segment: m of the tool's way (rad where it only turns) for paths of the
        tool, seconds at full speed of the joint that takes longest for paths of the joints.
    blends : ndarray, shape (n,), or None
        How far before and behind each posture its corner is rounded, in the measure of
        `lengths`; 0 rests there. None: one smooth curve through all of them.
    of_tool : bool
        True where `lengths` are those of the tool's way.
    success : bool
        True if every target was reached without a jump.
    status : ndarray of uint8, shape (targets,)
        Codes of `agrik_fast.Status`, of paths of the tool; empty otherwise.
    discontinuity : ndarray of bool, shape (targets,)
        True where no continuation was found.

    Examples
    --------
    >>> import agrik_fast as ik
    >>> arm = ik.Robot.load("ur5")
    >>> path = arm.joint_path([arm.home, arm.home + 0.3])
    >>> len(path), path.success
    (2, True)
    """

    q: FloatArray
    lengths: FloatArray
    blends: FloatArray | None
    of_tool: bool = False
    success: bool = True
    status: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, dtype=np.uint8))
    discontinuity: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    @property
    def _rows(self) -> FloatArray:
        return self.q

    def to_dict(self) -> dict[str, Any]:
        """Return the arrays by their names.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> list(arm.joint_path([arm.home, arm.home + 0.3]).to_dict())[:3]
        ['q', 'lengths', 'blends']
        """
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def _columns(self) -> dict[str, Any]:
        # A length is that of the way from a posture to the next: the last one has none.
        columns = {**joint_columns("q", self.q), "length": np.append(self.lengths, np.nan)}
        return columns if self.blends is None else {**columns, "blend": self.blends}

    def __repr__(self) -> str:
        kind = "smooth" if self.blends is None else "with corners"
        done = "" if self.success else f", the {len(self.status)} targets not all reached"
        return f"JointPath({len(self.q)} postures, {kind}{done})"
