"""Names that the compiled core gives; asked of it without NumPy, for the command line's help."""

from __future__ import annotations

from ._native import default_settings


def solver_names() -> tuple[str, ...]:
    """Return the names that `Robot.ik` takes for solvers, in the core's order."""
    return (*default_settings(), "closed_form", "auto")
