"""Targets as other libraries hold them, as arrays that the core takes.

What is looked for is what an object can do (``as_matrix``, ``__dlpack__``, ...), so that none of
those libraries is imported here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _rotations
from .._checks import FloatArray, float_array, shown, word
from ..errors import ArgumentError

__all__ = ["INVALID", "ORDERS", "Invalid", "Order", "as_targets"]

Invalid: TypeAlias = Literal["mark", "raise", "straighten"]
"""What becomes of poses that are no rigid transforms."""
INVALID: tuple[Invalid, ...] = ("mark", "raise", "straighten")


Order: TypeAlias = Literal["xyz_xyzw", "xyz_wxyz", "xyzw_xyz", "wxyz_xyz"]
"""Order of the seven numbers of a pose: the place, and the quaternion's x, y, z, w."""

ORDERS: dict[str, tuple[slice, list[int]]] = {
    "xyz_xyzw": (slice(0, 3), [3, 4, 5, 6]),
    "xyz_wxyz": (slice(0, 3), [4, 5, 6, 3]),
    "xyzw_xyz": (slice(4, 7), [0, 1, 2, 3]),
    "wxyz_xyz": (slice(4, 7), [1, 2, 3, 0]),
}
"""Where the place is in each order, and where x, y, z, w of the quaternion are."""

# How far a quaternion's length may be from 1, by what becomes of invalid targets.
_LENGTHS = {"mark": 1e-3, "straighten": 0.02, "raise": _rotations.RIGID_TOLERANCE}
_ON_THE_CPU = (1, 3, 11, 13)
"""DLPack's numbers of devices whose memory the processor can read."""


def as_targets(targets: Any, order: str | None, invalid: str) -> ArrayLike:
    """Return targets as an array, or as they are where NumPy can read them.

    Parameters
    ----------
    targets : array_like or object
        Arrays of any library with DLPack or ``__array__``; rows of seven numbers with `order`;
        poses as objects of SciPy, spatialmath or Pinocchio, or a list of them; a pair of places
        and SciPy's `Rotation`.
    order : str, optional
        Order of the numbers of rows of seven.
    invalid : str
        What becomes of quaternions whose length is not one, as for `Robot.ik`.

    Raises
    ------
    ArgumentError
        Tensors on another device or with gradients, shapes that do not go together; with
        ``invalid="raise"`` a quaternion whose length is not one.
    """
    made = _numbers(targets)
    if order is None:
        return cast("ArrayLike", made)
    word("order", order, ORDERS)
    rows = float_array("targets", made)
    if rows.ndim == 0 or rows.shape[-1] != 7:
        raise ArgumentError(
            "targets", f"shape {rows.shape}", "shape (..., 7), as there is an order"
        )
    return _poses(rows, order, invalid)


def _poses(rows: FloatArray, order: str, invalid: str) -> FloatArray:
    place, turn = ORDERS[order]
    quaternions = rows[..., turn]
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.linalg.norm(quaternions, axis=-1, keepdims=True)
        off = np.abs(length - 1.0)
    wrong = np.isfinite(quaternions).all(axis=-1) & ~(off[..., 0] <= _LENGTHS[invalid])
    if invalid == "raise" and wrong.any():
        at = tuple(int(k) for k in np.argwhere(wrong)[0])
        index = f"[{', '.join(map(str, at))}]" if at else ""
        received = f"a quaternion of length {float(length[*at, 0]):.6g}"
        raise ArgumentError(f"targets{index}", received, "a quaternion of length 1")
    with np.errstate(invalid="ignore", divide="ignore"):
        unit = np.where(wrong[..., None], np.nan, quaternions / length)
    return _rotations.transforms(rows[..., place], _rotations.from_quaternion(unit))


def _numbers(targets: Any) -> Any:
    """Return what NumPy can make numbers of."""
    if isinstance(targets, np.ndarray):
        return targets
    if hasattr(targets, "as_matrix"):
        return _rigid(targets)
    if isinstance(targets, Sequence) and not isinstance(targets, str) and len(targets):
        return _sequence(targets)
    if hasattr(targets, "__dlpack__"):
        return _tensor(targets)
    return _matrix(targets)


def _sequence(targets: Sequence[Any]) -> Any:
    if _is_spatialmath(targets):
        return _matrix(targets)
    if len(targets) == 2:
        for places, turns in (targets, reversed(targets)):
            if hasattr(turns, "as_matrix") and not hasattr(places, "as_matrix"):
                return _placed(_numbers(places), turns.as_matrix())
    first = targets[0]
    plain = isinstance(first, float | int | Sequence | np.ndarray) and not _is_spatialmath(first)
    if plain or not isinstance(_numbers(first), np.ndarray):
        return targets
    return np.stack([np.asarray(_numbers(one)) for one in targets])


def _placed(places: Any, turns: NDArray[np.float64]) -> FloatArray:
    points = float_array("targets", places)
    if points.ndim == 0 or points.shape[-1] != 3 or turns.shape[-2:] != (3, 3):
        received = f"places of shape {points.shape} and rotations of shape {turns.shape}"
        raise ArgumentError("targets", received, "places of shape (..., 3), and rotations")
    try:
        return _rotations.transforms(points, turns)
    except ValueError:
        received = f"{points.shape[:-1]} places and {turns.shape[:-2]} rotations"
        raise ArgumentError("targets", received, "as many places as rotations, or one") from None


def _rigid(targets: Any) -> Any:
    made = np.asarray(targets.as_matrix())
    if made.shape[-2:] == (4, 4):
        return made
    raise ArgumentError(
        "targets", shown(targets), "a pair: places of shape (..., 3), and rotations"
    )


def _is_spatialmath(value: Any) -> bool:
    return hasattr(value, "A") and hasattr(value, "isSE")


def _matrix(targets: Any) -> Any:
    """Return the matrix of a pose that is an object; else the value itself."""
    if _is_spatialmath(targets):
        # One matrix, or a list of them.
        return np.asarray(targets.A)
    if hasattr(targets, "homogeneous") and not hasattr(targets, "__array__"):
        return np.asarray(targets.homogeneous)
    return targets


def _tensor(tensor: Any) -> NDArray[Any]:
    if getattr(tensor, "requires_grad", False):
        expected = "one without: .detach(), or agrik_fast.torch.ik, which passes gradients on"
        raise ArgumentError("targets", "a tensor that requires gradients", expected)
    try:
        device = int(tensor.__dlpack_device__()[0])
        if device in _ON_THE_CPU:
            return np.from_dlpack(tensor)
    except (BufferError, RuntimeError, TypeError, ValueError) as error:
        detail = " ".join(str(error).split())[:120]
        received = f"a tensor that cannot be read ({detail})"
        raise ArgumentError("targets", received, "numbers in the processor's memory") from None
    raise ArgumentError("targets", "a tensor on another device", "one on the CPU, such as .cpu()")
