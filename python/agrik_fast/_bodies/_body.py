"""A solid on a frame of an arm, and which pairs of such solids are asked about each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from .._checks import items, real_number, shown, text, whole_number
from ..errors import ArgumentError
from ._shapes import BodyShape, Box, Capsule, Convex, Cover, Sphere

Pair: TypeAlias = tuple[str, str]


@dataclass(frozen=True)
class Body:
    """A solid that stands still in one frame of an arm.

    Parameters
    ----------
    name : str
        Its name, which no other body of the arm has.
    frame : int or str
        The frame: 0 or "base" for the base frame, k or a name out of ``Robot.link_names`` for
        that of link k (1 is the first); "tool", the last, is the tool frame.
    shape : Sphere, Capsule, Box, Convex or Cover
        What it is, in that frame, m.
    provenance : str, optional
        Where its numbers are from.
    overestimate : float, optional, m
        How far it reaches out of what it stands for; None if nobody said.

    Raises
    ------
    ArgumentError
        Something else than a shape, an empty name, a negative number.

    Examples
    --------
    >>> from agrik_fast.collision import Body, Sphere
    >>> Body("fruit", "tool", Sphere([0, 0, 0.04], 0.03)).frame
    'tool'
    """

    name: str
    frame: int | str
    shape: BodyShape
    provenance: str = ""
    overestimate: float | None = None

    def __post_init__(self) -> None:
        if not text("name", self.name):
            raise ArgumentError("name", "an empty text", "a name of one letter or more")
        if not isinstance(self.frame, str):
            object.__setattr__(self, "frame", whole_number("frame", self.frame, 0))
        shape: object = self.shape
        if not isinstance(shape, Sphere | Capsule | Box | Convex | Cover):
            expected = "a Sphere, Capsule, Box, Convex or Cover"
            raise ArgumentError(f"shape of {self.name!r}", shown(shape), expected)
        text("provenance", self.provenance)
        if self.overestimate is not None:
            over = real_number("overestimate", self.overestimate, 0.0, unit="m")
            object.__setattr__(self, "overestimate", over)


@dataclass(frozen=True)
class CollisionRules:
    """Which collisions of an arm's bodies count.

    Parameters
    ----------
    may_touch_target : sequence of str
        Bodies that may touch the objects of a target while the tool point is near it: the
        gripper.
    static_skip : sequence of (body, object)
        A body, and an object of a scene that it does not mind: what the arm stands on.
        Objects that a scene does not have do not matter.
    pairs : sequence of (body, body), optional
        The pairs of bodies that are asked whether they hit each other. Default: all but those
        that cannot, or always do; see `SelfPairs`.
    exclude : sequence of (body, body)
        Pairs that are not asked, without `pairs`.

    Raises
    ------
    ArgumentError
        Something else than names; both `pairs` and `exclude`.

    Examples
    --------
    >>> ik.Robot.load("cucumber").collision_rules.may_touch_target
    ('gripper', 'flange')
    """

    may_touch_target: tuple[str, ...] = ()
    static_skip: tuple[Pair, ...] = ()
    pairs: tuple[Pair, ...] | None = None
    exclude: tuple[Pair, ...] = ()

    def __post_init__(self) -> None:
        names = items("may_touch_target", self.may_touch_target, "a sequence of names")
        put = object.__setattr__
        put(self, "may_touch_target", tuple(text("may_touch_target", name) for name in names))
        for field in ("static_skip", "pairs", "exclude"):
            value = getattr(self, field)
            if value is not None:
                put(self, field, _pairs(field, value))
        if self.pairs is not None and self.exclude:
            raise ArgumentError("exclude", "pairs as well", "either pairs or exclude")


def _pairs(field: str, value: object) -> tuple[Pair, ...]:
    found = []
    for pair in items(field, value, "pairs of names"):
        both = items(field, pair, "pairs of names")
        if len(both) != 2:
            raise ArgumentError(field, shown(pair), "pairs of names")
        found.append((text(field, both[0]), text(field, both[1])))
    return tuple(found)


@dataclass(frozen=True)
class ExcludedPair:
    """Two bodies that are not asked whether they hit each other.

    Attributes
    ----------
    bodies : (str, str)
        Their names.
    reason : str
        "same link"; "adjacent", on links that one joint joins; "structural", at most two
        joints apart and hitting in more than a quarter of 4,000 postures, or in more than 95 %
        at any distance; "not listed" or "excluded" by the rules of the robot.
    share : float or None
        Share of the postures that hit, of a structural pair.

    Examples
    --------
    >>> one = ik.Robot.load("panda").self_pairs.excluded[0]
    >>> len(one.bodies), bool(one.reason)
    (2, True)
    """

    bodies: Pair
    reason: str
    share: float | None = None


@dataclass(frozen=True)
class SelfPairs:
    """Which bodies of an arm are asked whether they hit each other, and why others are not.

    Pairs that were never seen hitting are asked: a sample is no proof.

    Attributes
    ----------
    asked : tuple of (str, str)
        Pairs that are asked.
    excluded : tuple of ExcludedPair
        All others, with the reason.

    Examples
    --------
    >>> pairs = ik.Robot.load("panda").self_pairs
    >>> len(pairs.asked) > 0, len(pairs.excluded) > 0
    (True, True)
    """

    asked: tuple[Pair, ...]
    excluded: tuple[ExcludedPair, ...]
