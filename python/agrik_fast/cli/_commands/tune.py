"""Gains for a robot and its targets."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .. import _options
from .._exits import exit_codes, telling
from .._usage import refuses


@refuses(
    q0="attempts start at --start zero or middle",
    mask="gains are for whole positions or poses, --task position or pose",
)
def tune(
    robot: _options.Robot,
    output: Annotated[Path, typer.Option("--output", "-o", help="Gain file: .toml or .json.")],
    solver: Annotated[
        str, typer.Option(help="state-space, static-gain or ik-pid.")
    ] = "state-space",
    shape: Annotated[
        str, typer.Option(help="State space: input (B alone), diagonal (of A, and B) or full.")
    ] = "input",
    method: Annotated[
        str | None,
        typer.Option(help="pso (particle swarm, the default) or cma (CMA-ES, that of ik-pid)."),
    ] = None,
    start: Annotated[str, typer.Option(help="Where attempts start: zero or middle.")] = "zero",
    task: Annotated[
        str, typer.Option(help="What the gains are for: position or pose.")
    ] = "position",
    goals: Annotated[
        int | None, typer.Option(min=1, help="Training goals: 3000, or 600 for ik-pid.")
    ] = None,
    evaluations: Annotated[
        int | None,
        typer.Option(min=1, help="Gain sets to judge in a search: 4840, or 400 for ik-pid."),
    ] = None,
    runs: Annotated[int, typer.Option(min=1, help="Searches, of which the best is kept.")] = 3,
    refinement: Annotated[
        int | None,
        typer.Option(min=0, help="Gain sets to judge in the refinement, 0 for none: 2400, or 200."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the search and its goals.")] = 0,
    tol: Annotated[float, typer.Option(help="Position tolerance in metres.")] = 1e-3,
    tol_rad: Annotated[
        float, typer.Option(help="Orientation tolerance in radians, for poses.")
    ] = 1e-2,
    rotation_length: Annotated[
        float | None,
        typer.Option(
            help="Poses: metres that a radian of error counts as; 0.3 of the reach if not given."
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    threads: _options.Threads = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on from the checkpoint of a run that was killed.")
    ] = False,
) -> None:
    """Find the gains of a feedback solver and write them with how well they do.

    A checkpoint beside the output keeps the search, every few seconds, until the gains are
    written.
    """
    with exit_codes() as kept:
        from ...jobs import RobotChoice
        from ...tuning import Tuning
        from .._tune import comparison, tune_to_file, what_is_kept

        given = {
            "method": method,
            "goals": goals,
            "evaluations": evaluations,
            "refinement": refinement,
        }
        tuning = Tuning.usual(
            solver,
            shape=shape,
            start=start,
            runs=runs,
            seed=seed,
            task=task,
            tolerance=tol,
            orientation_tolerance=tol_rad,
            rotation_length=rotation_length,
            threads=threads,
            **{name: value for name, value in given.items() if value is not None},
        )
        kept.what = lambda: what_is_kept(output)
        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        content = tune_to_file(choice, tuning, output, force=force, resume=resume)
        kept.what = lambda: f"gains: {output}"
        success = content.success
        with telling(f"gains: {output}"):
            if success is not None:
                typer.echo(
                    f"{success.solved} of {success.goals} goals kept apart are reached "
                    f"(training: {content.training.solved} of {content.training.goals})"
                )
            for line in comparison(content, choice, tuning):
                typer.echo(line)
            typer.echo(f"gains: {output}")
