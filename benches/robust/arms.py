"""Random arms of the kinds that break solvers, each with the Python that builds it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .building import CONTINUOUS, PRISMATIC, REVOLUTE, Place, from_dh, from_places, place_of
from .chain import Arm, Array, random_rotation, transform

SCALES = (1e-3, 1e-2, 0.1, 1.0, 1.0, 1.0, 1.0, 10.0, 1e3)


def draw(rng: np.random.Generator) -> Arm:
    """Draw an arm."""
    names = list(KINDS)
    share = np.array([KINDS[name].share for name in names])
    kind = names[rng.choice(len(names), p=share / share.sum())]
    scale = float(rng.choice(SCALES))
    return KINDS[kind].make(rng, scale, kind)


# ---- limits ------------------------------------------------------------------------------------


def limits(rng: np.random.Generator, regime: str, kind: str, travel: float) -> tuple[float, float]:
    """Draw the limits of one joint: of a regime for the whole arm, now and then of its own."""
    if kind == CONTINUOUS:
        return -np.inf, np.inf
    if rng.random() < 0.1:
        regime = str(rng.choice(REGIMES))
    if kind == PRISMATIC:
        return _slide_limits(rng, regime, travel)
    narrow = float(rng.uniform(-3, 3))
    match regime:
        case "usual":
            most = float(rng.choice([1.57, 2.0, 2.9, 2.967, 3.1, np.pi]))
            return -most, most
        case "uneven":
            low, high = np.sort(rng.uniform(-np.pi, np.pi, 2))
            return float(low), float(high)
        case "narrow":
            return narrow, narrow + float(10.0 ** rng.uniform(-7, -0.3))
        case "two turns":
            return -2 * np.pi, 2 * np.pi
        case "odd":
            odd = (
                (np.pi / 8, 2 * np.pi),
                (-12 * np.pi, -8 * np.pi),
                (20 * np.pi, 22 * np.pi),
                (-0.1, 6.2),
                (0.0, 0.0),
                (-np.pi / 2, np.pi / 2),
            )
            return odd[rng.integers(len(odd))]
        case "far out":
            most = float(rng.choice([30.0, 1e4, 999999.0, 1e8, 1e16]))
            return -most, most
        case "infinite":
            return -np.inf, np.inf
    raise ValueError(regime)


REGIMES = ("usual", "uneven", "narrow", "two turns", "odd", "far out", "infinite")
_REGIME_SHARES = (0.42, 0.16, 0.08, 0.14, 0.08, 0.1, 0.02)


def _slide_limits(rng: np.random.Generator, regime: str, travel: float) -> tuple[float, float]:
    if regime == "narrow":
        low = float(rng.uniform(-1, 1)) * travel
        return low, low + travel * float(10.0 ** rng.uniform(-6, -1))
    if regime == "far out":
        most = float(rng.choice([1e4, 999999.0, 1e16])) * max(travel, 1e-3)
        return -most, most
    if regime == "uneven":
        low, high = np.sort(rng.uniform(-1, 1, 2)) * travel
        return float(low), float(high)
    return (0.0, travel) if rng.random() < 0.6 else (-travel / 2, travel / 2)


def regime(rng: np.random.Generator) -> str:
    return str(rng.choice(REGIMES, p=_REGIME_SHARES))


# ---- parts ---------------------------------------------------------------------------------------


def right_angle(rng: np.random.Generator, rounding: int | None) -> float:
    """A right angle, exact or as files have it: rounded to some decimals."""
    angle = float(rng.choice([-1, 1])) * np.pi / 2
    return angle if rounding is None else round(angle, rounding)


def rounding(rng: np.random.Generator) -> int | None:
    """To how many decimals a file's angles are rounded; None for exact ones."""
    return None if rng.random() < 0.5 else int(rng.choice([3, 4, 5, 6, 8, 10, 12]))


def misfit(rng: np.random.Generator, scale: float) -> Array:
    """By how much axes that should meet miss each other, m; mostly not at all."""
    if rng.random() < 0.6:
        return np.zeros(3)
    return rng.normal(size=3) * float(10.0 ** rng.uniform(-12, -9)) * min(scale, 1.0)


def tool_of(rng: np.random.Generator, scale: float) -> Array:
    """A tool: none, a plain offset along z, any frame, or one that is far away."""
    kind = rng.random()
    if kind < 0.35:
        return np.eye(4)
    if kind < 0.6:
        return transform(None, (0.0, 0.0, float(rng.uniform(0.02, 0.4)) * scale))
    far = float(rng.choice([0.2, 1.0, 3.0, 30.0], p=[0.5, 0.2, 0.15, 0.15])) * scale
    return transform(random_rotation(rng), rng.normal(size=3) * far / np.sqrt(3))


def base_of(rng: np.random.Generator, scale: float) -> Array:
    if rng.random() < 0.7:
        return np.eye(4)
    return transform(random_rotation(rng), rng.uniform(-1, 1, 3) * scale)


# ---- kinds ---------------------------------------------------------------------------------------

Maker = Callable[[np.random.Generator, float, str], Arm]


def random_dh(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """Any DH rows, right angles and zeros more often than others."""
    n = int(rng.integers(1, 10))
    rows = np.zeros((n, 4))
    rows[:, [0, 2]] = rng.choice([0.0, 0.0, 1.0, 0.3], (n, 2)) * rng.uniform(-1, 1, (n, 2)) * scale
    right = rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi], (n, 2))
    any_angle = rng.uniform(-4, 4, (n, 2))
    rows[:, [1, 3]] = np.where(rng.random((n, 2)) < 0.6, right, any_angle)
    kinds = [str(k) for k in rng.choice([REVOLUTE, CONTINUOUS, PRISMATIC, "fixed"], n,
                                        p=[0.65, 0.12, 0.18, 0.05])]  # fmt: skip
    if all(k == "fixed" for k in kinds):
        kinds[0] = REVOLUTE
    about = regime(rng)
    ends = [
        limits(rng, about, k, scale * float(rng.uniform(0.2, 2))) if k != "fixed" else (0.0, 0.0)
        for k in kinds
    ]
    convention = str(rng.choice(["standard", "modified"]))
    tool, base = tool_of(rng, scale), base_of(rng, scale)
    return from_dh(rows, convention, kinds, ends, tool, base, kind, scale)


def random_urdf(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """Any places and axes, followers among them."""
    n = int(rng.integers(2, 10))
    about = regime(rng)
    digits = rounding(rng)
    places: list[Place] = []
    for _ in range(n):
        k = str(rng.choice([REVOLUTE, CONTINUOUS, PRISMATIC], p=[0.7, 0.13, 0.17]))
        axis = np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0])
        if rng.random() < 0.3:
            axis = rng.normal(size=3)
        rpy = [right_angle(rng, digits) if rng.random() < 0.4 else 0.0 for _ in range(3)]
        if rng.random() < 0.3:
            rpy = rng.uniform(-np.pi, np.pi, 3).tolist()
        xyz = rng.uniform(-0.4, 0.4, 3) * rng.choice([0.0, 1.0], 3) * scale
        low, high = limits(rng, about, k, scale * float(rng.uniform(0.2, 1)))
        places.append(Place(k, xyz.tolist(), rpy, axis.tolist(), low, high))
    if rng.random() < 0.4:
        _follow(rng, places)
    return from_places(places, tool_of(rng, scale), base_of(rng, scale), kind, scale)


def _follow(rng: np.random.Generator, places: list[Place]) -> None:
    """Make one joint follow another of its kind; what it allows does not bind."""
    leader, follower = rng.permutation(len(places))[:2]
    one, other = places[leader], places[follower]
    slides = one.kind == PRISMATIC
    if slides != (other.kind == PRISMATIC) or max(abs(one.lower), abs(one.upper)) > 100:
        return
    multiplier = float(rng.choice([-1.0, 1.0, 0.5, -2.0, 1.5]))
    other.kind = PRISMATIC if slides else CONTINUOUS
    other.lower, other.upper = (-1e9, 1e9) if slides else (-np.inf, np.inf)
    other.mimic = (f"j{leader}", multiplier, float(rng.choice([0.0, 0.1])))


def wrist_6r(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """Six joints whose last three axes meet, or nearly so."""
    digits = rounding(rng)
    about = regime(rng)
    lengths = rng.uniform(0.05, 0.6, 6) * scale * rng.choice([0.0, 1.0, 1.0], 6)
    turn = [right_angle(rng, digits) for _ in range(6)]
    order = rng.random()
    places = [
        Place(REVOLUTE, (0.0, 0.0, lengths[0])),
        Place(REVOLUTE, (lengths[1], 0.0, 0.0), (turn[0], 0.0, 0.0)),
        Place(REVOLUTE, (0.3 * scale + lengths[2], 0.0, lengths[5] * (order < 0.5))),
        Place(REVOLUTE, (lengths[3], -0.3 * scale - lengths[4], 0.0), (turn[1], 0.0, 0.0)),
        Place(REVOLUTE, misfit(rng, scale), (turn[2], 0.0, 0.0)),
        Place(REVOLUTE, misfit(rng, scale), (-turn[2] if digits is None else turn[3], 0.0, 0.0)),
    ]
    if rng.random() < 0.15:
        # Wrists of painting robots: their axes are not square.
        places[4].rpy = (float(rng.uniform(0.5, 1.4)), 0.0, 0.0)
        places[5].rpy = (float(-rng.uniform(0.5, 1.4)), 0.0, 0.0)
    _limit(rng, places, about)
    return from_places(places, tool_of(rng, scale), base_of(rng, scale), kind, scale)


def srs_7r(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """Shoulder and wrist of three axes each that meet, and an elbow."""
    digits = rounding(rng)
    upper, fore = rng.uniform(0.1, 0.6, 2) * scale
    side = float(rng.choice([-1, 1]))
    turn = [side * (np.pi / 2 if digits is None else round(np.pi / 2, digits)) for _ in range(6)]
    offset = float(rng.uniform(-0.1, 0.1)) * scale if rng.random() < 0.15 else 0.0
    places = [
        Place(REVOLUTE, (0.0, 0.0, float(rng.uniform(0, 0.4)) * scale)),
        Place(REVOLUTE, misfit(rng, scale), (-turn[0], 0.0, 0.0)),
        Place(REVOLUTE, misfit(rng, scale), (turn[1], 0.0, 0.0)),
        Place(REVOLUTE, (offset, 0.0, upper), (turn[2], 0.0, 0.0)),
        Place(REVOLUTE, (-offset, side * fore, 0.0), (-turn[3], 0.0, 0.0)),
        Place(REVOLUTE, misfit(rng, scale), (-turn[4], 0.0, 0.0)),
        Place(REVOLUTE, misfit(rng, scale), (turn[5], 0.0, 0.0)),
    ]
    _limit(rng, places, regime(rng))
    return from_places(places, tool_of(rng, scale), base_of(rng, scale), kind, scale)


def ur_like(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """Three parallel axes and a wrist of offsets; limits of two turns as a rule."""
    d1, a2, a3, d4, d5, d6 = rng.uniform(0.05, 0.6, 6) * scale
    digits = rounding(rng)
    right = np.pi / 2 if digits is None else round(np.pi / 2, digits)
    rows = np.array(
        [
            [0.0, right, d1, 0.0],
            [-a2, 0.0, 0.0, 0.0],
            [-a3, 0.0, 0.0, 0.0],
            [0.0, right, d4, 0.0],
            [0.0, -right, d5, 0.0],
            [0.0, 0.0, d6, 0.0],
        ]
    )
    about = "two turns" if rng.random() < 0.6 else regime(rng)
    ends = [limits(rng, about, REVOLUTE, scale) for _ in range(6)]
    tool, base = tool_of(rng, scale), base_of(rng, scale)
    return from_dh(rows, "standard", [REVOLUTE] * 6, ends, tool, base, kind, scale)


def gantry(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """Three crossed slides of any travel, in metres or millimetres, with or without a wrist."""
    travel = (
        10.0 ** rng.uniform(-3, 4, 3)
        if rng.random() < 0.5
        else np.full(3, 10.0 ** rng.uniform(-3, 4))
    )
    about = "usual" if rng.random() < 0.7 else regime(rng)
    order = rng.permutation(3)
    places = [Place(PRISMATIC, axis=np.eye(3)[k].tolist()) for k in order]
    for place, most in zip(places, travel, strict=True):
        place.lower, place.upper = limits(rng, about, PRISMATIC, float(most))
    wrist = int(rng.integers(0, 4))
    length = float(rng.choice([1e-3, 0.1, 1.0])) * float(travel.max())
    places += [
        Place(REVOLUTE, (0.0, 0.0, length if i == 0 else 0.0), (0.0, 0.0, 0.0), axis)
        for i, axis in enumerate(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))[:wrist])
    ]
    _limit(rng, places[3:], "usual" if rng.random() < 0.7 else regime(rng))
    size = float(travel.max())
    return from_places(places, tool_of(rng, size), base_of(rng, size), kind, size)


def on_rail(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """A rail of any length below a six-joint arm."""
    length = scale * float(10.0 ** rng.uniform(-1, 4))
    arm = wrist_6r if rng.random() < 0.6 else random_urdf
    carried = arm(rng, scale, kind)
    axis = np.eye(3)[rng.integers(3)]
    low, high = limits(rng, "usual" if rng.random() < 0.7 else "far out", PRISMATIC, length)
    place = Place(PRISMATIC, axis=axis.tolist(), lower=low, upper=high)
    places = [place, *(place_of(joint) for joint in carried.joints)]
    return from_places(places, carried.end, np.eye(4), kind, scale)


def mobile(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """A cart that drives and turns below an arm; limits of +-999999 mean none."""
    carried = (wrist_6r if rng.random() < 0.5 else random_urdf)(rng, scale, kind)
    most = float(rng.choice([999999.0, 1e4, 1e16]))
    places = [
        Place(REVOLUTE, lower=-most, upper=most),
        Place(PRISMATIC, axis=(1.0, 0.0, 0.0), lower=-most, upper=most),
    ]
    if rng.random() < 0.5:
        places[0] = Place(PRISMATIC, axis=(0.0, 1.0, 0.0), lower=-most, upper=most)
        places.append(Place(CONTINUOUS))
    places += [place_of(joint) for joint in carried.joints]
    return from_places(places, carried.end, np.eye(4), kind, scale)


def palletiser(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """The hand stays level, since a joint follows two others' (parallel links)."""
    a, b = rng.uniform(0.2, 1.0, 2) * scale
    flat = (0.0, 1.0, 0.0)
    places = [
        Place(REVOLUTE, (0.0, 0.0, 0.4 * scale)),
        Place(REVOLUTE, (0.1 * scale, 0.0, 0.0), axis=flat),
        Place(CONTINUOUS, (0.0, 0.0, a), axis=flat, mimic=("j1", -1.0, 0.0)),
        Place(REVOLUTE, axis=flat),
        Place(CONTINUOUS, (b, 0.0, 0.0), axis=flat, mimic=("j3", -1.0, 0.0)),
        Place(REVOLUTE, (0.0, 0.0, -0.1 * scale)),
    ]
    own = [place for place in places if place.mimic is None]
    for place in own:
        place.lower, place.upper = limits(rng, "usual", REVOLUTE, scale)
        if max(abs(place.lower), abs(place.upper)) > 100:
            place.lower, place.upper = -1.5, 1.5
    return from_places(places, tool_of(rng, scale), base_of(rng, scale), kind, scale)


def planar(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """One to five parallel axes, of equal links or not."""
    n = int(rng.integers(1, 6))
    rows = np.zeros((n, 4))
    rows[:, 0] = scale if rng.random() < 0.5 else rng.uniform(0.1, 1, n) * scale
    about = regime(rng)
    kinds = [REVOLUTE if rng.random() < 0.8 else CONTINUOUS for _ in range(n)]
    ends = [limits(rng, about, k, scale) for k in kinds]
    base = base_of(rng, scale)
    return from_dh(rows, "standard", kinds, ends, np.eye(4), base, kind, scale)


def long_chain(rng: np.random.Generator, scale: float, kind: str) -> Arm:
    """Ten to thirty-two joints."""
    n = int(rng.integers(10, 33))
    rows = np.zeros((n, 4))
    rows[:, 0] = rng.uniform(0, 0.2, n) * scale
    rows[:, 1] = rng.choice([0.0, np.pi / 2, -np.pi / 2], n)
    rows[:, 2] = rng.uniform(0, 0.2, n) * scale * rng.choice([0.0, 1.0], n)
    about = regime(rng)
    kinds = [str(k) for k in rng.choice([REVOLUTE, CONTINUOUS, PRISMATIC], n, p=[0.8, 0.1, 0.1])]
    ends = [limits(rng, about, k, 0.3 * scale) for k in kinds]
    tool, base = tool_of(rng, scale), base_of(rng, scale)
    return from_dh(rows, "standard", kinds, ends, tool, base, kind, scale)


def _limit(rng: np.random.Generator, places: Sequence[Place], about: str) -> None:
    for place in places:
        if place.mimic is None and rng.random() < 0.05:
            place.kind = CONTINUOUS
        place.lower, place.upper = limits(rng, about, place.kind, 1.0)


@dataclass(frozen=True)
class Kind:
    """How arms of a kind are drawn, and how often."""

    make: Maker
    share: float


KINDS = {
    "DH": Kind(random_dh, 2),
    "URDF": Kind(random_urdf, 2),
    "spherical wrist": Kind(wrist_6r, 3),
    "S-R-S": Kind(srs_7r, 2.5),
    "UR-like": Kind(ur_like, 1.5),
    "gantry": Kind(gantry, 1.5),
    "on a rail": Kind(on_rail, 1),
    "mobile": Kind(mobile, 1),
    "palletiser": Kind(palletiser, 0.5),
    "planar": Kind(planar, 1),
    "long": Kind(long_chain, 0.5),
}
