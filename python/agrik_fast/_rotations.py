"""Rotation matrices from numbers as they come: what is no rotation becomes NaN, not an error.

`agrik_fast.rotations` is the public module, which checks its arguments.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ._checks import FloatArray

# Quaternions printed with four decimals have lengths within 1e-3 of one; anything
# farther off is no rotation, and its row becomes NaN so that it ends as bad_input.
QUATERNION_LENGTH_TOLERANCE = 1e-3
# Entries of R^T R - I: loose enough for float32 files, tight enough to catch scale or shear.
# The compiled core refuses by the same number and the same operations, so that what passes
# here passes there.
RIGID_TOLERANCE = 1e-6


def from_quaternion(xyzw: FloatArray) -> FloatArray:
    """Rotation of unit quaternions.

    Parameters
    ----------
    xyzw : ndarray, shape (..., 4)
        Quaternions, scalar last as in ROS and SciPy; rounding is normalised away.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        NaN where the quaternion is not finite or its length is not one.
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        length = np.linalg.norm(xyzw, axis=-1, keepdims=True)
        unit_length = np.abs(length - 1.0) <= QUATERNION_LENGTH_TOLERANCE
        unit = np.where(unit_length, xyzw / length, np.nan)
    x, y, z, w = np.moveaxis(unit, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return _matrices(rows)


def from_zyz(angles: FloatArray) -> FloatArray:
    """Rotation Rz(alpha) Ry(beta) Rz(gamma).

    Parameters
    ----------
    angles : ndarray, shape (..., 3), rad
        alpha, beta, gamma.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    (ca, cb, cg), (sa, sb, sg) = _cosines_and_sines(angles)
    rows = [
        [ca * cb * cg - sa * sg, -ca * cb * sg - sa * cg, ca * sb],
        [sa * cb * cg + ca * sg, -sa * cb * sg + ca * cg, sa * sb],
        [-sb * cg, sb * sg, cb],
    ]
    return _matrices(rows)


def from_rpy(angles: FloatArray) -> FloatArray:
    """Rotation Rz(yaw) Ry(pitch) Rx(roll): fixed axes, as in URDF.

    Parameters
    ----------
    angles : ndarray, shape (..., 3), rad
        roll, pitch, yaw.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    (cr, cp, cy), (sr, sp, sy) = _cosines_and_sines(angles)
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return _matrices(rows)


def from_axis_angle(vectors: FloatArray) -> FloatArray:
    """Rotation by rotation vectors, by Rodrigues' formula.

    Parameters
    ----------
    vectors : ndarray, shape (..., 3), rad
        Axes, of the angles' lengths.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    with np.errstate(invalid="ignore"):
        angle = np.linalg.norm(vectors, axis=-1)
        half = np.sinc(angle / (2 * np.pi))  # sin(angle / 2) / (angle / 2), 1 for no turn
        # 1 + s K + c K^2 with the cross-product matrix K of the vector itself.
        s, c = np.sinc(angle / np.pi), 0.5 * half * half
        x, y, z = np.moveaxis(vectors, -1, 0)
        rows = [
            [1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y],
            [c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x],
            [c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y)],
        ]
    return _matrices(rows)


def _cosines_and_sines(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the cosines and the sines, the last axis first."""
    with np.errstate(invalid="ignore"):
        return np.moveaxis(np.cos(angles), -1, 0), np.moveaxis(np.sin(angles), -1, 0)


def _matrices(rows: Sequence[Sequence[FloatArray]]) -> FloatArray:
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def transforms(position: FloatArray, rotation: FloatArray) -> FloatArray:
    """Homogeneous transforms, shape (..., 4, 4), of points (..., 3), m, and rotations."""
    leading = np.broadcast_shapes(position.shape[:-1], rotation.shape[:-2])
    out = np.zeros((*leading, 4, 4))
    out[..., :3, :3] = rotation
    out[..., :3, 3] = position
    out[..., 3, 3] = 1.0
    return out


def are_rotations(rotation: FloatArray) -> NDArray[np.bool_]:
    """Return whether matrices, shape (..., 3, 3), are rotations; shape (...)."""
    rows = rotation.reshape(-1, 3, 3)
    x, y, z = (np.ascontiguousarray(rows[:, :, k].T) for k in range(3))
    with np.errstate(invalid="ignore", over="ignore"):
        rigid = _right_handed_orthonormal(x, y, z)
    return rigid.reshape(rotation.shape[:-2])


def _right_handed_orthonormal(x: FloatArray, y: FloatArray, z: FloatArray) -> NDArray[np.bool_]:
    """Return whether three axes, each of shape (3, n), are those of a rotation."""
    off = [np.abs(_dot(a, b)) for a, b in ((x, y), (y, z), (z, x))]
    off += [np.abs(_dot(a, a) - 1.0) for a in (x, y, z)]
    # What is no number is not within the tolerance either.
    within = [distance <= RIGID_TOLERANCE for distance in off]
    rigid: NDArray[np.bool_] = np.logical_and.reduce(within)
    cross = (
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    )
    rigid &= _dot(cross, z) > 0.0
    return rigid


def _dot(a: Sequence[FloatArray] | FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product
