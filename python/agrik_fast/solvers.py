"""Solvers: how a target is reached.

Pass one to `Robot.ik` as an object or, with its defaults, by its name. There are three
kinds. `ClosedForm` computes the answer outright where the arm's geometry allows it; the
name "auto" takes it there, for full poses, and "lm" elsewhere. *Population solvers*
(`agrik_fast.population`) search the whole range of the joints with many postures at once.
*Step solvers*, defined here, share one loop: it tests for convergence, takes a step within
the joint limits, and restarts when an attempt has used up its iterations. Attempts start
from the best of some sampled postures, the first attempts of those around the target. The
solvers differ in how the step is computed.

Rows of the error and the Jacobian that concern orientation are scaled by a length per
radian (0.3 times the robot's reach), so that one damping serves metres and radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias

from ._checks import real_number, truth_value, whole_number
from ._feedback import (
    STARTS,
    Broyden,
    CyclicCoordinateDescent,
    Feedback,
    IkPid,
    StateSpace,
    StaticGain,
)
from .errors import ArgumentError, UnknownNameError
from .population import DifferentialEvolution, GeneticAlgorithm

__all__ = [
    "Broyden",
    "ClosedForm",
    "ClosedPseudoInverse",
    "CyclicCoordinateDescent",
    "DampedLeastSquares",
    "DifferentialEvolution",
    "GeneticAlgorithm",
    "IkPid",
    "JacobianSolver",
    "LevenbergMarquardt",
    "Plain",
    "PseudoInverse",
    "Solver",
    "StateSpace",
    "StaticGain",
    "Transpose",
]

# The compiled module counts in 32 bits.
_LARGEST_COUNT = 2**32 - 1


def _check_loop(solver: JacobianSolver) -> None:
    kind = type(solver).__name__
    whole_number(f"{kind}.max_iterations", solver.max_iterations, 1, _LARGEST_COUNT)
    whole_number(f"{kind}.max_restarts", solver.max_restarts, 0, _LARGEST_COUNT)
    real_number(f"{kind}.max_step", solver.max_step, 0, open_low=True, unit="rad or m")


@dataclass(frozen=True, slots=True, kw_only=True)
class LevenbergMarquardt:
    """Least squares damped by a share of the squared error; the default, named "lm".

    ``dq = J^T (J J^T + (damping |e|^2 / 2 + 1e-12 s^2) I)^-1 e``, with s the robot's size:
    steep and safe far from the target, quadratic near it, because the damping vanishes with
    the error.

    Parameters
    ----------
    damping : float, default 0.1
        Share of half the squared error that is added to the diagonal; no unit, > 0.
    max_iterations : int, default 10
        Steps of one attempt before it is given up; 1 to 2**32 - 1. An attempt that
        is closing in on a solution, slowly where that is singular, gets eight times as many.
    max_restarts : int, default 250
        Attempts after the first before the target is given up; 0 to 2**32 - 1.
    max_step : float, default 1.0
        Longest change of one joint in one step, rad or m; > 0. A step that is longer is
        shortened as a whole.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    References
    ----------
    Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt
    method", IEEE Transactions on Robotics 27(5), 2011.
    """

    name: ClassVar[str] = "lm"
    damping: float = 0.1
    max_iterations: int = 10
    max_restarts: int = 250
    max_step: float = 1.0

    def __post_init__(self) -> None:
        real_number("LevenbergMarquardt.damping", self.damping, 0, open_low=True)
        _check_loop(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class DampedLeastSquares:
    """Least squares with constant damping, named "dls".

    ``dq = J^T (J J^T + damping^2 I)^-1 e``: never a wild step, at the price of slow
    (linear) convergence.

    Parameters
    ----------
    damping : float, default 0.01
        Damping, m; > 0.
    max_iterations : int, default 60
        Steps of one attempt before it is given up; 1 to 2**32 - 1. An attempt that
        is closing in on a solution, slowly where that is singular, gets eight times as many.
    max_restarts : int, default 100
        Attempts after the first before the target is given up; 0 to 2**32 - 1.
    max_step : float, default 1.0
        Longest change of one joint in one step, rad or m; > 0. A step that is longer is
        shortened as a whole.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    References
    ----------
    Nakamura and Hanafusa, "Inverse kinematic solutions with singularity robustness for
    robot manipulator control", ASME Journal of Dynamic Systems, Measurement, and Control
    108(3), 1986.
    """

    name: ClassVar[str] = "dls"
    damping: float = 0.01
    max_iterations: int = 60
    max_restarts: int = 100
    max_step: float = 1.0

    def __post_init__(self) -> None:
        real_number("DampedLeastSquares.damping", self.damping, 0, open_low=True, unit="m")
        _check_loop(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class PseudoInverse:
    """Full steps by the Moore-Penrose pseudo-inverse, named "pinv".

    ``dq = J^+ e``. Directions with a singular value below `cutoff` times the largest are
    left out, so that a singular posture gives a short step and not a wild one.

    Parameters
    ----------
    cutoff : float, default 0.001
        Relative cutoff of singular values; no unit, > 0 and < 1.
    max_iterations : int, default 60
        Steps of one attempt before it is given up; 1 to 2**32 - 1. An attempt that
        is closing in on a solution, slowly where that is singular, gets eight times as many.
    max_restarts : int, default 100
        Attempts after the first before the target is given up; 0 to 2**32 - 1.
    max_step : float, default 1.0
        Longest change of one joint in one step, rad or m; > 0. A step that is longer is
        shortened as a whole.

    Raises
    ------
    ArgumentError
        A field is out of its range.
    """

    name: ClassVar[str] = "pinv"
    cutoff: float = 0.001
    max_iterations: int = 60
    max_restarts: int = 100
    max_step: float = 1.0

    def __post_init__(self) -> None:
        cutoff = real_number("PseudoInverse.cutoff", self.cutoff, 0, 1, open_low=True)
        if cutoff == 1:
            raise ArgumentError("PseudoInverse.cutoff", "1.0", "a finite number > 0 and < 1")
        _check_loop(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Transpose:
    """Steps along the Jacobian transpose with Buss's step length, named "transpose".

    ``dq = alpha J^T e`` with ``alpha = <e, J J^T e> / |J J^T e|^2``: cheap steps without an
    equation system, but many of them.

    Parameters
    ----------
    max_iterations : int, default 2000
        Steps of one attempt before it is given up; 1 to 2**32 - 1. An attempt that
        is closing in on a solution, slowly where that is singular, gets eight times as many.
    max_restarts : int, default 20
        Attempts after the first before the target is given up; 0 to 2**32 - 1.
    max_step : float, default 1.0
        Longest change of one joint in one step, rad or m; > 0. A step that is longer is
        shortened as a whole.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    References
    ----------
    Buss, "Introduction to inverse kinematics with Jacobian transpose, pseudoinverse and
    damped least squares methods", 2004.
    """

    name: ClassVar[str] = "transpose"
    max_iterations: int = 2000
    max_restarts: int = 20
    max_step: float = 1.0

    def __post_init__(self) -> None:
        _check_loop(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedPseudoInverse:
    """Full steps by the pseudo-inverse in closed form, named "pinv-closed".

    ``dq = J^T (J J^T)^-1 e``: cheap, but with no answer where ``J J^T`` is singular; there
    an attempt ends.

    Parameters
    ----------
    max_iterations : int, default 60
        Steps of one attempt before it is given up; 1 to 2**32 - 1.
    max_restarts : int, default 100
        Attempts after the first before the target is given up; 0 to 2**32 - 1.
    max_step : float, default 1.0
        Longest change of one joint in one step, rad or m; > 0. A step that is longer is
        shortened as a whole.

    Raises
    ------
    ArgumentError
        A field is out of its range.
    """

    name: ClassVar[str] = "pinv-closed"
    max_iterations: int = 60
    max_restarts: int = 100
    max_step: float = 1.0

    def __post_init__(self) -> None:
        _check_loop(self)


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
        if self.start not in STARTS:
            raise UnknownNameError("start", str(self.start), STARTS)
        whole_number("Plain.max_iterations", self.max_iterations, 1, _LARGEST_COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedForm:
    """Every branch of the exact solution, and the best of them; named "closed_form".

    For full poses of arms with a closed form (see `Robot.closed_form`): six revolute
    joints whose last three axes meet, or seven of which also the first three do (S-R-S).
    No iteration, no random start: `seed` does not matter, and a target without a solution
    within the limits is proven to have none.

    Parameters
    ----------
    choose : {"nearest", "margin", "middle"}, default "nearest"
        Which of the valid branches is the answer. "nearest": the least sum of squared
        distances from `q0`, or from the middle of the limits where no `q0` is given.
        "margin": the one whose worst joint is furthest from its limits, as a share of
        half the joint's range. "middle": the least sum of squared distances from the
        middle of the limits, as shares of half the range. Joints without limits do not
        count in the last two.
    arm_angle : float, optional
        Arm angle of an S-R-S arm, rad (see `Robot.arm_angle`). Default: the best one by
        `choose`, out of all that the limits allow.
    certify : bool, default False
        Prove that no other arm angle of an S-R-S arm is better by more than 1e-9 in the
        cost (rad^2, or shares), see the page on closed forms. Takes many times as long as
        the default, the best of a quick look round. Nothing to prove with `arm_angle`, for
        other arms, or where axes of shoulder or wrist meet at another than a right angle.

    Raises
    ------
    ArgumentError
        A field is out of its range.
    """

    name: ClassVar[str] = "closed_form"
    choose: Literal["nearest", "margin", "middle"] = "nearest"
    arm_angle: float | None = None
    certify: bool = False

    def __post_init__(self) -> None:
        if self.choose not in ("nearest", "margin", "middle"):
            raise ArgumentError(
                "ClosedForm.choose", repr(self.choose), "'nearest', 'margin' or 'middle'"
            )
        if self.arm_angle is not None:
            angle = real_number("ClosedForm.arm_angle", self.arm_angle, unit="rad")
            object.__setattr__(self, "arm_angle", angle)
        object.__setattr__(self, "certify", truth_value("ClosedForm.certify", self.certify))


Solver: TypeAlias = (
    JacobianSolver | Feedback | Plain | DifferentialEvolution | GeneticAlgorithm | ClosedForm
)
"""Any solver."""
