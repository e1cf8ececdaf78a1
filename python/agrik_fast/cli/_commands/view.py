"""A robot to look at and to drag."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .. import _options
from .._exits import exit_codes, telling
from .._usage import refuses


@refuses(mask="its panel has the tasks pose, axis and position")
def view(
    robot: _options.Robot,
    scene: Annotated[
        Path | None, typer.Option(help="What stands round it: a .json or .toml scene file.")
    ] = None,
    targets: Annotated[
        Path | None, typer.Option(help="Targets to step through, as for `solve`.")
    ] = None,
    path: Annotated[
        Path | None,
        typer.Option(help="Targets to follow, or postures that `solve` wrote, to be played."),
    ] = None,
    show: Annotated[
        str, typer.Option(help="What the arm is shown as: auto, chain, bodies or visuals.")
    ] = "auto",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 takes a free one.")] = 8080,
    host: Annotated[
        str, typer.Option(help="Address to listen to; by default this machine alone.")
    ] = "127.0.0.1",
    export: Annotated[
        Path | None,
        typer.Option(help="Write a page that needs no server instead: a .html file."),
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")
    ] = True,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing page.")] = False,
    q0: Annotated[
        str | None,
        typer.Option("--q0", help="Posture at first, radians and metres, such as 0,-1.57,0."),
    ] = None,
    solver: Annotated[
        str | None,
        typer.Option(
            help="Solver that the panel begins with: a name, or a gain file (.toml, .json).",
            show_default="lm",
            autocompletion=_options.solver_names,
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
) -> None:
    """Show an arm in the browser: drag its target, look at branches, limits and collisions.

    Ctrl-C ends it. Needs the extra `viewer`.
    """
    with exit_codes() as kept:
        from ...jobs import RobotChoice
        from .._view import ViewRequest, write_page

        kept.what = lambda: "the viewer has ended"
        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        request = ViewRequest(choice, scene, targets, path, show, host, port, q0, solver)
        if export is not None:
            kept.what = lambda: "nothing was written"
            file = write_page(request, export, force=force)
            with telling(f"page: {file}"):
                typer.echo(f"page: {file}")
            return
        with request.open(browser=browser) as viewer:
            with telling():
                typer.echo(f"{viewer.robot.name}: {viewer.url} (Ctrl-C ends it)")
            viewer.wait()
