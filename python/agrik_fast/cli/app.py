"""Commands, options and exit codes of ``agrik-fast``.

Only typer is imported here: ``--help`` must stay fast, so NumPy, the compiled module and rich
load inside the command that needs them.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

EXIT_BAD_ARGUMENTS = 2
EXIT_NOT_ALL_SOLVED = 3
EXIT_INTERRUPTED = 130  # the shell's 128 + SIGINT

app = typer.Typer(
    name="agrik-fast",
    help="Fast, verified inverse kinematics for serial robot arms.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def main() -> None:
    """Run the command line and exit with its status."""
    app(prog_name="agrik-fast")


@contextlib.contextmanager
def _exit_codes() -> Iterator[None]:
    """Turn expected errors into one line on stderr and an exit code."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo("agrik-fast: interrupted, nothing was written", err=True)
        raise typer.Exit(EXIT_INTERRUPTED) from None
    except Exception as error:
        from ..errors import AgrikError

        if not isinstance(error, AgrikError | OSError):
            raise
        line = "; ".join(part.strip() for part in str(error).splitlines() if part.strip())
        typer.echo(f"agrik-fast: {line}", err=True)
        raise typer.Exit(EXIT_BAD_ARGUMENTS) from None


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"agrik-fast {version('agrik_fast')}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    del version


@app.command()
def solve(
    robot: Annotated[str, typer.Argument(help="A bundled robot's name, or a .toml or .urdf file.")],
    targets: Annotated[Path, typer.Argument(help="Targets: .csv, .npy, .npz or .parquet.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Results: .csv, .npy, .npz or .parquet.")
    ],
    task: Annotated[
        str | None,
        typer.Option(help="position, pose or axis; by default pose if there are orientations."),
    ] = None,
    solver: Annotated[str, typer.Option(help="lm, dls, pinv or transpose.")] = "lm",
    tol: Annotated[float, typer.Option(help="Position tolerance in metres.")] = 1e-6,
    tol_rad: Annotated[float, typer.Option(help="Orientation tolerance in radians.")] = 1e-6,
    tool_axis: Annotated[
        str, typer.Option(help="Axis task: tool axis, such as z, -x or 0,0.6,0.8.")
    ] = "z",
    direction: Annotated[
        str | None,
        typer.Option(
            help="Axis task: where the tool axis points in the base frame, such as -z or 0,0,-1; "
            "by default along the targets' own tool axis."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the restarts.")] = 0,
    threads: Annotated[
        int | None, typer.Option(min=1, help="Threads; by default all cores.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing result.")] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 3 unless every row is solved.")
    ] = False,
) -> None:
    """Solve every target of a file and write the joint values to another.

    Lengths are metres and angles radians unless a column says otherwise (x_mm, roll_deg).
    Exit status: 0 every row was processed, 2 bad arguments or files, 3 some rows are not
    solved (with --strict), 130 interrupted; the result appears only when it is complete.
    """
    with _exit_codes():
        from .progress import for_stream
        from .solve import SolveRequest, solve_file
        from .summary import print_summaries

        request = SolveRequest(
            robot=robot,
            targets=targets,
            output=output,
            task=task,
            solver=solver,
            position_tolerance=tol,
            orientation_tolerance=tol_rad,
            tool_axis=tool_axis,
            direction=direction,
            seed=seed,
            threads=threads,
            force=force,
        )
        summary = solve_file(request, for_stream(sys.stderr))
        print_summaries([summary], sys.stdout)
        typer.echo(f"results: {output}")
    if strict and summary.solved < summary.rows:
        raise typer.Exit(EXIT_NOT_ALL_SOLVED)


@app.command()
def info(
    robot: Annotated[
        str | None,
        typer.Argument(help="A bundled robot's name, or a .toml or .urdf file; all names if none."),
    ] = None,
) -> None:
    """Print a robot's joints, limits, reach, DH rows and source."""
    with _exit_codes():
        from .info import describe, list_robots

        typer.echo(list_robots() if robot is None else describe(robot))


@app.command()
def paper(
    name: Annotated[str, typer.Argument(help="strawberry or tomato.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")],
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds files.")
    ] = False,
) -> None:
    """Compute a paper's tables and figures anew and write them to a folder.

    Published values, where there are any, stand beside ours. Needs the extra `papers`.
    """
    with _exit_codes():
        from .paper import reproduce

        for file in reproduce(name, output, force=force):
            typer.echo(str(file))
