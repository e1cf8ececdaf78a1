"""OpenCV, imported where it is first used: the extra ``vision`` brings it."""

from __future__ import annotations

from types import ModuleType

from ..errors import MissingExtraError


def opencv() -> ModuleType:
    """Return the module cv2.

    Raises
    ------
    MissingExtraError
        It is not installed.
    """
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("pictures", "vision") from None
    return cv2
