"""From where the arm is looked at, so that it and the target's handle are in the picture."""

from __future__ import annotations

import numpy as np

from .._checks import FloatArray

FIELD_OF_VIEW = np.radians(75.0)
"""From the lower to the upper edge of the picture; that of a browser that was told nothing."""
# From before, from the right and from above.
_SIDE = np.array([0.85, -0.85, 0.55])
# What is drawn lies this near to the edges, as a share of the way from the middle.
_FULL = 0.9


def viewpoint(
    arm: FloatArray, handle: FloatArray, size: float, aspect: float
) -> tuple[FloatArray, FloatArray]:
    """Return where a camera stands and what it looks at.

    Parameters
    ----------
    arm : ndarray, shape (n, 3), m
        Points of the arm; their middle is looked at.
    handle : ndarray, shape (m, 3), m
        Tips of the target's handle.
    size : float, m
        How large the arm is at least to be thought.
    aspect : float
        Width of the picture by its height.

    Returns
    -------
    position, look_at : ndarray, shape (3,), m
    """
    middle = (arm.min(axis=0) + arm.max(axis=0)) / 2
    far = 1.5 * max(float(np.ptp(arm, axis=0).max()), size)
    back = _SIDE / np.linalg.norm(_SIDE)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    above = np.cross(back, right)
    across, up, near = np.stack([right, above, back]) @ (np.concatenate([arm, handle]) - middle).T
    slope = _FULL * np.tan(FIELD_OF_VIEW / 2)
    # So far away that no point lies beside the picture: of a narrow one that is farther.
    needed = np.maximum(np.abs(across) / (slope * aspect), np.abs(up) / slope) + near
    distance = max(far * float(np.linalg.norm(_SIDE)), float(needed.max()))
    return middle + distance * back, middle
