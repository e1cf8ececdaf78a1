"""What the two-step method looks at, and what it prefers."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

from .._checks import real_number, truth_value, whole_number, word
from ..errors import ArgumentError

__all__ = ["Distance", "Settings"]

Distance = Literal["exact", "tree"]


@dataclass(frozen=True)
class Settings:
    """Settings of the two-step method; the paper prints none of these numbers.

    Parameters
    ----------
    angles : int, default 73
        Approach angles of the first scan, from ``-range`` to ``range``.
    range : float, default pi / 2, rad
        Farthest approach angle to either side of x, about the vertical.
    slides : int, default 41
        Places of the slide in the second scan, from one end to the other.
    min_distance : float, default 0.005, m
        Distance that a posture keeps from the crop.
    min_freedom : float, default 0.03
        Joint freedom that a posture keeps: distance of its worst turning joint from a limit,
        as a share of half the joint's range.
    enough : float, default 0.075, m
        Distance from the crop beyond which more is of no use.
    distance_weight, freedom_weight : float, default 0.6 and 0.4
        What distance (as a share of `enough`) and joint freedom weigh in the score.
    recovery : bool, default True
        Go on after the best approach angle has failed: with other angles, a finer grid round
        near misses, a tilted or shifted gripper, and a scan of all angles, in this order.
    spread : float, default 10 degrees, rad
        Other angles this far from all that failed are tried first.
    most_angles : int, default 8
        Angles tried one after the other before the rest of the recovery.
    tilt : float, default 0, rad
        How far the gripper may be tilted up or down; 0 for not at all.
    shift : float, default 0, m
        How far the grip point may be moved along the fruit; 0 for not at all.
    refine : bool, default False
        Improve the posture by a pattern search in approach angle and slide.
    time_limit : float, optional, s
        A decision that takes longer ends with `Status.TIME_LIMIT`. Answers then depend on
        the machine.

    Raises
    ------
    ArgumentError
        A number out of its range, or both weights 0.

    Examples
    --------
    >>> careful = ik.harvest.Settings(min_distance=0.01)
    >>> scene = ik.harvest.example_scene()
    >>> found = ik.harvest.plan("cucumber", scene, ["C1"], settings=careful)
    >>> bool(found["C1"].distance >= 0.01)
    True
    """

    angles: int = 73
    range: float = math.pi / 2
    slides: int = 41
    min_distance: float = 0.005
    min_freedom: float = 0.03
    enough: float = 0.075
    distance_weight: float = 0.6
    freedom_weight: float = 0.4
    recovery: bool = True
    spread: float = math.radians(10)
    most_angles: int = 8
    tilt: float = 0.0
    shift: float = 0.0
    refine: bool = False
    time_limit: float | None = None

    def __post_init__(self) -> None:
        whole_number("angles", self.angles, 1, 100_000)
        whole_number("slides", self.slides, 1, 100_000)
        whole_number("most_angles", self.most_angles, 1, 100_000)
        real_number("range", self.range, 0.0, math.pi, unit="rad")
        real_number("min_distance", self.min_distance, 0.0, unit="m")
        real_number("min_freedom", self.min_freedom, 0.0, 1.0)
        if real_number("enough", self.enough, 0.0, unit="m") == 0:
            raise ArgumentError("enough", "0", "a length above 0, m")
        real_number("distance_weight", self.distance_weight, 0.0)
        real_number("freedom_weight", self.freedom_weight, 0.0)
        if self.distance_weight + self.freedom_weight == 0:
            raise ArgumentError("weights", "all zero", "one of the weights above 0")
        real_number("spread", self.spread, 0.0, unit="rad")
        real_number("tilt", self.tilt, 0.0, math.pi / 2, unit="rad")
        real_number("shift", self.shift, 0.0, unit="m")
        truth_value("recovery", self.recovery)
        truth_value("refine", self.refine)
        if self.time_limit is not None and real_number("time_limit", self.time_limit, 0.0) == 0:
            raise ArgumentError("time_limit", "0", "a time above 0, s")

    def as_options(self) -> dict[str, Any]:
        """Return the settings as the compiled core takes them.

        Examples
        --------
        >>> ik.harvest.Settings(angles=37).as_options()["angles"]
        37
        """
        return asdict(self)


def checked_distance(distance: str) -> str:
    """Return the name of a way to measure distances."""
    return word("distance", distance, ("exact", "tree"))
