"""A second way to tell how far an arm is from a scene, in plain NumPy, apart from the library.

It reads the bodies out of a robot's TOML and the objects out of a scene's rows, places them
with `numpy_fk`, and looks for the nearest points along edges by shrinking intervals: the
distance of a convex set along a line is convex. Slow and plain on purpose.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import numpy_fk
from numpy_fk import Matrix, si

# Parts of an interval that are left after each look are two of three.
_LOOKS = 60


@dataclass(frozen=True)
class Solid:
    """A core and a radius, placed at any number of postures.

    Attributes
    ----------
    kind : {"segment", "box"}
        Points are segments without length.
    parts : tuple of ndarray
        Two ends (..., 3); or centre (..., 3), half (3,), axes as columns (..., 3, 3).
    radius : float
    """

    kind: str
    parts: tuple[Matrix, ...]
    radius: float

    def placed(self, pose: Matrix) -> Solid:
        """Return the solid of a frame at poses (..., 4, 4)."""
        turn, shift = pose[..., :3, :3], pose[..., :3, 3]

        def move(point: Matrix) -> Matrix:
            return np.einsum("...ij,...j->...i", turn, point) + shift

        if self.kind == "segment":
            return Solid("segment", (move(self.parts[0]), move(self.parts[1])), self.radius)
        centre, half, axes = self.parts
        return Solid("box", (move(centre), half, turn @ axes), self.radius)

    def take(self, rows: Any) -> Solid:
        """Return the solid at some of the postures."""
        if self.kind == "segment":
            return Solid("segment", (self.parts[0][rows], self.parts[1][rows]), self.radius)
        centre, half, axes = self.parts
        return Solid("box", (centre[rows], half, axes[rows]), self.radius)

    def edges(self) -> Iterator[tuple[Matrix, Matrix]]:
        """Yield the ends of the edges of the core."""
        if self.kind == "segment":
            yield self.parts[0], self.parts[1]
            return
        centre, half, axes = self.parts
        for axis in range(3):
            for signs in itertools.product((-1.0, 1.0), repeat=2):
                corner = np.zeros(3)
                corner[[k for k in range(3) if k != axis]] = signs
                ends = []
                for end in (-1.0, 1.0):
                    corner[axis] = end
                    ends.append(centre + np.einsum("...ij,j->...i", axes, corner * half))
                yield ends[0], ends[1]

    def distance_of(self, point: Matrix) -> Matrix:
        """Return the distance of points (..., 3) from the core."""
        if self.kind == "box":
            centre, half, axes = self.parts
            inner = np.einsum("...ji,...j->...i", axes, point - centre)
            return np.linalg.norm(np.maximum(np.abs(inner) - half, 0.0), axis=-1)
        a, b = self.parts
        along = b - a
        length = np.maximum((along * along).sum(-1), 1e-300)
        share = np.clip(((point - a) * along).sum(-1) / length, 0.0, 1.0)
        return np.linalg.norm(point - a - share[..., None] * along, axis=-1)


def distance(one: Solid, other: Solid) -> Matrix:
    """Return the distance of two solids; 0 or less in contact."""
    least: Matrix | None = None
    for first, second in ((one, other), (other, one)):
        for a, b in first.edges():
            away = _along(second, a, b)
            least = away if least is None else np.minimum(least, away)
    assert least is not None
    return least - one.radius - other.radius


def _along(core: Solid, a: Matrix, b: Matrix) -> Matrix:
    """Return the least distance of a core from the way from a to b."""
    a, b = np.broadcast_arrays(a, b)
    low = np.zeros(np.broadcast_shapes(a.shape, core.parts[0].shape)[:-1])
    high = np.ones_like(low)
    for _ in range(_LOOKS):
        left, right = (2 * low + high) / 3, (low + 2 * high) / 3
        first = core.distance_of(a + left[..., None] * (b - a))
        nearer = first < core.distance_of(a + right[..., None] * (b - a))
        low, high = np.where(nearer, low, left), np.where(nearer, right, high)
    middle = ((low + high) / 2)[..., None]
    ends = np.minimum(core.distance_of(a), core.distance_of(b))
    return np.minimum(core.distance_of(a + middle * (b - a)), ends)


def halfspace_distance(solid: Solid, normal: Matrix, offset: float) -> Matrix:
    """Return the distance of a solid from ``normal . x <= offset``."""
    length = np.linalg.norm(normal)
    corners = [point for edge in solid.edges() for point in edge]
    return np.min([(c @ normal - offset) / length for c in corners], axis=0) - solid.radius


def solids_of_arm(name: str, q: Matrix) -> dict[str, tuple[int, Solid]]:
    """Return frame and placed solid of each body of a bundled arm."""
    robot = numpy_fk.load(name)
    poses = numpy_fk.frames(robot, q)
    found = {}
    for row in robot["collision"]:
        radius = float(si(row, "radius"))
        if row["shape"] == "box":
            solid = Solid("box", (si(row, "centre"), si(row, "half"), turn_of(row)), radius)
        elif row["shape"] == "capsule":
            solid = Solid("segment", (si(row, "a"), si(row, "b")), radius)
        else:
            assert row["shape"] == "sphere"
            solid = Solid("segment", (si(row, "centre"), si(row, "centre")), radius)
        found[row["name"]] = (row["frame"], solid.placed(poses[row["frame"]]))
    return found


def turn_of(row: Mapping[str, Any]) -> Matrix:
    """Return the rotation of a body's table."""
    if "rotation" in row:
        return np.asarray(row["rotation"], dtype=float)
    return numpy_fk.transform({k: v for k, v in row.items() if k.startswith("rpy")})[:3, :3]


def least_distances(
    name: str, q: Matrix, scene: Any, self_pairs: Any, near: float = 0.3
) -> tuple[Matrix, Matrix]:
    """Return the distance from the scene and that of the self pairs, at each posture.

    Parameters
    ----------
    name : str
        A bundled arm.
    q : ndarray, shape (n, dof)
    scene : Scene
        Its rows are read, nothing is asked of it.
    self_pairs : iterable of (str, str)
    near : float
        What is certainly farther away than this is not looked at closely, m.

    Returns
    -------
    ndarray, ndarray
        Both of shape (n,); where nothing is near, `near`.
    """
    bodies = solids_of_arm(name, q)
    rules = numpy_fk.load(name).get("collision_rules", {})
    skip = {tuple(pair) for pair in rules.get("static_skip", ())}
    outside = np.full(len(q), near)
    for body, (frame, solid) in bodies.items():
        if frame == 0:
            continue
        for thing in scene.objects:
            if (body, thing.name) not in skip:
                _lower(outside, solid, thing, near)
    inside = np.full(len(q), near)
    for a, b in self_pairs:
        inside = np.minimum(inside, distance(bodies[a][1], bodies[b][1]))
    return outside, inside


def _lower(least: Matrix, solid: Solid, thing: Any, near: float) -> None:
    for row in thing.halfspaces:
        least[:] = np.minimum(least, halfspace_distance(solid, row[:3], row[3]))
    for row in thing.spheres:
        # A point: its distance from the core is closed.
        away = solid.distance_of(np.broadcast_to(row[:3], (len(least), 3)))
        least[:] = np.minimum(least, away - row[3] - solid.radius)
    others = [Solid("segment", (row[:3], row[3:6]), row[6]) for row in thing.capsules]
    others += [Solid("box", (row[:3], row[3:6], row[6:15].reshape(3, 3)), row[15])
               for row in thing.boxes]  # fmt: skip
    for other in others:
        rows = np.flatnonzero(_apart(solid, other) < near)
        if len(rows):
            least[rows] = np.minimum(least[rows], distance(solid.take(rows), other))
    assert not thing.hulls


def _apart(solid: Solid, other: Solid) -> Matrix:
    """Return a distance that is certainly no more than the true one."""

    def ball(one: Solid) -> tuple[Matrix, Matrix]:
        if one.kind == "box":
            return one.parts[0], np.linalg.norm(one.parts[1]) + one.radius
        a, b = one.parts
        return (a + b) / 2, np.linalg.norm(b - a, axis=-1) / 2 + one.radius

    (c1, r1), (c2, r2) = ball(solid), ball(other)
    return np.linalg.norm(c1 - c2, axis=-1) - r1 - r2
