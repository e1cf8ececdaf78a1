"""What a picture may be: every function that takes one says so in the same words."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._checks import shown
from ..errors import ArgumentError

Image = NDArray[np.uint8]
"""A picture: shape (height, width, 3), uint8, in the order blue, green, red."""

SMALLEST = 16
"""Pixels that a picture has at least in either direction."""

_EXPECTED = (
    "a colour picture, uint8 in the order blue, green, red, shape (height, width, 3), "
    f"at least {SMALLEST} pixels high and wide"
)


def checked_image(argument: str, value: object) -> Image:
    """Return `value` if it is a picture.

    Raises
    ------
    ArgumentError
        It is grey, of floats, empty, tiny or no array; the message says what is expected.
    """
    if not isinstance(value, np.ndarray):
        raise ArgumentError(argument, shown(value), _EXPECTED)
    if value.dtype != np.uint8:
        raise ArgumentError(argument, f"an array of {value.dtype}", _EXPECTED)
    if value.ndim == 2:
        raise ArgumentError(argument, f"a grey picture, shape {value.shape}", _EXPECTED)
    if value.ndim != 3 or value.shape[2] != 3 or min(value.shape[:2]) < SMALLEST:
        raise ArgumentError(argument, f"shape {value.shape}", _EXPECTED)
    return value


def same_size(argument: str, image: Image, width: int, height: int) -> None:
    """Refuse a picture of another size than the camera's calibration.

    Raises
    ------
    ArgumentError
        It is.
    """
    if image.shape[:2] != (height, width):
        raise ArgumentError(
            argument,
            f"{image.shape[1]} x {image.shape[0]} pixels",
            f"{width} x {height} pixels as the camera's calibration "
            "(`Camera.scaled` where the camera bins or scales its pictures)",
        )


_KindT = TypeVar("_KindT")


def of_kind(argument: str, value: object, kind: type[_KindT]) -> _KindT:
    """Return `value` if it is an object of a class.

    Raises
    ------
    ArgumentError
        It is none.
    """
    if not isinstance(value, kind):
        raise ArgumentError(argument, shown(value), f"a vision.{kind.__name__}")
    return value


def array_of(argument: str, value: object, kinds: str, expected: str) -> NDArray[Any]:
    """Return `value` as an array of one of several kinds of numbers, NumPy's letters.

    Raises
    ------
    ArgumentError
        It is none.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        raise ArgumentError(argument, "rows of unequal length", expected) from None
    if array.dtype.kind not in kinds:
        raise ArgumentError(argument, f"an array of {array.dtype}", expected)
    return array
