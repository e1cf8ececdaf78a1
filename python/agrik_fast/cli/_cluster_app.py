"""The commands ``agrik-fast cluster ...``. As in `_app`, only typer is imported here."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from . import _harvest_options as harvest_options
from . import _options
from ._cluster_options import Job, Place, RobotOption, job_command
from ._exits import PARTITIONS_FAILED, exit_codes, telling

app = typer.Typer(
    help="Many targets on many processes or machines: resumable, every result exactly once.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@job_command(app, "converged")
def solve(
    robot: RobotOption,
    task: _options.Task = None,
    solver: Annotated[
        str,
        typer.Option(help="As of `agrik-fast solve`.", autocompletion=_options.solver_names),
    ] = "lm",
    tol: Annotated[
        str, typer.Option(help="Position tolerance in metres; or three, along x, y, z.")
    ] = "1e-6",
    tol_rad: Annotated[
        str, typer.Option(help="Orientation tolerance in radians; or three, about x, y, z.")
    ] = "1e-6",
    tol_frame: Annotated[
        str | None, typer.Option(help="Whose axes three tolerances are for: base or tool.")
    ] = None,
    tool_axis: _options.ToolAxis = "z",
    direction: Annotated[
        str | None,
        typer.Option(help="Axis task: where the tool axis points, such as -z or 0,0,-1."),
    ] = None,
    mask: Annotated[
        str | None,
        typer.Option(help="Weights of the errors along and about x,y,z, such as 1,1,1,0,0,1."),
    ] = None,
    mask_frame: _options.MaskFrame = "base",
    q0: _options.StartValues = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    seed: _options.Seed = 0,
) -> Job:
    """Solve all targets of a folder of Parquet files, partition by partition.

    Called again, it goes on where it was cut off, whatever cut it off, and the results are the
    same bytes. Exit status: 0 all partitions are there, 2 bad arguments or files (nothing was
    started), 3 some rows are not solved (with --strict), 4 some partitions failed or the
    scheduler was lost, 130 interrupted, 143 terminated.
    """
    from ..cluster import solve as run
    from ._cluster import load
    from ._solve import parse_axis, parse_frame, parse_solver, parse_tolerance

    faults = _options.Faults()
    read: dict[str, Any] = {
        "solver": faults.of("--solver", solver, parse_solver),
        "position_tolerance": faults.of("--tol", tol, parse_tolerance),
        "orientation_tolerance": faults.of("--tol-rad", tol_rad, parse_tolerance),
        "tolerance_frame": faults.of("--tol-frame", tol_frame, parse_frame),
        "tool_axis": faults.of("--tool-axis", tool_axis, parse_axis),
        "direction": faults.of("--direction", direction, parse_axis),
        "mask": faults.of("--mask", mask, _options.weights),
        "mask_frame": faults.of("--mask-frame", mask_frame, parse_frame),
        "q0": faults.of("--q0", q0, _options.values),
    }
    place = faults.of("--tool", tool, _options.tool_numbers)
    faults.tell(lambda: ())
    arm = load(robot, base_link, tip_link, place, frame)
    return partial(run, robot=arm, task=task, seed=seed, **read)


@job_command(
    app,
    "finite",
    q0="joint values come from the rows",
    mask=_options.NO_SOLVING,
    solver=_options.NO_SOLVING,
)
def forward(
    robot: RobotOption,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
) -> Job:
    """Work out the tool's pose for all joint values, in columns that `cluster solve` reads.

    The columns read are those of result files: a joint's name with its unit (theta_rad, s10_m).
    Everything else is as for `cluster solve`.
    """
    from ..cluster import forward as run
    from ._cluster import load

    return partial(run, robot=load(robot, base_link, tip_link, _options.tool(tool), frame))


@job_command(
    app,
    "evaluated",
    q0="postures are looked for along the whole slide",
    mask=_options.BY_HARVEST["mask"],
    solver=_options.BY_HARVEST["solver"],
)
def harvest(
    robot: RobotOption = "cucumber",
    distance: harvest_options.DistanceOption = "exact",
    refine: harvest_options.Refine = True,
    recovery: harvest_options.Recovery = True,
    blockers: harvest_options.BlockersOption = True,
    tilt_deg: harvest_options.Tilt = 0.0,
    shift: harvest_options.Shift = 0.0,
    min_distance: harvest_options.MinDistance = 0.005,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
) -> Job:
    """Decide for the fruits of many crops which can be picked: a row for each crop.

    The columns read are `scene`, the path of a scene file, or arguments of a made-up greenhouse:
    `seed`, `plants`, `leaves`, `points`, `fruits`, `radius_m`, `y0_m`, `y1_m`, `stem_x_m`,
    `clear_from_m` and `clear_to_m`. Written are how many fruits there are, how many of them can
    be picked, what becomes of the others, and which leaves are in the way. Everything else is as
    for `cluster solve`.
    """
    from ..cluster import harvest as run
    from ..harvest import CropsJob
    from ._cluster import load
    from ._harvest import settings_of

    settings = settings_of(
        refine=refine,
        recovery=recovery,
        tilt_deg=tilt_deg,
        shift=shift,
        min_distance=min_distance,
    )
    arm = load(robot, base_link, tip_link, _options.tool(tool), frame)
    job = CropsJob(arm, settings, distance, blockers=blockers)
    return partial(run, job=job)


@app.command()
def split(
    targets: Annotated[Path, typer.Argument(help="Targets: .csv, .npy, .npz or .parquet.")],
    output: Annotated[Path, typer.Argument(metavar="IN", help="Folder for the Parquet files.")],
    rows: Annotated[int, typer.Option(min=1, help="Rows of each.")] = 1_000_000,
    force: Annotated[bool, typer.Option("--force", help="Replace files.")] = False,
) -> None:
    """Cut a target file of any kind into Parquet files, a partition each."""
    with exit_codes() as kept:
        from ..jobs import split_file

        kept.what = lambda: f"files that were finished are in {output}"
        files = split_file(targets, output, rows, force=force)
        with telling(f"files: {output}"):
            typer.echo(f"{len(files)} file{'' if len(files) == 1 else 's'} in {output}")


@app.command()
def status(place: Place) -> None:
    """Say how far a folder of results is, also while a job runs.

    Exit status: 0 complete, 4 not complete.
    """
    with exit_codes():
        from ..cluster import status as look
        from ._cluster import status_lines

        found = look(place)
        with telling():
            for line in status_lines(found):
                typer.echo(line)
        if not found.complete:
            raise typer.Exit(PARTITIONS_FAILED)


@app.command()
def verify(
    place: Place,
    keep: Annotated[
        bool, typer.Option("--keep", help="Only look: withdraw no records of damaged parts.")
    ] = False,
) -> None:
    """Read all results and compare them with the hashes in their records.

    What is damaged is listed, and its record withdrawn, so that the next start of the job makes
    it anew. Exit status: 0 all is as it was written, 4 it is not, or not complete.
    """
    with exit_codes():
        from ..cluster import verify as look

        found = look(place, keep=keep)
        with telling():
            for name, wrong in found.damaged.items():
                typer.echo(f"{name}: {wrong}")
            ending = "" if found.complete or found.damaged else "; the job is not complete"
            typer.echo(
                f"{found.parts} parts, {found.bytes} bytes: {len(found.damaged)} damaged{ending}"
            )
        if not found.complete:
            raise typer.Exit(PARTITIONS_FAILED)


@app.command()
def clean(
    place: Place,
    older: Annotated[
        float, typer.Option(min=0, help="Only what was not written to for so many seconds.")
    ] = 3600.0,
) -> None:
    """Remove temporary files that killed processes left behind."""
    with exit_codes():
        from ..cluster import clean as remove

        names = remove(place, older_s=older)
        with telling():
            for name in names:
                typer.echo(f"removed {name}")
            typer.echo(f"{len(names)} temporary file{'' if len(names) == 1 else 's'} removed")
