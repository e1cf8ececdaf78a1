"""Names that the compiled core gives; asked of it without NumPy, for the command line's help."""

from __future__ import annotations

from . import _native


def solver_names() -> tuple[str, ...]:
    """Return the names that `Robot.ik` takes for solvers, in the core's order."""
    return tuple(_native.solver_names())
