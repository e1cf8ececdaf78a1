"""The tomato pointing arm: all branches, servo limits, iterative methods.

Pan, shoulder and elbow, driven by hobby servos (Kviesis and Osadcuks). Joint values are
phi1 (shoulder), phi2 (elbow) and phi3 (pan), rad, in the paper's order;
``docs/papers/tomato.md`` has the derivation and what the printed formulas get wrong.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _native
from .._checks import (
    FloatArray,
    finite_array,
    float_array,
    real_number,
    truth_value,
    whole_number,
    word,
)
from ..errors import ArgumentError, UnknownNameError
from ..result import Status
from ..robot import Robot
from ._record import Record

__all__ = [
    "BRANCHES",
    "HOME",
    "Outcome",
    "PacedResult",
    "TomatoArm",
    "TomatoBranches",
    "TomatoResult",
    "TransposeStepWarning",
]

BRANCHES = ("up", "down", "up_flip", "down_flip")
"""Names of the branches in their order: elbow up or down, pan as is or half a turn round."""

HOME = (math.pi / 3, -math.pi / 2, 0.0)
"""Pose that the arm starts from, rad: the paper names none."""

METHODS = ("inverse", "pinv", "transpose", "dls")
"""Names of the iterative methods."""

# Relative cutoff of singular values of the pseudo-inverse.
_CUTOFF = 1e-8
# Below these a Jacobian counts as singular, a gradient as zero.
_SINGULAR = 1e-9
_STALLED = 1e-9


class TransposeStepWarning(UserWarning):
    """A fixed transpose step is above its stability bound for some targets.

    Examples
    --------
    >>> import warnings
    >>> from agrik_fast.arms import TomatoArm, TransposeStepWarning
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     _ = TomatoArm().iterate([0.2, 0, 0.1], "transpose", alpha=70.0, max_iterations=5)
    >>> issubclass(caught[0].category, TransposeStepWarning)
    True
    """


class Outcome(IntEnum):
    """What became of a target.

    Examples
    --------
    >>> from agrik_fast.arms import Outcome, TomatoArm
    >>> found = TomatoArm().solve([[0.2, 0.05, 0.1], [2.0, 0.0, 0.0]])
    >>> [Outcome(int(code)).name for code in found.outcome]
    ['OK', 'TOO_FAR']
    """

    OK = 0
    """Reached."""

    TOO_FAR = 1
    """Farther from the shoulder than the stretched arm."""

    TOO_NEAR = 2
    """Nearer to the shoulder than the folded arm."""

    ON_AXIS = 3
    """Reached, on the pan axis: the pan keeps its value."""

    BAD_INPUT = 4
    """The target is not finite."""

    SERVO_LIMIT = 5
    """No branch within the servos' limits."""


@dataclass(frozen=True, slots=True)
class TomatoResult(Record):
    """Answers of `TomatoArm.solve`; arrays have the targets' leading shape.

    Attributes
    ----------
    outcome : ndarray, shape (...)
        Codes of `Outcome`.
    branch : ndarray, shape (...)
        Number of the branch taken, in the order of `BRANCHES`; -1 for none.

    Examples
    --------
    >>> from agrik_fast.arms import TomatoArm
    >>> found = TomatoArm().solve([[0.2, 0.05, 0.1], [2.0, 0.0, 0.0]])
    >>> found.success.tolist(), found.branch.shape
    ([True, False], (2,))
    """

    outcome: NDArray[np.uint8]
    branch: NDArray[np.int8]


class TomatoBranches(NamedTuple):
    """All branches of `TomatoArm.branches`.

    Attributes
    ----------
    q : ndarray, shape (..., 4, 3), rad
        Joint values in the order of `BRANCHES`; NaN where the target is out of reach.
    valid : ndarray, shape (..., 4)
        Within the servos' limits.
    outcome : ndarray, shape (...)
        Codes of `Outcome`.

    Examples
    --------
    >>> from agrik_fast.arms import TomatoArm
    >>> found = TomatoArm().branches([0.2, 0.05, 0.1])
    >>> int(found.valid.sum()) >= 1
    True
    """

    q: FloatArray
    valid: NDArray[np.bool_]
    outcome: NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class PacedResult(Record):
    """Answers of `TomatoArm.iterate`.

    Attributes
    ----------
    reason : ndarray of str, shape (...)
        ok, cap, singular, stalled, diverged, too_far or bad_input.

    Examples
    --------
    >>> from agrik_fast.arms import TomatoArm
    >>> str(TomatoArm().iterate([1.0, 0.0, 0.0], "inverse").reason)
    'too_far'
    """

    reason: NDArray[np.str_]


class TomatoArm:
    """Closed form and iterative methods of the tomato pointing arm.

    Parameters
    ----------
    l1, l2 : float, default 0.16, m
        Link lengths. The paper prints none; these are what the servos' torque allows.
    lower, upper : array_like, shape (3,), rad, optional
        Servo limits; default those of ``Robot.load("tomato")``.
    centre : float, optional, m
        C of (8): where the arm's middle is on a y axis that grows to the right, as an
        image's does. Points are then given and returned along that axis; without it y is
        the base frame's, which grows to the left from the arm's middle.

    Raises
    ------
    ArgumentError
        A length, a limit or `centre` is out of its range.

    Examples
    --------
    >>> from agrik_fast.arms import TomatoArm
    >>> res = TomatoArm().solve([0.2, 0.05, 0.1])
    >>> bool(res.success), int(res.branch)
    (True, 0)
    >>> image = TomatoArm(centre=0.16).solve([0.2, 0.11, 0.1])  # C - y is 0.05 m
    >>> bool((image.q == res.q).all())
    True
    """

    __slots__ = ("_arm", "_loop", "centre", "l1", "l2", "lower", "upper")

    l1: float
    l2: float
    lower: FloatArray
    upper: FloatArray
    centre: float | None

    def __init__(
        self,
        l1: float = 0.16,
        l2: float = 0.16,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
        *,
        centre: float | None = None,
    ) -> None:
        servos = Robot.load("tomato")
        self.lower = float_array("lower", servos.lower if lower is None else lower)
        self.upper = float_array("upper", servos.upper if upper is None else upper)
        self.l1 = real_number("l1", l1, 0, open_low=True, unit="m")
        self.l2 = real_number("l2", l2, 0, open_low=True, unit="m")
        self.centre = None if centre is None else real_number("centre", centre, unit="m")
        self._arm = _native.TomatoArm(self.l1, self.l2, self.lower, self.upper)
        self._loop = _free_chain(self.l1, self.l2)

    def fk(self, q: ArrayLike) -> FloatArray:
        """Return tool points, shape (..., 3), m, of joint values, shape (..., 3), (10)-(12).

        Examples
        --------
        >>> from agrik_fast.arms import TomatoArm
        >>> TomatoArm().fk([1.0, -1.5, 0.0]).shape
        (3,)
        """
        return self._turned_round(self._loop.fk(q)[..., :3, 3])

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Return Jacobians of the tool point, shape (..., 3, 3), m/rad.

        Examples
        --------
        >>> from agrik_fast.arms import TomatoArm
        >>> TomatoArm().jacobian([1.0, -1.5, 0.0]).shape
        (3, 3)
        """
        jacobian = np.asarray(self._loop.jacobian(q)[..., :3, :])
        if self.centre is not None:
            jacobian[..., 1, :] *= -1
        return jacobian

    def _turned_round(self, points: ArrayLike) -> FloatArray:
        """Return points with y along the base frame's axis for the image's, or back again."""
        found = float_array("targets", points)
        if self.centre is None or found.ndim == 0 or found.shape[-1] != 3:
            return found
        found = found.copy()
        found[..., 1] = self.centre - found[..., 1]
        return found

    def solve(
        self,
        targets: ArrayLike,
        *,
        current: ArrayLike = HOME,
        branch: int | str | None = None,
        follow: bool = False,
    ) -> TomatoResult:
        """Find joint values within the servo limits.

        Parameters
        ----------
        targets : array_like, shape (..., 3), m
            Points in the base frame, or along the image's y axis (`centre`).
        current : array_like, shape (3,), rad
            Present joint values: the pan on its axis, and what failed rows hold (nothing
            moves unless the target is reached).
        branch : int or str, optional
            Present branch; kept while it is within the limits (hysteresis). Otherwise the
            first of `BRANCHES` that is.
        follow : bool, default False
            The targets are a path: each starts where the one before ended.

        Returns
        -------
        TomatoResult
            The common record, outcomes and branches.

        Raises
        ------
        ArgumentError
            A wrong shape or type, or a `current` that is not finite.
        UnknownNameError
            No branch has that name.

        Examples
        --------
        >>> from agrik_fast.arms import TomatoArm
        >>> arm = TomatoArm()
        >>> found = arm.solve([0.2, 0.05, 0.1])
        >>> bool(found.success), np.allclose(arm.fk(found.q), [0.2, 0.05, 0.1])
        (True, True)
        """
        current = finite_array("current", current, (3,))
        follow = truth_value("follow", follow)
        points = self._turned_round(targets)
        return TomatoResult(*self._arm.solve(points, current, _branch_number(branch), follow))

    def branches(self, targets: ArrayLike, *, pan: float = 0.0) -> TomatoBranches:
        """Return all four branches of targets, shape (..., 3), m.

        Parameters
        ----------
        targets : array_like, shape (..., 3), m
            Points in the base frame.
        pan : float, default 0.0, rad
            Pan of targets on its axis.

        Returns
        -------
        TomatoBranches
            Joint values, which are valid, outcomes.

        Raises
        ------
        ArgumentError
            A wrong shape, or a `pan` that is not finite.

        Examples
        --------
        >>> from agrik_fast.arms import TomatoArm
        >>> TomatoArm().branches([0.2, 0.05, 0.1]).q.shape
        (4, 3)
        """
        pan = real_number("pan", pan, unit="rad")
        return TomatoBranches(*self._arm.branches(self._turned_round(targets), pan))

    def transpose_bound(self, q: ArrayLike) -> FloatArray:
        """Return the fixed transpose step, 1/m^2, above which the iteration diverges.

        2 over the largest eigenvalue of ``J J^T`` at joint values, shape (..., 3).

        Examples
        --------
        >>> from agrik_fast.arms import TomatoArm
        >>> bool(TomatoArm().transpose_bound([1.0, -1.5, 0.0]) > 0)
        True
        """
        return self._arm.transpose_bound(q)

    def iterate(
        self,
        targets: ArrayLike,
        method: Literal["inverse", "pinv", "transpose", "dls"],
        *,
        q0: ArrayLike = HOME,
        gain: float = 1.0,
        step_length: float | None = None,
        alpha: float | None = None,
        damping: float = 0.02,
        tolerance: float = 5e-4,
        max_iterations: int = 10_000,
    ) -> PacedResult:
        """Solve by an iterative method, with the step rule of the paper's figure 6.

        The loop is that of `Robot.ik`, without restarts and without joint limits: test the
        distance, then step towards a part of it.

        Parameters
        ----------
        targets : array_like, shape (..., 3), m
            Points in the base frame.
        method : {"inverse", "pinv", "transpose", "dls"}
            Inverse and pseudo-inverse take the same steps: the Jacobian is square, (17) is
            then its inverse.
        q0 : array_like, shape broadcastable to (..., 3), rad
            Start.
        gain : float, default 1.0
            Share of the error that a step is to remove, above 0, at most 1.
        step_length : float, optional, m
            Instead of `gain`: at most this length of the error a step.
        alpha : float, optional, 1/m^2
            Fixed step of the transpose; without it Buss's automatic one. A
            `TransposeStepWarning` tells of targets where it is above the bound.
        damping : float, default 0.02, m
            Of damped least squares.
        tolerance : float, default 5e-4, m
            Distance that counts as reached.
        max_iterations : int, default 10000
            Cap.

        Returns
        -------
        PacedResult
            The common record and why each row ended.

        Raises
        ------
        ArgumentError
            A wrong shape, or a number out of its range.
        UnknownNameError
            No such method.

        Examples
        --------
        >>> from agrik_fast.arms import TomatoArm
        >>> found = TomatoArm().iterate([0.2, 0.05, 0.1], "dls")
        >>> bool(found.success), str(found.reason)
        (True, 'ok')
        """
        word("method", method, METHODS)
        points = float_array("targets", targets)
        if points.ndim == 0 or points.shape[-1] != 3:
            raise ArgumentError("targets", f"shape {points.shape}", "shape (..., 3)")
        start = float_array("q0", q0)
        try:
            start = np.broadcast_to(start, points.shape)
        except ValueError:
            expected = f"shape (3,), or one that broadcasts to {points.shape}"
            raise ArgumentError("q0", f"shape {start.shape}", expected) from None
        gain = real_number("gain", gain, 0, 1, open_low=True)
        if step_length is not None:
            step_length = real_number("step_length", step_length, 0, open_low=True, unit="m")
        if alpha is not None:
            alpha = real_number("alpha", alpha, 0, open_low=True, unit="1/m^2")
        damping = real_number("damping", damping, 0, open_low=True, unit="m")
        tolerance = real_number("tolerance", tolerance, 0, open_low=True, unit="m")
        cap = whole_number("max_iterations", max_iterations, 1, 2**32 - 1)
        # What each method takes: an automatic step without alpha, a cutoff, a damping.
        parameter = {"transpose": alpha or 0.0, "dls": damping}.get(method, _CUTOFF)
        step = "pinv" if method == "inverse" else method
        base = self._turned_round(points)
        record = _native.ik_paced(
            self._loop, base, step, parameter, gain, step_length, start, tolerance, cap
        )
        if method == "transpose" and alpha is not None:
            self._warn_of_step(points, alpha)
        return PacedResult(record, self._reasons(record, points, method, cap))

    def _warn_of_step(self, points: FloatArray, alpha: float) -> None:
        at = self.branches(points)
        inside = np.isfinite(at.q[..., 0, 0])
        bounds = self.transpose_bound(np.where(inside[..., None], at.q[..., 0, :], 0.0))
        above = inside & (alpha > bounds)
        if above.any():
            least = float(bounds[inside].min())
            warnings.warn(
                f"alpha = {alpha:g} is above the stability bound 2 / lambda_max of "
                f"{int(above.sum())} of {above.size} targets (least bound {least:.3g} per m^2)",
                TransposeStepWarning,
                stacklevel=3,
            )

    def _reasons(
        self, record: _native.IkResult, points: FloatArray, method: str, cap: int
    ) -> NDArray[np.str_]:
        """Say why rows that are not reached ended."""
        error = points - self.fk(record.q)
        jacobian = self.jacobian(record.q)
        gradient = np.linalg.norm(np.einsum("...ij,...i->...j", jacobian, error), axis=-1)
        smallest = np.linalg.svd(jacobian, compute_uv=False)[..., -1]
        far = ~np.isfinite(record.position_error)
        reasons = np.full(record.status.shape, "cap", dtype="<U9")
        ended = record.iterations < cap
        singular = (smallest < _SINGULAR) & (method in ("inverse", "pinv"))
        reasons[ended & (gradient < _STALLED)] = "stalled"
        reasons[ended & singular] = "singular"
        reasons[far] = "diverged"
        reasons[record.status == Status.OUT_OF_REACH] = "too_far"
        reasons[record.success] = "ok"
        reasons[record.status == Status.BAD_INPUT] = "bad_input"
        return reasons


def _branch_number(branch: int | str | None) -> int | None:
    if branch is None:
        return None
    if isinstance(branch, str):
        if branch not in BRANCHES:
            raise UnknownNameError("branch", branch, BRANCHES)
        return BRANCHES.index(branch)
    return whole_number("branch", branch, 0, 3)


def _free_chain(l1: float, l2: float) -> _native.Chain:
    """Return the arm without limits, joint values in the paper's order."""
    names = ("phi3", "phi1", "phi2")
    axes = ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.0, -1.0, 0.0))
    origins = [np.eye(4) for _ in names]
    origins[2][0, 3] = l1
    tool = np.eye(4)
    tool[0, 3] = l2
    joints: list[_native.JointSpec] = [
        {
            "name": name,
            "type": "continuous",
            "origin": origin,
            "axis": axis,
            "lower": -math.inf,
            "upper": math.inf,
            "mimic": None,
        }
        for name, axis, origin in zip(names, axes, origins, strict=True)
    ]
    order = ["phi1", "phi2", "phi3"]
    return _native.Chain.from_joints("tomato", joints, tool=tool, variable_order=order)
