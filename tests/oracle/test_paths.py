"""Paths that were returned, sampled every 2 mm, before coal, pair by pair.

Coal is asked about the pairs that a bound in NumPy does not keep apart by more than is certified.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

import numpy_collision
import numpy_fk
import path_checker
import paths_full
from coal_pairs import Made, by_coal, made, rigid
from numpy_collision import Solid
from paths_full import Returned

PATHS = 200


def plain(shape: Made) -> Solid | None:
    """Return one of our solids as the bound takes it; none for a half-space."""
    one, _, where, around = shape
    if hasattr(one, "normal"):
        return None
    if hasattr(one, "half"):
        return Solid("box", (where[:3, 3], np.array(one.half), where[:3, :3]), around)
    ends = (one.a, one.b) if hasattr(one, "a") else (one.centre, one.centre)
    return Solid("segment", (np.array(ends[0]), np.array(ends[1])), one.radius)


def nearest(one: Returned, near: float) -> float:
    """Return how near to each other anything comes at the samples of a path, `near` at most."""
    name = one.arm.name
    q = path_checker.sampled(name, one.path.path)
    frames = numpy_fk.frames(name, q)
    numbers = {body.name: one.arm.frame_number(body.frame) for body in one.arm.bodies}
    bodies = {body.name: made(body.shape) for body in one.arm.bodies}
    placed = numpy_collision.solids_of_arm(name, q)

    def at(body: str, row: int) -> Made:
        shape, geometry, where, around = bodies[body]
        return shape, geometry, rigid(frames[numbers[body]][row]) @ where, around

    def gap(first: Made, second: Made) -> float:
        return by_coal(first, second) - first[3] - second[3]

    least = near
    things = {thing.name: [made(shape) for shape in thing.shapes()] for thing in one.scene.objects}
    for body, thing, rows in path_checker.minded(name, q, one.scene, one.aim):
        solid = placed[body][1].take(rows)
        for shape in things[thing.name]:
            bound = plain(shape)
            close = rows
            if bound is not None:
                close = rows[numpy_collision._apart(solid, bound) < near]
            for row in close:
                least = min(least, gap(at(body, row), shape))
    for a, b in one.arm.self_pairs.asked:
        apart = numpy_collision._apart(placed[a][1], placed[b][1])
        for row in np.flatnonzero(np.broadcast_to(apart, len(q)) < near):
            least = min(least, gap(at(a, row), at(b, row)))
    return least


def some() -> Iterator[Returned]:
    for seed in itertools.count(1000):
        yield from paths_full.returned(seed)


@pytest.mark.timeout(1200)
def test_paths_keep_what_was_certified_as_coal_says() -> None:
    arms: Counter[str] = Counter()
    for one in itertools.islice(some(), PATHS):
        certified = one.path.certified
        assert certified >= paths_full.CLEAR - 1e-9
        assert nearest(one, certified + 1e-4) >= certified - 1e-9, (one.arm.name, one.path.how)
        arms[one.arm.name] += 1
    assert arms.total() == PATHS
    assert len(arms) >= 5
