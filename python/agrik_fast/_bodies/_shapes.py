"""The shapes that bodies and scenes are made of: a convex core and a radius round it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, float_array, real_number, whole_number, word
from .._rotations import RIGID_TOLERANCE
from ..errors import ArgumentError

Point: TypeAlias = tuple[float, float, float]
Rows: TypeAlias = tuple[Point, ...]

LARGEST = 1e9
"""The largest coordinate and size, m: what the compiled core takes."""
SPLITS = ("equal", "near-cubic")
_IDENTITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def point(argument: str, value: ArrayLike) -> Point:
    """Return three finite numbers of a length that the core can hold."""
    array = finite_array(argument, value, (3,))
    if np.abs(array).max() > LARGEST:
        raise ArgumentError(argument, str(array.tolist()), f"numbers up to {LARGEST:g} m")
    x, y, z = array.tolist()
    return x, y, z


def rotation_rows(argument: str, value: ArrayLike) -> Rows:
    """Return a rotation matrix as rows."""
    array = finite_array(argument, value, (3, 3))
    with np.errstate(over="ignore", invalid="ignore"):
        off = float(np.abs(array @ array.T - np.eye(3)).max())
    if not off <= RIGID_TOLERANCE:
        raise ArgumentError(argument, f"rows off by {off:.3g}", "orthonormal rows")
    if np.linalg.det(array) < 0:
        raise ArgumentError(argument, "a mirrored frame", "a right-handed frame")
    first, second, third = (point(argument, row) for row in array)
    return first, second, third


def pose_of(argument: str, value: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return rotation (3, 3) and translation (3,) of a rigid transform (4, 4)."""
    array = finite_array(argument, value, (4, 4))
    if array[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise ArgumentError(argument, f"last row {array[3].tolist()}", "last row [0, 0, 0, 1]")
    rotation_rows(argument, array[:3, :3])
    point(argument, array[:3, 3])
    return array[:3, :3], array[:3, 3]


def _moved(rotation: FloatArray, translation: FloatArray, where: ArrayLike) -> FloatArray:
    moved: FloatArray = np.asarray(where) @ rotation.T + translation
    return moved


def _radius(argument: str, value: float) -> float:
    return real_number(argument, value, 0.0, LARGEST, unit="m")


@dataclass(frozen=True)
class Sphere:
    """All points within `radius` of `centre`.

    Parameters
    ----------
    centre : array_like, shape (3,), m
    radius : float, m
        0 or more.

    Raises
    ------
    ArgumentError
        A wrong shape, a number that is not finite, a negative radius.

    Examples
    --------
    >>> from agrik_fast.collision import Sphere
    >>> Sphere([0, 0, 0.1], 0.05).moved([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    Sphere(centre=(1.0, 0.0, 0.1), radius=0.05)
    """

    centre: Point
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", point("centre", self.centre))
        object.__setattr__(self, "radius", _radius("radius", self.radius))

    def moved(self, pose: ArrayLike) -> Sphere:
        """Return the same shape of a frame that lies at `pose`, shape (4, 4), m.

        Examples
        --------
        >>> from agrik_fast.collision import Sphere
        >>> Sphere((1, 0, 0), 0.1).moved(ik.rotations.pose([0, 0, 1])).centre
        (1.0, 0.0, 1.0)
        """
        return Sphere(_moved(*pose_of("pose", pose), self.centre), self.radius)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` of the way from `a` to `b`.

    Parameters
    ----------
    a, b : array_like, shape (3,), m
        Ends of the core; the capsule goes on by its radius behind them.
    radius : float, m
        0 or more.

    Raises
    ------
    ArgumentError
        A wrong shape, a number that is not finite, a negative radius.

    Examples
    --------
    >>> from agrik_fast.collision import Capsule, Scene, SceneObject
    >>> post = Capsule((0.5, 0, 0), (0.5, 0, 1), 0.03)
    >>> len(Scene([SceneObject.of("post", post)]).objects)
    1
    """

    a: Point
    b: Point
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "a", point("a", self.a))
        object.__setattr__(self, "b", point("b", self.b))
        object.__setattr__(self, "radius", _radius("radius", self.radius))

    def moved(self, pose: ArrayLike) -> Capsule:
        """Return the same shape of a frame that lies at `pose`, shape (4, 4), m.

        Examples
        --------
        >>> from agrik_fast.collision import Capsule
        >>> Capsule((0, 0, 0), (0, 0, 1), 0.03).moved(ik.rotations.pose([1, 0, 0])).b
        (1.0, 0.0, 1.0)
        """
        a, b = _moved(*pose_of("pose", pose), [self.a, self.b])
        return Capsule(a, b, self.radius)


@dataclass(frozen=True)
class Box:
    """A box, turned anyhow, and all points within `radius` of it.

    Parameters
    ----------
    centre : array_like, shape (3,), m
    half : array_like, shape (3,), m
        Half lengths along its own axes, 0 or more.
    rotation : array_like, shape (3, 3), optional
        Its axes as columns; default those of the frame.
    radius : float, default 0, m
        What its edges are rounded by, outwards.

    Raises
    ------
    ArgumentError
        A wrong shape, a number that is not finite, a negative length, no rotation.

    Examples
    --------
    >>> from agrik_fast.collision import Box
    >>> Box((0.5, 0, 0.2), (0.1, 0.2, 0.2)).half
    (0.1, 0.2, 0.2)
    """

    centre: Point
    half: Point
    rotation: Rows = _IDENTITY
    radius: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", point("centre", self.centre))
        object.__setattr__(self, "half", point("half", self.half))
        object.__setattr__(self, "rotation", rotation_rows("rotation", self.rotation))
        object.__setattr__(self, "radius", _radius("radius", self.radius))
        if min(self.half) < 0.0:
            raise ArgumentError("half", str(list(self.half)), "half lengths >= 0 m")

    def moved(self, pose: ArrayLike) -> Box:
        """Return the same shape of a frame that lies at `pose`, shape (4, 4), m.

        Examples
        --------
        >>> from agrik_fast.collision import Box
        >>> Box((0, 0, 0), (0.1, 0.2, 0.3)).moved(ik.rotations.pose([1, 0, 0])).centre
        (1.0, 0.0, 0.0)
        """
        turn, shift = pose_of("pose", pose)
        centre, axes = _moved(turn, shift, self.centre), turn @ np.array(self.rotation)
        return Box(centre, self.half, axes, self.radius)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Cover:
    r"""A box that meets the objects of a scene as spheres that cover it, as in the paper.

    Level k has 8**k spheres, each round one of as many cells of the box. No point of the box
    is outside of them, and with equal cells none of theirs is farther from the box than
    (\|half\| - min(half)) / 2**k. Other bodies meet the box itself.

    Parameters
    ----------
    centre : array_like, shape (3,), m
    half : array_like, shape (3,), m
        Half lengths along its own axes, above 0.
    rotation : array_like, shape (3, 3), optional
        Its axes as columns; default those of the frame.
    level : int, default 3
        0 to 3.
    split : {"equal", "near-cubic"}
        Cells like the box, or ones that halve the longest side.

    Raises
    ------
    ArgumentError
        As for `Box`; another level or way to split.

    References
    ----------
    Van Henten et al. (2010), appendix A.

    Examples
    --------
    >>> from agrik_fast.collision import Cover
    >>> Cover((0, 0, 0), (0.1, 0.1, 0.1), level=2).level
    2
    """

    centre: Point
    half: Point
    rotation: Rows = _IDENTITY
    level: int = 3
    split: str = "equal"

    def __post_init__(self) -> None:
        box = Box(self.centre, self.half, self.rotation)
        if min(box.half) <= 0.0:
            raise ArgumentError("half", str(list(box.half)), "half lengths > 0 m")
        object.__setattr__(self, "centre", box.centre)
        object.__setattr__(self, "half", box.half)
        object.__setattr__(self, "rotation", box.rotation)
        object.__setattr__(self, "level", whole_number("level", self.level, 0, 3))
        word("split", self.split, SPLITS)

    @property
    def box(self) -> Box:
        """The box that is covered."""
        return Box(self.centre, self.half, self.rotation)

    @property
    def overestimate(self) -> float | None:
        """How far a sphere reaches out of the box at most, m; None for near-cubic cells."""
        if self.split != "equal":
            return None
        return float((math.hypot(*self.half) - min(self.half)) / 2**self.level)

    def moved(self, pose: ArrayLike) -> Cover:
        """Return the same shape of a frame that lies at `pose`, shape (4, 4), m.

        Examples
        --------
        >>> from agrik_fast.collision import Cover
        >>> Cover((0, 0, 0), (0.1, 0.1, 0.1)).moved(ik.rotations.pose([1, 0, 0])).centre
        (1.0, 0.0, 0.0)
        """
        box = self.box.moved(pose)
        return Cover(box.centre, box.half, box.rotation, self.level, self.split)


@dataclass(frozen=True)
class Convex:
    """The convex hull of points, and all points within `radius` of it.

    Parameters
    ----------
    vertices : array_like, shape (k, 3), m
        At least one point; those inside the hull cost time and nothing else.
    radius : float, default 0, m

    Raises
    ------
    ArgumentError
        A wrong shape, no point, a number that is not finite, a negative radius.

    Examples
    --------
    >>> from agrik_fast.collision import Convex
    >>> len(Convex(((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)), radius=0.01).vertices)
    4
    """

    vertices: Rows
    radius: float = 0.0

    def __post_init__(self) -> None:
        array = float_array("vertices", self.vertices)
        if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
            raise ArgumentError("vertices", f"shape {array.shape}", "shape (k, 3), k >= 1")
        if not (np.isfinite(array).all() and np.abs(array).max() <= LARGEST):
            row = int(np.argmin((np.abs(array) <= LARGEST).all(axis=1)))
            received = f"{array[row].tolist()} in row {row + 1}"
            raise ArgumentError("vertices", received, f"finite numbers up to {LARGEST:g} m")
        rows = tuple((x, y, z) for x, y, z in array.tolist())
        object.__setattr__(self, "vertices", rows)
        object.__setattr__(self, "radius", _radius("radius", self.radius))

    def moved(self, pose: ArrayLike) -> Convex:
        """Return the same shape of a frame that lies at `pose`, shape (4, 4), m.

        Examples
        --------
        >>> from agrik_fast.collision import Convex
        >>> Convex(((0, 0, 0), (0.1, 0, 0))).moved(ik.rotations.pose([1, 0, 0])).vertices[0]
        (1.0, 0.0, 0.0)
        """
        return Convex(_moved(*pose_of("pose", pose), self.vertices), self.radius)  # type: ignore[arg-type]


@dataclass(frozen=True)
class HalfSpace:
    """All on one side of a plane: the points x with ``normal . x <= offset``.

    Parameters
    ----------
    normal : array_like, shape (3,)
        Points out of what is solid; any length but zero, by which both are divided.
    offset : float, m
        Where the plane is, along the normal.

    Raises
    ------
    ArgumentError
        A wrong shape, a number that is not finite, a normal of no length.

    Examples
    --------
    >>> from agrik_fast.collision import HalfSpace
    >>> HalfSpace([0, 0, 2], 1.0)
    HalfSpace(normal=(0.0, 0.0, 1.0), offset=0.5)
    """

    normal: Point
    offset: float

    def __post_init__(self) -> None:
        normal = finite_array("normal", self.normal, (3,))
        length = float(np.linalg.norm(normal))
        if not (math.isfinite(length) and length > 0.0):
            raise ArgumentError("normal", str(normal.tolist()), "a direction of non-zero length")
        offset = real_number("offset", self.offset, unit="m") / length
        if not abs(offset) <= LARGEST:
            raise ArgumentError("offset", repr(self.offset), f"a number up to {LARGEST:g} m")
        object.__setattr__(self, "normal", point("normal", normal / length))
        object.__setattr__(self, "offset", offset)

    def moved(self, pose: ArrayLike) -> HalfSpace:
        """Return the same shape of a frame that lies at `pose`, shape (4, 4), m.

        Examples
        --------
        >>> from agrik_fast.collision import HalfSpace
        >>> HalfSpace((0, 0, 1), 0.0).moved(ik.rotations.pose([0, 0, 0.5])).offset
        0.5
        """
        turn, shift = pose_of("pose", pose)
        normal = turn @ np.array(self.normal)
        return HalfSpace(normal, self.offset + float(normal @ shift))


BodyShape: TypeAlias = Sphere | Capsule | Box | Convex | Cover
"""What a body can be."""

Shape: TypeAlias = Sphere | Capsule | Box | Convex | HalfSpace
"""What an object of a scene can be made of."""
