"""Poses from quaternions, roll-pitch-yaw, ZYZ and axis-angle, back again, and straightened.

All functions take any leading dimensions. A row that holds NaN or infinity gives NaN and no
error, so that in a batch of targets it ends as ``Status.BAD_INPUT`` and the rows around it
are solved; everything else that is no rotation raises.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _rotations
from ._checks import FloatArray, float_array, real_number
from .errors import ArgumentError

__all__ = [
    "EulerAngles",
    "Straightened",
    "axis_angle_of",
    "pose",
    "position_of",
    "quat_of",
    "rotation_of",
    "rpy_of",
    "straighten",
    "zyz_differences",
    "zyz_of",
]

GIMBAL_SINE = 1e-9
"""Below this sine of the middle angle the outer two turn about the same axis."""

_NUMBERS = {"quat": 4, "rpy": 3, "zyz": 3, "axis_angle": 3}
"""How many numbers each form of an orientation has."""


class EulerAngles(NamedTuple):
    """Three angles of rotations.

    Attributes
    ----------
    angles : ndarray, shape (..., 3), rad
        In the order in which `pose` takes them.
    gimbal : ndarray of bool, shape (...)
        True where only the sum (or difference) of the first and the last angle is
        determined; one of the two is 0 there by agreement.

    Examples
    --------
    >>> angles, singular = ik.rotations.zyz_of(np.eye(3))
    >>> bool(singular)
    True
    """

    angles: FloatArray
    gimbal: NDArray[np.bool_]


class Straightened(NamedTuple):
    """What `straighten` returns.

    Attributes
    ----------
    pose : ndarray, shape (..., 4, 4) or (..., 3, 3)
        The nearest rigid transforms or rotations; NaN where `reason` is not "ok".
    off : ndarray, shape (...)
        How far the matrix was from a rotation: the largest part by which it stretched or
        shrank a length; no unit. NaN where it is not finite.
    reason : ndarray of str, shape (...)
        "ok"; "not finite"; "last row" (not 0, 0, 0, 1); "mirrored" (left-handed axes);
        "too far" (`off` is above the tolerance, or an axis is lost).

    Examples
    --------
    >>> found = ik.rotations.straighten([[0.87, -0.5, 0.0], [0.5, 0.87, 0.0], [0.0, 0.0, 1.0]])
    >>> found.pose.shape, bool(found.off < 0.01)
    ((3, 3), True)
    """

    pose: FloatArray
    off: FloatArray
    reason: NDArray[np.str_]


def pose(
    xyz: ArrayLike,
    *,
    quat: ArrayLike | None = None,
    rpy: ArrayLike | None = None,
    zyz: ArrayLike | None = None,
    axis_angle: ArrayLike | None = None,
) -> FloatArray:
    """Return poses of positions and, at most, one form of orientation.

    Parameters
    ----------
    xyz : array_like, shape (..., 3), m
        Positions.
    quat : array_like, shape (..., 4), optional
        Unit quaternions x, y, z, w: scalar last, as in ROS and SciPy. Lengths within 1e-3
        of one are normalised.
    rpy : array_like, shape (..., 3), rad, optional
        Roll, pitch, yaw about the fixed axes x, y, z in turn, as in URDF:
        R = Rz(yaw) Ry(pitch) Rx(roll).
    zyz : array_like, shape (..., 3), rad, optional
        Euler angles alpha, beta, gamma: R = Rz(alpha) Ry(beta) Rz(gamma).
    axis_angle : array_like, shape (..., 3), rad, optional
        Rotation vectors: the axis, of the angle's length.

    Returns
    -------
    ndarray, shape (..., 4, 4)
        Rigid transforms, lengths in m; of rotation 1 without an orientation. The leading
        dimensions of positions and orientations are broadcast.

    Raises
    ------
    ArgumentError
        A wrong shape, two orientations, or a quaternion whose length is not one.

    Examples
    --------
    >>> from agrik_fast.rotations import pose
    >>> pose([0.3, 0.0, 0.5], rpy=[0.0, 0.0, np.pi / 2])[:3, :3].round(6) + 0.0
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    forms = {"quat": quat, "rpy": rpy, "zyz": zyz, "axis_angle": axis_angle}
    given = [(name, value) for name, value in forms.items() if value is not None]
    point = _last_axis("xyz", xyz, 3)
    if not given:
        return _rotations.transforms(point, np.eye(3))
    if len(given) > 1:
        names = " and ".join(name for name, _ in given)
        raise ArgumentError(given[1][0], names, "at most one orientation")
    ((name, value),) = given
    numbers = _last_axis(name, value, _NUMBERS[name])
    if name == "quat":
        _check_lengths(numbers)
    make = {
        "quat": _rotations.from_quaternion,
        "rpy": _rotations.from_rpy,
        "zyz": _rotations.from_zyz,
        "axis_angle": _rotations.from_axis_angle,
    }[name]
    try:
        return _rotations.transforms(point, make(numbers))
    except ValueError:
        expected = f"leading dimensions that broadcast with those of xyz, {point.shape[:-1]}"
        raise ArgumentError(name, f"shape {numbers.shape}", expected) from None


def position_of(poses: ArrayLike) -> FloatArray:
    """Return the positions, shape (..., 3), m, of poses, shape (..., 4, 4).

    Examples
    --------
    >>> ik.rotations.position_of(ik.rotations.pose([0.1, 0.2, 0.3]))
    array([0.1, 0.2, 0.3])
    """
    matrices = float_array("poses", poses)
    if matrices.ndim < 2 or matrices.shape[-2:] != (4, 4):
        raise ArgumentError("poses", f"shape {matrices.shape}", "shape (..., 4, 4)")
    return matrices[..., :3, 3].copy()


def rotation_of(poses: ArrayLike) -> FloatArray:
    """Return the rotation matrices of poses, unchanged.

    Parameters
    ----------
    poses : array_like, shape (..., 4, 4) or (..., 3, 3)
        Rigid transforms, or rotation matrices.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ArgumentError
        Another shape.

    Examples
    --------
    >>> ik.rotations.rotation_of(ik.rotations.pose([0.1, 0.2, 0.3]))
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    matrices = float_array("poses", poses)
    if matrices.ndim < 2 or matrices.shape[-2:] not in ((3, 3), (4, 4)):
        expected = "shape (..., 4, 4) or (..., 3, 3)"
        raise ArgumentError("poses", f"shape {matrices.shape}", expected)
    return matrices[..., :3, :3].copy()


def quat_of(poses: ArrayLike) -> FloatArray:
    """Return the unit quaternions of poses or rotations.

    Parameters
    ----------
    poses : array_like, shape (..., 4, 4) or (..., 3, 3)
        Rigid transforms, or rotation matrices.

    Returns
    -------
    ndarray, shape (..., 4)
        x, y, z, w: scalar last, w not negative.

    Raises
    ------
    ArgumentError
        Another shape, or a finite matrix that is no rotation (see `straighten`).

    Examples
    --------
    >>> ik.rotations.quat_of(np.eye(4))
    array([0., 0., 0., 1.])
    """
    r = _checked_rotation(poses)
    trace = np.trace(r, axis1=-2, axis2=-1)
    diagonal = np.diagonal(r, axis1=-2, axis2=-1)
    # The largest of the four squares leads, so that nothing small is divided by.
    squares = np.concatenate([1 - trace[..., None] + 2 * diagonal, 1 + trace[..., None]], axis=-1)
    x, y, z = r[..., 2, 1], r[..., 0, 2], r[..., 1, 0]
    u, v, w = r[..., 1, 2], r[..., 2, 0], r[..., 0, 1]
    products = [
        [squares[..., 0], z + w, v + y, x - u],
        [z + w, squares[..., 1], x + u, y - v],
        [v + y, x + u, squares[..., 2], z - w],
        [x - u, y - v, z - w, squares[..., 3]],
    ]
    table = np.stack([np.stack(row, axis=-1) for row in products], axis=-2)
    # Where a row holds NaN any choice is as good: it stays NaN.
    lead = np.argmax(np.nan_to_num(squares, nan=-1.0), axis=-1)[..., None, None]
    row = np.take_along_axis(table, lead, axis=-2)[..., 0, :]
    unit = row / np.linalg.norm(row, axis=-1, keepdims=True)
    found: FloatArray = np.where(unit[..., 3:] < 0, -unit, unit)
    return found


def axis_angle_of(poses: ArrayLike) -> FloatArray:
    """Return the rotation vectors of poses or rotations.

    Parameters
    ----------
    poses : array_like, shape (..., 4, 4) or (..., 3, 3)
        Rigid transforms, or rotation matrices.

    Returns
    -------
    ndarray, shape (..., 3), rad
        Axes of the angles' lengths; angles in [0, pi].

    Raises
    ------
    ArgumentError
        Another shape, or a finite matrix that is no rotation (see `straighten`).

    Examples
    --------
    >>> turned = ik.rotations.pose([0, 0, 0], axis_angle=[0, 0, 0.5])
    >>> ik.rotations.axis_angle_of(turned).round(6)
    array([0. , 0. , 0.5])
    """
    quat = quat_of(poses)
    sine = np.linalg.norm(quat[..., :3], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, quat[..., 3:])
    # Near the identity the angle is twice the sine.
    small = sine < GIMBAL_SINE
    return quat[..., :3] * np.where(small, 2.0, angle / np.where(small, 1.0, sine))


def rpy_of(poses: ArrayLike) -> EulerAngles:
    """Return roll, pitch and yaw of poses or rotations.

    Parameters
    ----------
    poses : array_like, shape (..., 4, 4) or (..., 3, 3)
        Rigid transforms, or rotation matrices.

    Returns
    -------
    EulerAngles
        Roll and yaw in [-pi, pi], pitch in [-pi/2, pi/2]; roll is 0 where it and yaw turn
        about the same axis.

    Raises
    ------
    ArgumentError
        Another shape, or a finite matrix that is no rotation (see `straighten`).

    Examples
    --------
    >>> turned = ik.rotations.pose([0, 0, 0], rpy=[0.1, 0.2, 0.3])
    >>> np.round(ik.rotations.rpy_of(turned).angles, 6)
    array([0.1, 0.2, 0.3])
    """
    r = _checked_rotation(poses)
    cosine = np.hypot(r[..., 2, 1], r[..., 2, 2])
    gimbal = cosine < GIMBAL_SINE
    pitch = np.arctan2(-r[..., 2, 0], cosine)
    roll = np.where(gimbal, 0.0, np.arctan2(r[..., 2, 1], r[..., 2, 2]))
    yaw = np.where(
        gimbal,
        np.arctan2(-r[..., 0, 1], r[..., 1, 1]),
        np.arctan2(r[..., 1, 0], r[..., 0, 0]),
    )
    return EulerAngles(np.stack([roll, pitch, yaw], axis=-1), gimbal)


def zyz_of(poses: ArrayLike) -> EulerAngles:
    """Return the ZYZ Euler angles of poses or rotations.

    Parameters
    ----------
    poses : array_like, shape (..., 4, 4) or (..., 3, 3)
        Rigid transforms, or rotation matrices.

    Returns
    -------
    EulerAngles
        alpha and gamma in [-pi, pi], beta in [0, pi]; gamma is 0 where it and alpha turn
        about the same axis.

    Raises
    ------
    ArgumentError
        Another shape, or a finite matrix that is no rotation (see `straighten`).

    References
    ----------
    Li et al., equation (3), with the quadrants of ``atan2`` in place of divisions.

    Examples
    --------
    >>> turned = ik.rotations.pose([0, 0, 0], zyz=[0.1, 0.2, 0.3])
    >>> np.round(ik.rotations.zyz_of(turned).angles, 6)
    array([0.1, 0.2, 0.3])
    """
    r = _checked_rotation(poses)
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
    return EulerAngles(np.stack([alpha, beta, gamma], axis=-1), gimbal)


def zyz_differences(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Return a - b of ZYZ angles, shape (..., 3), rad; alpha and gamma wrapped to half a turn.

    Examples
    --------
    >>> ik.rotations.zyz_differences([0.1, 0.2, 0.3], [0.1, 0.2, 0.4]).round(6)
    array([ 0. ,  0. , -0.1])
    """
    first, second = float_array("a", a), float_array("b", b)
    for name, angles in (("a", first), ("b", second)):
        if angles.ndim < 1 or angles.shape[-1] != 3:
            raise ArgumentError(name, f"shape {angles.shape}", "shape (..., 3)")
    try:
        difference = first - second
    except ValueError:
        expected = f"a shape that broadcasts with {first.shape}"
        raise ArgumentError("b", f"shape {second.shape}", expected) from None
    wrapped = np.pi - (np.pi - difference) % (2 * np.pi)
    return np.where(np.array([True, False, True]), wrapped, difference)


def straighten(poses: ArrayLike, *, tolerance: float = 0.02) -> Straightened:
    """Return the rigid transforms that are nearest to rounded or measured ones.

    The rotation is the nearest in the sum of squares of the entries' differences: the
    orthogonal factor of the polar decomposition. Positions stay as they are.

    Parameters
    ----------
    poses : array_like, shape (..., 4, 4) or (..., 3, 3)
        Transforms (lengths in m) or rotation matrices, for example printed with few digits.
    tolerance : float, default 0.02
        Largest part by which a matrix may stretch or shrink a length; no unit, above 0 and
        at most 0.5. Two printed decimals are off by 0.015 at most.

    Returns
    -------
    Straightened
        The transforms, how far each was off, and for each that cannot be straightened the
        reason; these are NaN.

    Raises
    ------
    ArgumentError
        Another shape, or a tolerance out of its range.

    References
    ----------
    Higham, "Computing the polar decomposition, with applications", SIAM Journal on
    Scientific and Statistical Computing 7(4), 1986.

    Examples
    --------
    >>> from agrik_fast.rotations import straighten
    >>> found = straighten([[0.87, -0.5, 0.0], [0.5, 0.87, 0.0], [0.0, 0.0, 1.0]])
    >>> str(found.reason), round(float(found.off), 4)
    ('ok', 0.0034)
    """
    tolerance = real_number("tolerance", tolerance, 0, 0.5, open_low=True)
    given = float_array("poses", poses)
    rough = rotation_of(given)
    finite = np.asarray(np.isfinite(given).all(axis=(-2, -1)))
    u, stretch, vt = np.linalg.svd(np.where(finite[..., None, None], rough, np.eye(3)))
    off = np.where(finite, np.abs(stretch - 1.0).max(axis=-1), np.nan)
    mirrored = np.linalg.det(u) * np.linalg.det(vt) < 0
    last = np.zeros_like(finite)
    if given.shape[-1] == 4:
        bottom = np.abs(given[..., 3, :] - np.array([0.0, 0.0, 0.0, 1.0])).max(axis=-1)
        last = ~(bottom <= _rotations.RIGID_TOLERANCE)
    faults = (~finite, last, off > tolerance, mirrored)
    names = ("not finite", "last row", "too far", "mirrored")
    reason = np.select(faults, names, default="ok")
    straight = np.full(given.shape, np.nan)
    rotation = u @ vt
    good = reason == "ok"
    if given.shape[-1] == 4:
        straight[good] = _rotations.transforms(given[..., :3, 3], rotation)[good]
    else:
        straight[good] = rotation[good]
    return Straightened(straight, off, reason)


def _last_axis(argument: str, value: ArrayLike, size: int) -> FloatArray:
    array = float_array(argument, value)
    if array.ndim < 1 or array.shape[-1] != size:
        raise ArgumentError(argument, f"shape {array.shape}", f"shape (..., {size})")
    return array


def _check_lengths(quat: FloatArray) -> None:
    finite = np.asarray(np.isfinite(quat).all(axis=-1))
    length = np.asarray(np.linalg.norm(np.where(finite[..., None], quat, 0.5), axis=-1))
    wrong = np.abs(length - 1.0) > _rotations.QUATERNION_LENGTH_TOLERANCE
    if wrong.any():
        place = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise ArgumentError(
            f"quat{list(place)}" if place else "quat",
            f"one of length {float(length[place]):.6g}",
            "a quaternion of length one",
        )


def _checked_rotation(poses: ArrayLike) -> FloatArray:
    """Return the rotations of poses, NaN where one is not finite; what is none is refused."""
    rotation = rotation_of(poses)
    finite = np.asarray(np.isfinite(rotation).all(axis=(-2, -1)))
    wrong = finite & ~_rotations.are_rotations(rotation)
    if wrong.any():
        place = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise ArgumentError(
            f"poses{list(place)}" if place else "poses",
            str(rotation[place].tolist()),
            "a rotation (right-handed orthonormal rows; `straighten` mends rounded ones)",
        )
    whole: FloatArray = np.where(finite[..., None, None], rotation, np.nan)
    return whole
