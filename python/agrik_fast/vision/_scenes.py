"""What the renderer draws: fruits, leaves, a wall, light and the camera's faults."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, direction, finite_array, real_number, whole_number
from ..errors import ArgumentError
from ._camera import Camera
from ._images import checked_image

__all__ = ["Fruit", "Leaf", "Look", "Patch", "Scene", "Wall", "paper_camera"]

RED = (38.0, 34.0, 205.0)
GREEN = (60.0, 150.0, 95.0)
LEAF = (35.0, 95.0, 45.0)
BACKGROUND = (84.0, 122.0, 94.0)
SOIL = (55.0, 92.0, 140.0)

_Colour = tuple[float, float, float]
_Triple = tuple[float, float, float]


def _triple(name: str, value: object) -> _Triple:
    x, y, z = finite_array(name, value, (3,)).tolist()  # type: ignore[arg-type]
    return x, y, z


def _perpendicular(owner: str, normal: object, along: object) -> tuple[_Triple, _Triple]:
    """Return unit vectors, the second made perpendicular to the first."""
    face = np.array(direction(f"{owner}.normal", normal))
    way = np.array(direction(f"{owner}.along", along))
    side = np.cross(face, way)
    if np.linalg.norm(side) < 1e-6:
        raise ArgumentError(f"{owner}.along", str(along), f"no multiple of {owner}.normal")
    way = np.cross(side / np.linalg.norm(side), face)
    return _triple(f"{owner}.normal", face), _triple(f"{owner}.along", way)


@dataclass(frozen=True)
class Fruit:
    """A sphere, flattened along an axis.

    Parameters
    ----------
    centre : tuple of 3 floats, m
        In the world's frame.
    radius : float, m
        Equatorial radius.
    flattening : float, default 1.0
        Half axis along `axis` over the radius; above 1 for a long fruit.
    axis : tuple of 3 floats, default (0, 1, 0)
        Unit vector.
    colour : tuple of 3 floats, default ripe red
        Blue, green, red, 0 to 255.
    red : bool, default True
        Whether the detector ought to find it.
    texture : float, default 0.0
        Share by which the colour varies over the skin.

    Examples
    --------
    >>> from agrik_fast.vision import Fruit
    >>> Fruit((0, 0, 0.35), 0.03, flattening=0.8).red
    True
    """

    centre: _Triple
    radius: float
    flattening: float = 1.0
    axis: _Triple = (0.0, 1.0, 0.0)
    colour: _Colour = RED
    red: bool = True
    texture: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", _triple("Fruit.centre", self.centre))
        object.__setattr__(self, "axis", direction("Fruit.axis", self.axis))
        real_number("Fruit.radius", self.radius, 0, open_low=True, unit="m")
        real_number("Fruit.flattening", self.flattening, 0.1, 20)


@dataclass(frozen=True)
class Leaf:
    """A flat blade that tapers at both ends, with a vein.

    Parameters
    ----------
    centre : tuple of 3 floats, m
        In the world's frame.
    along, normal : tuple of 3 floats
        Where its tip and its face point; made perpendicular.
    length, width : float, m
        Whole.
    colour : tuple of 3 floats
        Blue, green, red, 0 to 255.

    Examples
    --------
    >>> from agrik_fast.vision import Leaf
    >>> Leaf((0, 0, 0.3), along=(1, 0, 0), normal=(0, 0, -1)).length
    0.07
    """

    centre: _Triple
    along: _Triple
    normal: _Triple
    length: float = 0.07
    width: float = 0.035
    colour: _Colour = LEAF

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", _triple("Leaf.centre", self.centre))
        normal, along = _perpendicular("Leaf", self.normal, self.along)
        object.__setattr__(self, "normal", normal)
        object.__setattr__(self, "along", along)
        for name in ("length", "width"):
            real_number(f"Leaf.{name}", getattr(self, name), 0, open_low=True, unit="m")


@dataclass(frozen=True)
class Patch:
    """A flat rectangle without texture, or with a picture on it: paper, squares, boards.

    Parameters
    ----------
    centre : tuple of 3 floats, m
        In the world's frame.
    along, normal : tuple of 3 floats
        Where the picture's rows run, and where its face points; made perpendicular.
    width, height : float, m
        Sizes along the rows and across.
    colour : tuple of 3 floats
        Blue, green, red, 0 to 255.
    picture : ndarray, shape (h, w, 3), uint8, optional
        Instead of the colour.

    Examples
    --------
    >>> from agrik_fast.vision import Patch
    >>> Patch((0, 0, 0.5), (1, 0, 0), (0, 0, -1), width=0.2, height=0.1).width
    0.2
    """

    centre: _Triple
    along: _Triple
    normal: _Triple
    width: float
    height: float
    colour: _Colour = (235.0, 235.0, 235.0)
    picture: NDArray[np.uint8] | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", _triple("Patch.centre", self.centre))
        normal, along = _perpendicular("Patch", self.normal, self.along)
        object.__setattr__(self, "normal", normal)
        object.__setattr__(self, "along", along)
        for name in ("width", "height"):
            real_number(f"Patch.{name}", getattr(self, name), 0, open_low=True, unit="m")
        if self.picture is not None:
            checked_image("Patch.picture", self.picture)


@dataclass(frozen=True)
class Wall:
    """A plane behind everything.

    Parameters
    ----------
    point, normal : tuple of 3 floats, m
        A point of it, and where it faces.
    colour : tuple of 3 floats
        Blue, green, red, 0 to 255.

    Examples
    --------
    >>> from agrik_fast.vision import Wall
    >>> Wall(point=(0, 0, 0.8)).normal
    (0.0, 0.0, -1.0)
    """

    point: _Triple = (0.0, 0.0, 0.6)
    normal: _Triple = (0.0, 0.0, -1.0)
    colour: _Colour = BACKGROUND

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", _triple("Wall.point", self.point))
        object.__setattr__(self, "normal", direction("Wall.normal", self.normal))


@dataclass(frozen=True)
class Look:
    """Light, and what a camera makes of it.

    Parameters
    ----------
    light : tuple of 3 floats
        Where light comes from, in the world's frame.
    gloss, shininess : float
        Height and narrowness of highlights on fruits.
    gain : float
        Exposure; above 1 what is bright is cut off.
    gradient : float
        Share of the light that is lost across the picture.
    gradient_angle : float, rad
        Direction in the picture in which it is lost.
    balance : tuple of 3 floats
        Factors of blue, green, red.
    noise : float, grey levels
        Standard deviation s; the variance is s^2 + 0.05 I.
    blur : float, pixels
        Standard deviation.

    Examples
    --------
    >>> from agrik_fast.vision import Look
    >>> Look(noise=4.0).blur
    0.6
    """

    light: _Triple = (0.15, -0.75, -0.65)
    gloss: float = 0.55
    shininess: float = 30.0
    gain: float = 1.0
    gradient: float = 0.0
    gradient_angle: float = 0.0
    balance: _Triple = (1.0, 1.0, 1.0)
    noise: float = 2.0
    blur: float = 0.6

    def __post_init__(self) -> None:
        object.__setattr__(self, "light", direction("Look.light", self.light))
        object.__setattr__(self, "balance", _triple("Look.balance", self.balance))
        for name in ("gloss", "shininess", "gain", "noise", "blur"):
            real_number(f"Look.{name}", getattr(self, name), 0)
        real_number("Look.gradient", self.gradient, 0, 1)


@dataclass(frozen=True)
class Scene:
    """Everything that the renderer draws.

    Parameters
    ----------
    fruits, leaves : tuple
        `Fruit` and `Leaf`.
    patches : tuple
        `Patch`.
    wall : Wall or None
        What is behind; None is black.
    look : Look
        Light and camera.
    seed : int
        Of the texture and the noise.

    Examples
    --------
    >>> from agrik_fast.vision import Fruit, Scene
    >>> len(Scene((Fruit((0, 0, 0.35), 0.03),)).fruits)
    1
    """

    fruits: tuple[Fruit, ...] = ()
    leaves: tuple[Leaf, ...] = ()
    wall: Wall | None = field(default_factory=Wall)
    look: Look = field(default_factory=Look)
    seed: int = 0
    patches: tuple[Patch, ...] = ()


def paper_camera(width: int = 320) -> Camera:
    """Return the camera of the examples: 60 degrees wide, with a web camera's distortion.

    Parameters
    ----------
    width : {320, 640}
        The two sizes of the tomato paper.

    Examples
    --------
    >>> from agrik_fast.vision import paper_camera
    >>> paper_camera().width, paper_camera(640).width
    (320, 640)
    """
    if whole_number("width", width, 320, 640) not in (320, 640):
        raise ArgumentError("width", repr(width), "320 or 640")
    focal = 160 / math.tan(math.radians(30))
    five = (-0.18, 0.06, 0.001, -0.0008, 0.0)
    small = Camera(320, 240, focal, focal, 159.5, 119.5, five)
    return small if width == 320 else small.scaled(640, 480)


# ---- rays ------------------------------------------------------------------------------------


def cone_rays(centre: FloatArray, radius: float, count: int = 600) -> FloatArray:
    """Return rays that fill the cone in which a sphere is seen, evenly, shape (count, 3)."""
    far = float(np.linalg.norm(centre))
    axis = centre / far
    edge = math.sqrt(1 - min(radius / far, 0.999) ** 2)
    number = np.arange(count) + 0.5
    cosine = 1 - (1 - edge) * number / count
    turn = number * math.pi * (3 - math.sqrt(5))
    first, second = across(axis)
    sine = np.sqrt(1 - cosine**2)
    return np.asarray(
        cosine[:, None] * axis
        + (sine * np.cos(turn))[:, None] * first
        + (sine * np.sin(turn))[:, None] * second
    )


def across(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors that are perpendicular to one and to each other."""
    least = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(axis, least)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def rim_of(axis: FloatArray, alpha: float, count: int) -> FloatArray:
    """Return rays on a cone, so many round it, shape (count, 3)."""
    first, second = across(axis)
    turn = np.linspace(0, 2 * math.pi, count, endpoint=False)[:, None]
    around = np.cos(turn) * first + np.sin(turn) * second
    return np.asarray(math.cos(alpha) * axis + math.sin(alpha) * around)


def leaf_hits(
    leaf: Leaf, origin: FloatArray, rays: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return how far along rays a leaf's plane is, and which of them hit the blade."""
    normal, along = np.array(leaf.normal), np.array(leaf.along)
    slope = rays @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((np.array(leaf.centre) - origin) @ normal) / slope
        point = origin + t[..., None] * rays - np.array(leaf.centre)
        x = 2 / leaf.length * (point @ along)
        y = 2 / leaf.width * (point @ np.cross(normal, along))
        # A blade tapers to both ends.
        hit = (t > 1e-6) & (np.abs(x) < 1) & (np.abs(y) < (1 - x * x) ** 0.8)
    return t, hit
