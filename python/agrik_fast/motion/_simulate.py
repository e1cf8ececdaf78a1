"""Errors drawn at random, without any linearisation: what the formulas are checked by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, finite_array, float_array, whole_number
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import Robot
from ._case import Case
from ._errors import Errors
from ._play import half_play, moved_last

__all__ = ["Simulated", "simulate"]


@dataclass(frozen=True, eq=False)
class Simulated:
    """Errors drawn at random, without any linearisation.

    Attributes
    ----------
    rms : float
        Root mean square distance of the tool point from where it was to be, m.
    free : float
        Share of the draws in which the posture, or the whole path, stays free: of the scene,
        and bodies of the arm of each other.
    clearance : ndarray, shape (draws,), m
        Clearance of each from the scene, the least along a path.
    own : ndarray, shape (draws,), m
        The same of the bodies of the arm from each other; infinite where none can hit another.

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
    own: FloatArray


def simulate(
    arm: Robot,
    scene: Scene,
    q: ArrayLike,
    errors: Errors | None = None,
    *,
    moving: ArrayLike | None = None,
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
    moving : array_like, shape (dof,), optional
        As for `sensitivity`; along a path that before it, and play is followed from posture to
        posture. Default: play is drawn once, evenly.
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
    rng = np.random.default_rng(whole_number("seed", seed, 0))
    drawn = _Draws(case, count, rng, postures[0], moved_last(case, moving))
    collider = case.collider
    clearance, own = np.full(count, np.inf), np.full(count, np.inf)
    error = np.zeros((count, 3))
    for posture in postures:
        moved, shifts, error = drawn.at(posture)
        clearance = np.minimum(clearance, collider.shifted_clearance(moved, shifts, threads))
        between = _native.collision_shifted_own(collider, moved, shifts, threads)
        own = np.minimum(own, between)
    return Simulated(
        float(np.sqrt((error**2).sum(axis=1).mean())),
        float(((clearance > 0) & (own > 0)).mean()),
        clearance,
        own,
    )


class _Draws:
    """Errors that were drawn, the same all along a path."""

    def __init__(
        self,
        case: Case,
        count: int,
        rng: np.random.Generator,
        start: FloatArray,
        signs: FloatArray | None,
    ) -> None:
        of, dof = case.errors, case.arm.dof
        turning = np.array([kind != "prismatic" for kind in case.arm.joint_types])
        self._case = case
        self._joints = rng.normal(0, 1, (count, dof)) * np.where(turning, of.joint, of.slide)
        place = turning * rng.uniform(-0.5, 0.5, (count, dof)) * of.backlash
        self._stands = None
        if signs is None:
            self._joints += place
        else:
            half = half_play(case)
            self._half = half
            self._stands = start + np.where(signs == 0, place, -half * signs)
        self._lengths = rng.normal(0, of.length, (count, len(case.lengths.frames), 1))
        self._vision = rng.normal(0, of.vision, (count, 3))
        self._turn = rng.normal(0, of.camera, (count, 3))

    def at(self, posture: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return joint values, shifts of the bodies, errors of the tool point."""
        case = self._case
        if self._stands is None:
            moved = posture + self._joints
        else:
            # A joint stays where it stands unless it would be off by more than half its play.
            self._stands = np.clip(self._stands, posture - self._half, posture + self._half)
            moved = self._stands + self._joints
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
