"""A known plane: red squares on a sheet of paper, as in the tomato paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array
from ..errors import ArgumentError
from ._camera import Camera
from ._cv import opencv
from ._errors import CalibrationRefusedError
from ._images import Image, of_kind
from ._red import red_mask

__all__ = ["Plane", "red_squares"]

_FEWEST = 9
_AREA = 60
# Of a square its box is filled, also where perspective skews it; of a circle 0.785.
_SQUARE = 0.81


@dataclass(frozen=True)
class Plane:
    """Where pixels are on a plane.

    Attributes
    ----------
    camera : Camera
        Whose pixels; the homography is that of undistorted rays.
    matrix : ndarray, shape (3, 3)
        From (x/z, y/z) of rays to metres on the plane.
    residual_mean, residual_p95 : float, m
        How far the points that it was fitted to are off it.

    Examples
    --------
    >>> from agrik_fast.vision import Camera, Plane
    >>> corners = [[x, y] for x in (-0.1, 0.0, 0.1) for y in (-0.1, 0.0, 0.1)]
    >>> camera = Camera.of_view(320, 240, 60.0)
    >>> pixels = camera.project(np.column_stack([corners, np.full(9, 0.5)]))
    >>> bool(Plane.fit(camera, pixels, corners).residual_mean < 1e-6)
    True
    """

    camera: Camera
    matrix: FloatArray
    residual_mean: float
    residual_p95: float

    @classmethod
    def fit(cls, camera: Camera, pixels: ArrayLike, points: ArrayLike) -> Plane:
        """Return the plane through points of known place.

        Parameters
        ----------
        camera : Camera
            Its distortion is taken out first.
        pixels : array_like, shape (n, 2)
            Where the points are seen, n >= 9.
        points : array_like, shape (n, 2), m
            Where they are on the plane.

        Raises
        ------
        ArgumentError
            Shapes differ or are others.
        CalibrationRefusedError
            Fewer than 9 points, or all on a line.

        Examples
        --------
        >>> from agrik_fast.vision import Camera, Plane
        >>> corners = [[x, y] for x in (-0.1, 0.0, 0.1) for y in (-0.1, 0.0, 0.1)]
        >>> camera = Camera.of_view(320, 240, 60.0)
        >>> pixels = camera.project(np.column_stack([corners, np.full(9, 0.5)]))
        >>> Plane.fit(camera, pixels, corners).matrix.shape
        (3, 3)
        """
        of_kind("camera", camera, Camera)
        uv, xy = float_array("pixels", pixels), float_array("points", points)
        for name, value in (("pixels", uv), ("points", xy)):
            if value.ndim != 2 or value.shape[1] != 2 or not np.isfinite(value).all():
                raise ArgumentError(name, f"shape {value.shape}", "finite numbers, shape (n, 2)")
        if len(uv) != len(xy):
            raise ArgumentError("points", f"{len(xy)} points", f"as many as pixels, {len(uv)}")
        if len(uv) < _FEWEST:
            raise CalibrationRefusedError(
                f"a plane needs {_FEWEST} points or more, {len(uv)} were given"
            )
        for value in (uv, xy):
            sizes = np.linalg.svd(value - value.mean(axis=0), compute_uv=False)
            if sizes[1] < 1e-3 * sizes[0] or sizes[0] == 0:
                raise CalibrationRefusedError("a plane needs points that are not on one line")
        flat = _flat(camera, uv)
        matrix, _ = opencv().findHomography(flat, xy, 0)
        if matrix is None:
            raise CalibrationRefusedError("no homography goes through these points")
        fitted = cls(camera, np.asarray(matrix, float), 0.0, 0.0)
        off = np.linalg.norm(fitted.points(uv) - xy, axis=1)
        return cls(camera, fitted.matrix, float(off.mean()), float(np.percentile(off, 95)))

    def points(self, pixels: ArrayLike) -> FloatArray:
        """Return where pixels are on the plane, shape (..., 2), m.

        Examples
        --------
        >>> from agrik_fast.vision import Camera, Plane
        >>> corners = [[x, y] for x in (-0.1, 0.0, 0.1) for y in (-0.1, 0.0, 0.1)]
        >>> camera = Camera.of_view(320, 240, 60.0)
        >>> pixels = camera.project(np.column_stack([corners, np.full(9, 0.5)]))
        >>> np.allclose(Plane.fit(camera, pixels, corners).points(pixels), corners, atol=1e-6)
        True
        """
        flat = _flat(self.camera, float_array("pixels", pixels))
        ones = np.ones((*flat.shape[:-1], 1))
        found = np.concatenate([flat, ones], axis=-1) @ self.matrix.T
        return np.asarray(found[..., :2] / found[..., 2:])


def _flat(camera: Camera, uv: FloatArray) -> FloatArray:
    rays = camera.rays(uv)
    return np.asarray(rays[..., :2] / rays[..., 2:])


def red_squares(image: Image) -> FloatArray:
    """Return the centres of red squares, from the top row down, each from left to right.

    The centre is that of the filled outline's area: measured, it is better than the crossing of
    diagonals between refined corners.

    Parameters
    ----------
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.

    Returns
    -------
    ndarray, shape (n, 2), pixels
        Column and row.

    Examples
    --------
    >>> from agrik_fast.vision import red_squares
    >>> picture = np.full((80, 80, 3), 255, dtype=np.uint8)
    >>> picture[30:50, 20:40] = (0, 0, 255)
    >>> red_squares(picture).round(1).tolist()
    [[29.5, 39.5]]
    """
    cv2 = opencv()
    mask = red_mask(image)
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    least = _AREA * (image.shape[1] / 320) ** 2
    found = []
    for outline in outlines:
        area = cv2.contourArea(outline)
        _, sizes, _ = cv2.minAreaRect(outline)
        box = (sizes[0] + 1e-9) * (sizes[1] + 1e-9)
        if area < least or area < _SQUARE * box or min(sizes) < 0.5 * max(sizes):
            continue
        filled = cv2.drawContours(np.zeros_like(mask), [outline], -1, 255, cv2.FILLED)
        sums = cv2.moments(filled, binaryImage=True)
        found.append((sums["m10"] / sums["m00"], sums["m01"] / sums["m00"], min(sizes)))
    if not found:
        return np.zeros((0, 2))
    # Rows of a sheet are seldom level: a new row begins where the next centre is half a square
    # or more below the last one.
    found.sort(key=lambda each: each[1])
    rows = [[found[0]]]
    for each in found[1:]:
        if each[1] - rows[-1][-1][1] > 0.5 * each[2]:
            rows.append([])
        rows[-1].append(each)
    return np.array([each[:2] for row in rows for each in sorted(row)])
