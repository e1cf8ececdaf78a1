"""Ripe fruits in a picture: from red blobs to the cones of their outlines."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, finite_array, real_number, shown
from ..errors import ArgumentError
from ._camera import Camera
from ._cluster import Outline, spheres_of
from ._cone import Cone, along, best_cone
from ._cv import opencv
from ._detection import Detection, DetectionStatus
from ._images import Image, checked_image, of_kind, same_size
from ._red import red_mask
from ._scenes import across, rim_of

__all__ = ["Detector"]

_AREA = 60
_MOST_BLOBS = 8
_LEFT_OVER = 0.1
_ON_CONE_PX = 1.3
_ON_ELLIPSE_PX = 1.5
_TAKEN_PX = 3.0
# Pixels of outline before and after a point that tell its direction, at a width of 320.
_TANGENT = 3
_SECTORS = 36
_BORDER_PX = 2
# Half axes of an outline that counts as an ellipse, and by how much its fit has to be better.
_ROUND, _LONGEST = 1.05, 1.7
_BETTER = 0.6
# A circle with less red inside is the edge of something that lies before a fruit.
_LEAST_FILL = 0.3
# Red that goes on beyond a circle and belongs to no fruit beside it: the circle is no outline then.
# One that is red all over is a fruit nevertheless, as in a cluster of which not all were found.
_RING, _MOST_BEYOND = (1.1, 1.35), 0.05
_ALL_RED = 0.96
# A centre so far inside a better circle, by its radius, is no fruit. Nearer to its outline it may
# be one that touches it, as exactly as both are seen.
_NESTED = 0.9


class Detector:
    """Finds ripe fruits in the pictures of one camera.

    Parameters
    ----------
    camera : Camera
        Its calibration.
    radius : tuple of 2 floats, m, optional
        Least and largest radius that a fruit may have; with `distance`, what is too small or too
        large in the picture is discarded.
    distance : tuple of 2 floats, m, optional
        Least and largest distance of a fruit.
    edge_bias_px : float, default 0.0, pixels
        Added to every outline's radius. One picture of a measured ball at a known distance tells
        it for a real camera.
    least_cover : float, default 0.38
        Share of 36 sectors of the outline that ``OK`` needs.
    least_fill : float, default 0.5
        Share of red inside that ``OK`` needs.
    least_score : float, default 0.12
        Score that ``OK`` needs; choose it on photographs of your own.
    least_radius_px : float, default 8.0, pixels
        Radius that ``OK`` and ``EDGE`` need: of a smaller circle half a pixel of outline is more
        than 6 % of the distance, and specks of red are as round.

    Raises
    ------
    ArgumentError
        A number is out of its range.

    Examples
    --------
    >>> from agrik_fast.vision import Detector, paper_camera, random_scene, render
    >>> picture = render(random_scene("clean", seed=1))
    >>> found = Detector(paper_camera()).detect(picture.image)
    >>> [each.status.name for each in found]
    ['OK']
    """

    def __init__(
        self,
        camera: Camera,
        *,
        radius: tuple[float, float] | None = None,
        distance: tuple[float, float] | None = None,
        edge_bias_px: float = 0.0,
        least_cover: float = 0.38,
        least_fill: float = 0.5,
        least_score: float = 0.12,
        least_radius_px: float = 8.0,
    ) -> None:
        self.camera = of_kind("camera", camera, Camera)
        if (radius is None) != (distance is None):
            raise ArgumentError("radius, distance", "one of them", "both or neither")
        self.narrowest, self.widest = 0.0, math.inf
        if radius is not None and distance is not None:
            small, large = _range("radius", radius)
            near, far = _range("distance", distance)
            self.narrowest = math.asin(min(small / far, 1.0))
            self.widest = math.asin(min(large / near, 1.0))
        self.edge_bias_px = real_number("edge_bias_px", edge_bias_px, -20, 20, unit="pixels")
        self.least_cover = real_number("least_cover", least_cover, 0, 1)
        self.least_fill = real_number("least_fill", least_fill, 0, 1)
        self.least_score = real_number("least_score", least_score, 0, 1)
        self.least_radius_px = real_number("least_radius_px", least_radius_px, 0, unit="pixels")

    def detect(self, image: Image) -> list[Detection]:
        """Return the fruits of a picture, the best first; empty where there are none.

        Parameters
        ----------
        image : ndarray, shape (height, width, 3), uint8
            Blue, green, red, of the calibration's size.

        Raises
        ------
        ArgumentError
            It is grey, of floats, empty, tiny, or of another size than the calibration.

        Examples
        --------
        >>> from agrik_fast.vision import Detector, paper_camera, random_scene, render
        >>> picture = render(random_scene("clean", seed=1))
        >>> len(Detector(paper_camera()).detect(picture.image))
        1
        """
        image = checked_image("image", image)
        same_size("image", image, self.camera.width, self.camera.height)
        return self.in_mask(red_mask(image))

    def bias(self, image: Image, radius: float, distance: float) -> float:
        """Return the `edge_bias_px` by which a measured ball comes out at its distance.

        Parameters
        ----------
        image : ndarray, shape (height, width, 3), uint8
            A picture of one ball.
        radius, distance : float, m
            Its radius, and how far its centre is.

        Raises
        ------
        ArgumentError
            The picture does not show exactly one round fruit that is ok.

        Examples
        --------
        >>> from agrik_fast.vision import Detector, Fruit, Scene, paper_camera, render
        >>> camera = paper_camera()
        >>> picture = render(Scene((Fruit((0, 0, 0.35), 0.03),)), camera)
        >>> abs(Detector(camera).bias(picture.image, 0.03, 0.35)) < 2
        True
        """
        radius = real_number("radius", radius, 0, open_low=True, unit="m")
        distance = real_number("distance", distance, radius, open_low=True, unit="m")
        sure = [each for each in self.detect(image) if each.status == DetectionStatus.OK]
        if len(sure) != 1:
            raise ArgumentError("image", f"{len(sure)} fruits that are ok", "one measured ball")
        off = math.asin(radius / distance) - sure[0].alpha
        return self.edge_bias_px + off * self.camera.focal

    def in_mask(self, mask: NDArray[np.uint8]) -> list[Detection]:
        """Return the round fruits of a mask: one of your own, whatever colour it stands for.

        Parameters
        ----------
        mask : ndarray, shape (height, width), uint8
            Not 0 where there is fruit.

        Raises
        ------
        ArgumentError
            It is no mask of the calibration's size.

        Examples
        --------
        >>> from agrik_fast.vision import Detector, paper_camera, random_scene, red_mask, render
        >>> picture = render(random_scene("clean", seed=1))
        >>> len(Detector(paper_camera()).in_mask(red_mask(picture.image)))
        1
        """
        cv2 = opencv()
        shape = (self.camera.height, self.camera.width)
        given: object = mask
        if not isinstance(given, np.ndarray) or mask.dtype != np.uint8 or mask.shape != shape:
            array = isinstance(given, np.ndarray)
            received = f"{mask.dtype}, {mask.shape}" if array else shown(given)
            raise ArgumentError("mask", received, f"uint8, shape {shape}")
        outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        least = _AREA * (self.camera.width / 320) ** 2
        sized = [(cv2.contourArea(each), each[:, 0, :]) for each in outlines]
        sized = [(area, each) for area, each in sized if area >= least]
        sized.sort(key=lambda pair: -pair[0])
        found: list[Detection] = []
        for area, outline in sized[:_MOST_BLOBS]:
            hull = cv2.contourArea(cv2.convexHull(outline))
            found += self._in_blob(mask, outline, area / max(hull, 1.0))
        found = _without_nested(found)
        return [self._judged(mask, each, found) for each in found]

    # ---- one blob ----------------------------------------------------------------------------

    def _in_blob(self, mask: NDArray[np.uint8], outline: Any, solidity: float) -> list[Detection]:
        camera = self.camera
        # The border of the picture is no outline.
        limit = np.array([camera.width, camera.height]) - 1 - _BORDER_PX
        inside = ((outline >= _BORDER_PX) & (outline <= limit)).all(axis=1)
        edge = not bool(inside.all())
        if inside.sum() < 6:
            return []
        whole = self._outline(outline.astype(np.float64))
        seen = whole.of(np.nonzero(inside)[0])
        rays = seen.rays
        tolerance, narrowest = _ON_CONE_PX / camera.focal, self.narrowest * 0.98
        best = best_cone(rays, tolerance, narrowest, self.widest)
        if best is None:
            return []
        cone, on = best
        cones = [cone]
        over = np.abs(cone.off(rays)) >= _TAKEN_PX / camera.focal
        if over.sum() >= max(_LEFT_OVER * len(rays), 6):
            cones = spheres_of(seen, camera.focal, tolerance, narrowest, self.widest) or cones
        if solidity >= 0.96 and not edge:
            spheroid = self._spheroid(mask, rays, cone, float(on.mean()), cones)
            if spheroid is not None:
                return [spheroid]
        found: list[Detection] = []
        left = np.ones(len(rays), bool)
        for cone in cones:
            off = np.abs(cone.off(rays))
            share = float((off[left] < tolerance).sum()) / max(int(left.sum()), 1)
            detection = self._detection("sphere", mask, cone, rays, share, edge)
            if detection is not None:
                found.append(detection)
            left &= off >= _TAKEN_PX / camera.focal
        return found

    def _outline(self, pixels: FloatArray) -> Outline:
        """Return the rays of a closed outline's pixels, and which way is out."""
        rays = self.camera.rays(pixels)
        step = max(round(_TANGENT * self.camera.width / 320), 1)
        out = np.cross(np.roll(rays, -step, axis=0) - np.roll(rays, step, axis=0), rays)
        u, v = pixels.T
        turned = float(np.sum(u * np.roll(v, -1) - v * np.roll(u, -1)))
        out *= math.copysign(1.0, turned) / np.maximum(np.linalg.norm(out, axis=1), 1e-12)[:, None]
        return Outline(rays, out)

    def _detection(
        self,
        kind: str,
        mask: NDArray[np.uint8],
        cone: Cone,
        rays: FloatArray,
        share: float,
        edge: bool,
        on: NDArray[np.bool_] | None = None,
    ) -> Detection | None:
        """Return what a cone is worth, or None where it is out of bounds."""
        camera = self.camera
        if on is None:
            on = np.abs(cone.off(rays)) < _ON_CONE_PX / camera.focal
        first, second = across(cone.axis)
        turn = np.arctan2(along(rays[on], second), along(rays[on], first))
        sectors = np.floor((turn / (2 * math.pi) + 0.5) * _SECTORS).astype(int) % _SECTORS
        cover = len(np.unique(sectors)) / _SECTORS
        # The outline runs through the outermost pixels inside: half a pixel more.
        alpha = cone.alpha + (0.5 + self.edge_bias_px) / camera.focal
        if not (self.narrowest <= alpha <= self.widest and 0 < alpha < math.pi / 2):
            return None
        fill = self._fill(mask, cone.axis, alpha)
        if fill < _LEAST_FILL:
            return None
        score = cover * share
        radius_px = camera.focal * math.tan(alpha)
        status = DetectionStatus.WEAK
        if self._sound(radius_px, fill, score):
            if edge and self._at_border(cone.axis, alpha):
                status = DetectionStatus.EDGE
            elif cover >= self.least_cover:
                status = DetectionStatus.OK
        return Detection(
            status,
            kind,
            cone.axis,
            camera.project(cone.axis),
            alpha,
            radius_px,
            cover,
            fill,
            score,
        )

    def _sound(self, radius_px: float, fill: float, score: float) -> bool:
        """Whether a detection is more than weak, as far as it does not depend on the border."""
        return (
            radius_px >= self.least_radius_px
            and fill >= self.least_fill
            and score >= self.least_score
        )

    def _fill(self, mask: NDArray[np.uint8], axis: FloatArray, alpha: float) -> float:
        """Return the share of a disc that is in the mask, of that part that is in the picture."""
        part = self._around(axis, alpha)
        if part is None:
            return 0.0
        inside = along(self.camera.grid_rays()[part], axis) > math.cos(alpha)
        count = int(inside.sum())
        return float((mask[part][inside] > 0).sum() / count) if count else 0.0

    def _around(self, axis: FloatArray, alpha: float) -> tuple[slice, slice] | None:
        """Return every other row and column of the part of the picture that holds a cone."""
        camera = self.camera
        uv = camera.project(axis)
        if not np.isfinite(uv).all():
            return None
        # Off the axis a disc is longer than it is wide.
        half = 1.3 * camera.focal * math.tan(alpha) / max(float(axis[2]), 0.3) ** 2 + 2
        left, top = (max(int(c - half), 0) for c in uv)
        return slice(top, int(uv[1] + half) + 1, 2), slice(left, int(uv[0] + half) + 1, 2)

    def _judged(
        self, mask: NDArray[np.uint8], each: Detection, found: list[Detection]
    ) -> Detection:
        """Return a detection, weak where red goes on beyond it that is no other fruit's."""
        if each.status == DetectionStatus.WEAK or each.fill >= _ALL_RED:
            return each
        near, far = (factor * each.alpha for factor in _RING)
        part = self._around(each.axis, far)
        if part is None or far >= math.pi / 2:
            return each
        rays = self.camera.grid_rays()[part]
        cosine = along(rays, each.axis)
        ring = (cosine < math.cos(near)) & (cosine > math.cos(far))
        red = ring & (mask[part] > 0)
        for other in found:
            if other.fill >= _ALL_RED and other.status != DetectionStatus.WEAK:
                red &= along(rays, other.axis) < math.cos(1.06 * other.alpha)
        if red.sum() <= _MOST_BEYOND * ring.sum():
            return each
        return replace(each, status=DetectionStatus.WEAK)

    def _at_border(self, axis: FloatArray, alpha: float) -> bool:
        """Whether a cone reaches the picture's border."""
        uv = self.camera.project(rim_of(axis, alpha, 24))
        size = np.array([self.camera.width, self.camera.height])
        return not bool(((uv > 1) & (uv < size - 2)).all())

    def _spheroid(
        self,
        mask: NDArray[np.uint8],
        rays: FloatArray,
        cone: Cone,
        share: float,
        cones: list[Cone],
    ) -> Detection | None:
        """Return an ellipse on the plane that touches the axis, where it fits much better.

        Not where two spheres tell more of the outline than it does. The longer half axis of an
        oblate fruit's outline is its equatorial radius from every side.
        """
        cv2 = opencv()
        focal = self.camera.focal
        first, second = across(cone.axis)
        depth = along(rays, cone.axis)
        flat = np.stack([along(rays, first) / depth, along(rays, second) / depth], axis=1)
        flat *= focal
        on = np.ones(len(flat), bool)
        for _ in range(4):
            if on.sum() < 12:
                return None
            middle, sizes, degrees = cv2.fitEllipseDirect(flat[on].astype(np.float32))
            if not (np.isfinite([*middle, *sizes, degrees]).all() and min(sizes) > 0):
                return None
            on = np.abs(_off_ellipse(flat, middle, sizes, degrees)) < _ON_ELLIPSE_PX
        long, short = max(sizes) / 2, min(sizes) / 2
        off = _off_ellipse(flat, middle, sizes, degrees)
        fit = float(on.mean())
        # Either far more of the outline fits, or what fits does so far better.
        more = share < 0.8 and fit > share + 0.1 and fit > 0.75
        rough = focal * float(np.sqrt(np.mean(cone.off(rays) ** 2)))
        better = fit > 0.9 and float(np.sqrt(np.mean(off**2))) < _BETTER * rough
        if not ((more or better) and _ROUND <= long / short <= _LONGEST):
            return None
        if len(cones) > 1:
            told = np.min([np.abs(each.off(rays)) for each in cones], axis=0)
            if float((told < _ON_ELLIPSE_PX / focal).mean()) > fit:
                return None
        axis = cone.axis + (middle[0] * first + middle[1] * second) / focal
        axis /= np.linalg.norm(axis)
        found = Cone(axis, math.atan(long / focal))
        detection = self._detection("spheroid", mask, found, rays, fit, False, on)
        if detection is None or not math.isfinite(detection.alpha):
            return None
        # The disc of the longer half axis is wider than the fruit.
        fill = min(detection.fill * long / short, 1.0)
        sound = detection.cover >= self.least_cover and self._sound(
            detection.radius_px, fill, detection.score
        )
        status = DetectionStatus.OK if sound else DetectionStatus.WEAK
        return replace(detection, fill=fill, status=status)


def _off_ellipse(
    points: FloatArray, middle: FloatArray, sizes: FloatArray, degrees: float
) -> FloatArray:
    """Return how far points are outside an ellipse, to first order."""
    turn = math.radians(degrees)
    x, y = (points - middle).T
    u = (x * math.cos(turn) + y * math.sin(turn)) / (sizes[0] / 2)
    v = (y * math.cos(turn) - x * math.sin(turn)) / (sizes[1] / 2)
    size = np.hypot(u, v)
    slope = np.hypot(u / (sizes[0] / 2), v / (sizes[1] / 2))
    return np.asarray((size - 1) * size / np.maximum(slope, 1e-9))


def _without_nested(found: list[Detection]) -> list[Detection]:
    """Return detections, the best first, without those whose centre lies well inside a better."""
    kept: list[Detection] = []
    for each in sorted(found, key=lambda d: (d.status == DetectionStatus.WEAK, -d.score)):
        if all(
            math.acos(float(np.clip(each.axis @ other.axis, -1, 1))) > _NESTED * other.alpha
            for other in kept
        ):
            kept.append(each)
    return kept


def _range(name: str, value: object) -> tuple[float, float]:
    low, high = finite_array(name, value, (2,)).tolist()  # type: ignore[arg-type]
    if not 0 < low <= high:
        raise ArgumentError(name, str(value), "two lengths, 0 < least <= largest, m")
    return low, high
