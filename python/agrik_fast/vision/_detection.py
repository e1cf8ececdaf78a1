"""What was found in a picture, and how it may be used."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from .._checks import FloatArray, real_number

__all__ = ["Detection", "DetectionStatus"]


class DetectionStatus(IntEnum):
    """How a detection may be used.

    Examples
    --------
    >>> from agrik_fast.vision import DetectionStatus
    >>> DetectionStatus.OK.name
    'OK'
    """

    OK = 0
    """Fit to approach."""

    WEAK = 1
    """Reported, never approached: too little outline, too little red, too small or not round."""

    EDGE = 2
    """The picture's border cuts it: the position holds, the size less so; not approached."""

    NOT_FOUND = 3
    """Nothing was found: what a tracker or a table says of a whole picture."""


@dataclass(frozen=True)
class Detection:
    """A fruit that was found.

    Attributes
    ----------
    status : DetectionStatus
        Whether it may be approached.
    kind : str
        sphere, or spheroid for a flattened fruit.
    axis : ndarray, shape (3,)
        Unit vector towards its centre, in the camera's frame.
    uv : ndarray, shape (2,), pixels
        Where its centre is in the picture.
    alpha : float, rad
        Half angle in which it is seen.
    radius_px : float, pixels
        The same as a length, focal length times tan(alpha).
    cover : float
        Share of 36 sectors around the centre in which its outline was seen.
    fill : float
        Share of its disc that is red.
    score : float
        cover times the share of the outline that fits; larger is better.

    Examples
    --------
    >>> from agrik_fast.vision import Detector, paper_camera, random_scene, render
    >>> picture = render(random_scene("clean", seed=1))
    >>> best = Detector(paper_camera()).detect(picture.image)[0]
    >>> best.status.name, best.axis.shape
    ('OK', (3,))
    """

    status: DetectionStatus
    kind: str
    axis: FloatArray
    uv: FloatArray
    alpha: float
    radius_px: float
    cover: float
    fill: float
    score: float

    def distance(self, radius: float) -> float:
        """Return how far its centre is, m, by a known radius (m): R / sin(alpha).

        An error of the radius is passed on one to one: 5 % of R are 5 % of the distance.

        Examples
        --------
        >>> from agrik_fast.vision import Detector, Fruit, Scene, paper_camera, render
        >>> picture = render(Scene((Fruit((0, 0, 0.35), 0.03),)))
        >>> best = Detector(paper_camera()).detect(picture.image)[0]
        >>> abs(best.distance(0.03) - 0.35) < 0.02
        True
        """
        return real_number("radius", radius, 0, open_low=True, unit="m") / math.sin(self.alpha)

    def centre(self, radius: float) -> FloatArray:
        """Return its centre, shape (3,), m, in the camera's frame, by a known radius (m).

        Examples
        --------
        >>> from agrik_fast.vision import Detector, Fruit, Scene, paper_camera, render
        >>> picture = render(Scene((Fruit((0, 0, 0.35), 0.03),)))
        >>> best = Detector(paper_camera()).detect(picture.image)[0]
        >>> bool(abs(best.centre(0.03)[2] - 0.35) < 0.02)
        True
        """
        return self.distance(radius) * self.axis
