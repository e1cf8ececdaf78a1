"""Where a picture is red."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._cv import opencv
from ._images import Image, checked_image

__all__ = ["red_mask"]

# OpenCV's hue is 0 to 179.
_RED_BELOW, _RED_ABOVE = 10, 168
_SATURATION, _VALUE = 90, 15


def red_mask(image: Image) -> NDArray[np.uint8]:
    """Return where a picture is red, 255, and where not, 0.

    Hue 0 to 10 or 168 to 179 of 180, saturation >= 90, value >= 15 after a 3 x 3 blur: the shaded
    side of a fruit is dark, red soil is less saturated and more orange. Then small specks are
    removed and small gaps closed.

    Parameters
    ----------
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.

    Examples
    --------
    >>> from agrik_fast.vision import random_scene, red_mask, render
    >>> mask = red_mask(render(random_scene("clean", seed=1)).image)
    >>> mask.shape, sorted(set(mask.ravel().tolist()))
    ((240, 320), [0, 255])
    """
    cv2 = opencv()
    image = checked_image("image", image)
    hsv = cv2.cvtColor(cv2.GaussianBlur(image, (3, 3), 0), cv2.COLOR_BGR2HSV)
    low = cv2.inRange(hsv, (0, _SATURATION, _VALUE), (_RED_BELOW, 255, 255))
    high = cv2.inRange(hsv, (_RED_ABOVE, _SATURATION, _VALUE), (179, 255, 255))
    mask = cv2.morphologyEx(low | high, cv2.MORPH_OPEN, _kernel(3))
    closed: NDArray[np.uint8] = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _kernel(7))
    return closed


def _kernel(size: int) -> Any:
    cv2 = opencv()
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
