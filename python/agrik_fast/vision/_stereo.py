"""Two views: depth of a rectified pair, and points of matched pixels."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, float_array, real_number
from .._checks import path as checked_path
from ..errors import ArgumentError
from ._camera import Camera
from ._cv import opencv
from ._images import Image, checked_image, of_kind, same_size
from ._tables import read_numbers

__all__ = ["StereoPair", "Triangulated", "triangulate"]

_DISPARITIES = 128
COLUMNS = ("u_left", "v_left", "u_right", "v_right")


@dataclass(frozen=True)
class StereoPair:
    """Two cameras side by side whose rows agree.

    Parameters
    ----------
    camera : Camera
        Both of them, without distortion: the pictures are rectified.
    baseline : float, m
        How far the right one is along +x.

    Examples
    --------
    >>> from agrik_fast.vision import Camera, StereoPair
    >>> StereoPair(Camera.of_view(320, 240, 60.0), baseline=0.06).baseline
    0.06
    """

    camera: Camera
    baseline: float

    def __post_init__(self) -> None:
        real_number("StereoPair.baseline", self.baseline, 0, open_low=True, unit="m")
        of_kind("StereoPair.camera", self.camera, Camera)
        if any(self.camera.distortion):
            raise ArgumentError("StereoPair.camera", "one with distortion", "a rectified pair's")

    def depth(self, left: Image, right: Image) -> FloatArray:
        """Return z of every pixel of the left picture, shape (height, width), m; NaN unmatched.

        Semi-global matching: block 5, 128 disparities, P1 200, P2 800. A highlight on a sphere is
        seen behind its surface, so that a glossy fruit comes out too far: see `obstacles`.

        Parameters
        ----------
        left, right : ndarray, shape (height, width, 3), uint8
            The pair.

        Examples
        --------
        >>> from agrik_fast.vision import Camera, StereoPair, random_scene, render
        >>> camera = Camera.of_view(320, 240, 60.0)
        >>> shifted = np.eye(4)
        >>> shifted[0, 3] = 0.06
        >>> scene = random_scene("clean", seed=1)
        >>> left, right = render(scene, camera), render(scene, camera, pose=shifted)
        >>> StereoPair(camera, baseline=0.06).depth(left.image, right.image).shape
        (240, 320)
        """
        cv2 = opencv()
        for name, image in (("left", left), ("right", right)):
            same_size(name, checked_image(name, image), self.camera.width, self.camera.height)
        matcher = cv2.StereoSGBM_create(
            minDisparity=0,
            numDisparities=_DISPARITIES,
            blockSize=5,
            P1=200,
            P2=800,
            uniquenessRatio=8,
            speckleWindowSize=80,
            speckleRange=2,
            mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY,
        )
        # The matcher leaves as many columns out as it has disparities, though most things are
        # farther than the nearest that it can tell: a margin of its own spares the picture's.
        grey = (
            cv2.copyMakeBorder(
                cv2.cvtColor(image, cv2.COLOR_BGR2GRAY),
                *(0, 0, _DISPARITIES, 0),
                cv2.BORDER_REPLICATE,
            )
            for image in (left, right)
        )
        disparity = matcher.compute(*grey)[:, _DISPARITIES:].astype(np.float64) / 16
        in_both = np.arange(self.camera.width) >= disparity
        with np.errstate(divide="ignore", invalid="ignore"):
            z = self.camera.fx * self.baseline / disparity
        return np.asarray(np.where((disparity > 0.5) & in_both, z, np.nan))


class Triangulated(NamedTuple):
    """Points of matched pixels.

    Attributes
    ----------
    points : ndarray, shape (n, 3), m
        In the left camera's frame; NaN where rays do not meet before the cameras.
    gaps : ndarray, shape (n,), m
        How far the two rays pass each other.
    names : tuple of str
        Of the objects that the pixels belong to; empty without such a column.

    Examples
    --------
    >>> from agrik_fast.vision import Triangulated
    >>> found = Triangulated(points=np.zeros((1, 3)), gaps=np.zeros(1), names=("leaf",))
    >>> found.names
    ('leaf',)
    """

    points: FloatArray
    gaps: FloatArray
    names: tuple[str, ...]


def triangulate(
    matches: str | Path | ArrayLike, left: Camera, right: Camera, right_pose: ArrayLike
) -> Triangulated:
    """Return points from pixels that were matched by hand.

    The cucumber paper matched pixels by hand, and trained a network to give depth. With calibrated
    cameras depth is geometry: where the two rays come nearest to each other.

    Parameters
    ----------
    matches : path, or array_like of shape (n, 4), pixels
        A CSV file with the columns u_left, v_left, u_right, v_right and, if wanted, name; or the
        four numbers.
    left, right : Camera
        The cameras, with their distortion.
    right_pose : array_like, shape (4, 4), m
        Of the right camera in the left one's frame.

    Raises
    ------
    VisionFileError
        The file cannot be read; names row and column.
    ArgumentError
        Another shape, or both cameras are at one place.

    Examples
    --------
    >>> from agrik_fast.vision import Camera, triangulate
    >>> camera, beside = Camera.of_view(320, 240, 60.0), np.eye(4)
    >>> beside[0, 3] = 0.1
    >>> left = camera.project([[0.0, 0.0, 0.5]])
    >>> right = camera.project([[-0.1, 0.0, 0.5]])
    >>> triangulate(np.hstack([left, right]), camera, camera, beside).points.round(6).tolist()
    [[0.0, 0.0, 0.5]]
    """
    of_kind("left", left, Camera)
    of_kind("right", right, Camera)
    names: tuple[str, ...] = ()
    if isinstance(matches, str | Path):
        rows, names = read_numbers(checked_path("matches", matches), COLUMNS, "name")
    else:
        rows = float_array("matches", matches)
    if rows.ndim != 2 or rows.shape[1] != 4:
        raise ArgumentError("matches", f"shape {rows.shape}", "shape (n, 4)")
    pose = finite_array("right_pose", right_pose, (4, 4))
    offset = pose[:3, 3]
    if float(np.linalg.norm(offset)) < 1e-6:
        raise ArgumentError("right_pose", "the left camera's place", "another place")
    a, b = left.rays(rows[:, :2]), right.rays(rows[:, 2:]) @ pose[:3, :3].T
    # The points of two lines that are nearest to each other.
    dot = np.einsum("ij,ij->i", a, b)
    sine2 = 1 - dot * dot
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (a @ offset - dot * (b @ offset)) / sine2
        t = (dot * (a @ offset) - b @ offset) / sine2
    first, second = s[:, None] * a, offset + t[:, None] * b
    good = (s > 0) & (t > 0) & (sine2 > 1e-12)
    points = np.where(good[:, None], (first + second) / 2, np.nan)
    gaps = np.where(good, np.linalg.norm(first - second, axis=1), np.nan)
    return Triangulated(points, gaps, names)
