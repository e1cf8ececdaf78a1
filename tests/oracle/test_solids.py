"""Distances of pairs of solids of all kinds, against coal, pair by pair.

Coal's managers are not asked: their distance with the default callback is not always the least.
"""

from __future__ import annotations

import itertools
from typing import Any

import coal
import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.collision import (
    Body,
    Box,
    Capsule,
    Convex,
    HalfSpace,
    Scene,
    SceneObject,
    Sphere,
)
from coal_pairs import Made, by_coal, made, rigid

PAIRS = 400
KINDS = ("sphere", "capsule", "box", "convex")


def pose(random: np.random.Generator, spread: float) -> np.ndarray:
    quat = random.normal(size=4)
    return ik.rotations.pose(random.uniform(-spread, spread, 3), quat=quat / np.linalg.norm(quat))


def solid(kind: str, random: np.random.Generator, spread: float) -> Made:
    """Make one solid, ours and coal's; now and then one without thickness or length."""
    where = pose(random, spread)
    flat = random.random() < 0.1
    if kind == "sphere":
        radius = 0.0 if flat else random.uniform(0.01, 0.3)
        return Sphere((0, 0, 0), radius).moved(where), coal.Sphere(radius), where, 0.0
    if kind == "capsule":
        radius, half = random.uniform(0.01, 0.2), 0.0 if flat else random.uniform(0.0, 0.4)
        ours = Capsule((0, 0, -half), (0, 0, half), radius)
        return ours.moved(where), coal.Capsule(radius, 2 * half), where, 0.0
    # The radius round a box or a hull is none of coal's.
    around = random.choice([0.0, random.uniform(0.0, 0.1)])
    if kind == "box":
        half = random.uniform(0.01, 0.3, 3)
        if flat:
            half[random.integers(3)] = 1e-6
        ours_box = Box((0, 0, 0), half, radius=around)
        return ours_box.moved(where), coal.Box(*(2 * half)), where, around
    points = random.normal(size=(random.integers(4, 20), 3))
    points *= random.uniform(0.05, 0.3) / np.linalg.norm(points, axis=1, keepdims=True)
    vertices = coal.StdVec_Vec3s()
    vertices.extend(list(points))
    hull = coal.Convex.convexHull(vertices, False, None)
    return Convex(points, around).moved(where), hull, where, around


def ours(one: Any, other: Any) -> tuple[float, bool]:
    arm = ik.Robot.from_dh([[0, 0, 0, 0]]).with_bodies([Body("body", 1, one)])
    scene = Scene([SceneObject.of("thing", other)])
    return float(scene.clearance(arm, [0.0])), bool(scene.collides(arm, [0.0]))


@pytest.mark.parametrize(
    ("first", "second"), list(itertools.combinations_with_replacement(KINDS, 2))
)
def test_pairs_are_as_far_apart_as_coal_says(first: str, second: str) -> None:
    random = np.random.default_rng([KINDS.index(first), KINDS.index(second)])
    apart = 0
    for number in range(PAIRS):
        spread = (0.2, 0.6, 2.0)[number % 3]
        one, other = solid(first, random, spread), solid(second, random, spread)
        for a, b in ((one, other), (other, one)):
            gap, hit = ours(a[0], b[0])
            cores = by_coal(a, b)
            expected = cores - a[3] - b[3]
            assert hit == (gap <= 0)
            if cores > 1e-7:
                apart += 1
                assert gap == pytest.approx(expected, abs=1e-9, rel=1e-9), (number, a, b)
                assert hit == (expected <= 0) or abs(expected) < 1e-9
            else:  # where they meet, depths are coal's own affair
                assert gap <= 1e-7
    assert apart > PAIRS / 2


@pytest.mark.parametrize("kind", KINDS)
def test_half_spaces_are_as_far_away_as_coal_says(kind: str) -> None:
    random = np.random.default_rng(KINDS.index(kind))
    for _ in range(PAIRS):
        one = solid(kind, random, 0.5)
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        offset = random.uniform(-0.5, 0.5)
        gap, hit = ours(one[0], HalfSpace(normal, offset))
        plane = (None, coal.Halfspace(normal, offset), np.eye(4), 0.0)
        expected = by_coal(one, plane) - one[3]
        assert hit == (gap <= 0)
        assert gap == pytest.approx(expected, abs=1e-9) or max(gap, expected) <= 1e-7


@pytest.mark.parametrize("name", ["panda", "cucumber"])
def test_arms_in_scenes_are_as_far_away_as_coal_says(name: str) -> None:
    """All bodies of an arm and all solids of a made-up greenhouse, the least of all pairs."""
    import numpy_fk
    from agrik_fast.collision import greenhouse

    arm, scene = ik.Robot.load(name), greenhouse(2, 3, 6, machine=False)
    things = [made(shape) for one in scene.objects for shape in one.shapes()]
    q = arm.random_q(20, seed=1)
    found = scene.distances(arm, q)
    for row, values in enumerate(q):
        frames = numpy_fk.frames(name, values)
        for k, body in enumerate(arm.bodies):
            number = arm.frame_number(body.frame)
            if number == 0:
                continue
            placed = made(body.shape.moved(rigid(frames[number])))
            least = min(by_coal(placed, thing) - placed[3] - thing[3] for thing in things)
            if least > 1e-7:
                assert found.distance[row, k] == pytest.approx(least, abs=1e-9)
            else:
                assert found.distance[row, k] <= 1e-7
