"""The pinhole camera with Brown's distortion: pixels to rays and back."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, direction, finite_array, float_array, real_number, whole_number
from .._checks import path as checked_path
from ..errors import ArgumentError
from ._errors import VisionFileError
from ._images import SMALLEST

__all__ = ["Camera", "looking_at"]

_ROUNDS = 12
_KEYS = ("width", "height", "fx", "fy", "cx", "cy")


@dataclass(frozen=True)
class Camera:
    """How a camera sees: x to the right, y down, z forward; the first pixel's centre is (0, 0).

    Parameters
    ----------
    width, height : int
        Pixels.
    fx, fy : float, pixels
        Focal lengths.
    cx, cy : float, pixels
        Principal point.
    distortion : tuple of 5 floats
        Brown's k1, k2, p1, p2, k3, in OpenCV's order.

    Raises
    ------
    ArgumentError
        A number is out of its range.

    Examples
    --------
    >>> from agrik_fast.vision import Camera
    >>> camera = Camera.of_view(320, 240, 60.0)
    >>> float(camera.rays([[159.5, 119.5]])[0, 2])
    1.0
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            whole_number(f"Camera.{name}", getattr(self, name), SMALLEST, 20000)
        for name in ("fx", "fy"):
            real_number(f"Camera.{name}", getattr(self, name), 0, open_low=True, unit="pixels")
        for name in ("cx", "cy"):
            real_number(f"Camera.{name}", getattr(self, name), unit="pixels")
        given = finite_array("Camera.distortion", self.distortion, (5,))
        object.__setattr__(self, "distortion", tuple(given.tolist()))

    # ---- making one --------------------------------------------------------------------------

    @classmethod
    def of_view(cls, width: int, height: int, degrees: float) -> Camera:
        """Return a camera without distortion by its horizontal field of view.

        Parameters
        ----------
        width, height : int
            Pixels.
        degrees : float, degrees
            Angle between the left and the right border.

        Examples
        --------
        >>> from agrik_fast.vision import Camera
        >>> Camera.of_view(320, 240, 60.0).width
        320
        """
        width = whole_number("width", width, SMALLEST, 20000)
        height = whole_number("height", height, SMALLEST, 20000)
        degrees = real_number("degrees", degrees, 1, 170)
        focal = width / 2 / math.tan(math.radians(degrees) / 2)
        return cls(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)

    @classmethod
    def from_matrix(
        cls, width: int, height: int, matrix: ArrayLike, distortion: ArrayLike = (0, 0, 0, 0, 0)
    ) -> Camera:
        """Return the camera of a matrix K, shape (3, 3), pixels, and OpenCV's distortion.

        Raises
        ------
        ArgumentError
            K has skew or no last row (0, 0, 1).

        Examples
        --------
        >>> from agrik_fast.vision import Camera
        >>> K = [[300.0, 0.0, 159.5], [0.0, 300.0, 119.5], [0.0, 0.0, 1.0]]
        >>> float(Camera.from_matrix(320, 240, K).fx)
        300.0
        """
        k = finite_array("matrix", matrix, (3, 3))
        if k[0, 1] or k[1, 0] or k[2].tolist() != [0, 0, 1]:
            raise ArgumentError("matrix", str(k.tolist()), "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
        five = finite_array("distortion", distortion, (5,))
        return cls(
            width, height, k[0, 0], k[1, 1], k[0, 2], k[1, 2], distortion=tuple(five.tolist())
        )

    @property
    def matrix(self) -> FloatArray:
        """K, shape (3, 3), pixels."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1.0]])

    @property
    def focal(self) -> float:
        """Geometric mean of the focal lengths, pixels."""
        return math.sqrt(self.fx * self.fy)

    def scaled(self, width: int, height: int) -> Camera:
        """Return the same camera for pictures that it bins or scales.

        A camera that cuts its small pictures out of the large one needs a calibration of its own.

        Parameters
        ----------
        width, height : int
            New size, pixels; both scaled by one factor.

        Raises
        ------
        ArgumentError
            The two factors differ.

        Examples
        --------
        >>> from agrik_fast.vision import paper_camera
        >>> paper_camera(640).scaled(320, 240).width
        320
        """
        width = whole_number("width", width, SMALLEST, 20000)
        height = whole_number("height", height, SMALLEST, 20000)
        factor = width / self.width
        if abs(height - factor * self.height) > 0.5:
            expected = f"the shape of {self.width} x {self.height}"
            raise ArgumentError("width, height", f"{width} x {height}", expected)
        # Pixels have areas: their corner stays, not the first one's centre.
        cx, cy = ((c + 0.5) * factor - 0.5 for c in (self.cx, self.cy))
        return Camera(width, height, factor * self.fx, factor * self.fy, cx, cy, self.distortion)

    # ---- files -------------------------------------------------------------------------------

    @classmethod
    def load(cls, file: str | Path) -> Camera:
        """Return the camera of a JSON file as `save` writes it.

        Raises
        ------
        VisionFileError
            It cannot be read, or a number is missing or out of its range.

        Examples
        --------
        >>> from agrik_fast.vision import Camera, paper_camera
        >>> paper_camera().save("camera.json")
        >>> Camera.load("camera.json") == paper_camera()
        True
        """
        name = checked_path("file", file)
        try:
            content = json.loads(name.read_text(encoding="utf-8"))
        except OSError as error:
            raise VisionFileError(str(file), error.strerror or str(error)) from None
        except ValueError as error:
            raise VisionFileError(str(file), f"no JSON: {error}") from None
        if not isinstance(content, dict):
            raise VisionFileError(str(file), "no camera: an object with width, height, fx, ...")
        missing = [key for key in _KEYS if key not in content]
        extra = sorted(set(content) - {*_KEYS, "distortion"})
        if missing or extra:
            what = ", ".join(missing or extra)
            raise VisionFileError(str(file), f"{'missing' if missing else 'unknown'}: {what}")
        five = content.get("distortion", [0.0] * 5)
        try:
            return cls(**{key: content[key] for key in _KEYS}, distortion=five)
        except ArgumentError as error:
            raise VisionFileError(str(file), str(error)) from None

    def save(self, file: str | Path) -> None:
        """Write the camera to a JSON file.

        Raises
        ------
        VisionFileError
            It cannot be written.

        Examples
        --------
        >>> from agrik_fast.vision import Camera, paper_camera
        >>> paper_camera().save("small.json")
        >>> Camera.load("small.json").height
        240
        """
        content = {key: getattr(self, key) for key in _KEYS}
        content["distortion"] = list(self.distortion)
        try:
            checked_path("file", file).write_text(json.dumps(content, indent=1) + "\n", "utf-8")
        except OSError as error:
            raise VisionFileError(str(file), error.strerror or str(error)) from None

    # ---- pixels and rays ---------------------------------------------------------------------

    def rays(self, pixels: ArrayLike) -> FloatArray:
        """Return unit rays of pixels.

        Brown's distortion is inverted by a fixed point of 12 rounds.

        Parameters
        ----------
        pixels : array_like, shape (..., 2)
            Column and row.

        Returns
        -------
        ndarray, shape (..., 3)
            Unit vectors in the camera's frame.

        Examples
        --------
        >>> from agrik_fast.vision import Camera
        >>> Camera.of_view(320, 240, 60.0).rays([[159.5, 119.5]]).tolist()
        [[0.0, 0.0, 1.0]]
        """
        uv = float_array("pixels", pixels)
        if not uv.ndim or uv.shape[-1] != 2:
            raise ArgumentError("pixels", f"shape {uv.shape}", "shape (..., 2)")
        x0 = (uv[..., 0] - self.cx) / self.fx
        y0 = (uv[..., 1] - self.cy) / self.fy
        x, y = x0, y0
        if any(self.distortion):
            k1, k2, p1, p2, k3 = self.distortion
            for _ in range(_ROUNDS):
                r2 = x * x + y * y
                radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
                dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
                dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
                x, y = (x0 - dx) / radial, (y0 - dy) / radial
        length = np.sqrt(x * x + y * y + 1)
        return np.stack([x / length, y / length, 1 / length], axis=-1)

    def project(self, points: ArrayLike) -> FloatArray:
        """Return pixels of points.

        Parameters
        ----------
        points : array_like, shape (..., 3), m
            In the camera's frame; NaN comes back for those that are not in front of it.

        Returns
        -------
        ndarray, shape (..., 2)
            Column and row; they may lie outside the picture.

        Examples
        --------
        >>> from agrik_fast.vision import Camera
        >>> Camera.of_view(320, 240, 60.0).project([[0.0, 0.0, 1.0]]).tolist()
        [[159.5, 119.5]]
        """
        p = float_array("points", points)
        if not p.ndim or p.shape[-1] != 3:
            raise ArgumentError("points", f"shape {p.shape}", "shape (..., 3)")
        z = np.where(p[..., 2] > 0, p[..., 2], np.nan)
        x, y = p[..., 0] / z, p[..., 1] / z
        k1, k2, p1, p2, k3 = self.distortion
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return np.stack([self.fx * u + self.cx, self.fy * v + self.cy], axis=-1)

    def grid_rays(self, samples: int = 1) -> FloatArray:
        """Return the unit rays of all pixels, or of `samples` x `samples` places in each.

        Returns
        -------
        ndarray, shape (samples * height, samples * width, 3)
            Read only: kept for the next call.

        Examples
        --------
        >>> from agrik_fast.vision import Camera
        >>> Camera.of_view(32, 24, 60.0).grid_rays().shape
        (24, 32, 3)
        """
        return _grid_rays(self, whole_number("samples", samples, 1, 8))


def looking_at(
    position: ArrayLike, target: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)
) -> FloatArray:
    """Return the pose of a camera that looks at a point, shape (4, 4).

    Parameters
    ----------
    position, target : array_like, shape (3,), m
        Where it stands, and what is in the middle of its picture.
    up : array_like, shape (3,)
        What is upwards in its picture, as far as that can be.

    Examples
    --------
    >>> from agrik_fast.vision import looking_at
    >>> looking_at([0, 0, 0], [1, 0, 0])[:3, 2].round(9).tolist()
    [1.0, 0.0, 0.0]
    """
    place = finite_array("position", position, (3,))
    forward = np.array(direction("target", finite_array("target", target, (3,)) - place))
    right = np.cross(forward, direction("up", up))
    if np.linalg.norm(right) < 1e-9:
        raise ArgumentError("up", str(up), "no multiple of the direction of view")
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3] = np.stack([right, np.cross(forward, right), forward, place], axis=1)
    return pose


@lru_cache(maxsize=6)
def _grid_rays(camera: Camera, samples: int) -> FloatArray:
    u = (np.arange(samples * camera.width) + 0.5) / samples - 0.5
    v = (np.arange(samples * camera.height) + 0.5) / samples - 0.5
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1))
    rays.flags.writeable = False
    return rays
