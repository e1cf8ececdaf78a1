"""What the step solvers share: the fields of their common loop, described and checked once."""

from __future__ import annotations

from dataclasses import dataclass

from ._core import check_fields


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """Fields of the loop that all step solvers share; each solver has defaults of its own.

    Parameters
    ----------
    max_iterations : int
        Steps of one attempt before it is given up (of solvers that move one joint after the
        other: sweeps over all joints); 1 to 2**32 - 1.
    max_restarts : int
        Attempts after the first before the target is given up; 0 to 2**32 - 1.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    Examples
    --------
    >>> ik.solvers.Transpose(max_iterations=500, max_restarts=3).max_restarts
    3
    """

    max_iterations: int
    max_restarts: int

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class JacobianLoop(Loop):
    """Fields of the loop of solvers whose steps come from the Jacobian.

    An attempt that is closing in on a solution, slowly where that is singular, gets eight
    times as many steps (but not from `ClosedPseudoInverse`).

    Parameters
    ----------
    max_iterations, max_restarts : int
        As in `Loop`.
    max_step : float, default 1.0
        Longest change of one joint in one step, rad or m; > 0. A step that is longer is
        shortened as a whole.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    Examples
    --------
    >>> ik.solvers.LevenbergMarquardt(max_step=0.2).max_step
    0.2
    """

    max_step: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FeedbackLoop(Loop):
    """Fields of the loop of feedback laws.

    Parameters
    ----------
    max_iterations, max_restarts : int
        As in `Loop`.
    start : {"sampled", "zero", "middle"}
        Where the first attempt starts without `q0`; default "sampled".

    Raises
    ------
    ArgumentError
        A field is out of its range.
    UnknownNameError
        No start has that name.

    Examples
    --------
    >>> ik.solvers.CyclicCoordinateDescent(start="zero").start
    'zero'
    """

    start: str = "sampled"
