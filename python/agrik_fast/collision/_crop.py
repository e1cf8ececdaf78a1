"""Crops by their parts: stems, leaves, fruits, wires, pipes, and rows of plants."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .._bodies import Capsule, point
from .._checks import items, real_number, shown, whole_number
from ..errors import ArgumentError
from ._objects import SceneObject

# The golden angle, by which sunflowers set one seed after the other, rad.
GOLDEN_ANGLE = 2.399963229728653


def spiral(
    centre: Sequence[float], radius: float, azimuth: float, tilt: float, points: int
) -> list[list[float]]:
    """Return points spread evenly over a disc, in the unit of `centre` and `radius`.

    A sunflower's spiral, in the plane of the directions u, `azimuth` and down by `tilt`, and
    v, level and to the left of it.
    """
    u = (
        math.cos(azimuth) * math.cos(tilt),
        math.sin(azimuth) * math.cos(tilt),
        -math.sin(tilt),
    )
    v = (-math.sin(azimuth), math.cos(azimuth), 0.0)
    found = []
    for k in range(points):
        r, angle = radius * math.sqrt((k + 0.5) / points), GOLDEN_ANGLE * k
        c, s = math.cos(angle), math.sin(angle)
        found.append([centre[i] + r * (c * u[i] + s * v[i]) for i in range(3)])
    return found


def pipe(name: str, a: ArrayLike, b: ArrayLike, radius: float = 0.0255) -> SceneObject:
    """Make a heating pipe, or a rail.

    Parameters
    ----------
    name : str
    a, b : array_like, shape (3,), m
        Ends of its middle line.
    radius : float, default 0.0255, m

    Returns
    -------
    SceneObject
        A capsule: exact but for the round ends.

    Examples
    --------
    >>> ik.collision.pipe("pipe", (0.3, -1, 0.1), (0.3, 1, 0.1)).kind
    'pipe'
    """
    return SceneObject.of(name, Capsule(a, b, radius), kind="pipe")  # type: ignore[arg-type]


def wire(name: str, a: ArrayLike, b: ArrayLike, radius: float = 0.002) -> SceneObject:
    """Make a wire or a string.

    Parameters
    ----------
    name : str
    a, b : array_like, shape (3,), m
        Its ends.
    radius : float, default 0.002, m

    Returns
    -------
    SceneObject

    Examples
    --------
    >>> ik.collision.wire("wire", (0.7, -1, 2.5), (0.7, 1, 2.5)).capsules.shape
    (1, 7)
    """
    return SceneObject.of(name, Capsule(a, b, radius), kind="wire")  # type: ignore[arg-type]


def stem(name: str, foot: ArrayLike, top: ArrayLike, radius: float = 0.009) -> SceneObject:
    """Make the stem of a plant.

    Parameters
    ----------
    name : str
    foot, top : array_like, shape (3,), m
        Its ends.
    radius : float, default 0.009, m

    Returns
    -------
    SceneObject

    Examples
    --------
    >>> ik.collision.stem("stem", (0.7, 0, 0), (0.7, 0, 2.0)).capsules.shape
    (1, 7)
    """
    return SceneObject.of(name, Capsule(foot, top, radius), kind="stem")  # type: ignore[arg-type]


def stalk(
    name: str, fruit_top: ArrayLike, at_stem: ArrayLike, radius: float = 0.004
) -> SceneObject:
    """Make the stalk that a fruit hangs from.

    Parameters
    ----------
    name : str
    fruit_top, at_stem : array_like, shape (3,), m
        Its ends.
    radius : float, default 0.004, m

    Returns
    -------
    SceneObject

    Examples
    --------
    >>> ik.collision.stalk("stalk", (0.65, 0, 1.1), (0.7, 0, 1.15)).kind
    'stalk'
    """
    capsule = Capsule(fruit_top, at_stem, radius)  # type: ignore[arg-type]
    return SceneObject.of(name, capsule, kind="stalk")


def fruit(name: str, top: ArrayLike, length: float, radius: float = 0.025) -> SceneObject:
    """Make a fruit that hangs straight down.

    Parameters
    ----------
    name : str
    top : array_like, shape (3,), m
        Where the stalk ends.
    length : float, m
        From top to tip; at least two radii, which is a ball.
    radius : float, default 0.025, m

    Returns
    -------
    SceneObject
        A capsule.

    Raises
    ------
    ArgumentError
        A length of less than two radii.

    Examples
    --------
    >>> ik.collision.fruit("fruit", (0.65, 0, 1.1), 0.3).capsules.shape
    (1, 7)
    """
    x, y, z = point("top", top)
    radius = real_number("radius", radius, 0.0, unit="m")
    length = real_number("length", length, 2 * radius, unit="m")
    capsule = Capsule((x, y, z - radius), (x, y, z - length + radius), radius)
    return SceneObject.of(name, capsule, kind="fruit")


def leaf(
    name: str,
    centre: ArrayLike,
    radius: float,
    azimuth: float = 0.0,
    tilt: float = 0.0,
    *,
    points: int = 15,
    point_radius: float = 0.025,
) -> SceneObject:
    """Make a leaf of points on a disc, as a stereo camera would see it; it may be removed.

    Parameters
    ----------
    name : str
    centre : array_like, shape (3,), m
        Middle of the disc.
    radius : float, m
        Of the disc.
    azimuth : float, default 0, rad
        Direction in which the leaf points away from its stem, about z.
    tilt : float, default 0, rad
        How far it hangs down in that direction.
    points : int, default 15
        How many; gaps are left where they are farther apart than two `point_radius`.
    point_radius : float, default 0.025, m

    Returns
    -------
    SceneObject

    Examples
    --------
    >>> ik.collision.leaf("leaf", (0.6, 0.1, 1.2), 0.1).spheres.shape
    (15, 4)
    """
    radius = real_number("radius", radius, 0.0, unit="m")
    azimuth, tilt = real_number("azimuth", azimuth), real_number("tilt", tilt)
    count = whole_number("points", points, 1, 10**7)
    rows = spiral(point("centre", centre), radius, azimuth, tilt, count)
    each = real_number("point_radius", point_radius, 0.0, unit="m")
    return SceneObject.cloud(name, rows, each, kind="leaf", removable=True)


def row(plant: Iterable[SceneObject], count: int, pitch: ArrayLike) -> list[SceneObject]:
    """Repeat the parts of a plant along a row.

    Parameters
    ----------
    plant : iterable of SceneObject
        The parts of the first plant.
    count : int
        Plants in the row, >= 1.
    pitch : array_like, shape (3,), m
        From one plant to the next.

    Returns
    -------
    list of SceneObject
        ``count`` times the parts; those of plant k, from 0, have ``_k`` behind their names.

    Examples
    --------
    >>> from agrik_fast.collision import row, stem
    >>> plants = row([stem("stem", [0.7, 0, 0.1], [0.7, 0, 1.9])], 3, [0, 0.5, 0])
    >>> [one.name for one in plants]
    ['stem_0', 'stem_1', 'stem_2']
    >>> plants[2].capsules[0, :3].tolist()
    [0.7, 1.0, 0.1]
    """
    parts = items("plant", plant, "an iterable of SceneObject")
    for one in parts:
        if not isinstance(one, SceneObject):
            raise ArgumentError("plant", shown(one), "an iterable of SceneObject")
    step = np.array(point("pitch", pitch))
    found = []
    for k in range(whole_number("count", count, 1, 10**6)):
        pose = np.eye(4)
        pose[:3, 3] = k * step
        found += [replace(one.moved(pose), name=f"{one.name}_{k}") for one in parts]
    return found
