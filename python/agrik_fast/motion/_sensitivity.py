"""How errors of joints, lengths and vision become errors of the tool and of the clearance."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, float_array, real_number, shown, whole_number
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import Robot
from ._errors import Errors, Lengths

__all__ = ["Sensitivity", "Simulated", "sensitivity", "simulate"]

# Step of the central differences of points on bodies, rad and m.
_STEP = 1e-6
# Postures that are worked on at a time.
_TOGETHER = 256


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """First-order effects of errors at a posture.

    Attributes
    ----------
    covariance : ndarray, shape (3, 3), m^2
        Of the tool point relative to the scene.
    rms : float
        Root of its trace, m.
    bodies : tuple of n str
        Bodies that move and have something near.
    clearance : ndarray, shape (n,), m
        Of each body from the scene.
    deviation : ndarray, shape (n,), m
        Standard deviation of each clearance.
    guaranteed : ndarray, shape (n,), m
        What is left of each clearance if no error is larger than its standard deviation
        (play: half of it), whatever their directions: the joints' levers times their errors,
        every length's error in full, the scene off the worst way. No linearisation.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> scene = Scene([SceneObject.of("ball", Sphere([0.6, 0.0, 0.5], 0.05))])
    >>> found = motion.sensitivity(Robot.load("panda"), scene, [0, 0, 0, -1.5, 0, 1.5, 0])
    >>> found.covariance.shape, len(found.bodies) == len(found.clearance)
    ((3, 3), True)
    """

    covariance: FloatArray
    rms: float
    bodies: tuple[str, ...]
    clearance: FloatArray
    deviation: FloatArray
    guaranteed: FloatArray

    @property
    def nearest(self) -> float:
        """Probability that the body most at risk is free: an upper bound to first order."""
        return float(phi(_ratio(self.clearance, self.deviation)).min(initial=1.0))

    @property
    def free(self) -> float:
        """Least probability that all bodies are free: the union bound, of any correlation."""
        return max(0.0, 1.0 - float(phi(-_ratio(self.clearance, self.deviation)).sum()))

    def min_distance(self, probability: float) -> float:
        """Return the distance to keep for a probability of staying free.

        Parameters
        ----------
        probability : float
            Above 0 and below 1.

        Returns
        -------
        float, m
            If the body whose clearance varies most keeps it, it is free with this probability.

        Raises
        ------
        ArgumentError
            A probability out of its range.

        Examples
        --------
        >>> from agrik_fast import Robot, motion
        >>> from agrik_fast.collision import Scene, SceneObject, Sphere
        >>> scene = Scene([SceneObject.of("ball", Sphere([0.6, 0.0, 0.5], 0.05))])
        >>> found = motion.sensitivity(Robot.load("panda"), scene, [0, 0, 0, -1.5, 0, 1.5, 0])
        >>> found.min_distance(0.9) < found.min_distance(0.99)
        True
        """
        wanted = real_number("probability", probability, 0.0, 1.0, open_low=True)
        if wanted == 1:
            raise ArgumentError("probability", "1", "a number below 1")
        largest = float(self.deviation.max(initial=0.0))
        low, high = -40.0, 40.0
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if float(phi(np.array(middle))) < wanted else (low, middle)
        return max(0.0, high * largest)


@dataclass(frozen=True, eq=False)
class Simulated:
    """Errors drawn at random, without any linearisation.

    Attributes
    ----------
    rms : float
        Root mean square distance of the tool point from where it was to be, m.
    free : float
        Share of the draws in which the posture, or the whole path, stays free of the scene.
    clearance : ndarray, shape (draws,), m
        Clearance of each, the least along a path.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> scene = Scene([SceneObject.of("ball", Sphere([0.9, 0.0, 0.5], 0.05))])
    >>> arm = Robot.load("panda")
    >>> drawn = motion.simulate(arm, scene, [0, 0, 0, -1.5, 0, 1.5, 0], draws=100)
    >>> drawn.clearance.shape
    (100,)
    """

    rms: float
    free: float
    clearance: FloatArray


def phi(x: FloatArray) -> FloatArray:
    """Return the normal distribution function."""
    erf = np.vectorize(math.erf, otypes=[float])
    return np.asarray(0.5 * (1 + erf(np.asarray(x) / math.sqrt(2))))


def _ratio(clearance: FloatArray, deviation: FloatArray) -> FloatArray:
    """Return clearances in their standard deviations; without errors they are never lost."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = clearance / deviation
    return np.where(clearance > 0, np.where(deviation > 0, ratio, np.inf), -np.inf)


def sensitivity(
    arm: Robot, scene: Scene, q: ArrayLike, errors: Errors | None = None
) -> Sensitivity:
    """Work out how errors show at a posture, to first order.

    The tool point: ``J S_q J' + J_l S_l J_l' + [r x] S_w [r x]' + S_v``. The clearance of a body
    changes by the way of its nearest point along the line to the nearest object.

    Parameters
    ----------
    arm : Robot
        An arm with bodies.
    scene : Scene
        What its exemptions and its target's touch zone let touch does not count.
    q : array_like, shape (dof,), rad and m
        The posture.
    errors : Errors, optional

    Returns
    -------
    Sensitivity

    Raises
    ------
    ArgumentError
        A wrong shape, numbers that are not finite, an arm without bodies.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> scene = Scene([SceneObject.of("ball", Sphere([0.6, 0.0, 0.5], 0.05))])
    >>> arm = Robot.load("panda")
    >>> found = motion.sensitivity(arm, scene, [0, 0, 0, -1.5, 0, 1.5, 0])
    >>> bool(found.free <= found.nearest)
    True
    """
    case = Case(arm, scene, errors)
    posture = finite_array("q", q, (arm.dof,))
    found = case.at(posture[None])
    told = np.isfinite(found.clearance[0])
    covariance = case.covariance(posture)
    return Sensitivity(
        covariance,
        float(np.sqrt(np.trace(covariance))),
        tuple(np.array(case.names, dtype=object)[told].tolist()),
        found.clearance[0][told],
        found.deviation[0][told],
        found.guaranteed[0][told],
    )


def simulate(
    arm: Robot,
    scene: Scene,
    q: ArrayLike,
    errors: Errors | None = None,
    *,
    draws: int = 2000,
    seed: int = 0,
    threads: int | None = None,
) -> Simulated:
    """Draw errors at random and place the arm anew: what `sensitivity` is checked by.

    Parameters
    ----------
    arm, scene, errors
        As for `sensitivity`.
    q : array_like, shape (dof,) or (m, dof), rad and m
        A posture, or those of a path: each draw's errors hold on all of it.
    draws : int, default 2000
    seed : int, default 0
    threads : int, optional

    Returns
    -------
    Simulated
        `rms` is that of the last posture.

    Raises
    ------
    ArgumentError
        As `sensitivity`; numbers out of their ranges.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> scene = Scene([SceneObject.of("ball", Sphere([0.9, 0.0, 0.5], 0.05))])
    >>> arm = Robot.load("panda")
    >>> motion.simulate(arm, scene, [0, 0, 0, -1.5, 0, 1.5, 0], draws=100).free
    1.0
    """
    case = Case(arm, scene, errors)
    given = float_array("q", q)
    rows = finite_array("q", q, (len(given), arm.dof) if given.ndim == 2 else (arm.dof,))
    postures = np.atleast_2d(rows)
    if not len(postures):
        raise ArgumentError("q", f"shape {postures.shape}", "at least one posture")
    count = whole_number("draws", draws, 1, 10**7)
    drawn = _Draws(case, count, np.random.default_rng(whole_number("seed", seed, 0)))
    collider = scene.collider(arm)
    clearance = np.full(count, np.inf)
    error = np.zeros((count, 3))
    for posture in postures:
        moved, shifts, error = drawn.at(posture)
        clearance = np.minimum(clearance, collider.shifted_clearance(moved, shifts, threads))
    return Simulated(
        float(np.sqrt((error**2).sum(axis=1).mean())),
        float((clearance > 0).mean()),
        clearance,
    )


class _Draws:
    """Errors that were drawn, the same all along a path."""

    def __init__(self, case: Case, count: int, rng: np.random.Generator) -> None:
        of, dof = case.errors, case.arm.dof
        turning = np.array([kind != "prismatic" for kind in case.arm.joint_types])
        self._case = case
        self._joints = rng.normal(0, 1, (count, dof)) * np.where(turning, of.joint, of.slide)
        self._joints += turning * rng.uniform(-0.5, 0.5, (count, dof)) * of.backlash
        self._lengths = rng.normal(0, of.length, (count, len(case.lengths.frames), 1))
        self._vision = rng.normal(0, of.vision, (count, 3))
        self._turn = rng.normal(0, of.camera, (count, 3))

    def at(self, posture: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return joint values, shifts of the bodies, errors of the tool point."""
        case = self._case
        moved = posture + self._joints
        directions, tool = case.lengths.directions(moved)
        shifts = np.zeros((len(moved), len(case.frames), 3))
        for body, frame in enumerate(case.frames):
            before = case.lengths.frames <= frame
            shifts[:, body] = (directions * self._lengths)[:, before].sum(axis=1)
        point = case.arm.fk(posture)[:3, 3]
        off = self._vision + np.cross(self._turn, point)
        error = tool + (directions * self._lengths).sum(axis=1) - point - off
        # What is seen off by so much is as if the arm stood off by as much the other way.
        return moved, shifts - off[:, None], error


@dataclass(frozen=True, eq=False)
class AtPostures:
    """Of m postures: clearance, its deviation and what is guaranteed, shape (m, bodies), m.

    Infinite for bodies that have nothing near.
    """

    clearance: FloatArray
    deviation: FloatArray
    guaranteed: FloatArray


class Case:
    """An arm in a scene, with errors."""

    def __init__(self, arm: Robot, scene: Scene, errors: Errors | None) -> None:
        if not isinstance(arm, Robot):
            raise ArgumentError("arm", shown(arm), "a Robot")
        if not isinstance(scene, Scene):
            raise ArgumentError("scene", shown(scene), "a Scene")
        self.errors = Errors() if errors is None else errors
        if not isinstance(self.errors, Errors):
            raise ArgumentError("errors", shown(errors), "Errors")
        self.arm, self.scene = arm, scene
        self.bodies = arm.compiled_bodies()
        self.names = tuple(self.bodies.names)
        self.frames = np.array(self.bodies.frames, dtype=np.int64)
        self.lengths = Lengths(arm)

    def covariance(self, q: FloatArray) -> FloatArray:
        """Return the covariance of the tool point relative to the scene, m^2."""
        of = self.errors
        jacobian = self.arm.jacobian(q)[:3]
        directions, point = self.lengths.directions(q[None])
        x, y, z = point[0]
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        lengths = directions[0] * of.length
        covariance = (jacobian * of.joints(self.arm) ** 2) @ jacobian.T + lengths.T @ lengths
        covariance += of.vision**2 * np.eye(3) + of.camera**2 * cross @ cross.T
        return np.asarray(covariance)

    def at(self, q: FloatArray, reach: FloatArray | None = None) -> AtPostures:
        """Return what errors do to the bodies at m postures, shape (m, dof).

        With `reach`, shape (m, dof), all postures whose joint values differ by no more than
        that are meant: clearances are less by what the bodies can move on the way to them.
        """
        blocks = list(self._blocks(q, reach))
        each = (np.concatenate([getattr(one, name) for one in blocks]) for name in _FIELDS)
        return AtPostures(*each)

    def _blocks(self, q: FloatArray, reach: FloatArray | None) -> Iterator[AtPostures]:
        for first in range(0, len(q), _TOGETHER):
            rows = slice(first, first + _TOGETHER)
            yield self._block(q[rows], None if reach is None else reach[rows])

    def _block(self, q: FloatArray, reach: FloatArray | None) -> AtPostures:
        of, near = self.errors, self.scene.distances(self.arm, q)
        told = np.isfinite(near.distance) & (self.frames > 0)
        way = near.on_body - near.on_object
        size = np.linalg.norm(way, axis=-1, keepdims=True)
        normal = np.divide(way, size, out=np.zeros_like(way), where=size > 0)
        rates = np.einsum("mjbx,mbx->mbj", self._point_rates(q, near.on_body), normal)
        square = ((rates * of.joints(self.arm)) ** 2).sum(axis=-1)
        directions, _ = self.lengths.directions(q)
        moves = self.lengths.frames[None, :] <= self.frames[:, None]
        along = np.einsum("mlx,mbx->mbl", directions, normal) * moves
        square += ((along * of.length) ** 2).sum(axis=-1)
        square += (of.vision * np.linalg.norm(normal, axis=-1)) ** 2
        square += (of.camera * np.linalg.norm(np.cross(near.on_body, normal), axis=-1)) ** 2
        distance = near.distance if reach is None else near.distance - self.motion(q, reach)
        clearance = np.where(told, distance, np.inf)
        return AtPostures(clearance, np.sqrt(square), clearance - self._worst(q, near.on_body))

    def motion(self, q: FloatArray, reach: FloatArray) -> FloatArray:
        """Return how far core points of the bodies move within `reach`, shape (m, bodies), m."""
        levers = [self.bodies.levers(row, most) for row, most in zip(q, reach, strict=True)]
        return np.asarray(np.einsum("mjb,mj->mb", np.array(levers), reach))

    def _worst(self, q: FloatArray, points: FloatArray) -> FloatArray:
        """Return by how much errors of no more than their sizes lessen clearances at most."""
        of = self.errors
        slides = np.array([kind == "prismatic" for kind in self.arm.joint_types])
        joints = np.where(slides, of.slide, of.joint + 0.5 * of.backlash)
        worst = self.motion(q, np.broadcast_to(joints, q.shape))
        moved = (self.lengths.frames[None, :] <= self.frames[:, None]).sum(axis=1)
        # Three errors of the same size along three axes are off by the root of three of it.
        seen = math.sqrt(3.0) * (of.vision + of.camera * np.linalg.norm(points, axis=-1))
        return np.asarray(worst + moved * of.length + seen)

    def _point_rates(self, q: FloatArray, points: FloatArray) -> FloatArray:
        """Return how points on the bodies move with each joint, shape (m, dof, bodies, 3)."""
        frames = np.maximum(self.frames, 1) - 1
        poses = self.arm.fk_links(q)[:, frames]
        turned = np.swapaxes(poses[..., :3, :3], -1, -2)
        local = np.einsum("mbxy,mby->mbx", turned, points - poses[..., :3, 3])
        steps = _STEP * np.eye(q.shape[1])
        ends = []
        for sign in (1.0, -1.0):
            moved = self.arm.fk_links(q[:, None] + sign * steps)[:, :, frames]
            ends.append(np.einsum("mjbxy,mby->mjbx", moved[..., :3, :3], local))
            ends[-1] += moved[..., :3, 3]
        rates = (ends[0] - ends[1]) / (2 * _STEP)
        return np.asarray(rates * (self.frames > 0)[:, None])


_FIELDS = ("clearance", "deviation", "guaranteed")
