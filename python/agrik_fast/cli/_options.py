"""Options that several commands share, and texts read as numbers."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import ArgumentError

Robot = Annotated[
    str,
    typer.Argument(
        help="A robot's name (see `agrik-fast robots`), or a .toml, .urdf or .xacro file."
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
    return None if text is None else numbers("--tool", text, (3, 6))
