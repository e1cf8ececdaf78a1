"""How errors of joints, lengths and vision become errors of the tool and of the clearance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, real_number
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import Robot
from ._case import Case, phi, ratio
from ._errors import Errors
from ._play import moved_last, stands
from ._risks import Risks, risks

__all__ = ["Sensitivity", "sensitivity"]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """First-order effects of errors at a posture.

    Attributes
    ----------
    covariance : ndarray, shape (3, 3), m^2
        Of the tool point relative to the scene.
    rms : float
        Root mean square of how far the tool point is from where it was to be, m.
    bias : ndarray, shape (3,), m
        What it is off by on the average: what play does that has a known direction.
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
    risks : Risks
        All that may be met, the most probable first.

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
    bias: FloatArray
    bodies: tuple[str, ...]
    clearance: FloatArray
    deviation: FloatArray
    guaranteed: FloatArray
    risks: Risks

    @property
    def nearest(self) -> float:
        """Probability that the body most at risk is free: an upper bound to first order."""
        return float(phi(ratio(self.clearance, self.deviation)).min(initial=1.0))

    @property
    def free(self) -> float:
        """Least probability that nothing is met: the union bound over `risks`.

        It holds for any correlation, with each probability to first order.
        """
        return max(0.0, 1.0 - float(self.risks.failures(1)[0]))

    @property
    def free_of_nearest(self) -> float:
        """The same if each body could meet the object nearest to it alone."""
        return max(0.0, 1.0 - float(phi(-ratio(self.clearance, self.deviation)).sum()))

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


def sensitivity(
    arm: Robot,
    scene: Scene,
    q: ArrayLike,
    errors: Errors | None = None,
    *,
    moving: ArrayLike | None = None,
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
    moving : array_like, shape (dof,), optional
        The direction in which each joint moved last: its sign counts, 0 where it is not known.
        A joint that was driven one way stands half its play behind. Default: not known of any,
        so play counts as even.

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
    told_to = finite_array("q", q, (arm.dof,))
    signs = moved_last(case, moving)
    posture, play = (told_to, None) if signs is None else stands(case, told_to, signs)
    unknown = None if play is None else play[None]
    found = case.at(posture[None], play=unknown)
    told = np.isfinite(found.clearance[0])
    covariance = case.covariance(posture, unknown)
    bias = arm.fk(posture)[:3, 3] - arm.fk(told_to)[:3, 3]
    return Sensitivity(
        covariance,
        float(np.sqrt(np.trace(covariance) + bias @ bias)),
        bias,
        tuple(np.array(case.names, dtype=object)[told].tolist()),
        found.clearance[0][told],
        found.deviation[0][told],
        found.guaranteed[0][told],
        risks(case, posture[None], found, play=unknown),
    )
