"""Targets of a file to joint values."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from .. import _options
from .._exits import NOT_ALL_SOLVED, exit_codes, say, telling


class SolveCommand(TyperCommand):
    """`solve`, whose help names the solvers that the core knows when it is asked for."""

    def get_help(self, ctx: Any) -> str:
        """Return the help."""
        from ..._names import solver_names

        (option,) = (each for each in self.params if each.name == "solver")
        *first, last = solver_names()
        vars(option)["help"] = f"{', '.join(first)} or {last}; or a gain file (.toml, .json)."
        return super().get_help(ctx)


def solve(
    robot: _options.Robot,
    targets: Annotated[Path, typer.Argument(help="Targets: .csv, .npy, .npz or .parquet.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Results: .csv, .npy, .npz or .parquet.")
    ],
    task: _options.Task = None,
    solver: Annotated[
        str | None,
        typer.Option(  # its help is in SolveCommand
            help="Name of the solver.", show_default="lm", autocompletion=_options.solver_names
        ),
    ] = None,
    tol: Annotated[
        str,
        typer.Option(
            help="Position tolerance in metres; or three, along x, y, z, such as 1e-3,1e-3,inf, "
            "where inf leaves an axis free."
        ),
    ] = "1e-6",
    tol_rad: Annotated[
        str,
        typer.Option(help="Orientation tolerance in radians; or three, about x, y, z."),
    ] = "1e-6",
    tol_frame: Annotated[
        str | None,
        typer.Option(help="Whose axes three tolerances are for: base or tool; by default base."),
    ] = None,
    tool_axis: _options.ToolAxis = "z",
    direction: Annotated[
        str | None,
        typer.Option(
            help="Axis task: where the tool axis points in the base frame, such as -z or 0,0,-1; "
            "by default along the targets' own tool axis."
        ),
    ] = None,
    mask: Annotated[
        str | None,
        typer.Option(
            help="Weights of the errors along x,y,z and about x,y,z, 0 where it is free, such as "
            "1,1,1,0,0,1."
        ),
    ] = None,
    mask_frame: _options.MaskFrame = "base",
    q0: _options.StartValues = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    seed: _options.Seed = 0,
    threads: _options.Threads = None,
    scene: Annotated[
        Path | None,
        typer.Option(help="Scene that answers must not hit: a .json or .toml scene file."),
    ] = None,
    clear: Annotated[
        float, typer.Option(help="Scene: distance in metres that answers keep from it.")
    ] = 0.0,
    prefer: Annotated[
        str, typer.Option(help="Scene: which of several free postures: first, near or clearance.")
    ] = "first",
    aim: Annotated[
        str | None,
        typer.Option(help="Scene: name of the target in it that the gripper may touch."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing result.")] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 3 unless every row is solved.")
    ] = False,
    all_branches: Annotated[
        bool,
        typer.Option(
            "--all-branches",
            help="Write a row for each branch of a target within the limits; no solver then.",
        ),
    ] = False,
) -> None:
    """Solve every target of a file and write the joint values to another.

    Lengths are metres and angles radians unless a column says otherwise (x_mm, roll_deg).
    Exit status: 0 every row was processed, 2 bad arguments or files, 3 some rows are not
    solved (with --strict), 4 out of memory, 5 done but standard output is full, 129 hung up,
    130 interrupted, 143 terminated. The result appears only when it is complete.
    """
    with exit_codes() as kept:
        from ...jobs import SolveRequest
        from .._solve import (
            AXES,
            load_scene,
            other_faults,
            parse_axis,
            parse_frame,
            parse_preference,
            parse_solver,
            parse_tolerance,
            solve_words,
            unused,
        )
        from ..progress import for_stream
        from ..summary import print_summaries

        faults = _options.Faults()
        request = SolveRequest(
            robot=robot,
            targets=targets,
            output=output,
            task=task,
            solver=faults.given("--solver", solver, parse_solver, "lm"),
            position_tolerance=faults.given("--tol", tol, parse_tolerance, 1e-6),
            orientation_tolerance=faults.given("--tol-rad", tol_rad, parse_tolerance, 1e-6),
            tolerance_frame=faults.of("--tol-frame", tol_frame, parse_frame),
            tool_axis=faults.given("--tool-axis", tool_axis, parse_axis, AXES["z"]),
            direction=faults.of("--direction", direction, parse_axis),
            seed=seed,
            threads=threads,
            force=force,
            base_link=base_link,
            tip_link=tip_link,
            tool=faults.of("--tool", tool, _options.tool_numbers),
            frame=frame,
            q0=faults.of("--q0", q0, _options.values),
            mask=faults.of("--mask", mask, _options.weights),
            mask_frame=faults.given("--mask-frame", mask_frame, parse_frame, "base"),
            scene=faults.of("--scene", "", lambda option, text: load_scene(scene, aim)),
            scene_name="" if scene is None else scene.name,
            clear=clear,
            prefer=faults.given("--prefer", prefer, parse_preference, "first"),
            all_branches=all_branches,
        )
        faults.tell(lambda: other_faults(request))
        for line in unused(solver=solver, seed=seed, all_branches=all_branches):
            say(f"agrik-fast: {line}")
        summary = solve_words(request, for_stream(sys.stderr))
        kept.what = lambda: f"results: {output}"
        with telling(f"results: {output}"):
            print_summaries([summary], sys.stdout)
            typer.echo(f"results: {output}")
    if strict and summary.solved < summary.rows:
        raise typer.Exit(NOT_ALL_SOLVED)
