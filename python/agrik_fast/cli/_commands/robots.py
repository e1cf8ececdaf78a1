"""What there is: robots, solvers and the files of both."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .. import _options
from .._exits import exit_codes, say, telling
from .._usage import refuses


@refuses(mask=_options.NO_SOLVING, solver=_options.NO_SOLVING)
def info(
    robot: Annotated[
        str | None,
        typer.Argument(
            help="A robot's name or file, as for `solve`; all names if none.",
            autocompletion=_options.robot_names,
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    q0: Annotated[
        str | None,
        typer.Option(
            "--q0", help="Print the tool's pose at these joint values, in radians and metres."
        ),
    ] = None,
    body: Annotated[
        bool, typer.Option("--body", help="Print its bodies for collisions instead.")
    ] = False,
    self_pairs: Annotated[
        bool,
        typer.Option(
            "--self-pairs",
            help="Print which bodies may hit each other, and why others are left out.",
        ),
    ] = False,
) -> None:
    """Print a robot's joints, limits, reach, DH rows and source."""
    with exit_codes():
        from ...jobs import RobotChoice
        from .._info import about_collisions, describe, list_robots, no_robot

        asked = [base_link, tip_link, tool, frame, q0, body or None, self_pairs or None]
        if robot is None and any(each is not None for each in asked):
            raise no_robot()
        if robot is None:
            text = list_robots()
        else:
            arm = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame).load()
            if body or self_pairs:
                text = about_collisions(arm, body=body, self_pairs=self_pairs)
            else:
                text = describe(arm, None if q0 is None else _options.values("--q0", q0))
        with telling():
            typer.echo(text)


def robots() -> None:
    """Print the robots that can be loaded by name, with a line on each."""
    with exit_codes():
        from .._info import list_robots

        with telling():
            typer.echo(list_robots())


def solvers() -> None:
    """Print the solvers, with a line on each."""
    with exit_codes():
        from .._info import list_solvers

        with telling():
            typer.echo(list_solvers())


@refuses(
    q0="a robot file holds no start; its home posture is in the keys home_deg, home_m, ...",
    mask=_options.NO_SOLVING,
    solver=_options.NO_SOLVING,
)
def convert(
    robot: _options.Robot,
    output: Annotated[Path, typer.Argument(help="The robot file to write: .toml.")],
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """Write a robot, such as one from a URDF, to a robot file."""
    with exit_codes():
        from ...jobs import RobotChoice

        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        arm = choice.load()
        for note in arm.notes:
            say(f"{arm.name}: {note}")
        arm.save(output, force=force)
        with telling(f"robot: {output}"):
            typer.echo(f"robot: {output}")


def schema(
    kind: Annotated[str, typer.Argument(help="robot, gains, scene or calibration.")],
) -> None:
    """Print the JSON Schema of a kind of file, for editors."""
    with exit_codes():
        from .._schema import json_schema

        text = json_schema(kind)
        with telling():
            typer.echo(text)
