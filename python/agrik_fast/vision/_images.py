"""What a picture may be: every function that takes one says so in the same words."""

from __future__ import annotations

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
