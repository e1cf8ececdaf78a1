"""How sure a place is, and how near to it an arm may go."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, real_number, truth_value
from ..errors import ArgumentError
from ._detection import Detection
from ._images import of_kind

__all__ = ["Budget", "StandOff", "budget", "range_sigma", "stand_off"]

LEAST_GAP = 0.010
APPROACH_GAP = 0.040
# Squares of what is larger are no numbers any more.
_LARGEST = 1e6
# Of an outline's radius, as renders show it once its constant bias is taken out.
_PIXEL_SIGMA = 0.15


def range_sigma(
    detection: Detection,
    radius: float,
    *,
    radius_sigma: float = 0.0,
    pixel_sigma: float = _PIXEL_SIGMA,
) -> float:
    """Return the standard deviation of a distance that was told by size, m.

    Two terms: an error of the radius is passed on one to one; one of the outline's half angle
    counts D / tan(alpha).

    Parameters
    ----------
    detection : Detection
        What was seen.
    radius, radius_sigma : float, m
        The fruit's radius, and its standard deviation.
    pixel_sigma : float, default 0.15, pixels
        Of the outline's radius.

    Examples
    --------
    >>> from agrik_fast.vision import Detector, paper_camera, random_scene, range_sigma, render
    >>> picture = render(random_scene("clean", seed=1))
    >>> (found,) = Detector(paper_camera()).detect(picture.image)
    >>> sure = range_sigma(found, 0.03)
    >>> sure < range_sigma(found, 0.03, radius_sigma=0.0015)
    True
    """
    of_kind("detection", detection, Detection)
    far = detection.distance(radius)
    radius_sigma = real_number("radius_sigma", radius_sigma, 0, unit="m")
    pixel_sigma = real_number("pixel_sigma", pixel_sigma, 0, unit="pixels")
    tangent = math.tan(detection.alpha)
    focal = detection.radius_px / tangent
    # The angle that a pixel at the outline stands for.
    angle = pixel_sigma / focal / (1 + tangent**2)
    return math.hypot(far * radius_sigma / radius, far * angle / tangent)


class StandOff(NamedTuple):
    """Where an arm may go before a fruit.

    Attributes
    ----------
    first, final : ndarray, shape (3,), m
        A point 40 mm or more before the surface, and the last one.
    gap : float, m
        From the surface to the last point: 10 mm, or three standard deviations of the distance.

    Examples
    --------
    >>> from agrik_fast.vision import StandOff
    >>> found = StandOff(np.zeros(3), np.ones(3), 0.01)
    >>> found.gap
    0.01
    """

    first: FloatArray
    final: FloatArray
    gap: float


def stand_off(
    centre: ArrayLike,
    radius: float,
    *,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    sigma: float = 0.0,
) -> StandOff:
    """Return the points before a fruit's surface, on the line from a shoulder to its centre.

    The tomato paper aimed at the centre and hit the fruit. The gap follows what is known of the
    distance: with a radius known to 5 % it is 52 mm at 0.35 m.

    Parameters
    ----------
    centre : array_like, shape (3,), m
        Of the fruit.
    radius : float, m
        Of the fruit.
    origin : array_like, shape (3,), m
        Where the approach comes from: the shoulder, or the camera.
    sigma : float, m
        Standard deviation of the distance, as `range_sigma` gives it.

    Raises
    ------
    ArgumentError
        A number is out of its range, or the origin is inside the fruit.

    Examples
    --------
    >>> from agrik_fast.vision import stand_off
    >>> stand_off([0.3, 0, 0], 0.03).final.round(3).tolist()
    [0.26, 0.0, 0.0]
    """
    middle, start = finite_array("centre", centre, (3,)), finite_array("origin", origin, (3,))
    radius = real_number("radius", radius, 0, open_low=True, unit="m")
    gap = max(LEAST_GAP, 3 * real_number("sigma", sigma, 0, unit="m"))
    far = float(np.linalg.norm(middle - start))
    if far <= radius:
        raise ArgumentError(
            "origin", f"{far:g} m from the centre", f"outside the fruit, {radius:g}"
        )
    way = (middle - start) / far
    return StandOff(
        middle - (radius + max(gap, APPROACH_GAP)) * way, middle - (radius + gap) * way, gap
    )


@dataclass(frozen=True)
class Budget:
    """What an error is made of.

    Attributes
    ----------
    terms : mapping of str to float, m
        Standard deviations by name.
    total : float, m
        Root of the sum of their squares.
    percent : float
        The total in percent of the distance.

    Examples
    --------
    >>> from agrik_fast.vision import Budget
    >>> Budget(terms={"pixels": 0.001}, total=0.001, percent=0.5).total
    0.001
    """

    terms: Mapping[str, float]
    total: float
    percent: float


def budget(
    distance: float = 0.3,
    *,
    calibrated: bool = True,
    focal: float = 277.13,
    picture_px: float | None = None,
    calibration: float | None = None,
    camera_to_base: float | None = None,
    dead_band_deg: float = 0.45,
    servo_zero_deg: float | None = None,
    links: float | None = None,
    levers: tuple[float, float] = (0.26, 0.16),
    radius_share: float = 0.0,
) -> Budget:
    """Return the error of pointing at a fruit, term by term, 1 sigma.

    `calibrated` chooses the defaults of the terms that are not given: those of a calibrated rig, or
    those that may explain the tomato paper's percent. The latter's sizes are assumptions.

    Parameters
    ----------
    distance : float, default 0.3, m
        From the camera.
    calibrated : bool, default True
        Which defaults.
    focal : float, pixels
        Focal length.
    picture_px : float, pixels
        Of a fruit's centre: 0.35, or 0.7 % of 320 pixels.
    calibration : float, m
        Of the camera's calibration, or of scaling: 0.0006 or 0.0015.
    camera_to_base : float, m
        0.001 or 0.002.
    dead_band_deg : float, degrees
        Half the servos' dead band, evenly distributed.
    servo_zero_deg : float, degrees
        0.15 or 0.5.
    links : float, m
        Of the links' lengths: 0.0002 or 0.0007.
    levers : tuple of 2 floats, m
        From shoulder and elbow to the tip.
    radius_share : float
        Standard deviation of the fruit's radius as a share of it: all of it goes into the distance.

    Raises
    ------
    ArgumentError
        A number is out of its range.

    Examples
    --------
    >>> from agrik_fast.vision import budget
    >>> budget(0.3).percent < 1.0 < budget(0.3, calibrated=False).percent
    True
    """
    distance = real_number("distance", distance, 0, _LARGEST, open_low=True, unit="m")
    good = truth_value("calibrated", calibrated)
    focal = real_number("focal", focal, 0, _LARGEST, open_low=True, unit="pixels")

    def given(name: str, value: float | None, better: float, worse: float, unit: str) -> float:
        chosen = (better if good else worse) if value is None else value
        return real_number(name, chosen, 0, _LARGEST, unit=unit)

    reach = math.hypot(*finite_array("levers", levers, (2,)).tolist())
    dead = math.radians(real_number("dead_band_deg", dead_band_deg, 0, 360, unit="degrees"))
    zero = math.radians(given("servo_zero_deg", servo_zero_deg, 0.15, 0.5, "degrees"))
    terms = {
        "picture": given("picture_px", picture_px, 0.35, 2.24, "pixels") / focal * distance,
        "calibration": given("calibration", calibration, 0.0006, 0.0015, "m"),
        "camera to base": given("camera_to_base", camera_to_base, 0.001, 0.002, "m"),
        "servo dead band": dead / math.sqrt(3) * reach,
        "servo zero": zero * reach,
        "links": given("links", links, 0.0002, 0.0007, "m"),
        "radius": real_number("radius_share", radius_share, 0, 1) * distance,
    }
    total = math.sqrt(sum(value**2 for value in terms.values()))
    return Budget(MappingProxyType(terms), total, 100 * total / distance)
