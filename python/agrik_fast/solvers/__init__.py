"""Solvers: how a target is reached.

Pass one to `Robot.ik` as an object or, with its defaults, by its name. There are three
kinds. `ClosedForm` computes the answer outright where the arm's geometry allows it; the
name "auto" takes it there, for full poses, and "lm" elsewhere. *Population solvers*
(`DifferentialEvolution`, `GeneticAlgorithm`) search the whole range of the joints with many
postures at once. *Step solvers* share one loop: it tests for convergence, takes a step
within the joint limits, and restarts when an attempt has used up its iterations. Attempts
start from the best of some sampled postures, the first attempts of those around the target.
The solvers differ in how the step is computed: from the Jacobian, or, with *feedback laws*,
without one.

Rows of the error and the Jacobian that concern orientation are scaled by a length per
radian (0.3 times the robot's reach), so that one damping serves metres and radians.
"""

from __future__ import annotations

from os import PathLike
from typing import Any, TypeAlias, TypeVar, overload

from ._closed_form import ClosedForm
from ._feedback import (
    Broyden,
    CyclicCoordinateDescent,
    Feedback,
    IkPid,
    StateSpace,
    StaticGain,
)
from ._population import DifferentialEvolution, GeneticAlgorithm
from ._step import (
    ClosedPseudoInverse,
    DampedLeastSquares,
    JacobianSolver,
    LevenbergMarquardt,
    Plain,
    PseudoInverse,
    Transpose,
)

__all__ = [
    "Broyden",
    "ClosedForm",
    "ClosedPseudoInverse",
    "CyclicCoordinateDescent",
    "DampedLeastSquares",
    "DifferentialEvolution",
    "Feedback",
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
    "load_gains",
]

Solver: TypeAlias = (
    JacobianSolver | Feedback | Plain | DifferentialEvolution | GeneticAlgorithm | ClosedForm
)
"""Any solver."""

_SolverT = TypeVar("_SolverT")


@overload
def load_gains(
    source: str | PathLike[str], kind: None = None, *, as_tuned: bool | None = None
) -> StateSpace | StaticGain | IkPid: ...


@overload
def load_gains(
    source: str | PathLike[str], kind: type[_SolverT], *, as_tuned: bool | None = None
) -> _SolverT: ...


def load_gains(
    source: str | PathLike[str], kind: type[Any] | None = None, *, as_tuned: bool | None = None
) -> Any:
    """Return the solver of a gain file.

    Parameters
    ----------
    source : str or path
        Path of a .toml or .json file, or the name of a bundled set.
    kind : type, optional
        `StateSpace`, `StaticGain` or `IkPid`, to refuse gains of another kind. Default: the
        kind that the file names.
    as_tuned : bool, optional
        True: one attempt of at most 1,000 steps from the start that the gains were tuned for,
        which is how gains are compared. False: the solver's usual start, steps and restarts,
        which solve more targets. Default: as tuned, with a warning that says which settings
        this changes.

    Returns
    -------
    solver
        The gains in a solver.

    Raises
    ------
    UnknownNameError
        Neither a file nor a bundled set.
    GainFileError
        The file holds no valid gains, or gains of another kind of solver.

    Warns
    -----
    SettingsWarning
        Start, steps and restarts are not the usual ones, and `as_tuned` was not given.

    Examples
    --------
    >>> from agrik_fast.solvers import StateSpace, load_gains
    >>> load_gains("hydrolek_k15_cma", as_tuned=True).robot
    'hydrolek'
    >>> type(load_gains("hydrolek_k15_cma", StateSpace, as_tuned=True)).__name__
    'StateSpace'
    """
    # pydantic, which reads the file, takes longer to import than everything else together.
    from . import gain_file

    return gain_file.load(source, kind, as_tuned)
