"""Step solvers whose steps come from the Jacobian, and other solvers' steps as published."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from ..errors import ArgumentError
from ._core import check_fields
from ._feedback import Feedback
from ._loop import JacobianLoop


@dataclass(frozen=True, slots=True, kw_only=True)
class LevenbergMarquardt(JacobianLoop):
    """Least squares damped by a share of the squared error; the default, named "lm".

    ``dq = J^T (J J^T + (damping |e|^2 / 2 + 1e-12 s^2) I)^-1 e``, with s the robot's size:
    steep and safe far from the target, quadratic near it, because the damping vanishes with
    the error.

    Parameters
    ----------
    damping : float, default 0.1
        Share of half the squared error that is added to the diagonal; no unit, > 0.
    max_iterations : int, default 10
    max_restarts : int, default 1500
    max_step : float, default 1.0
        The loop's, see `JacobianLoop`.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    References
    ----------
    Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt
    method", IEEE Transactions on Robotics 27(5), 2011.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> patient = ik.solvers.LevenbergMarquardt(max_iterations=20)
    >>> bool(arm.ik([0.4, 0.2, 0.3], solver=patient).success)
    True
    """

    name: ClassVar[str] = "lm"
    damping: float = 0.1
    max_iterations: int = 10
    max_restarts: int = 1500


@dataclass(frozen=True, slots=True, kw_only=True)
class DampedLeastSquares(JacobianLoop):
    """Least squares with constant damping, named "dls".

    ``dq = J^T (J J^T + damping^2 I)^-1 e``: never a wild step, at the price of slow
    (linear) convergence.

    Parameters
    ----------
    damping : float, default 0.01
        Damping, m; > 0.
    max_iterations : int, default 60
    max_restarts : int, default 100
    max_step : float, default 1.0
        The loop's, see `JacobianLoop`.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    References
    ----------
    Nakamura and Hanafusa, "Inverse kinematic solutions with singularity robustness for
    robot manipulator control", ASME Journal of Dynamic Systems, Measurement, and Control
    108(3), 1986.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> solver = ik.solvers.DampedLeastSquares(damping=0.02)
    >>> bool(arm.ik([0.4, 0.2, 0.3], solver=solver).success)
    True
    """

    name: ClassVar[str] = "dls"
    damping: float = 0.01
    max_iterations: int = 60
    max_restarts: int = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class PseudoInverse(JacobianLoop):
    """Full steps by the Moore-Penrose pseudo-inverse, named "pinv".

    ``dq = J^+ e``. Directions with a singular value below `cutoff` times the largest are
    left out, so that a singular posture gives a short step and not a wild one.

    Parameters
    ----------
    cutoff : float, default 0.001
        Relative cutoff of singular values; no unit, > 0 and < 1.
    max_iterations : int, default 60
    max_restarts : int, default 100
    max_step : float, default 1.0
        The loop's, see `JacobianLoop`.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> bool(arm.ik([0.4, 0.2, 0.3], solver=ik.solvers.PseudoInverse(cutoff=1e-4)).success)
    True
    """

    name: ClassVar[str] = "pinv"
    cutoff: float = 0.001
    max_iterations: int = 60
    max_restarts: int = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Transpose(JacobianLoop):
    """Steps along the Jacobian transpose with Buss's step length, named "transpose".

    ``dq = alpha J^T e`` with ``alpha = <e, J J^T e> / |J J^T e|^2``: cheap steps without an
    equation system, but many of them.

    Parameters
    ----------
    max_iterations : int, default 2000
    max_restarts : int, default 20
    max_step : float, default 1.0
        The loop's, see `JacobianLoop`.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    References
    ----------
    Buss, "Introduction to inverse kinematics with Jacobian transpose, pseudoinverse and
    damped least squares methods", 2004.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> bool(arm.ik([0.4, 0.2, 0.3], solver=ik.solvers.Transpose()).success)
    True
    """

    name: ClassVar[str] = "transpose"
    max_iterations: int = 2000
    max_restarts: int = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedPseudoInverse(JacobianLoop):
    """Full steps by the pseudo-inverse in closed form, named "pinv-closed".

    ``dq = J^T (J J^T)^-1 e``: cheap, but with no answer where ``J J^T`` is singular; there
    an attempt ends.

    Parameters
    ----------
    max_iterations : int, default 60
    max_restarts : int, default 100
    max_step : float, default 1.0
        The loop's, see `JacobianLoop`.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> bool(arm.ik([0.4, 0.2, 0.3], solver=ik.solvers.ClosedPseudoInverse()).success)
    True
    """

    name: ClassVar[str] = "pinv-closed"
    max_iterations: int = 60
    max_restarts: int = 100


JacobianSolver: TypeAlias = (
    LevenbergMarquardt | DampedLeastSquares | PseudoInverse | ClosedPseudoInverse | Transpose
)
"""Any solver whose steps come from the Jacobian."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plain:
    """Another solver's steps the way textbooks and papers have them.

    One attempt from one start, full steps, limits by saturation after the step alone.
    `Status.STALLED` tells an attempt that came to rest from one that ran out of steps.
    For comparisons with published methods; by far not as reliable as the solver itself.

    Parameters
    ----------
    solver : solver
        Whose steps: a Jacobian solver or a feedback solver.
    start : {"sampled", "zero", "middle"}
        Where to start without `q0`; default "zero" (clamped into the limits).
    max_iterations : int, default 1000
        Steps before the target is given up; 1 to 2**32 - 1.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> textbook = ik.solvers.Plain(solver=ik.solvers.PseudoInverse(), start="middle")
    >>> arm.ik([[0.4, 0.2, 0.3]], solver=textbook).restarts.tolist()
    [0]
    """

    name: ClassVar[str] = "plain"
    solver: JacobianSolver | Feedback
    start: str = "zero"
    max_iterations: int = 1000

    def __post_init__(self) -> None:
        given: object = self.solver
        if not isinstance(given, JacobianSolver | Feedback):
            expected = "a solver object that takes steps"
            raise ArgumentError("Plain.solver", repr(given), expected)
        check_fields(self)
