"""Depth to labelled obstacle points, in the form of a scene file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, finite_array, float_array, items, real_number, text, whole_number
from ..errors import ArgumentError
from ._camera import Camera
from ._cv import opencv
from ._detection import Detection, DetectionStatus
from ._images import Image, array_of, checked_image, of_kind

__all__ = ["Obstacle", "balls_that_cover", "fruit_radius", "green_masks", "obstacles"]

_ERODED_PX = 2
_NEAR_MEDIAN = 0.050
_FEWEST_PIXELS = 30
_FEWEST_POINTS = 15
_MOST_POINTS = 200
_FRONT_SHARE = 0.03
_MASKS = "masks, or masks by name"


@dataclass(frozen=True)
class Obstacle:
    """Balls of one radius that cover an object.

    Attributes
    ----------
    name, kind : str
        As in a scene file.
    points : ndarray, shape (n, 3), m
        Centres.
    radius : float, m
        Of all of them.
    covering : float, m
        How far what was seen is from the nearest centre, at most.

    Examples
    --------
    >>> from agrik_fast.vision import Obstacle
    >>> one = Obstacle("leaf", "leaf", np.zeros((1, 3)), 0.01, 0.005)
    >>> one.radius
    0.01
    """

    name: str
    kind: str
    points: FloatArray
    radius: float
    covering: float

    def row(self) -> dict[str, Any]:
        """Return the object of a scene document.

        Examples
        --------
        >>> from agrik_fast.vision import Obstacle
        >>> one = Obstacle("leaf", "leaf", np.zeros((1, 3)), 0.01, 0.005)
        >>> one.row()["name"]
        'leaf'
        """
        return {
            "name": self.name,
            "kind": self.kind,
            "radius": self.radius,
            "points": self.points.tolist(),
        }


def balls_that_cover(
    points: ArrayLike,
    *,
    depth_error: float = 0.003,
    half_thickness: float = 0.0005,
    fewest: int = _FEWEST_POINTS,
    most: int = _MOST_POINTS,
) -> tuple[FloatArray, float, float]:
    """Return points of a cloud, and the radius with which balls round them cover all of it.

    Farthest-point sampling from the point next to the centroid. The radius is half the covering
    radius, and the depth's error and half the thickness on top; points are added until that is
    the covering radius or more, so that every point lies in some ball.

    Parameters
    ----------
    points : array_like, shape (n, 3), m
        The cloud.
    depth_error : float, default 0.003, m
        Of the depth, 95 %.
    half_thickness : float, default 0.0005, m
        Of the object.
    fewest, most : int
        Numbers of points; where `most` are not enough, the radius is the covering radius.

    Returns
    -------
    centres : ndarray, shape (k, 3), m
    radius, covering : float, m

    Examples
    --------
    >>> from agrik_fast.vision import balls_that_cover
    >>> points = np.random.default_rng(1).uniform(size=(50, 3)) * 0.05
    >>> centres, radius, covering = balls_that_cover(points)
    >>> centres.shape[1], radius > covering / 2
    (3, True)
    """
    cloud = float_array("points", points)
    if cloud.ndim != 2 or cloud.shape[1] != 3 or not len(cloud) or not np.isfinite(cloud).all():
        raise ArgumentError("points", f"shape {cloud.shape}", "finite points, shape (n >= 1, 3)")
    depth_error = real_number("depth_error", depth_error, 0, unit="m")
    half_thickness = real_number("half_thickness", half_thickness, 0, unit="m")
    fewest, most = whole_number("fewest", fewest, 1), whole_number("most", most, 1)
    more = depth_error + half_thickness
    chosen = [int(np.linalg.norm(cloud - cloud.mean(axis=0), axis=1).argmin())]
    far = np.linalg.norm(cloud - cloud[chosen[0]], axis=1)
    while len(chosen) < min(most, len(cloud)):
        covering = float(far.max())
        if covering < 1e-9 or (len(chosen) >= fewest and covering <= covering / 2 + more):
            break
        chosen.append(int(far.argmax()))
        far = np.minimum(far, np.linalg.norm(cloud - cloud[chosen[-1]], axis=1))
    covering = float(far.max())
    return cloud[chosen], max(covering / 2 + more, covering), covering


def green_masks(
    image: Image, depth: ArrayLike, *, saturation: int = 110, step: float = 0.012
) -> list[NDArray[np.bool_]]:
    """Return masks of green things, the largest first, parted where the depth jumps.

    Green is hue 35 to 85 of 180.

    Parameters
    ----------
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.
    depth : array_like, shape (height, width), m
        0 or NaN where it is not known.
    saturation : int, default 110
        Least saturation: a wall is paler than leaves.
    step : float, default 0.012, m
        A jump between neighbouring pixels that parts two leaves.

    Examples
    --------
    >>> from agrik_fast.vision import green_masks
    >>> picture = np.zeros((40, 40, 3), dtype=np.uint8)
    >>> picture[5:35, 5:35] = (0, 200, 0)
    >>> len(green_masks(picture, np.full((40, 40), 0.5)))
    1
    """
    cv2 = opencv()
    picture = checked_image("image", image)
    z = depth_of(depth, picture.shape[:2])
    saturation = whole_number("saturation", saturation, 0, 255)
    step = real_number("step", step, 0, open_low=True, unit="m")
    hsv = cv2.cvtColor(cv2.GaussianBlur(picture, (3, 3), 0), cv2.COLOR_BGR2HSV)
    mask = cv2.inRange(hsv, (35, saturation, 15), (85, 255, 255)) > 0
    mask &= np.isfinite(z)
    filled = np.where(np.isfinite(z), z, 0.0)
    jumps = np.zeros(mask.shape, bool)
    jumps[:, 1:] |= np.abs(np.diff(filled, axis=1)) > step
    jumps[1:, :] |= np.abs(np.diff(filled, axis=0)) > step
    count, labels = cv2.connectedComponents((mask & ~jumps).astype(np.uint8), connectivity=4)
    found = [labels == number for number in range(1, count)]
    found = [each for each in found if each.sum() >= 4 * _FEWEST_PIXELS]
    return sorted(found, key=lambda each: -int(each.sum()))


def depth_of(value: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    z = float_array("depth", value).copy()
    if z.shape != tuple(shape):
        raise ArgumentError("depth", f"shape {z.shape}", f"shape {tuple(shape)}")
    # Cameras write 0 where they know nothing.
    z[~(np.isfinite(z) & (z > 0))] = np.nan
    return z


def points_of(
    mask: NDArray[np.bool_], depth: FloatArray, camera: Camera, *, rim: bool = False
) -> FloatArray:
    """Return the points of a mask's pixels in the camera's frame.

    At an object's rim the depth is half that of what is behind: those pixels are left out, or,
    with `rim`, take the depth of the nearest one inside.
    """
    cv2 = opencv()
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * _ERODED_PX + 1,) * 2)
    inner = cv2.erode(mask.astype(np.uint8), kernel) > 0
    inner &= np.isfinite(depth)
    if inner.sum() < _FEWEST_PIXELS:
        return np.zeros((0, 3))
    inner &= np.abs(depth - np.median(depth[inner])) < _NEAR_MEDIAN
    if rim:
        near = (cv2.dilate(inner.astype(np.uint8), kernel) > 0) & mask
        _, labels = cv2.distanceTransformWithLabels(
            (~inner).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
        )
        of_label = np.zeros(int(labels.max()) + 1)
        of_label[labels[inner]] = depth[inner]
        depth, inner = of_label[labels], near
    rows, columns = np.nonzero(inner)
    rays = camera.rays(np.stack([columns, rows], axis=1).astype(float))
    return np.asarray(rays / rays[:, 2:] * depth[inner][:, None])


def fruit_radius(found: Detection, points: ArrayLike) -> float:
    """Return the radius of a fruit by the nearest of its points, m.

    Highlights are seen behind the surface, so that most points of a glossy fruit are too far. The
    nearest 3 % along the axis tell where its front is, D - R, and the cone the rest:
    R = front sin(alpha) / (1 - sin(alpha)).

    Parameters
    ----------
    found : Detection
        The fruit.
    points : array_like, shape (n, 3), m
        Of its pixels, in the camera's frame.

    Examples
    --------
    >>> from agrik_fast.vision import Detector, Fruit, Scene, fruit_radius, paper_camera, render
    >>> camera = paper_camera()
    >>> picture = render(Scene((Fruit((0, 0, 0.35), 0.03),)))
    >>> best = Detector(camera).detect(picture.image)[0]
    >>> seen = picture.labels == 0
    >>> points = camera.grid_rays()[seen]
    >>> points = points / points[:, 2:] * picture.depth[seen][:, None]
    >>> abs(fruit_radius(best, points) - 0.03) < 0.003
    True
    """
    of_kind("found", found, Detection)
    cloud = float_array("points", points)
    if cloud.ndim != 2 or cloud.shape[1] != 3 or len(cloud) < _FEWEST_PIXELS:
        expected = f"shape (n >= {_FEWEST_PIXELS}, 3)"
        raise ArgumentError("points", f"shape {cloud.shape}", expected)
    front = float(np.quantile(cloud @ found.axis, _FRONT_SHARE))
    sine = math.sin(found.alpha)
    return front * sine / (1 - sine)


def obstacles(
    camera: Camera,
    depth: ArrayLike,
    masks: Mapping[str, NDArray[np.bool_]] | Iterable[NDArray[np.bool_]],
    *,
    fruits: Iterable[Detection] = (),
    radius: float | None = None,
    pose: ArrayLike | None = None,
    kind: str = "leaf",
    depth_error: float = 0.003,
    half_thickness: float = 0.0005,
) -> dict[str, Any]:
    """Return a scene document (unit m) of what a depth picture and masks show.

    `collision.from_document` makes a scene of it. Objects of masks become balls that cover all
    their pixels. Fruits become one ball each: place and size come from the cone, never from the
    depth of their surface, whose highlights are seen behind it.

    Parameters
    ----------
    camera : Camera
        Whose pixels; a stereo pair's left one.
    depth : array_like, shape (height, width), m
        z of every pixel; 0 or NaN where it is not known. A stereo pair's, or an RGB-D camera's.
    masks : mapping of str to mask, or iterable of masks
        Boolean, shape (height, width); names by default leaf0, leaf1, ...
    fruits : iterable of Detection
        Named fruit0, fruit1, ...; those of status weak are left out.
    radius : float, m, optional
        Of the fruits; by default of the nearest 3 % of each one's points.
    pose : array_like, shape (4, 4), optional
        Of the camera, in the scene's frame.
    kind : str, default "leaf"
        Of the masks' objects.
    depth_error, half_thickness
        As for `balls_that_cover`.

    Raises
    ------
    ArgumentError
        A mask or the depth has another shape than the camera's pictures.

    Examples
    --------
    >>> from agrik_fast.vision import Camera, obstacles
    >>> camera, depth = Camera.of_view(32, 24, 60.0), np.full((24, 32), 0.5)
    >>> mask = np.zeros((24, 32), dtype=bool)
    >>> mask[5:10, 5:10] = True
    >>> len(obstacles(camera, depth, {"leaf": mask})["objects"])
    0
    """
    of_kind("camera", camera, Camera)
    shape = (camera.height, camera.width)
    z = depth_of(depth, shape)
    place = np.eye(4) if pose is None else finite_array("pose", pose, (4, 4))
    named = (
        dict(masks)
        if isinstance(masks, Mapping)
        else {f"{kind}{number}": each for number, each in enumerate(items("masks", masks, _MASKS))}
    )
    kind = text("kind", kind)
    if radius is not None:
        radius = real_number("radius", radius, 0, open_low=True, unit="m")
    real_number("depth_error", depth_error, 0, unit="m")
    real_number("half_thickness", half_thickness, 0, unit="m")
    rows = []
    for name, mask in named.items():
        given = array_of(f"masks[{name}]", mask, "b", "a mask of bool")
        if given.dtype != bool or given.shape != shape:
            raise ArgumentError(f"masks[{name}]", f"{given.dtype}, {given.shape}", f"bool, {shape}")
        cloud = points_of(given, z, camera, rim=True)
        if not len(cloud):
            continue
        centres, size, covering = balls_that_cover(
            cloud, depth_error=depth_error, half_thickness=half_thickness
        )
        rows.append(Obstacle(name, kind, _moved(place, centres), size, covering).row())
    for number, found in enumerate(items("fruits", fruits, "detections")):
        of_kind(f"fruits[{number}]", found, Detection)
        if found.status == DetectionStatus.WEAK:
            continue
        size = _radius_of(found, z, camera) if radius is None else radius
        centre = found.centre(size)[None]
        rows.append(Obstacle(f"fruit{number}", "fruit", _moved(place, centre), size, 0.0).row())
    return {"unit": "m", "objects": rows}


def _radius_of(found: Detection, z: FloatArray, camera: Camera) -> float:
    inside = camera.grid_rays() @ found.axis > math.cos(found.alpha)
    return fruit_radius(found, points_of(inside, z, camera))


def _moved(pose: FloatArray, points: FloatArray) -> FloatArray:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])
