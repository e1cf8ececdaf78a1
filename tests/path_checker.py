"""A second judge of paths, in plain NumPy, apart from the library.

It reads the arm's file, samples a path so finely that no corner of a body moves more than 2 mm
from one sample to the next, and measures how far every body is from everything, with the
distances of `numpy_collision`. What a target may be touched by counts only near the target.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

import numpy_collision
import numpy_fk
from numpy_fk import Matrix

STEP = 0.002
"""Farthest that anything moves between two samples, m."""


@dataclass(frozen=True)
class Judged:
    """What a path keeps at its samples, m, and whether it stays within the limits."""

    scene: float
    own: float
    within_limits: bool
    samples: int

    @property
    def least(self) -> float:
        """The nearest that anything comes to anything."""
        return min(self.scene, self.own)


def sampled(name: str, path: Matrix) -> Matrix:
    """Return postures along a path, 2 mm apart at most."""
    rows = [path[:1]]
    for a, b in itertools.pairwise(path):
        count = 16
        while True:
            q = a + np.linspace(0, 1, count + 1)[:, None] * (b - a)
            solids = numpy_collision.solids_of_arm(name, q).values()
            ends = [end for _, solid in solids for edge in solid.edges() for end in edge]
            ends = [np.broadcast_to(end, (count + 1, 3)) for end in ends]
            most = max(np.linalg.norm(np.diff(end, axis=0), axis=1).max() for end in ends)
            if most <= STEP:
                break
            count = int(np.ceil(count * most / STEP * 1.05))
        rows.append(q[1:])
    return np.concatenate(rows)


def minded(
    name: str, q: Matrix, scene: Any, target: Any = None, touch_radius: float = 0.15
) -> Iterator[tuple[str, Any, Matrix]]:
    """Yield each body that moves with each thing that it minds, and the samples at which."""
    robot = numpy_fk.load(name)
    rules = robot.get("collision_rules", {})
    skip = {tuple(pair) for pair in rules.get("static_skip", ())}
    touching = set(rules.get("may_touch_target", ()))
    tool = numpy_fk.fk(robot, q)[:, :3, 3]
    for body, (frame, _) in numpy_collision.solids_of_arm(name, q[:1]).items():
        if frame == 0:
            continue
        for thing in scene.objects:
            if (body, thing.name) in skip:
                continue
            rows = np.arange(len(q))
            if target is not None and body in touching and thing.name in target.objects:
                away = np.linalg.norm(tool - np.array(target.point), axis=1)
                rows = np.flatnonzero(away > touch_radius)
            if len(rows):
                yield body, thing, rows


def judge(
    name: str,
    path: Matrix,
    scene: Any,
    self_pairs: Any,
    target: Any = None,
    touch_radius: float = 0.15,
    near: float = 0.05,
) -> Judged:
    """Judge a path of a bundled arm; distances above `near` (m) are told as it."""
    robot = numpy_fk.load(name)
    q = sampled(name, path)
    bodies = numpy_collision.solids_of_arm(name, q)
    outside = np.full(len(q), near)
    balls = {thing.name: _ball(thing) for thing in scene.objects}
    for body, thing, rows in minded(name, q, scene, target, touch_radius):
        solid = bodies[body][1]
        (centre, radius), (middle, reach) = numpy_collision.ball(solid), balls[thing.name]
        if np.linalg.norm(centre - middle, axis=-1).min() - radius - reach > near:
            continue
        outside[rows] = np.minimum(outside[rows], _least(solid.take(rows), thing, near))
    inside = near
    for a, b in self_pairs:
        one, other = bodies[a][1], bodies[b][1]
        # As in `_least`, but both move.
        reach = near + 20 * STEP
        rows = np.arange(0, len(q), 10)
        coarse = _between(one, other, rows, len(q), reach)
        rows = np.flatnonzero(np.repeat(coarse < reach, 10)[: len(q)])
        inside = min(inside, _between(one, other, rows, len(q), near).min(initial=near))
    lower, upper = numpy_fk.limits(robot).T
    return Judged(
        scene=float(outside.min()),
        own=float(inside),
        within_limits=bool(((q >= lower - 1e-9) & (q <= upper + 1e-9)).all()),
        samples=len(q),
    )


def _ball(thing: Any) -> tuple[Matrix, float]:
    """Return a ball round a thing; one without end where it has none."""
    if len(thing.halfspaces):
        return np.zeros(3), np.inf
    points = [(row[:3], row[3]) for row in thing.spheres]
    points += [(end, row[6]) for row in thing.capsules for end in (row[:3], row[3:6])]
    points += [(row[:3], np.linalg.norm(row[3:6]) + row[15]) for row in thing.boxes]
    middle = np.mean([point for point, _ in points], axis=0)
    return middle, max(float(np.linalg.norm(point - middle)) + r for point, r in points)


def _least(solid: Any, thing: Any, near: float) -> Matrix:
    """Return the distances of a body from a thing at samples in their order, `near` at most.

    One sample of ten is looked at first: from one to the next nothing moves more than `STEP`, so
    those between far ones are far.
    """
    count = len(solid.parts[0])
    first = np.arange(0, count, 10)
    reach = near + 10 * STEP
    coarse = np.full(len(first), reach)
    numpy_collision._lower(coarse, solid.take(first), thing, reach)
    rows = np.flatnonzero(np.repeat(coarse < reach, 10)[:count])
    least = np.full(count, near)
    if len(rows):
        close = np.full(len(rows), near)
        numpy_collision._lower(close, solid.take(rows), thing, near)
        least[rows] = close
    return least


def _between(one: Any, other: Any, rows: Matrix, count: int, near: float) -> Matrix:
    """Return the distances of two bodies at some postures, `near` at most."""
    one, other = (_taken(solid, rows, count) for solid in (one, other))
    close = np.flatnonzero(np.broadcast_to(numpy_collision._apart(one, other) < near, len(rows)))
    least = np.full(len(rows), near)
    if len(close):
        one, other = (_taken(solid, close, len(rows)) for solid in (one, other))
        least[close] = np.minimum(near, numpy_collision.distance(one, other, near))
    return least


def _taken(solid: Any, rows: Matrix, count: int) -> Any:
    """Return a solid at some postures; one on the base is the same at all."""
    moves = any(np.shape(part)[:1] == (count,) for part in solid.parts)
    return solid.take(rows) if moves else solid
