"""Postures, and paths into them, for the targets of a scene."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from .. import _harvest_options, _options
from .._exits import exit_codes, say, telling
from .._usage import refuses


@refuses(**_options.BY_HARVEST)
def harvest(
    scene: Annotated[Path, typer.Argument(help="Scene with targets: .json or .toml.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")],
    robot: Annotated[
        str,
        typer.Option(
            help="An arm on a slide with bodies: a name, .toml or .urdf.",
            autocompletion=_options.robot_names,
        ),
    ] = "cucumber",
    distance: _harvest_options.DistanceOption = "exact",
    refine: _harvest_options.Refine = True,
    recovery: _harvest_options.Recovery = True,
    blockers: _harvest_options.BlockersOption = True,
    pictures: Annotated[bool, typer.Option(help="Draw pictures; needs Matplotlib.")] = True,
    tilt_deg: _harvest_options.Tilt = 0.0,
    shift: _harvest_options.Shift = 0.0,
    min_distance: _harvest_options.MinDistance = 0.005,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    paths: Annotated[
        bool, typer.Option("--path", help="Plan the ways into the postures as well.")
    ] = False,
    start: _options.Start = None,
    threads: _options.Threads = None,
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds files.")
    ] = False,
) -> None:
    """Decide for every fruit of a scene whether and how it can be picked.

    Writes harvest.csv (one row a fruit), harvest.json and pictures: the share that can be
    picked, why not the rest, and which leaves block it. With --path also paths.json: for each
    fruit the way into its posture, proven free, or why there is none.
    """
    with exit_codes() as kept:
        from ...errors import ArgumentError
        from ...jobs import RobotChoice
        from .._harvest import check_folder, evaluate, lines, settings_of
        from ..progress import for_stream

        if start is not None and not paths:
            raise ArgumentError("--start", repr(start), "--path as well: ways start there")
        check_folder(output, force=force)
        arm = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        kept.what = lambda: f"files that were finished are in {output}"
        with for_stream(sys.stderr) as bar:
            done = 0

            def advance(now: int, total: int) -> None:
                nonlocal done
                if done == 0:
                    bar.start("fruits", total)
                bar.advance(now - done)
                done = now

            settings = settings_of(
                refine=refine,
                recovery=recovery,
                tilt_deg=tilt_deg,
                shift=shift,
                min_distance=min_distance,
            )
            found = evaluate(
                scene,
                arm,
                distance,
                settings=settings,
                blockers=blockers,
                threads=threads,
                progress=advance,
            )
        from ...harvest import write_report

        files = write_report(found, output, pictures=pictures, report=say)
        for line in lines(found):
            say(line)
        if paths:
            from .._harvest import write_paths

            file, said = write_paths(found, output, start=start, threads=threads)
            files.append(file)
            say(said)
        with telling(f"files: {output}"):
            for file in files:
                typer.echo(str(file))
