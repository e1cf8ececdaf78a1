"""What `Robot.ik` and `Robot.ik_all` return: status codes, results, singularities."""

from __future__ import annotations

from enum import IntEnum, IntFlag

from ._native import Branches, IkResult

__all__ = ["Branches", "IkResult", "Singularity", "Status"]


class Singularity(IntFlag):
    """Where a branch of `Robot.ik_all` nearly meets another, as in ``Branches.singular``.

    Nearly means: the sine of the angle between the two is below 1e-6.
    """

    SHOULDER = 1
    """The wrist's centre is on the first axis or at the edge of what the first joints
    allow; of an S-R-S arm, its first and third axis are in line."""

    ELBOW = 2
    """The arm is stretched or folded."""

    WRIST = 4
    """The first and the last axis of the wrist are in line."""


class Status(IntEnum):
    """Outcome of one target, as stored in ``IkResult.status``.

    A status array compares with these members directly:
    ``result.status == Status.CONVERGED``.
    """

    CONVERGED = 0
    """The joint values meet the tolerances and the limits, by a final FK check."""

    OUT_OF_REACH = 1
    """Proven unreachable: by a bound (reach radius, reach box; tried once, to come near), or
    because no branch of a closed form reaches the target within the limits."""

    NOT_FOUND = 2
    """No solution within the iteration and restart caps; one may still exist."""

    BAD_INPUT = 3
    """The target or its start value holds NaN or infinity."""

    STALLED = 4
    """The search came to rest before it reached the target, as in a local minimum; told by
    feedback solvers, population solvers without polish and `solvers.Plain` only."""

    NON_FINITE = 5
    """Numbers of a feedback solver grew beyond all bounds, as those of an unstable A do."""

    IN_COLLISION = 6
    """Reached within tolerances and limits, but by no posture found that keeps clear of the
    scene and of the arm itself; the least bad one is returned (only with a scene)."""
