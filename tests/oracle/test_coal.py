"""Distances of random solids of all kinds: this library against coal, pair by pair.

coal (C++) finds them by GJK, from shapes that it is given one pair at a time. Its managers are
not asked, whose least distances are not always the least.
"""

from __future__ import annotations

from itertools import product

import coal
import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from agrik_fast import _native

KINDS = ("sphere", "capsule", "box", "convex")
BODIES = 40
OBJECTS = 12


def still() -> _native.Chain:
    """Return an arm of one joint whose link stands in the base frame at 0."""
    joint = {
        "name": "q",
        "type": "revolute",
        "origin": np.eye(4),
        "axis": [0, 0, 1],
        "lower": -1,
        "upper": 1,
        "mimic": None,
    }
    return _native.Chain.from_joints("still", [joint])


class Solid:
    """A core of a kind at a random place, as both libraries know it."""

    def __init__(self, kind: str, rng: np.random.Generator, spread: float) -> None:
        self.kind, self.radius = kind, rng.uniform(0.01, 0.2)
        self.place = rng.uniform(-spread, spread, 3)
        turn = Rotation.random(rng=rng).as_matrix()
        size = rng.uniform(0.05, 0.4, 3)
        pose = coal.Transform3s(turn, self.place)
        if kind == "sphere":
            self.core: object = self.place
            shape = coal.Sphere(self.radius)
        elif kind == "capsule":
            half = size[0] * turn[:, 2]
            self.core = np.array([self.place - half, self.place + half])
            shape = coal.Capsule(self.radius, 2 * size[0])
        elif kind == "box":
            # The radius round a box is none of coal's.
            self.core = (self.place, size, turn)
            shape = coal.Box(*(2 * size))
        else:
            points = rng.uniform(-1, 1, (12, 3)) * size
            hull = ConvexHull(points)
            points = points[hull.vertices]
            self.core = points @ turn.T + self.place
            number = {vertex: i for i, vertex in enumerate(hull.vertices)}
            faces = coal.StdVec_Triangle()
            for simplex in hull.simplices:
                faces.append(coal.Triangle(*(number[vertex] for vertex in simplex)))
            vertices = coal.StdVec_Vec3s()
            for point in points:
                vertices.append(point)
            shape = coal.Convex(vertices, faces)
        self.shape, self.pose = shape, pose
        self.beyond = self.radius if kind in ("box", "convex") else 0.0

    def distance(self, other: Solid) -> float:
        """Return the distance as coal has it."""
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        request.gjk_tolerance = 1e-14
        request.gjk_max_iterations = 1000
        apart = coal.distance(self.shape, self.pose, other.shape, other.pose, request, result)
        return apart - self.beyond - other.beyond


def as_scene(solid: Solid) -> _native.Scene:
    radius = solid.radius
    if solid.kind == "sphere":
        return _native.Scene(["it"], spheres=[[*solid.place, radius]], sphere_labels=[0])
    if solid.kind == "capsule":
        row = [*np.ravel(solid.core), radius]
        return _native.Scene(["it"], capsules=[row], capsule_labels=[0])
    if solid.kind == "box":
        centre, half, turn = solid.core
        row = [*centre, *half, *np.ravel(turn), radius]
        return _native.Scene(["it"], boxes=[row], box_labels=[0])
    return _native.Scene(["it"], hulls=[solid.core], hull_radii=[radius], hull_labels=[0])


def our_distances(bodies: list[Solid], scene: _native.Scene) -> np.ndarray:
    arm = _native.Bodies(
        still(),
        [f"body{i}" for i in range(len(bodies))],
        [1] * len(bodies),
        [body.kind for body in bodies],
        [body.core for body in bodies],
        [body.radius for body in bodies],
        self_pairs=[],
    )
    collider = _native.Collider(arm, scene)
    found = collider.distances([0.0]).distance
    # One by one they hit exactly where they are 0 or less away.
    assert bool(collider.collides([0.0])) == bool((found <= 0).any())
    return found


@pytest.mark.parametrize(("kind", "other"), list(product(KINDS, KINDS)))
def test_distances_are_those_of_coal(kind: str, other: str) -> None:
    rng = np.random.default_rng([KINDS.index(kind), KINDS.index(other)])
    apart = 0
    for spread in (0.4, 1.5):
        for _ in range(OBJECTS):
            thing = Solid(other, rng, spread)
            bodies = [Solid(kind, rng, spread) for _ in range(BODIES)]
            ours = our_distances(bodies, as_scene(thing))
            theirs = np.array([body.distance(thing) for body in bodies])
            radii = np.array([body.radius + thing.radius for body in bodies])
            # Where cores meet, depths are coal's own affair; both say that they do.
            outside = theirs + radii > 1e-9
            apart += int(outside.sum())
            off = np.abs(ours - theirs) / (np.abs(theirs) + radii)
            assert off[outside].max(initial=0) < 1e-9
            assert (ours[~outside] <= 0).all()
            clear = np.abs(theirs) > 1e-9
            np.testing.assert_array_equal((ours <= 0)[clear], (theirs <= 0)[clear])
    assert apart > 0.5 * 2 * OBJECTS * BODIES


@pytest.mark.parametrize("kind", KINDS)
def test_half_spaces_are_those_of_coal(kind: str) -> None:
    rng = np.random.default_rng(9)
    for _ in range(OBJECTS):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        offset = rng.uniform(-1, 1)
        plane = coal.Halfspace(normal, offset)
        scene = _native.Scene(["it"], halfspaces=[[*normal, offset]], halfspace_labels=[0])
        bodies = [Solid(kind, rng, 1.0) for _ in range(BODIES)]
        ours = our_distances(bodies, scene)
        for body, found in zip(bodies, ours, strict=True):
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            here = coal.Transform3s()
            known = coal.distance(body.shape, body.pose, plane, here, request, result)
            assert abs(found - (known - body.beyond)) < 1e-9
