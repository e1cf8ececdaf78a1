"""What wrappers for libraries with gradients share: solve, and pull gradients back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._checks import FloatArray

if TYPE_CHECKING:
    from ._native import IkResult
    from .robot import Robot

__all__ = ["as_doubles", "solved", "to_joints", "to_targets"]


def solved(
    robot: Robot, targets: FloatArray, options: dict[str, Any]
) -> tuple[IkResult, FloatArray]:
    """Solve targets and return how their joint values follow them.

    Parameters
    ----------
    robot : Robot
    targets : ndarray, shape (..., 4, 4) or (..., 3)
    options : dict
        As for `Robot.ik`.

    Returns
    -------
    result : IkResult
    follows : ndarray, shape (..., n, 6) or (..., n, 3)
        As of `IkResult.jacobian_of_q`.
    """
    result = robot.ik(targets, **options)
    return result, result.jacobian_of_q()


def to_targets(targets: Any, follows: Any, gradient: Any, numbers: Any) -> Any:
    """Pull a gradient by joint values back to the numbers of the targets.

    Of a pose the turn is that of the rotation nearest to the matrix: a change ``dR`` of it
    turns by ``sum_k r_k x dr_k / 2``, with the columns ``r_k``.

    Parameters
    ----------
    targets : array, shape (..., 4, 4) or (..., 3)
    follows : array, shape (..., n, 6) or (..., n, 3)
    gradient : array, shape (..., n)
    numbers : module
        NumPy, or what works on such arrays as NumPy does.

    Returns
    -------
    array, shape of the targets
    """
    twist = (gradient[..., None] * follows).sum(-2)
    if follows.shape[-1] == 3:
        return twist
    way, turn = twist[..., :3], twist[..., 3:]
    columns = [0.5 * numbers.cross(turn, targets[..., :3, k], axis=-1) for k in range(3)]
    upper = numbers.stack([*columns, way], axis=-1)
    return numbers.concatenate([upper, numbers.zeros_like(upper[..., :1, :])], axis=-2)


def to_joints(robot: Robot, q: FloatArray, poses: FloatArray, gradient: FloatArray) -> FloatArray:
    """Pull a gradient by the numbers of poses back to the joint values.

    Parameters
    ----------
    robot : Robot
    q : ndarray, shape (..., n)
    poses : ndarray, shape (..., 4, 4)
        Of the tool at `q`.
    gradient : ndarray, shape (..., 4, 4)

    Returns
    -------
    ndarray, shape (..., n)
    """
    axes, by_axes = poses[..., :3, :3], gradient[..., :3, :3]
    # A turn w moves an axis r by w x r.
    turn = np.cross(axes, by_axes, axis=-2).sum(axis=-1)
    twist = np.concatenate([gradient[..., :3, 3], turn], axis=-1)
    made: FloatArray = (twist[..., None] * robot.jacobian(q)).sum(axis=-2)
    return made


def as_doubles(array: Any) -> FloatArray:
    """Return an array of any library as a NumPy array of doubles."""
    return np.asarray(array, dtype=np.float64)
