"""Other people's detectors: whatever gives masks or boxes; fruits that are long and green."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, float_array, real_number, truth_value
from ..errors import ArgumentError
from ._camera import Camera
from ._detect import Detector
from ._detection import Detection, DetectionStatus
from ._images import array_of, of_kind
from ._obstacles import depth_of, points_of

__all__ = ["LongFruit", "from_boxes", "from_masks", "long_fruit"]


def from_masks(masks: ArrayLike, detector: Detector) -> list[Detection]:
    """Return detections of masks that another program made, one or none for each.

    Parameters
    ----------
    masks : array_like, shape (n, height, width), bool or uint8
        Not 0 where there is fruit.
    detector : Detector
        Whose camera and limits count; colours do not.

    Examples
    --------
    >>> import numpy as np
    >>> from agrik_fast.vision import Detector, from_masks, paper_camera
    >>> y, x = np.mgrid[:240, :320]
    >>> disc = np.hypot(x - 150, y - 100) < 25
    >>> [found.status.name for found in from_masks([disc], Detector(paper_camera()))]
    ['OK']
    """
    of_kind("detector", detector, Detector)
    given = array_of("masks", masks, "bu", "masks of bool or uint8")
    shape = (detector.camera.height, detector.camera.width)
    if given.ndim != 3 or given.shape[1:] != shape or given.dtype.kind not in "bu":
        received = f"{given.dtype}, shape {given.shape}"
        raise ArgumentError("masks", received, f"bool or uint8, shape (n, {shape[0]}, {shape[1]})")
    found = []
    for mask in given:
        in_one = detector.in_mask(np.where(mask, 255, 0).astype(np.uint8))
        found += in_one[:1]
    return found


def checked_boxes(boxes: ArrayLike) -> FloatArray:
    """Return boxes as numbers, shape (n, 4): left, top, right, bottom."""
    rows = float_array("boxes", boxes)
    if rows.size == 0:
        return np.zeros((0, 4))
    if rows.ndim != 2 or rows.shape[1] != 4 or not np.isfinite(rows).all():
        raise ArgumentError("boxes", f"shape {rows.shape}", "finite numbers, shape (n, 4)")
    for number, (left, top, right, bottom) in enumerate(rows.tolist()):
        if not (right > left and bottom > top):
            received = f"{[left, top, right, bottom]}"
            raise ArgumentError(f"boxes[{number}]", received, "left < right, top < bottom")
    return rows


def from_boxes(boxes: ArrayLike, camera: Camera, *, trusted: bool = False) -> list[Detection]:
    """Return detections of boxes round fruits.

    A box tells less than an outline: where leaves cover a fruit, its box is too small. So the
    status is ``WEAK`` unless `trusted`, and then only for boxes that are nearly square and within
    the picture.

    Parameters
    ----------
    boxes : array_like, shape (n, 4), pixels
        left, top, right, bottom.
    camera : Camera
        Who took the picture.
    trusted : bool, default False
        Whether boxes may be approached.

    Raises
    ------
    ArgumentError
        Another shape, or a box that is none.

    Examples
    --------
    >>> from agrik_fast.vision import from_boxes, paper_camera
    >>> [found.status.name for found in from_boxes([[100, 80, 140, 120]], paper_camera())]
    ['WEAK']
    """
    rows = checked_boxes(boxes)
    of_kind("camera", camera, Camera)
    trusted = truth_value("trusted", trusted)
    found = []
    for left, top, right, bottom in rows:
        middle = (left + right) / 2, (top + bottom) / 2
        sides = camera.rays(
            [[left, middle[1]], [right, middle[1]], [middle[0], top], [middle[0], bottom]]
        )
        wide, high = (math.acos(float(np.clip(sides[i] @ sides[i + 1], -1, 1))) for i in (0, 2))
        ends = (0, 1) if wide >= high else (2, 3)
        axis = sides[ends[0]] + sides[ends[1]]
        axis /= np.linalg.norm(axis)
        alpha = max(wide, high) / 2
        edge = left < 1 or top < 1 or right > camera.width - 2 or bottom > camera.height - 2
        square = min(wide, high) > 0.8 * max(wide, high)
        status = DetectionStatus.EDGE if edge else DetectionStatus.WEAK
        if trusted and square and not edge:
            status = DetectionStatus.OK
        radius_px = camera.focal * math.tan(alpha)
        found.append(
            Detection(status, "box", axis, camera.project(axis), alpha, radius_px, 0.0, 0.0, 0.0)
        )
    return found


@dataclass(frozen=True)
class LongFruit:
    """A fruit that is longer than it is wide, by its mask and the depth.

    Attributes
    ----------
    axis : ndarray, shape (3,)
        Unit vector from its lower to its upper end (up is -y of the camera).
    top, bottom : ndarray, shape (3,), m
        Ends of its middle line, in the camera's frame.
    grip : ndarray, shape (3,), m
        On the middle line, at a share of the length below the top.
    length, radius : float, m
        Of the fruit; the radius is half its width in the picture.

    Examples
    --------
    >>> from agrik_fast.vision import LongFruit
    >>> up = np.array([0.0, -1.0, 0.0])
    >>> fruit = LongFruit(up, 0.1 * up, -0.1 * up, 0.05 * up, length=0.2, radius=0.02)
    >>> fruit.length
    0.2
    """

    axis: FloatArray
    top: FloatArray
    bottom: FloatArray
    grip: FloatArray
    length: float
    radius: float


def long_fruit(
    mask: NDArray[np.bool_], depth: ArrayLike, camera: Camera, *, grip: float = 0.25
) -> LongFruit:
    """Return axis and grip point of a fruit from any mask and depth.

    Cucumbers are as green as their leaves, so their mask has to come from elsewhere: a network, or
    a hand. Limits: the fruit must be seen over its whole length, and nearly across the direction
    of view; what leaves cover is not part of the length; the middle line is taken to lie half the
    visible width behind the surface, which a bent fruit does not do.

    Parameters
    ----------
    mask : ndarray, shape (height, width), bool
        Where the fruit is.
    depth : array_like, shape (height, width), m
        0 or NaN where it is not known.
    camera : Camera
        Whose pixels.
    grip : float, default 0.25
        Share of the length, from the top.

    Raises
    ------
    ArgumentError
        Another shape, too few pixels with depth, or something that is not long.

    Examples
    --------
    >>> from agrik_fast.vision import Camera, long_fruit
    >>> mask = np.zeros((240, 320), dtype=bool)
    >>> mask[60:180, 150:170] = True
    >>> found = long_fruit(mask, np.full((240, 320), 0.5), Camera.of_view(320, 240, 60.0))
    >>> bool(found.length > found.radius)
    True
    """
    of_kind("camera", camera, Camera)
    shape = (camera.height, camera.width)
    given = array_of("mask", mask, "b", "a mask of bool")
    if given.dtype != bool or given.shape != shape:
        raise ArgumentError("mask", f"{given.dtype}, shape {given.shape}", f"bool, shape {shape}")
    share = real_number("grip", grip, 0, 1)
    cloud = points_of(given, depth_of(depth, shape), camera)
    if not len(cloud):
        raise ArgumentError("mask", "too few pixels with depth", "30 or more, 2 from its rim")
    # The mask's own shape across the line of view: depth is rougher than pixels are.
    rows, columns = np.nonzero(given)
    far = float(np.median(cloud[:, 2]))
    rays = camera.rays(np.stack([columns, rows], axis=1).astype(float))
    flat = rays[:, :2] / rays[:, 2:] * far
    middle = flat.mean(axis=0)
    _, sizes, ways = np.linalg.svd(flat - middle, full_matrices=False)
    if sizes[0] < 1.5 * sizes[1]:
        raise ArgumentError("mask", "something as wide as it is long", "a long fruit")
    along, across = (flat - middle) @ ways[0], (flat - middle) @ ways[1]
    # Its width where it is widest: the middle half of its length.
    low, high = float(along.min()), float(along.max())
    inner = np.abs(along - (low + high) / 2) < (high - low) / 4
    radius = float(np.quantile(across[inner], 0.98) - np.quantile(across[inner], 0.02)) / 2
    # The slope in depth along the fruit, by its front: the pixels near its middle line.
    place = (cloud[:, :2] / cloud[:, 2:] * far - middle) @ ways.T
    front = np.abs(place[:, 1]) < 0.4 * radius
    if front.sum() < 10:
        raise ArgumentError("depth", "too few points on the fruit's middle", "10 or more")
    slope, height = np.polyfit(place[front, 0], cloud[front, 2], 1)
    ends = []
    for t in (low, high):
        z = height + slope * t
        flat_end = (middle + t * ways[0]) / far
        end = np.array([flat_end[0] * z, flat_end[1] * z, z])
        # From the surface to the middle line.
        ends.append(end * (1 + radius / float(np.linalg.norm(end))))
    top, bottom = sorted(ends, key=lambda end: float(end[1]))
    length = float(np.linalg.norm(top - bottom))
    axis = (top - bottom) / length
    return LongFruit(axis, top, bottom, top - share * length * axis, length, radius)
