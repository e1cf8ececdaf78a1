"""Errors at a harvest posture: what `agrik_fast.motion` says of it, the fruit being touched."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..collision import Scene, Target
from ..motion import Errors, Sensitivity, Simulated
from ..motion import sensitivity as sensitivity_of
from ..motion import simulate as simulate_of
from ..robot import Robot
from ._programme import Programme

__all__ = ["Errors", "Sensitivity", "Simulated", "sensitivity", "simulate"]


def sensitivity(
    robot: Robot | str,
    scene: Scene,
    target: str | Target | ArrayLike,
    q: ArrayLike,
    errors: Errors | None = None,
    *,
    moving: ArrayLike | None = None,
) -> Sensitivity:
    """Work out how errors show at a posture, to first order.

    The fruit, its stalk and what carries the arm do not count, as for `Programme`; see
    `agrik_fast.motion.sensitivity`.

    Parameters
    ----------
    robot, scene, target
        As for `Programme`.
    q : array_like, shape (dof,), rad and m
        The posture.
    errors : Errors, optional
    moving : array_like, shape (dof,), optional
        The direction in which each joint moved last; see `agrik_fast.motion.sensitivity`.

    Returns
    -------
    Sensitivity

    Raises
    ------
    ArgumentError, UnknownNameError
        As `Programme`; `q` of another shape.

    Examples
    --------
    >>> scene = ik.harvest.example_scene()
    >>> one = ik.harvest.plan("cucumber", scene, ["C1"])["C1"]
    >>> found = ik.harvest.sensitivity("cucumber", scene, "C1", one.q)
    >>> 0.004 < found.rms < 0.02
    True
    """
    arm, minded = _minded(robot, scene, target)
    return sensitivity_of(arm, minded, q, errors, moving=moving)


def simulate(
    robot: Robot | str,
    scene: Scene,
    target: str | Target | ArrayLike,
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
    robot, scene, target, errors
        As for `sensitivity`.
    q : array_like, shape (dof,) or (m, dof), rad and m
        A posture, or those of a path: each draw's errors hold on all of it.
    moving : array_like, shape (dof,), optional
        As for `sensitivity`; along a path that before it.
    draws : int, default 2000
    seed : int, default 0
    threads : int, optional

    Returns
    -------
    Simulated

    Raises
    ------
    ArgumentError, UnknownNameError
        As `sensitivity`.

    Examples
    --------
    >>> scene = ik.harvest.example_scene()
    >>> one = ik.harvest.plan("cucumber", scene, ["C1"])["C1"]
    >>> drawn = ik.harvest.simulate("cucumber", scene, "C1", one.q, draws=200)
    >>> drawn.clearance.shape
    (200,)
    """
    arm, minded = _minded(robot, scene, target)
    return simulate_of(
        arm, minded, q, errors, moving=moving, draws=draws, seed=seed, threads=threads
    )


def _minded(
    robot: Robot | str, scene: Scene, target: str | Target | ArrayLike
) -> tuple[Robot, Scene]:
    """Return the arm, and the scene without what it may touch."""
    programme = Programme(robot, scene, target)
    crop, chosen = programme._crop, programme._chosen
    statics = {scene.names[k] for k in crop.statics}
    kept = [one for one in scene.objects if one.name not in statics]
    own = {scene.names[k] for k in chosen.objects[0]}
    exempt = [
        (crop.bodies.names[body], one.name)
        for body in crop.touching
        for one in kept
        if one.name in own
    ]
    return crop.robot, Scene(kept, exemptions=exempt)
