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


def distance(one: Solid, other: Solid, near: float = np.inf) -> Matrix:
    """Return the distance of two solids; 0 or less in contact.

    Where it is more than `near`, a number above `near` that is no more than it.
    """
    if one.kind == other.kind == "segment":
        return _between_segments(*one.parts, *other.parts) - one.radius - other.radius
    if one.kind == "segment":
        one, other = other, one
    # One of them is a box. A nearest point of the other is on an edge of it, or inside a face,
    # and then that of the box is on an edge: a corner, or where a rod passes through a plate.
    reach = near + one.radius + other.radius
    least = _from_edges(one, other, reach)
    if other.kind == "box":
        least = np.minimum(least, _from_edges(other, one, reach))
    return least - one.radius - other.radius


def _from_edges(core: Solid, other: Solid, near: float) -> Matrix:
    """Return the least distance of a core from the edges of another; of far ones a bound."""
    shape = np.broadcast_shapes(core.parts[0].shape, other.parts[0].shape)
    starts, ends = (
        np.stack([np.broadcast_to(end, shape) for end in each])
        for each in zip(*other.edges(), strict=True)
    )
    return _along(core, starts, ends, near).min(axis=0)


def _between_segments(a: Matrix, b: Matrix, c: Matrix, d: Matrix) -> Matrix:
    """Return the distance of segments from a to b and from c to d, in closed form.

    The nearest points are inside both, or one of them is an end.
    """
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    uw, vw = (u * w).sum(-1), (v * w).sum(-1)
    one, other = Solid("segment", (a, b), 0.0), Solid("segment", (c, d), 0.0)
    least = np.minimum(
        np.minimum(one.distance_of(c), one.distance_of(d)),
        np.minimum(other.distance_of(a), other.distance_of(b)),
    )
    det = uu * vv - uv * uv
    crossing = det > 1e-14 * uu * vv
    safe = np.where(crossing, det, 1.0)
    s, t = (uv * vw - vv * uw) / safe, (uu * vw - uv * uw) / safe
    crossing &= (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    between = np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
    return np.where(crossing, np.minimum(least, between), least)


def _along(core: Solid, a: Matrix, b: Matrix, near: float) -> Matrix:
    """Return the least distance of a core from the way from a to b; of far ones a bound."""
    shape = np.broadcast_shapes(a.shape, core.parts[0].shape)
    if core.kind == "box":
        centre, half, axes = core.parts
        a, b = (np.einsum("...ji,...j->...i", axes, end - centre) for end in (a, b))
        core = Solid("box", (np.zeros(3), half, np.eye(3)), 0.0)
    a, b = np.broadcast_to(a, shape), np.broadcast_to(b, shape)
    least = core.distance_of((a + b) / 2) - np.linalg.norm(b - a, axis=-1) / 2
    rows = least < near
    a, b = a[rows], b[rows]
    if core.kind == "segment":
        core = Solid("segment", tuple(np.broadcast_to(p, shape)[rows] for p in core.parts), 0.0)

    def away(share: Matrix) -> Matrix:
        point = a + share[..., None] * (b - a)
        if core.kind == "segment":
            return core.distance_of(point)
        out = np.maximum(np.abs(point) - core.parts[1], 0.0)
        return np.sqrt(np.einsum("...j,...j->...", out, out))

    low, high = np.zeros(len(a)), np.ones(len(a))
    for _ in range(_LOOKS):
        left, right = (2 * low + high) / 3, (low + 2 * high) / 3
        nearer = away(left) < away(right)
        low, high = np.where(nearer, low, left), np.where(nearer, right, high)
    ends = np.minimum(away(np.zeros(len(a))), away(np.ones(len(a))))
    least[rows] = np.minimum(away((low + high) / 2), ends)
    return least


def halfspace_distance(solid: Solid, normal: Matrix, offset: float) -> Matrix:
    """Return the distance of a solid from ``normal . x <= offset``."""
    length = np.linalg.norm(normal)
    corners = [point for edge in solid.edges() for point in edge]
    return np.min([(c @ normal - offset) / length for c in corners], axis=0) - solid.radius


def solids_of_arm(name: str, q: Matrix) -> dict[str, tuple[int, Solid]]:
    """Return frame and placed solid of each body of a bundled arm; frame 0 where none moves it."""
    robot = numpy_fk.load(name)
    poses = numpy_fk.frames(robot, q)
    rows = robot["dh"] if "dh" in robot else robot["joint"]
    numbers = {"base": 0, "tool": len(poses) - 1}
    numbers |= {row["link"]: k for k, row in enumerate(rows, 1) if "link" in row}
    still = next(k for k, row in enumerate(rows) if row["type"] != "fixed")
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
        number = numbers.get(row["frame"], row["frame"])
        found[row["name"]] = (0 if number <= still else number, solid.placed(poses[number]))
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
    for first in range(0, len(thing.spheres), 64):
        # Points: their distances from the core are closed.
        some = thing.spheres[first : first + 64]
        away = solid.distance_of(some[:, None, :3]) - some[:, None, 3]
        least[:] = np.minimum(least, away.min(axis=0) - solid.radius)
    for other in _longer(thing):
        rows = np.flatnonzero(_apart(solid, other) < near)
        if len(rows):
            least[rows] = np.minimum(least[rows], distance(solid.take(rows), other, near))
    assert not thing.hulls


def _longer(thing: Any) -> list[Solid]:
    """Return the capsules and boxes of a thing."""
    found = [Solid("segment", (row[:3], row[3:6]), row[6]) for row in thing.capsules]
    boxes = ((row, (row[:3], row[3:6], row[6:15].reshape(3, 3))) for row in thing.boxes)
    return found + [Solid("box", parts, row[15]) for row, parts in boxes]


def ball(one: Solid) -> tuple[Matrix, Matrix]:
    """Return centre and radius of a ball round a solid."""
    if one.kind == "box":
        return one.parts[0], np.linalg.norm(one.parts[1]) + one.radius
    a, b = one.parts
    return (a + b) / 2, np.linalg.norm(b - a, axis=-1).max(initial=0.0) / 2 + one.radius


def _apart(solid: Solid, other: Solid) -> Matrix:
    """Return a distance that is certainly no more than the true one."""
    (c1, r1), (c2, r2) = ball(solid), ball(other)
    return np.linalg.norm(c1 - c2, axis=-1) - r1 - r2
