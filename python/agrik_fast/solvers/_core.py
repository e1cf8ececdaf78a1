"""What the compiled core knows of solvers: their names, and what their fields may be."""

from __future__ import annotations

from .._checks import shown
from .._native import check_solver
from ..errors import ArgumentError, UnknownNameError


def check_fields(solver: object) -> None:
    """Refuse a solver object with a field that the core does not take, by the class's name."""
    try:
        check_solver(solver)
    except UnknownNameError:
        raise
    except ArgumentError as error:
        argument = f"{type(solver).__name__}.{error.argument}"
        # As the caller wrote it.
        given = getattr(solver, error.argument, None)
        received = error.received if given is None else shown(given)
        raise ArgumentError(argument, received, error.expected) from None
