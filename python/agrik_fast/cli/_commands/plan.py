"""A path from posture to posture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .. import _options
from .._exits import NOT_ALL_SOLVED, exit_codes, say
from .._usage import refuses


@refuses(mask="a way ends at a point, in a whole pose or in joint values")
def plan(
    robot: _options.Robot,
    target: Annotated[
        str,
        typer.Option(
            "--target",
            help="A target of the scene by name, x,y,z in metres, x,y,z,roll,pitch,yaw with "
            "radians, or q= and joint values.",
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Trajectory: .csv, .json, .npz, ...")
    ],
    scene: Annotated[
        Path | None, typer.Option("--scene", help="What stands round it: .json or .toml.")
    ] = None,
    start: _options.Start = None,
    solver: Annotated[
        str | None,
        typer.Option(
            help="Solver of the searches for postures at a point x,y,z.",
            show_default="lm",
            autocompletion=_options.solver_names,
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    clear: Annotated[float, typer.Option(help="Distance kept from the scene, m.")] = 0.002,
    blend: Annotated[
        float, typer.Option(help="How much of a segment corners are rounded on, 0 to 0.5.")
    ] = 0.4,
    seed: Annotated[int, typer.Option(min=0, help="Which random numbers are drawn.")] = 0,
    force: Annotated[
        bool, typer.Option("--force", help="Write over a file that is there.")
    ] = False,
) -> None:
    """Plan a path that is proven free, and write it as a trajectory.

    Corners are rounded as far as that is proven too. Exit status 3 where there is no path; the
    reason is said.
    """
    with exit_codes():
        from ...jobs import RobotChoice
        from .._motion import lines, trajectory
        from .._motion import plan as planned

        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        arm, around, found = planned(
            choice, scene, start, target, clear=clear, seed=seed, solver=solver
        )
        for note in arm.notes:
            say(f"{arm.name}: {note}")
        for line in lines(found):
            say(line)
        if not found.ok:
            raise typer.Exit(NOT_ALL_SOLVED)
        made = trajectory(arm, around, found, blend=blend, clear=clear)
        made.save(output, force=force)
        say(f"{len(made.times)} points, {made.duration:.3f} s: {output}")
