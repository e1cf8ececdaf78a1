"""Rotation matrices from the orientation columns a target file may hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Quaternions printed with four decimals have lengths within 1e-3 of one; anything
# farther off is no rotation, and its row becomes NaN so that it ends as bad_input.
QUATERNION_LENGTH_TOLERANCE = 1e-3
# Entries of R^T R - I: loose enough for float32 files, tight enough to catch scale or shear.
RIGID_TOLERANCE = 1e-5
# Poses checked at a time; their entries and what is made of them stay in a core's cache.
ROWS_IN_CACHE = 4096


def from_quaternion(xyzw: Array) -> Array:
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
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _about(axis: int, angle: Array) -> Array:
    """Rotation by `angle` (rad, shape (...)) about base axis 0, 1 or 2."""
    with np.errstate(invalid="ignore"):
        cosine, sine = np.cos(angle), np.sin(angle)
    out = np.zeros((*angle.shape, 3, 3))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    out[..., axis, axis] = 1.0
    out[..., j, j] = out[..., k, k] = cosine
    out[..., j, k], out[..., k, j] = -sine, sine
    return out


def from_zyz(angles: Array) -> Array:
    """Rotation Rz(alpha) Ry(beta) Rz(gamma) of the redundant7 paper's eq. (3).

    Parameters
    ----------
    angles : ndarray, shape (..., 3), rad
        alpha, beta, gamma.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    alpha, beta, gamma = np.moveaxis(angles, -1, 0)
    return _about(2, alpha) @ _about(1, beta) @ _about(2, gamma)


def from_rpy(angles: Array) -> Array:
    """Rotation Rz(yaw) Ry(pitch) Rx(roll): fixed axes, as in URDF.

    Parameters
    ----------
    angles : ndarray, shape (..., 3), rad
        roll, pitch, yaw.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    roll, pitch, yaw = np.moveaxis(angles, -1, 0)
    return _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)


def transforms(position: Array, rotation: Array) -> Array:
    """Homogeneous transforms, shape (n, 4, 4), of (n, 3) points in m and (n, 3, 3) rotations."""
    out = np.zeros((len(position), 4, 4))
    out[:, :3, :3] = rotation
    out[:, :3, 3] = position
    out[:, 3, 3] = 1.0
    return out


def blank_non_rigid(pose: Array) -> Array:
    """Return the (n, 4, 4) poses with NaN in place of those that are no rigid transform."""
    bad = np.empty(len(pose), dtype=np.bool_)
    for first in range(0, len(pose), ROWS_IN_CACHE):
        rows = slice(first, first + ROWS_IN_CACHE)
        bad[rows] = ~_are_rigid(pose[rows])
    if not bad.any():
        return pose
    return np.where(bad[:, None, None], np.nan, pose)


def _are_rigid(pose: Array) -> NDArray[np.bool_]:
    # One long row for each of the sixteen entries: NumPy's operations on many small
    # matrices cost several times what solving a pose does.
    entries = np.ascontiguousarray(pose.reshape(-1, 16).T)
    x, y, z = (entries[k:12:4] for k in range(3))
    with np.errstate(invalid="ignore", over="ignore"):
        off = [np.abs(_dot(a, b)) for a, b in ((x, y), (y, z), (z, x))]
        off += [np.abs(_dot(a, a) - 1.0) for a in (x, y, z)]
        off += [np.abs(entries[k] - (k == 15)) for k in range(12, 16)]
        # What is no number is not within the tolerance either.
        within = [distance <= RIGID_TOLERANCE for distance in off]
        rigid: NDArray[np.bool_] = np.logical_and.reduce(within)
        cross = (
            x[1] * y[2] - x[2] * y[1],
            x[2] * y[0] - x[0] * y[2],
            x[0] * y[1] - x[1] * y[0],
        )
        rigid &= _dot(cross, z) > 0.0
    rigid &= np.isfinite(entries[3:12:4]).all(axis=0)
    return rigid


def _dot(a: Sequence[Array] | Array, b: Array) -> Array:
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product
