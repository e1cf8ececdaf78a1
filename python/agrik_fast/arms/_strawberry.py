"""The strawberry handling arm: AS, SSAS, NCOS and the exact least energy.

Three slides carry an arm with a pitch and a roll joint, so that a target leaves two joint
values open. The paper (Defterli and Xu 2017) chooses them by rule (AS), by a search over
one of them (SSAS) or by nonlinear optimisation (NCOS). "exact" is the global minimum of
the same energy index, in closed form where no slide is at a limit and certified where one
is; ``docs/papers/strawberry.md`` has the derivation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _native
from .._checks import FloatArray, finite_array, float_array, real_number, truth_value, word
from ..errors import ArgumentError
from ._base_move import least_moves
from ._commands import Commands, back, there
from ._ncos import solve_all
from ._record import Record

__all__ = ["Place", "StrawberryArm", "StrawberryResult"]

Method = Literal["exact", "as", "ssas", "ncos"]
METHODS = ("exact", "as", "ssas", "ncos")
THETA_RULES = ("least_magnitude", "middle")
SLOPE_CASES = ("fixed", "s21", "s32")
Interval = tuple[float, float]

STEEPEST = 1e12
"""A derivative above this (J/m, rad/m) is that of a pose that has none, but for rounding."""


class Place(IntEnum):
    """What lies in the way of a target.

    Examples
    --------
    >>> from agrik_fast.arms import Place, StrawberryArm
    >>> found = StrawberryArm().solve([[0.426, 0.345, -0.3316], [0.426, 2.0, -0.33]])
    >>> [Place(int(code)).name for code in found.place]
    ['REACHED', 'S10']
    """

    REACHED = 0
    """Nothing."""

    S10 = 1
    """Slide s10: its set, (12), is empty."""

    S21 = 2
    """Slide s21: its part of the set of theta, (14), is empty."""

    S32 = 3
    """Slide s32: its part of the set of theta, (15), is empty."""

    THETA = 4
    """Slides s21 and s32 each leave some theta, but none in common, (16)."""

    BAD_INPUT = 5
    """The target is not finite."""


@dataclass(frozen=True, slots=True)
class StrawberryResult(Record):
    """Answers of `StrawberryArm.solve`; arrays have the targets' leading shape.

    Attributes
    ----------
    energy : ndarray, shape (...), J
        Energy index; NaN where the target is not reached.
    place : ndarray, shape (...)
        Codes of `Place`: what lies in the way.
    gap : ndarray, shape (...)
        Travel that the slide lacks, m, positive past its upper limit and negative past
        its lower one; for ``Place.THETA`` the distance in x and z that slides s21 and s32
        lack together. 0 where the target is reached.

    Examples
    --------
    >>> from agrik_fast.arms import StrawberryArm
    >>> found = StrawberryArm().solve([[0.426, 0.345, -0.3316], [0.426, 2.0, -0.33]])
    >>> found.success.tolist(), found.energy.shape
    ([True, False], (2,))
    """

    energy: NDArray[np.float64]
    place: NDArray[np.uint8]
    gap: NDArray[np.float64]


class StrawberryArm:
    """Closed forms of the strawberry handling arm.

    The geometry is that of ``Robot.load("strawberry")``; joint values are s10, s21, s32
    (m), theta, beta (rad).

    Parameters
    ----------
    l1, l2, l3 : float, optional
        Lengths, m.
    d : array_like, shape (3,), optional
        Offsets of the base frame, m.
    lower, upper : array_like, shape (5,), optional
        Limits, m and rad; theta and beta within a quarter turn.
    friction : float, optional
        Friction force of a moving slide, N.
    mass2, mass3 : float, optional
        Masses of the arm's links, kg.
    gravity : float, optional
        m/s^2.

    Raises
    ------
    ArgumentError
        A parameter is out of its range.

    Examples
    --------
    >>> from agrik_fast.arms import StrawberryArm
    >>> arm = StrawberryArm()
    >>> res = arm.solve([0.426, 0.345, -0.3316])
    >>> bool(res.success), round(float(res.energy), 3)
    (True, 5.95)
    """

    __slots__ = ("_arm",)

    def __init__(
        self,
        *,
        l1: float | None = None,
        l2: float | None = None,
        l3: float | None = None,
        d: ArrayLike | None = None,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
        friction: float | None = None,
        mass2: float | None = None,
        mass3: float | None = None,
        gravity: float | None = None,
    ) -> None:
        scalars = {
            "l1": l1,
            "l2": l2,
            "l3": l3,
            "friction": friction,
            "mass2": mass2,
            "mass3": mass3,
            "gravity": gravity,
        }
        given = {name: real_number(name, x) for name, x in scalars.items() if x is not None}
        self._arm = _native.StrawberryArm(d=d, lower=lower, upper=upper, **given)

    @property
    def parameters(self) -> Mapping[str, float | list[float]]:
        """Parameters by name, in the units of the constructor."""
        return self._arm.parameters

    @property
    def lower(self) -> FloatArray:
        """Smallest joint values, shape (5,), m and rad."""
        return np.asarray(self._arm.parameters["lower"])

    @property
    def upper(self) -> FloatArray:
        """Largest joint values, shape (5,), m and rad."""
        return np.asarray(self._arm.parameters["upper"])

    @property
    def free_pose(self) -> tuple[float, float] | None:
        """Theta and beta (rad) of least energy where no slide is at a limit; None if the
        joints' limits exclude it.
        """  # noqa: D205
        return self._arm.free_pose

    @property
    def reset_pose(self) -> FloatArray:
        """Pose before and after every task, shape (5,), m and rad."""
        return self._arm.reset_pose

    @property
    def target_box(self) -> FloatArray:
        """Bounds of the reachable targets, shape (2, 3), m; (5)-(10) corrected."""
        return self._arm.target_box

    def solve(
        self,
        targets: ArrayLike,
        method: Method = "exact",
        *,
        s10_share: float = 0.5,
        theta_rule: Literal["least_magnitude", "middle"] = "least_magnitude",
        theta_step: float = 0.01,
        q0: ArrayLike | None = None,
    ) -> StrawberryResult:
        """Find joint values for a batch of targets.

        Parameters
        ----------
        targets : array_like, shape (..., 3), m
            Points in the base frame.
        method : {"exact", "as", "ssas", "ncos"}
            "exact": least energy index of all. "as": the analytical solution. "ssas":
            least energy over s10 with theta by rule. "ncos": SciPy's SLSQP from home, as
            a baseline (needs the extra ``papers``).
        s10_share : float, default 0.5
            AS: where in its set s10 is chosen, 0 to 1 (remark 1: the middle).
        theta_rule : {"least_magnitude", "middle"}
            AS and SSAS: theta of least magnitude (remark 2), or the middle of the widest
            interval of its set.
        theta_step : float, default 0.01, rad
            AS and SSAS: theta where the set holds 0. Table 3 was computed with 0.01; 0
            is the remark's text.
        q0 : array_like, shape broadcastable to (..., 5), m and rad, optional
            NCOS: where its search starts, clamped into the limits; home without it. No
            other method has a start.

        Returns
        -------
        StrawberryResult
            The common record, energies, and what lies in the way of failed targets.
            "exact" proves that what it does not reach cannot be reached
            (``Status.OUT_OF_REACH``); "as" and "ssas" try few beta and may miss
            (``Status.NOT_FOUND``). Failed rows hold the reset pose. Iterations are
            SLSQP's; the closed forms have none.

        Raises
        ------
        ArgumentError
            A wrong shape or option, or constants for which the exact minimum cannot be
            proven.

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> arm = StrawberryArm()
        >>> found = arm.solve([0.426, 0.345, -0.3316])
        >>> bool(found.success), np.allclose(arm.fk(found.q), [0.426, 0.345, -0.3316])
        (True, True)
        """
        word("method", method, METHODS)
        s10_share = real_number("s10_share", s10_share, 0, 1)
        theta_step = real_number("theta_step", theta_step, unit="rad")
        word("theta rule", theta_rule, THETA_RULES)
        if method == "ncos":
            return self._ncos(targets, q0)
        if q0 is not None:
            raise ArgumentError("q0", f"a start for method {method!r}", 'None but for "ncos"')
        record, energy, place, gap = self._arm.solve(
            targets, method, s10_share, theta_rule, theta_step
        )
        return StrawberryResult(record, energy, place, gap)

    def _ncos(self, targets: ArrayLike, q0: ArrayLike | None) -> StrawberryResult:
        points = _points(targets)
        start = self.reset_pose if q0 is None else float_array("q0", q0)
        if not np.isfinite(start).all():
            raise ArgumentError("q0", str(start.tolist()), "finite numbers")
        wanted = (*points.shape[:-1], 5)
        try:
            starts = np.broadcast_to(start, wanted)
        except ValueError:
            expected = f"shape (5,), or one that broadcasts to {wanted}"
            raise ArgumentError("q0", f"shape {start.shape}", expected) from None
        found = solve_all(self, points, np.clip(starts, self.lower, self.upper))
        record = _native.ik_record(found.q, found.status, found.error, found.iterations)
        solved = record.success
        energy = np.where(solved, self.energy(found.q), np.nan)
        # Why SLSQP fails it does not say; the exact method does, or for constants for which
        # it has no proof the analytical one.
        try:
            why = self.solve(points, "exact")
        except ArgumentError:
            why = self.solve(points, "as")
        place = np.where(solved, 0, why.place).astype(np.uint8)
        return StrawberryResult(record, energy, place, np.where(solved, 0.0, why.gap))

    def fk(self, q: ArrayLike) -> FloatArray:
        """Return tool points, shape (..., 3), m, of joint values, shape (..., 5).

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> StrawberryArm().fk([0.2, 0.3, 0.15, 0.0, 0.0]).shape
        (3,)
        """
        return self._arm.fk(q)

    def energy(self, q: ArrayLike) -> FloatArray:
        """Return energy indices, shape (...), J, of joint values, shape (..., 5).

        Friction of the slides on their way from home, (22), less the potential energy
        that the arm loses: (21) with its bracket and its sign corrected.

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> StrawberryArm().energy([[0.2, 0.3, 0.15, 0.0, 0.0], [0.3, 0.3, 0.15, 0.0, 0.0]]).shape
        (2,)
        """
        return self._arm.energy(q)

    def s10_set(self, target: ArrayLike) -> Interval | None:
        """Return the interval of s10 (m) for a target, (12), or None if it is empty.

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> low, high = StrawberryArm().s10_set([0.426, 0.345, -0.3316])
        >>> low < high, StrawberryArm().s10_set([0.5, 5.0, -0.3]) is None
        (True, True)
        """
        return self._arm.s10_set(finite_array("target", target, (3,)))[0]

    def theta_sets(self, target: ArrayLike, beta: float) -> Mapping[str, list[Interval]]:
        """Return the sets of theta for a target at a beta, as lists of intervals.

        Parameters
        ----------
        target : array_like, shape (3,), m
            Point in the base frame.
        beta : float, rad
            Roll.

        Returns
        -------
        dict
            ``s21``: what slide s21 leaves, (14); ``s32``: what slide s32 leaves, (15) with
            its negative branch; ``all``: what both and the joint's limits leave, (16).

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> "all" in StrawberryArm().theta_sets([0.426, 0.345, -0.3316], 0.4)
        True
        """
        target = finite_array("target", target, (3,))
        return self._arm.theta_sets(target, real_number("beta", beta, unit="rad"))

    def slopes(
        self, theta: float, beta: float, case: Literal["fixed", "s21", "s32"] = "fixed"
    ) -> Mapping[str, float]:
        """Return derivatives along s10 for problem P1, (24)-(28) corrected.

        Parameters
        ----------
        theta, beta : float, rad
            Pose.
        case : {"fixed", "s21", "s32"}
            Theta stays, or keeps slide s21 (case 1) or s32 (case 2) where it is.

        Returns
        -------
        dict
            ``beta_by_s10`` (rad/m), ``theta_by_beta``, ``friction_by_s10`` and
            ``potential_by_s10`` (J/m).

        Raises
        ------
        ArgumentError
            A wrong argument, or a pose without derivative: theta cannot keep slide s32
            where it is at theta 0, nor s21 at a quarter turn.

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> sorted(StrawberryArm().slopes(-0.5, 0.4))
        ['beta_by_s10', 'friction_by_s10', 'potential_by_s10', 'theta_by_beta']
        """
        theta = real_number("theta", theta, unit="rad")
        beta = real_number("beta", beta, unit="rad")
        word("case", case, SLOPE_CASES)
        found = self._arm.slopes(theta, beta, case)
        if not all(abs(slope) < STEEPEST for slope in found.values()):
            pose = f"theta {theta!r}, beta {beta!r}, case {case!r}"
            raise ArgumentError("theta, beta", pose, "a pose that has derivatives along s10")
        return found

    def commands(
        self, q: ArrayLike, *, psi: float = 0.0, h_extra: float = 0.05, reset: bool = False
    ) -> Commands:
        """Return the steps of remark 3 that drive the arm to a pose, or of step 7 home again.

        Parameters
        ----------
        q : array_like, shape (5,), m and rad
            Pose, within the limits.
        psi : float, default 0.0, rad
            Turn of the gripper, within a quarter turn.
        h_extra : float, default 0.05, m
            How far above its end the arm waits while the rest moves. The paper gives no
            value, and prints the wrong sign: s32 grows downward.
        reset : bool, default False
            The way home from the pose (algorithm 1, step 7): lifted first, then the other
            axes in the reverse of their order, slide s32 last. The gripper stays closed.

        Returns
        -------
        Commands
            Nine steps, or seven home: a list of `Command` with the clearance that is really
            kept. It is less than `h_extra` where that would take slide s32 past its home;
            ``Commands.note`` says so.

        Raises
        ------
        ArgumentError
            A pose or psi outside the limits, or a negative `h_extra`; for both ways.

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> arm = StrawberryArm()
        >>> steps = arm.commands(arm.solve([0.426, 0.345, -0.3316]).q)
        >>> [step.axis for step in steps]
        ['gripper', 's32', 's10', 's21', 'theta', 'beta', 'psi', 's32', 'gripper']
        """
        psi = real_number("psi", psi, unit="rad")
        h_extra = real_number("h_extra", h_extra, 0, unit="m")
        reset = truth_value("reset", reset)
        out = there(self._arm.commands(q, psi, h_extra), h_extra)
        return back(out, self.reset_pose.tolist()) if reset else out

    def suggest_base_shift(
        self, targets: ArrayLike, axes: str = "xyz", *, yaw_weight: float | None = None
    ) -> FloatArray:
        """Return the smallest moves of the platform that bring targets in reach.

        Translations are proven to be the smallest but for 1e-8 m: pitch in closed form, roll
        by pieces that are halved until no piece's lower bound is shorter. With yaw the least
        weighted move is proven but for 1e-3 m, by pieces of yaw in the same way.

        Parameters
        ----------
        targets : array_like, shape (..., 3), m
            Points in the base frame.
        axes : str, default "xyz"
            Axes along which the platform may move.
        yaw_weight : float, optional, m
            Lets the platform turn about the base frame's z axis too, before it moves along
            its own axes; a radian costs as much as so many metres, and the root of the sum
            of both squares is least. Needs x and y among `axes`.

        Returns
        -------
        ndarray, shape (..., 3), m, or (..., 4), m and rad
            Zero for targets in reach, NaN where no such move helps (there is none for a
            target that is not finite). After the platform has moved by ``shift`` the target
            is at ``target - shift``; with yaw, the last column, at ``Rz(-yaw) target -
            shift``.

        Raises
        ------
        ArgumentError
            Axes or a weight that are none, or a wrong shape.

        Examples
        --------
        >>> from agrik_fast.arms import StrawberryArm
        >>> arm = StrawberryArm()
        >>> shift = arm.suggest_base_shift([0.426, 1.5, -0.33])
        >>> bool(arm.solve(np.array([0.426, 1.5, -0.33]) - 1.0001 * shift).success)
        True
        """
        given: object = axes
        if not isinstance(given, str) or not given or not set(given) <= set("xyz"):
            raise ArgumentError("axes", repr(axes), "one or more of the letters x, y, z")
        may_move = [axis in axes for axis in "xyz"]
        if yaw_weight is None:
            return self._arm.suggest_base_shift(targets, may_move)
        weight = real_number("yaw_weight", yaw_weight, 0, open_low=True, unit="m")
        if not {"x", "y"} <= set(axes):
            raise ArgumentError("axes", repr(axes), "x and y among them, to go with yaw")
        points = _points(targets)
        return least_moves(
            lambda p, within: self._arm.suggest_base_shift(p, may_move, within), points, weight
        )


def _points(targets: ArrayLike) -> FloatArray:
    points = float_array("targets", targets)
    if points.ndim == 0 or points.shape[-1] != 3:
        raise ArgumentError("targets", f"shape {points.shape}", "shape (..., 3)")
    return points
