"""ZYZ Euler angles, in which some papers print poses: R = Rz(alpha) Ry(beta) Rz(gamma)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks import FloatArray, float_array
from .errors import ArgumentError

__all__ = ["ZyzAngles", "pose_from_zyz", "rotation_from_zyz", "zyz_differences", "zyz_from_pose"]

GIMBAL_SINE = 1e-9
"""Below this sine of beta, alpha and gamma turn about the same axis."""


class ZyzAngles(NamedTuple):
    """ZYZ angles of rotations.

    Attributes
    ----------
    angles : ndarray, shape (..., 3), rad
        alpha and gamma in (-pi, pi], beta in [0, pi].
    gimbal : ndarray of bool, shape (...)
        True where only the sum (or difference) of alpha and gamma is determined; gamma is
        0 there by agreement.
    """

    angles: FloatArray
    gimbal: NDArray[np.bool_]


def zyz_from_pose(pose: ArrayLike) -> ZyzAngles:
    """Return the ZYZ angles of poses or rotations.

    Parameters
    ----------
    pose : array_like, shape (..., 4, 4) or (..., 3, 3)
        Rigid transforms, or rotation matrices.

    Returns
    -------
    ZyzAngles
        Angles and gimbal flags.

    Raises
    ------
    ArgumentError
        Another shape.

    References
    ----------
    Li et al., equation (3), with the quadrants of ``atan2`` in place of divisions.
    """
    r = float_array("pose", pose)
    if r.ndim < 2 or r.shape[-2:] not in ((3, 3), (4, 4)):
        raise ArgumentError("pose", f"shape {r.shape}", "shape (..., 4, 4) or (..., 3, 3)")
    sine = np.hypot(r[..., 2, 0], r[..., 2, 1])
    gimbal = sine < GIMBAL_SINE
    sign = np.where(r[..., 2, 2] < 0, -1.0, 1.0)
    beta = np.arctan2(sine, r[..., 2, 2])
    alpha = np.where(
        gimbal,
        np.arctan2(sign * r[..., 1, 0], sign * r[..., 0, 0]),
        np.arctan2(r[..., 1, 2], r[..., 0, 2]),
    )
    gamma = np.where(gimbal, 0.0, np.arctan2(r[..., 2, 1], -r[..., 2, 0]))
    return ZyzAngles(np.stack([alpha, beta, gamma], axis=-1), gimbal)


def rotation_from_zyz(angles: ArrayLike) -> FloatArray:
    """Return rotation matrices, shape (..., 3, 3), of ZYZ angles, shape (..., 3), rad."""
    given = float_array("angles", angles)
    if given.ndim < 1 or given.shape[-1] != 3:
        raise ArgumentError("angles", f"shape {given.shape}", "shape (..., 3)")
    (ca, cb, cg) = np.moveaxis(np.cos(given), -1, 0)
    (sa, sb, sg) = np.moveaxis(np.sin(given), -1, 0)
    rows = [
        [ca * cb * cg - sa * sg, -ca * cb * sg - sa * cg, ca * sb],
        [sa * cb * cg + ca * sg, -sa * cb * sg + ca * cg, sa * sb],
        [-sb * cg, sb * sg, cb],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def pose_from_zyz(position: ArrayLike, angles: ArrayLike) -> FloatArray:
    """Return poses, shape (..., 4, 4), of positions (..., 3), m, and ZYZ angles, rad."""
    rotation = rotation_from_zyz(angles)
    point = float_array("position", position)
    if point.ndim < 1 or point.shape[-1] != 3:
        raise ArgumentError("position", f"shape {point.shape}", "shape (..., 3)")
    pose = np.zeros((*np.broadcast_shapes(point.shape[:-1], rotation.shape[:-2]), 4, 4))
    pose[..., :3, :3] = rotation
    pose[..., :3, 3] = point
    pose[..., 3, 3] = 1.0
    return pose


def zyz_differences(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Return a - b of ZYZ angles, shape (..., 3), rad; alpha and gamma wrapped to half a turn."""
    difference = float_array("a", a) - float_array("b", b)
    wrapped = np.pi - (np.pi - difference) % (2 * np.pi)
    return np.where(np.array([True, False, True]), wrapped, difference)
