"""Scenes by chance: the sixteen kinds that a detector is measured on."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np

from .._checks import FloatArray, whole_number, word
from ._camera import Camera
from ._images import of_kind
from ._scenes import (
    BACKGROUND,
    GREEN,
    LEAF,
    SOIL,
    Fruit,
    Leaf,
    Look,
    Scene,
    Wall,
    across,
    cone_rays,
    leaf_hits,
    paper_camera,
)

__all__ = ["KINDS", "random_scene"]

KINDS = (
    "clean",
    "noise",
    "bright",
    "dark",
    "spec",
    "grad",
    "wb",
    "oblate",
    "occl15",
    "occl30",
    "occl45",
    "cluster",
    "edge",
    "green",
    "empty",
    "soil",
)
"""Kinds of scene: what is difficult in each."""


# Radii that a cluster's fruits are in front of the wall, at least.
_CLEAR = 1.05


def random_scene(kind: str = "clean", seed: int = 0, camera: Camera | None = None) -> Scene:
    """Return a scene of a kind, in the camera's frame.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    seed : int
        Another scene for every seed.
    camera : Camera, optional
        Who looks at it, to have fruits in view; `paper_camera` by default.

    Raises
    ------
    UnknownNameError
        No such kind.

    Examples
    --------
    >>> from agrik_fast.vision import random_scene
    >>> len(random_scene("cluster", seed=3).fruits) >= 2
    True
    """
    word("kind", kind, KINDS)
    seed = whole_number("seed", seed, 0)
    camera = paper_camera() if camera is None else of_kind("camera", camera, Camera)
    rng = np.random.default_rng([KINDS.index(kind), seed])
    look = _look(kind, rng)
    wall = Wall(
        point=(0.0, 0.0, float(rng.uniform(0.5, 0.7))),
        normal=(float(rng.uniform(-0.2, 0.2)), float(rng.uniform(-0.2, 0.2)), -1.0),
        colour=SOIL if kind == "soil" else BACKGROUND,
    )
    fruits: list[Fruit] = []
    if kind == "cluster":
        fruits = _cluster(camera, rng)
        wall = _behind(wall, fruits)
    elif kind == "green":
        while len(fruits) < int(rng.integers(1, 4)):
            fruits.append(_green(camera, rng))
    elif kind == "edge":
        fruits = [_at_border(camera, rng)]
    elif kind not in ("empty", "soil"):
        fruit = _inside(camera, rng)
        if kind == "oblate":
            axis = rng.normal(size=3)
            axis = (axis / np.linalg.norm(axis)).tolist()
            fruit = replace(fruit, flattening=float(rng.uniform(0.75, 0.9)), axis=tuple(axis))
        fruits = [fruit]
    leaves = [_leaf(camera, rng, fruits) for _ in range(int(rng.integers(2, 5)))]
    if kind.startswith("occl"):
        leaves.append(_cover(fruits[0], int(kind[4:]) / 100, rng))
    return Scene(tuple(fruits), tuple(leaves), wall, look, seed)


def _look(kind: str, rng: np.random.Generator) -> Look:
    light = np.array([rng.uniform(-0.35, 0.35), -0.75, -0.65])
    look = Look(light=tuple(light.tolist()))
    if kind == "noise":
        return replace(look, noise=9.0)
    if kind == "bright":
        return replace(look, gain=1.5)
    if kind == "dark":
        return replace(look, gain=0.35)
    if kind == "spec":
        return replace(look, gloss=1.6, shininess=14.0)
    if kind == "grad":
        return replace(look, gradient=0.6, gradient_angle=float(rng.uniform(0, 2 * math.pi)))
    if kind == "wb":
        warm = (0.8, 1.0, 1.2) if rng.random() < 0.5 else (1.3, 1.05, 0.75)
        return replace(look, balance=warm)
    return look


def _inside(camera: Camera, rng: np.random.Generator) -> Fruit:
    """Return a fruit wholly in the picture."""
    while True:
        radius = float(rng.uniform(0.025, 0.04))
        far = float(rng.uniform(0.22, 0.45))
        alpha = math.asin(radius / far)
        margin = 1.15 * camera.focal * math.tan(alpha) + 6
        if 2 * margin > 0.9 * camera.height:
            continue
        u = rng.uniform(margin, camera.width - 1 - margin)
        v = rng.uniform(margin, camera.height - 1 - margin)
        centre = far * camera.rays([u, v])
        return Fruit(tuple(centre.tolist()), radius)


def _at_border(camera: Camera, rng: np.random.Generator) -> Fruit:
    """Return a fruit that the left or right border cuts."""
    radius, far = float(rng.uniform(0.025, 0.04)), float(rng.uniform(0.25, 0.45))
    pixels = camera.focal * radius / far
    inset = float(rng.uniform(-0.2, 0.5)) * pixels
    u = inset if rng.random() < 0.5 else camera.width - 1 - inset
    v = float(rng.uniform(pixels + 10, camera.height - pixels - 10))
    return Fruit(tuple((far * camera.rays([u, v])).tolist()), radius)


def _green(camera: Camera, rng: np.random.Generator) -> Fruit:
    return replace(_inside(camera, rng), colour=GREEN, red=False)


def _cluster(camera: Camera, rng: np.random.Generator) -> list[Fruit]:
    """Return two to four ripe fruits that touch, and at times a green one.

    Each is more than half in view, and no centre is behind another: of a fruit that shows less
    there is too little outline.
    """
    while True:
        count = int(rng.integers(2, 5))
        first = _inside(camera, rng)
        first = replace(first, centre=tuple((np.array(first.centre) * 1.15).tolist()))
        fruits = [first]
        for _ in range(60):
            if len(fruits) == count:
                break
            near = fruits[int(rng.integers(len(fruits)))]
            radius = float(rng.uniform(0.026, 0.038))
            way = rng.normal(size=3) * [1.0, 1.0, 0.5]
            way *= 1.02 * (near.radius + radius) / np.linalg.norm(way)
            centre = np.array(near.centre) + way
            u, v = camera.project(centre)
            margin = camera.focal * radius / max(float(centre[2]), 0.1) + 6
            inside = margin < u < camera.width - margin and margin < v < camera.height - margin
            apart = all(
                np.linalg.norm(centre - each.centre) > radius + each.radius for each in fruits
            )
            if inside and apart and centre[2] > 0.2:
                fruits.append(Fruit(tuple(centre.tolist()), radius))
        if (
            len(fruits) == count
            and all(share_in_view(each, fruits, camera) > 0.55 for each in fruits)
            and all(_apart(one, other) for one, other in combinations(fruits, 2))
        ):
            break
    if rng.random() < 0.5:
        green = _green(camera, rng)
        gap = min(
            math.acos(np.clip(np.dot(_unit(green.centre), _unit(each.centre)), -1, 1))
            - math.asin(green.radius / math.dist(green.centre, (0, 0, 0)))
            - math.asin(each.radius / math.dist(each.centre, (0, 0, 0)))
            for each in fruits
        )
        if gap > 0.03:
            fruits.append(green)
    return fruits


def _behind(wall: Wall, fruits: list[Fruit]) -> Wall:
    """Return a wall that is no nearer than fruits, moved away where it cuts one."""
    normal = np.array(wall.normal)
    size = float(np.linalg.norm(normal))
    least = max(_CLEAR * each.radius * size - float(normal @ each.centre) for each in fruits)
    x, y, z = wall.point
    return replace(wall, point=(x, y, max(z, least)))


def _apart(one: Fruit, other: Fruit) -> bool:
    """Whether neither's centre is seen inside the other."""
    angle = math.acos(np.clip(np.dot(_unit(one.centre), _unit(other.centre)), -1, 1))
    wider = max(math.asin(each.radius / math.dist(each.centre, (0, 0, 0))) for each in (one, other))
    return angle > wider


def share_in_view(fruit: Fruit, fruits: list[Fruit], camera: Camera) -> float:
    """Return the share of a sphere's disc that no other one covers."""
    rays = cone_rays(np.array(fruit.centre), fruit.radius)
    hidden = np.zeros(len(rays), bool)
    far = math.dist(fruit.centre, (0, 0, 0))
    for other in fruits:
        if other is fruit or math.dist(other.centre, (0, 0, 0)) > far:
            continue
        centre = np.array(other.centre)
        sine = other.radius / np.linalg.norm(centre)
        hidden |= rays @ _unit(other.centre) > math.sqrt(1 - sine * sine)
    return float(1 - hidden.mean())


def _unit(vector: tuple[float, float, float]) -> FloatArray:
    return np.asarray(np.array(vector) / np.linalg.norm(vector))


def _leaf(camera: Camera, rng: np.random.Generator, fruits: list[Fruit]) -> Leaf:
    """Return a leaf that covers no fruit: it lies behind all of them, or beside."""
    while True:
        u, v = rng.uniform(0, camera.width), rng.uniform(0, camera.height)
        far = float(rng.uniform(0.3, 0.5))
        centre = far * camera.rays([u, v])
        normal = rng.normal(size=3) * [0.4, 0.4, 0] + [0, 0, -1]
        along = rng.normal(size=3)
        size = float(rng.uniform(0.03, 0.07))
        leaf = Leaf(
            tuple(centre.tolist()),
            tuple(along.tolist()),
            tuple(normal.tolist()),
            size,
            size * float(rng.uniform(0.3, 0.6)),
            tuple((np.array(LEAF) * rng.uniform(0.7, 1.25)).tolist()),
        )
        beside = all(
            math.acos(np.clip(np.dot(centre / far, _unit(each.centre)), -1, 1))
            > math.asin(each.radius / math.dist(each.centre, (0, 0, 0))) + size / far / 2
            for each in fruits
        )
        if beside:
            return leaf


def _cover(fruit: Fruit, share: float, rng: np.random.Generator) -> Leaf:
    """Return a leaf in front of a fruit that hides a share of its disc."""
    centre = np.array(fruit.centre)
    far = float(np.linalg.norm(centre))
    rays = cone_rays(centre, fruit.radius)
    first, second = across(centre / far)
    turn = float(rng.uniform(0, 2 * math.pi))
    way = math.cos(turn) * first + math.sin(turn) * second
    tilt = rng.normal(size=3) * 0.2 - centre / far
    # Nearer than the fruit's front, and larger than the fruit.
    place = (far - fruit.radius) * float(rng.uniform(0.75, 0.92))
    length = float(rng.uniform(3.6, 5.0)) * fruit.radius
    along = math.cos(1.3) * way + math.sin(1.3) * np.cross(centre / far, way)
    low, high = 0.0, 4 * fruit.radius / far
    while high - low > 1e-5:
        middle = (low + high) / 2
        axis = centre / far + math.tan(middle) * way
        leaf = Leaf(
            tuple((place * axis / np.linalg.norm(axis)).tolist()),
            tuple(along.tolist()),
            tuple(tilt.tolist()),
            length,
            0.62 * length,
        )
        if float(leaf_hits(leaf, np.zeros(3), rays)[1].mean()) > share:
            low = middle
        else:
            high = middle
    return leaf
