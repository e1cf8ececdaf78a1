"""ZYZ Euler angles; the former names of what `agrik_fast.rotations` does for all forms."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ._checks import FloatArray
from .rotations import EulerAngles, pose, rotation_of, zyz_differences, zyz_of

__all__ = ["ZyzAngles", "pose_from_zyz", "rotation_from_zyz", "zyz_differences", "zyz_from_pose"]

ZyzAngles = EulerAngles
zyz_from_pose = zyz_of


def rotation_from_zyz(angles: ArrayLike) -> FloatArray:
    """Return rotation matrices, shape (..., 3, 3), of ZYZ angles, shape (..., 3), rad.

    Examples
    --------
    >>> ik.euler.rotation_from_zyz([0.0, 0.0, 0.0]) + 0.0
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    return rotation_of(pose([0.0, 0.0, 0.0], zyz=angles))


def pose_from_zyz(position: ArrayLike, angles: ArrayLike) -> FloatArray:
    """Return poses, shape (..., 4, 4), of positions (..., 3), m, and ZYZ angles, rad.

    Examples
    --------
    >>> ik.euler.pose_from_zyz([0.1, 0.2, 0.3], [0.0, 0.0, 0.0])[:3, 3]
    array([0.1, 0.2, 0.3])
    """
    return pose(position, zyz=angles)
