"""What `Robot.ik` returns: the status codes and the result record."""

from __future__ import annotations

from enum import IntEnum

from ._native import IkResult

__all__ = ["IkResult", "Status"]


class Status(IntEnum):
    """Outcome of one target, as stored in ``IkResult.status``.

    A status array compares with these members directly:
    ``result.status == Status.CONVERGED``.
    """

    CONVERGED = 0
    """The joint values meet the tolerances and the limits, by a final FK check."""

    OUT_OF_REACH = 1
    """Proven unreachable by a bound (reach radius, reach box); tried once, to come near."""

    NOT_FOUND = 2
    """No solution within the iteration and restart caps; one may still exist."""

    BAD_INPUT = 3
    """The target or its start value holds NaN or infinity."""

    STALLED = 4
    """The search came to rest before it reached the target, as in a local minimum; told by
    feedback solvers, population solvers without polish and `solvers.Plain` only."""

    NON_FINITE = 5
    """Numbers of a feedback solver grew beyond all bounds, as those of an unstable A do."""
