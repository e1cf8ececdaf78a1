"""Options that several commands share, and texts read as numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Annotated, TypeVar

import typer

from ..errors import AgrikError, ArgumentError

_ValueT = TypeVar("_ValueT")
_ElseT = TypeVar("_ElseT")


def robot_names(incomplete: str) -> list[str]:
    """Return the robots whose names begin so, for the shell; files it completes by itself."""
    from ..robot import Robot

    return [name for name in Robot.names() if name.startswith(incomplete)]


def solver_names(incomplete: str) -> list[str]:
    """Return the solvers whose names begin so, for the shell."""
    from .._names import solver_names

    return [name for name in solver_names() if name.startswith(incomplete)]


Robot = Annotated[
    str,
    typer.Argument(
        help="A robot's name (see `agrik-fast robots`), or a .toml, .urdf or .xacro file.",
        autocompletion=robot_names,
    ),
]
BaseLink = Annotated[str | None, typer.Option("--base-link", help="URDF: first link of the arm.")]
TipLink = Annotated[
    str | None, typer.Option("--tip-link", help="URDF: last link of the arm, the tool's frame.")
]
Tool = Annotated[
    str | None,
    typer.Option(
        "--tool",
        help="Tool in the last link's frame, instead of the robot's own: x,y,z in metres or "
        "x,y,z,roll,pitch,yaw with radians, such as 0,0,0.1.",
    ),
]
Frame = Annotated[
    str | None,
    typer.Option("--frame", help="Frame of the robot file in which poses are given."),
]

Start = Annotated[
    str | None,
    typer.Option("--start", "--q0", help="Where ways start, radians and metres; by default home."),
]

Task = Annotated[
    str | None,
    typer.Option(
        help="position, pose, axis, masked or position-first; by default masked with --mask, "
        "else pose if there are orientations."
    ),
]
ToolAxis = Annotated[str, typer.Option(help="Axis task: tool axis, such as z, -x or 0,0.6,0.8.")]
MaskFrame = Annotated[str, typer.Option(help="Frame in which --mask counts: base or tool.")]
StartValues = Annotated[
    str | None,
    typer.Option("--q0", help="Start values in radians and metres, such as 0,-1.57,0."),
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the restarts.")]
Threads = Annotated[int | None, typer.Option(min=1, help="Threads; by default all cores.")]

# Why commands take no mask and no solver.
NO_SOLVING = "nothing is solved here"
BY_HARVEST = {
    "mask": "what is free is said by the way to a fruit; --tilt-deg and --shift widen it",
    "solver": "postures come from the arm's closed form",
}


class Faults:
    """Faults of options, all told at once, a line each."""

    def __init__(self) -> None:
        self._found: list[AgrikError] = []

    def of(
        self, option: str, text: str | None, read: Callable[[str, str], _ValueT]
    ) -> _ValueT | None:
        """Return what an option's text reads as; None where it was not given, or is faulty."""
        if text is None:
            return None
        try:
            return read(option, text)
        except AgrikError as error:
            self._found.append(error)
            return None

    def given(
        self, option: str, text: str | None, read: Callable[[str, str], _ValueT], default: _ElseT
    ) -> _ValueT | _ElseT:
        """Return the same, or a default instead of None."""
        value = self.of(option, text, read)
        return default if value is None else value

    def tell(self, more: Callable[[], Iterable[AgrikError]]) -> None:
        """Raise what was found, with what else is wrong; nothing where nothing was found.

        Raises
        ------
        AgrikError
            The fault, or all of them.
        """
        if self._found:
            raise together([*self._found, *more()])


def together(faults: list[AgrikError]) -> AgrikError:
    """Return one error that tells several, each once."""
    texts = list(dict.fromkeys(str(fault) for fault in faults))
    if len(texts) == 1:
        return faults[0]
    return AgrikError("\n  ".join([f"{len(texts)} faults", *texts]))


def numbers(option: str, text: str, counts: tuple[int, ...]) -> tuple[float, ...]:
    """Return the numbers of a text such as "0,0.6,0.8".

    Raises
    ------
    ArgumentError
        Something that is no finite number, or another count of them.
    """
    said = " or ".join(map(str, counts))
    expected = f"{said} numbers with commas between them"
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ArgumentError(option, repr(text), expected) from None
    if len(values) not in counts or any(value - value != 0.0 for value in values):
        raise ArgumentError(option, repr(text), expected)
    return values


def tool(text: str | None) -> tuple[float, ...] | None:
    """Return the numbers of the option --tool."""
    return None if text is None else tool_numbers("--tool", text)


def tool_numbers(option: str, text: str) -> tuple[float, ...]:
    """Return a place, or a place and angles."""
    return numbers(option, text, (3, 6))


def weights(option: str, text: str) -> tuple[float, ...]:
    """Return the six weights of a mask."""
    return numbers(option, text, (6,))


def values(option: str, text: str) -> tuple[float, ...]:
    """Return the joint values that a text such as "0,-1.57,0" holds, however many."""
    return numbers(option, text, (text.count(",") + 1,))
