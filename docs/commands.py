"""The command line's reference, from the program itself."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from typer.main import get_command

from agrik_fast.cli import _app

_OPTION = re.compile(r"(?<![\w-])--[a-z][\w-]*")


def page() -> str:
    """Return a section for each command: what it does, its arguments and options."""
    return "\n".join(
        line for words, command in commands() for line in _section(" ".join(words), command)
    )


def commands() -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the words of each command, and the command."""
    yield from _commands(("agrik-fast",), get_command(_app.app))


def _commands(words: tuple[str, ...], command: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    inner = getattr(command, "commands", None)
    if inner is None:
        yield words, command
        return
    for name, each in inner.items():
        yield from _commands((*words, name), each)


def _section(words: str, command: Any) -> Iterator[str]:
    context = command.make_context(words, [], resilient_parsing=True)
    # Some options are described when help is asked for.
    command.get_help(context)
    shown = [each for each in command.params if not getattr(each, "hidden", False)]
    arguments = [each for each in shown if each.param_type_name == "argument"]
    options = [each for each in shown if each.param_type_name == "option"]
    yield f"## {words}\n"
    usage = [name if each.required else f"[{name}]" for each in arguments if (name := _name(each))]
    yield f"```text\n{' '.join([words, *usage, *['[OPTIONS]'] * bool(options)])}\n```\n"
    for paragraph in (command.help or "").split("\n\n"):
        yield f"{_text(paragraph)}\n"
    if not arguments and not options:
        return
    yield "| | | default |\n|---|---|---|"
    for each in arguments:
        yield f"| `{_name(each)}` | {_cell(each.help)} | {_default(each)} |"
    for each in options:
        names = ", ".join(f"`{name}`" for name in (*each.opts, *each.secondary_opts))
        yield f"| {names} | {_cell(each.help)} | {_default(each)} |"
    yield ""


def _name(argument: Any) -> str:
    return str(argument.metavar or argument.name.upper())


def _text(help_: str) -> str:
    """Return help for a page: options in the typewriter's face, or their dashes would be joined."""
    words = " ".join(help_.split())
    parts = words.split("`")
    parts[::2] = [_OPTION.sub(r"`\g<0>`", part.replace("<", "&lt;")) for part in parts[::2]]
    return "`".join(parts)


def _cell(help_: str | None) -> str:
    return _text(help_ or "").replace("|", "\\|")


def _default(parameter: Any) -> str:
    if parameter.required:
        return "needed"
    if isinstance(parameter.show_default, str):
        return f"`{parameter.show_default}`"
    value = parameter.default
    if value is None or callable(value) or value is False or value == "":
        return ""
    return "yes" if value is True else f"`{getattr(value, 'value', value)}`"
