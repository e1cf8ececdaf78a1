"""All branches of a robot: every posture that reaches a target."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, frame_of, word
from ._targets import INVALID, Invalid, Order, as_targets

if TYPE_CHECKING:
    from .._native import Chain
    from ..result import Branches, Family
    from ..tasks import Task

__all__ = ["EveryBranch"]


class EveryBranch:
    """The part of `Robot` that finds all joint values for poses and positions."""

    __slots__ = ()

    _chain: Chain

    @property
    def closed_form(self) -> str | None:
        """Family of the arm's closed form, "spherical wrist" or "S-R-S"; None without."""
        return self._chain.closed_form[0]

    @property
    def family(self) -> Family:
        """What the arm was recognised as, why, and how `ik_all` finds its branches."""
        from ..result import Family

        return Family(*self._chain.family)

    def ik_all(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        arm_angle: ArrayLike | None = None,
        *,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        tolerance_frame: Literal["base", "tool"] | None = None,
        locked: Mapping[str, ArrayLike] | None = None,
        sweep: int | None = None,
        wrap: bool = False,
        task: Task | str | None = None,
        invalid: Invalid = "mark",
        order: Order | None = None,
    ) -> Branches:
        """Every branch of the inverse kinematics: all real solutions of each target.

        Arms of six joints that turn have up to 16 branches, up to eight where three axes
        meet or are parallel; `family` says what was recognised. Seven joints have those
        of the arm that is left when one is locked (S-R-S arms up to eight for each arm
        angle), and an arm on a slide at each place of it. Five joints reach a point and a
        direction of the tool axis (``task="axis"``), three or more a point. Of what asks for more
        than the arm has joints for, those targets have branches that are reached all the same,
        and of the others the nearest posture is given. Each branch is checked by forward
        kinematics.

        Parameters
        ----------
        targets : array_like, shape (..., 4, 4), (..., 3) or (..., 7)
            Poses of the tool in the base frame, or positions of the tool point where the
            task is one; m. Of any kind that `ik` takes.
        q0 : array_like, shape broadcastable to (..., n), rad, optional
            Of the values a whole turn apart that a joint's limits allow, the one nearest to
            this is returned, and angles that a singularity leaves open are taken from it.
            Default: the middle of the limits.
        tool : array_like, shape (4, 4) or (3,), optional
            An offset behind the robot's own tool for this call, as for `ik`, m.
        threads : int, optional
            Number of threads, as for `ik`.
        arm_angle : array_like, shape broadcastable to (...), rad, optional
            Arm angle of an S-R-S arm, see `arm_angle`; for full poses. Default: that of `q0`,
            or 0.
        position_tolerance, orientation_tolerance, tolerance_frame : optional
            As for `ik`. Branches of reachable targets come to rounding, so that these
            decide at the edge of the reach alone: a branch counts that is within the
            smallest of three numbers, and a proof holds for the whole of them.
        locked : mapping of str to array_like, shape broadcastable to (...), optional
            Joints that are kept where they are, by name, and their values within the limits,
            rad or m: one for all targets, or one a target. What is left must be an arm whose
            branches are known. A NaN makes its target ``BAD_INPUT``. Default: of seven joints
            that are no S-R-S arm the one of `family` stays where `q0`, or the middle of the
            limits, has it.
        sweep : int, optional
            So many values of that joint over its limits (of the arm angle of an S-R-S arm, of
            the slide of an arm on one), 1 to 100,000: the branches of all of them, value by
            value, as ``Branches.value`` and ``Branches.branch`` say. That none of them is within
            the limits is no proof: the status is ``NOT_FOUND`` then.
        wrap : bool, default False
            Also the values of valid branches that are whole turns away, as far as the limits
            allow: each is a branch of its own, the nearest to `q0` first (at most 4,096). Joints
            without limits keep the nearest value.
        task : task or {"pose", "position", "axis"}, optional
            What counts as reached, see `agrik_fast.tasks`: "axis" for arms of up to five joints,
            "position" for any: of more than three joints those that move the point least stay
            where `q0`, or the middle of the limits, has them, and the status is
            ``SINGULAR_FAMILY``. Default: by the shape of the targets, as for `ik`.
        invalid : {"mark", "raise", "straighten"}, default "mark"
            As for `ik`.
        order : str, optional
            Of targets of shape (..., 7), as for `ik`.

        Returns
        -------
        Branches
            Joint values (..., branches, n), which of them are valid, and a status per target:
            ``CONVERGED`` with at least one valid branch (``SINGULAR_FAMILY`` where a joint turns
            freely in one); ``JOINT_LIMITS`` if there are branches, but none within the limits;
            ``OUT_OF_REACH`` if it is proven that there is none; ``NOT_FOUND`` if there is
            neither; ``OVERDETERMINED`` where more is asked than there are joints for, with the
            nearest posture and what it leaves; ``UNSUPPORTED`` for arms that nothing here solves,
            such as those with slides between their joints. For spherical wrists and S-R-S arms
            ``OUT_OF_REACH`` takes the limits into account. Where a joint stays that neither
            `locked` nor `sweep` names, its place proves nothing of others: the status is
            ``NOT_FOUND`` then, unless the bounds of the whole arm's reach exclude the target.
            Warnings stand beside the status.

        Raises
        ------
        ArgumentError
            An argument is wrong, as a locked value outside the limits, a sweep of 0 values or
            of an arm without a joint to spare, a target that is no rigid transform.
        UnknownNameError
            `locked` names a joint that the arm has not; the message names the nearest.
        KeyboardInterrupt
            Ctrl-C; a long batch stops within a second.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> arm = ik.Robot.load("puma560")
        >>> branches = arm.ik_all(arm.fk([0.1, 0.6, -0.4, 0.3, 0.5, 0.2]))
        >>> branches.q.shape, int(branches.valid.sum())
        ((8, 6), 4)

        An arm on a slide, at one place of the slide:

        >>> arm = ik.Robot.load("cucumber")
        >>> pose = arm.fk([0.5, 0.1, -0.9, 0.3, 0.2, 0.4, 3.0])
        >>> branches = arm.ik_all(pose, locked={"d1": 0.5})
        >>> branches.q.shape, int(branches.reached.sum())
        ((8, 7), 4)

        An arm with an offset wrist, and one of seven joints at 64 values of the last:

        >>> arm = ik.Robot.load("hydrolek")
        >>> branches = arm.ik_all(arm.fk([0.4, 0.3, -0.5, 0.2, 0.6, -0.1]))
        >>> branches.q.shape, int(branches.reached.sum())
        ((16, 6), 2)
        >>> arm = ik.Robot.load("panda")
        >>> branches = arm.ik_all(arm.fk([0.1, 0.3, 0.2, -1.5, 0.1, 1.8, 0.5]), sweep=64)
        >>> branches.q.shape
        (512, 7)

        A full pose for an arm of three joints, which can take few of them:

        >>> arm = ik.Robot.from_dh([[0.0, 0.3, 0.0, 1.57], [0.4, 0, 0, 0], [0.3, 0, 0, 0]])
        >>> pose = arm.fk([0.2, 0.5, -0.4])
        >>> int(arm.ik_all(pose).valid.sum())
        1
        >>> pose[2, 3] += 0.01
        >>> branches = arm.ik_all(pose)
        >>> ik.Status(int(branches.status)).name, round(float(branches.position_error), 5)
        ('OVERDETERMINED', 0.00146)
        """
        if order is not None or type(targets) is not np.ndarray:
            targets = as_targets(targets, order, word("invalid", invalid, INVALID))
        return self._chain.ik_all(
            targets,
            q0,
            tool if tool is None else frame_of("tool", tool),
            threads,
            arm_angle,
            position_tolerance,
            orientation_tolerance,
            tolerance_frame,
            locked,
            sweep,
            wrap,
            task,
            invalid,
        )

    def arm_angle(self, q: ArrayLike) -> FloatArray:
        """Arm angle of an S-R-S arm.

        The elbow's turn about the line from shoulder to wrist, by the right hand about the
        direction to the wrist. It is zero where the elbow leans towards the direction of
        the first axis (where the wrist is right above or below the shoulder: towards x of
        the base frame, or y if the first axis is along x).

        Parameters
        ----------
        q : array_like, shape (..., 7), rad
            Joint values.

        Returns
        -------
        ndarray, shape (...), rad
            Angles in [-pi, pi].

        Raises
        ------
        ArgumentError
            The arm is no S-R-S arm, or `q` has another last dimension.

        Examples
        --------
        >>> arm = ik.Robot.load("redundant7")
        >>> float(arm.arm_angle([0.4, 0.7, 0.2, 1.5, 0.3, 0.6, 0.1]).round(4))
        0.1294
        """
        return self._chain.arm_angle(q)

    def arm_angle_intervals(
        self, target: ArrayLike, tool: ArrayLike | None = None
    ) -> tuple[FloatArray, ...]:
        """Arm angles at which the limits allow a pose of an S-R-S arm, for each branch.

        Parameters
        ----------
        target : array_like, shape (4, 4)
            Pose of the tool in the base frame; m.
        tool : array_like, shape (4, 4) or (3,), optional
            An offset behind the robot's own tool for this call, as for `ik`, m.

        Returns
        -------
        tuple of 8 ndarray, shape (k, 2), rad
            First and last arm angle of each interval, in the order of the branches of
            `ik_all`; the first in [-pi, pi), the last above pi where the interval goes
            through half a turn. No rows for a branch without any.

        Raises
        ------
        ArgumentError
            The arm is no S-R-S arm, or the target is no rigid transform.

        Examples
        --------
        >>> arm = ik.Robot.load("redundant7")
        >>> intervals = arm.arm_angle_intervals(arm.fk([0.4, 0.7, 0.2, 1.5, 0.3, 0.6, 0.1]))
        >>> len(intervals), intervals[0].shape[1]
        (8, 2)
        """
        offset = tool if tool is None else frame_of("tool", tool)
        found = self._chain.arm_angle_intervals(target, offset)
        return tuple(np.array(one, dtype=np.float64).reshape(-1, 2) for one in found)
