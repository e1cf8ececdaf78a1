"""Words that a command cannot take: one line each, with the reason."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Callable, Iterator
from functools import wraps
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from ._exits import BAD_ARGUMENTS, say

__all__ = ["OneLineGroup", "refuses"]

# The base of all usage errors; its own module has moved between versions of typer.
_UsageError: Any = typer.BadParameter.__mro__[1]


class OneLineGroup(TyperGroup):
    """Commands whose usage errors are told in one line, as all other faults are."""

    def make_context(self, *args: Any, **extra: Any) -> Any:
        """Read the words before the command."""
        with _one_line():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: Any) -> Any:
        """Read the words of the command, and run it."""
        with _one_line():
            return super().invoke(ctx)


@contextlib.contextmanager
def _one_line() -> Iterator[None]:
    try:
        yield
    except _UsageError as error:
        message = error.format_message().rstrip(".")
        if error.ctx is None or "\n" in message:
            raise  # the whole help, where there are no words at all
        say(f"agrik-fast: {message}; see {error.ctx.command_path} --help")
        raise typer.Exit(BAD_ARGUMENTS) from None


def refuses(**reasons: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Let a command say why options of other commands mean nothing to it.

    Parameters
    ----------
    **reasons : str
        For each option what the command does instead, such as ``mask="it takes whole poses"``.
        They are left out of the help.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def run(**given: Any) -> None:
            unfit = [name for name in reasons if given.pop(name) is not None]
            for name in unfit:
                option = name.replace("_", "-")
                said = f"`--{option}` means nothing to `{command.__name__}`: {reasons[name]}"
                say(f"agrik-fast: {said}")
            if unfit:
                raise typer.Exit(BAD_ARGUMENTS)
            command(**given)

        own = inspect.signature(command, eval_str=True)
        more = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                annotation=Annotated[
                    str | None, typer.Option(f"--{name.replace('_', '-')}", hidden=True)
                ],
                default=None,
            )
            for name in reasons
        ]
        kept = [
            each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in own.parameters.values()
        ]
        # What typer reads options from.
        vars(run)["__signature__"] = own.replace(parameters=[*kept, *more])
        run.__annotations__ = {each.name: each.annotation for each in [*kept, *more]}
        return run

    return decorate
