"""What `Robot.ik` and `Robot.ik_all` return: status codes, results, singularities."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, IntFlag

from ._native import Branches, IkResult

__all__ = ["Branches", "Family", "IkResult", "Singularity", "Status", "Warnings"]


@dataclass(frozen=True)
class Family:
    """What an arm was recognised as, see `Robot.family`.

    Examples
    --------
    >>> arm = ik.Robot.load("puma560")
    >>> arm.family.name, arm.family.branches
    ('spherical wrist', 8)
    """

    name: str
    """Short name, such as "three parallel axes"; "unsupported" where no branches are found."""

    method: str
    """How `Robot.ik_all` finds its branches."""

    reason: str
    """What was seen in the axes, or why there is no closed form, or nothing at all."""

    branches: int
    """Most branches of a target, at one value of the locked joint or arm angle; 0 where none
    are found."""

    locked: str | None
    """Joint that `Robot.ik_all` locks where nothing is said, and sweeps; None without one."""

    def __str__(self) -> str:
        return f"{self.name} ({self.method}): {self.reason}"


class Singularity(IntFlag):
    """Where a branch of `Robot.ik_all` nearly meets another, as in ``Branches.singular``.

    Nearly means: the sine of the angle between the two is below 1e-6.

    Examples
    --------
    >>> arm = ik.Robot.load("puma560")
    >>> found = arm.ik_all(arm.fk([0.4, 0.9, -0.6, 0.5, 0.0, 0.2]))
    >>> any(ik.Singularity.WRIST in ik.Singularity(int(code)) for code in found.singular)
    True
    """

    SHOULDER = 1
    """The wrist's centre is on the first axis or at the edge of what the first joints
    allow; of an S-R-S arm, its first and third axis are in line."""

    ELBOW = 2
    """The arm is stretched or folded."""

    WRIST = 4
    """The first and the last axis of the wrist are in line."""

    GENERAL = 8
    """The arm's Jacobian is singular, of arms without names for their singularities."""


class Warnings(IntFlag):
    """What is to be said of a target beside its status; all but STRAIGHTENED by `Robot.ik_all`.

    Examples
    --------
    >>> arm = ik.Robot.load("puma560")
    >>> found = arm.ik_all(arm.fk([0.4, 0.9, -0.6, 0.5, 0.0, 0.2]))
    >>> ik.Warnings.MORE in ik.Warnings(int(found.warnings))
    False
    """

    FOLD = 1
    """An odd number of branches: two of them met, or all but met."""

    NEAR_SINGULAR = 2
    """A branch is near a singularity; ``Branches.singular`` tells which."""

    SECOND_CUT = 4
    """The general solver doubted its first look and took a second one."""

    SINGULAR_FAMILY = 8
    """A joint turns freely: ``Branches.free_joint``. Its value is that of `q0`, or the middle
    of its limits."""

    MORE = 16
    """There are more branches than are given."""

    STRAIGHTENED = 32
    """The target's rotation was rounded; the nearest rotation took its place."""

    UNPROVEN = 64
    """The search for the postures of an arm of few joints was cut short: that there is no other
    one, or none that comes nearer, is not proven."""


class Status(IntEnum):
    """Outcome of one target, as stored in ``IkResult.status``.

    A status array compares with these members directly:
    ``result.status == Status.CONVERGED``.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> result = arm.ik([[0.4, 0.2, 0.3], [9.0, 0.0, 0.0]])
    >>> [ik.Status(code).name for code in result.status]
    ['CONVERGED', 'OUT_OF_REACH']
    >>> (result.status == ik.Status.OUT_OF_REACH).tolist()
    [False, True]
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

    JOINT_LIMITS = 7
    """There are postures for it, but none within the limits (`Robot.ik_all` only)."""

    SINGULAR_FAMILY = 8
    """Reached within the limits, by postures in which a joint turns freely: which one is in
    ``Branches.free_joint`` (`Robot.ik_all` only)."""

    OVERDETERMINED = 9
    """The target asks for more than the arm has joints for, and no posture happens to reach it.
    The nearest one is given, with what is left in ``Branches.orientation_error`` and
    ``Branches.position_error`` (`Robot.ik_all` only)."""

    UNSUPPORTED = 10
    """No method here finds the branches of such an arm; `Robot.family` says why
    (`Robot.ik_all` only)."""

    HELD = 11
    """Not reached in this tick: the posture goes to the target, or as near to it as the reach
    allows, no faster than it may (`Robot.solver` with `max_change` or `rate_hz` only)."""
