"""All that an arm with errors may meet: every object near its bodies, and its own bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _native
from .._checks import FloatArray
from ._case import TOGETHER, AtPostures, Case, phi, ratio

__all__ = ["Risks", "risks"]

# Objects count that are farther than a body's nearest by so many standard deviations of its
# clearance.
_BEYOND = 4.0
# Bodies farther apart than so many count for less than the last digit of a probability.
_APART = 9.0
# Pairs that are kept exactly as far apart as they can move are asked about too, m.
_TOUCH = 1e-9
# Intervals are cut where what is at risk by this may move by more than such a share of a standard
# deviation within them, into so many pieces at most.
_AT_RISK = 1e-6
_FINE = 0.25
_PIECES = 64


@dataclass(frozen=True, eq=False)
class Risks:
    """What bodies may meet, the most probable first.

    Of each body every object counts that is farther from it than its nearest by no more than
    four standard deviations of its clearance, and every pair of bodies that can hit each other.

    Attributes
    ----------
    segment : ndarray of int, shape (k,)
        The segment of the path; 0 at a posture.
    body, other : tuple of k str
        The body, and the object or the other body.
    is_own : ndarray of bool, shape (k,)
        The other is a body of the arm.
    clearance : ndarray, shape (k,), m
        Distance between the two, on a path the certified one of the interval at most risk.
    deviation : ndarray, shape (k,), m
        Its standard deviation, to first order.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> ball = SceneObject.of("ball", Sphere([0.6, 0.0, 0.5], 0.05))
    >>> found = motion.sensitivity(Robot.load("panda"), Scene([ball]), [0, 0, 0, -1.5, 0, 1.5, 0])
    >>> "ball" in found.risks.other
    True
    """

    segment: NDArray[np.int64]
    body: tuple[str, ...]
    other: tuple[str, ...]
    is_own: NDArray[np.bool_]
    clearance: FloatArray
    deviation: FloatArray

    @property
    def hit(self) -> FloatArray:
        """Probability of each, to first order, shape (k,)."""
        return phi(-ratio(self.clearance, self.deviation))

    def __len__(self) -> int:
        return len(self.body)

    def failures(self, segments: int) -> FloatArray:
        """Return the sum of the probabilities of each segment, shape (segments,).

        Parameters
        ----------
        segments : int
            How many there are.

        Returns
        -------
        ndarray

        Examples
        --------
        >>> from agrik_fast import Robot, motion
        >>> from agrik_fast.collision import Scene, SceneObject, Sphere
        >>> scene = Scene([SceneObject.of("ball", Sphere([0.9, 0.0, 0.5], 0.05))])
        >>> arm = Robot.load("panda")
        >>> start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
        >>> found = motion.path_sensitivity(arm, scene, [start, start + 0.1, start + 0.2])
        >>> found.risks.failures(2).shape
        (2,)
        """
        counts = np.bincount(self.segment, weights=self.hit, minlength=segments)
        return np.asarray(counts, dtype=np.float64)


def risks(
    case: Case,
    q: FloatArray,
    found: AtPostures,
    *,
    reach: FloatArray | None = None,
    play: FloatArray | None = None,
    segment: NDArray[np.int64] | None = None,
    half: FloatArray | None = None,
) -> Risks:
    """Return what may be met at m postures, shape (m, dof), within `reach` of them.

    `found` is what `Case.at` says of them, `segment` (shape (m,)) which postures stand together:
    of these the one at most risk is told. `half`, shape (m, dof), is the way from the middle of
    each interval to its end where the interval is straight: these are cut finer where something
    is at risk.
    """
    around = np.zeros_like(q) if reach is None else reach
    of = np.zeros(len(q), dtype=np.int64) if segment is None else segment
    collider = case.collider
    # How far away objects count, of each body.
    within = np.where(np.isfinite(found.distance), found.distance + _BEYOND * found.deviation, 0.0)
    parts = []
    for first in range(0, len(q), TOGETHER):
        rows = slice(first, first + TOGETHER)
        unknown = None if play is None else play[rows]
        part = _block(case, collider, q[rows], around[rows], within[rows], unknown)
        if half is not None and len(part):
            part = _cut(case, collider, part, q[rows], half[rows], within[rows])
        numbers = of[rows][part[:, 0].astype(np.int64)]
        parts.append(np.column_stack([numbers, part[:, 1:5]]))
    table = np.concatenate(parts) if parts else np.zeros((0, 5))
    # The one at most risk of those that are alike comes first.
    at_risk = ratio(table[:, 3], table[:, 4])
    table = table[np.lexsort((at_risk, table[:, 2], table[:, 1], table[:, 0]))]
    kinds = table[:, :3]
    first_of = np.ones(len(table), dtype=bool)
    first_of[1:] = (kinds[1:] != kinds[:-1]).any(axis=1)
    table = table[first_of]
    table = table[np.argsort(ratio(table[:, 3], table[:, 4]), kind="stable")]
    bodies = table[:, 1].astype(np.int64).tolist()
    others = table[:, 2].astype(np.int64).tolist()
    objects = case.scene.names
    return Risks(
        segment=table[:, 0].astype(np.int64),
        body=tuple(case.names[k] for k in bodies),
        other=tuple(objects[k] if k >= 0 else case.names[-1 - k] for k in others),
        is_own=table[:, 2] < 0,
        clearance=table[:, 3],
        deviation=table[:, 4],
    )


def _cut(
    case: Case,
    collider: _native.Collider,
    table: FloatArray,
    q: FloatArray,
    half: FloatArray,
    within: FloatArray,
) -> FloatArray:
    """Return what `_block` says with intervals cut where something moves too far for its risk."""
    row, deviation, motion = table[:, 0].astype(np.int64), table[:, 4], table[:, 5]
    at_risk = (phi(-ratio(table[:, 3], deviation)) > _AT_RISK) & (deviation > 0)
    wanted = np.ones(len(table))
    np.divide(motion, _FINE * deviation, out=wanted, where=at_risk)
    pieces = np.ones(len(q), dtype=np.int64)
    np.maximum.at(pieces, row, np.ceil(np.clip(wanted, 1, _PIECES)).astype(np.int64))
    parts = [table[pieces[row] == 1]]
    for k in np.flatnonzero(pieces > 1):
        count = int(pieces[k])
        places = (2 * np.arange(count) + 1) / count - 1
        middles = q[k] + places[:, None] * half[k]
        reach = np.broadcast_to(np.abs(half[k]) / count, middles.shape)
        # Whatever counts in the middle counts in the pieces too.
        moved = case.motion(q[k][None], np.abs(half[k])[None])[0]
        farther = np.where(within[k] > 0, within[k] + moved, 0.0)
        around = np.broadcast_to(farther, (count, len(farther)))
        found = _block(case, collider, middles, reach, around, None)
        found[:, 0] = k
        parts.append(found)
    return np.concatenate(parts)


def _block(
    case: Case,
    collider: _native.Collider,
    q: FloatArray,
    reach: FloatArray,
    within: FloatArray,
    play: FloatArray | None,
) -> FloatArray:
    """Return rows of row, body, other, certified clearance, deviation and motion."""
    spread = np.broadcast_to(case.spread(play), q.shape)
    # Two bodies come no nearer to each other than the joints move the outer one.
    levers = case.levers(q, reach).max(axis=-1, initial=0.0)
    lengths = len(case.lengths.frames) * case.errors.length**2
    largest = np.sqrt(((levers * spread) ** 2).sum(axis=1) + lengths)
    own = (levers * reach).sum(axis=1) + _APART * largest + _TOUCH
    each = _native.collision_near(collider, q, reach, within, own)
    clearance = each["distance"] - each["motion"]
    names = [each[name] for name in ("row", "body", "other")]
    columns = [*names, clearance, _deviation(case, q, spread, each), each["motion"]]
    return np.column_stack([np.asarray(column, dtype=np.float64) for column in columns])


def _deviation(case: Case, q: FloatArray, spread: FloatArray, each: dict[str, Any]) -> FloatArray:
    """Return the standard deviation of the distance of each pair, m."""
    of, row, body, other = case.errors, each["row"], each["body"], each["other"]
    normal, own = each["normal"], other < 0
    square = ((each["rates"] * spread[row]) ** 2).sum(axis=1)
    directions, _ = case.lengths.directions(q)
    along = np.einsum("klx,kx->kl", directions[row], normal)
    moved = case.lengths.frames[None, :] <= case.frames[:, None]
    # A length before both bodies of a pair moves both alike.
    moves = np.where(own[:, None], moved[body] ^ moved[np.where(own, -1 - other, 0)], moved[body])
    square += ((along * moves * of.length) ** 2).sum(axis=1)
    # The scene is off as a whole; it has no part in what two bodies do to each other.
    seen = of.vision**2 * (normal**2).sum(axis=1)
    seen += of.camera**2 * (np.cross(each["on_body"], normal) ** 2).sum(axis=1)
    return np.asarray(np.sqrt(square + np.where(own, 0.0, seen)))
