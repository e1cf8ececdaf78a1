"""The commands ``agrik-fast cluster ...``. As in `_app`, only typer is imported here."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ._exits import NOT_ALL_SOLVED, PARTITIONS_FAILED, exit_codes, say, telling

app = typer.Typer(
    help="Many targets on many processes or machines: resumable, every result exactly once.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Paths = Annotated[
    list[str],
    typer.Argument(
        metavar="[IN] OUT",
        help="IN: a folder of Parquet files, a Parquet file, or results of another job; not with "
        "--generate. OUT: the folder for results. Paths, or URLs such as s3://bucket/name.",
    ),
]
Place = Annotated[str, typer.Argument(help="Folder of results, or its URL.")]
RobotOption = Annotated[
    str, typer.Option("--robot", "-r", help="A bundled robot's name, or a .toml or .urdf file.")
]
Generate = Annotated[
    Path | None, typer.Option(help="Make the rows from this TOML file, where they are needed.")
]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Processes on this machine; by default one per core.")
]
Threads = Annotated[int, typer.Option(min=1, help="Threads of each worker.")]
Scheduler = Annotated[
    str | None,
    typer.Option(help="Work on a Dask cluster: its scheduler, tcp://HOST:PORT or tls://HOST:PORT."),
]
TlsCa = Annotated[Path | None, typer.Option(help="TLS: certificate of the authority (PEM).")]
TlsCert = Annotated[Path | None, typer.Option(help="TLS: certificate of this side (PEM).")]
TlsKey = Annotated[Path | None, typer.Option(help="TLS: key of this side (PEM).")]
Insecure = Annotated[
    bool, typer.Option("--insecure", help="Allow a scheduler of another machine without TLS.")
]
Timeout = Annotated[float, typer.Option(help="Seconds that the scheduler has to answer.")]
Shard = Annotated[
    str | None,
    typer.Option(help="i/N: only partitions whose number leaves i when divided by N."),
]
Rows = Annotated[
    int, typer.Option(min=1, help="Rows of a partition; larger files are cut between row groups.")
]
Retries = Annotated[int, typer.Option(min=0, help="Further attempts at a partition that fails.")]
Simd = Annotated[str | None, typer.Option(help="Instruction set: scalar, neon, avx2 or avx512.")]
AllowMixed = Annotated[
    bool,
    typer.Option("--allow-mixed", help="Let workers differ in their instruction sets."),
]
Force = Annotated[
    bool, typer.Option("--force", help="Replace results of another job or source in OUT.")
]
Log = Annotated[Path | None, typer.Option(help="Append every event to this file, as JSON lines.")]
Strict = Annotated[bool, typer.Option("--strict", help="Exit with 3 unless every row is solved.")]


@app.command()
def solve(
    paths: Paths,
    robot: RobotOption,
    task: Annotated[
        str | None,
        typer.Option(help="position, pose or axis; by default pose if there are orientations."),
    ] = None,
    solver: Annotated[str, typer.Option(help="As of `agrik-fast solve`.")] = "lm",
    tol: Annotated[float, typer.Option(help="Position tolerance in metres.")] = 1e-6,
    tol_rad: Annotated[float, typer.Option(help="Orientation tolerance in radians.")] = 1e-6,
    tool_axis: Annotated[
        str, typer.Option(help="Axis task: tool axis, such as z, -x or 0,0.6,0.8.")
    ] = "z",
    direction: Annotated[
        str | None,
        typer.Option(help="Axis task: where the tool axis points, such as -z or 0,0,-1."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the restarts.")] = 0,
    generate: Generate = None,
    workers: Workers = None,
    threads: Threads = 1,
    scheduler: Scheduler = None,
    tls_ca: TlsCa = None,
    tls_cert: TlsCert = None,
    tls_key: TlsKey = None,
    insecure: Insecure = False,
    timeout: Timeout = 10.0,
    shard: Shard = None,
    rows: Rows = 1_000_000,
    retries: Retries = 2,
    simd: Simd = None,
    allow_mixed: AllowMixed = False,
    force: Force = False,
    strict: Strict = False,
    log: Log = None,
) -> None:
    """Solve all targets of a folder of Parquet files, partition by partition.

    Called again, it goes on where it was cut off, whatever cut it off, and the results are the
    same bytes. Exit status: 0 all partitions are there, 2 bad arguments or files (nothing was
    started), 3 some rows are not solved (with --strict), 4 some partitions failed or the
    scheduler was lost, 130 interrupted, 143 terminated.
    """
    with exit_codes() as kept:
        from ._cluster import options_of, run_words
        from ._solve import parse_axis

        given = {
            "task": task,
            "solver": solver,
            "position_tolerance": tol,
            "orientation_tolerance": tol_rad,
            "tool_axis": parse_axis("--tool-axis", tool_axis),
            "direction": None if direction is None else parse_axis("--direction", direction),
            "seed": seed,
        }
        options = options_of(
            generate=generate,
            workers=workers,
            threads=threads,
            scheduler=scheduler,
            tls=(tls_ca, tls_cert, tls_key),
            insecure=insecure,
            scheduler_timeout=timeout,
            shard=shard,
            partition_rows=rows,
            retries=retries,
            simd=simd,
            allow_mixed=allow_mixed,
            force=force,
        )
        summary = run_words("solve", paths, robot, given | options, log, kept)
        _tell(summary, "converged", strict)


@app.command()
def forward(
    paths: Paths,
    robot: RobotOption,
    generate: Generate = None,
    workers: Workers = None,
    threads: Threads = 1,
    scheduler: Scheduler = None,
    tls_ca: TlsCa = None,
    tls_cert: TlsCert = None,
    tls_key: TlsKey = None,
    insecure: Insecure = False,
    timeout: Timeout = 10.0,
    shard: Shard = None,
    rows: Rows = 1_000_000,
    retries: Retries = 2,
    simd: Simd = None,
    allow_mixed: AllowMixed = False,
    force: Force = False,
    strict: Strict = False,
    log: Log = None,
) -> None:
    """Work out the tool's pose for all joint values, in columns that `cluster solve` reads.

    The columns read are those of result files: a joint's name with its unit (theta_rad, s10_m).
    Everything else is as for `cluster solve`.
    """
    with exit_codes() as kept:
        from ._cluster import options_of, run_words

        options = options_of(
            generate=generate,
            workers=workers,
            threads=threads,
            scheduler=scheduler,
            tls=(tls_ca, tls_cert, tls_key),
            insecure=insecure,
            scheduler_timeout=timeout,
            shard=shard,
            partition_rows=rows,
            retries=retries,
            simd=simd,
            allow_mixed=allow_mixed,
            force=force,
        )
        summary = run_words("forward", paths, robot, options, log, kept)
        _tell(summary, "finite", strict)


def _tell(summary: Any, good: str, strict: bool) -> None:
    from ._cluster import lines_of

    with telling(f"results: {summary.place}"):
        for line in lines_of(summary):
            typer.echo(line)
    if summary.failures:
        first = summary.failures[0]
        say(
            f"agrik-fast: {len(summary.failures)} of {summary.partitions} partitions failed, "
            f"first {first.name}: {first.error}; the list is in {summary.place}, the same command "
            "tries them again"
        )
        raise typer.Exit(PARTITIONS_FAILED)
    if strict and summary.counts.get(good, 0) < summary.rows:
        raise typer.Exit(NOT_ALL_SOLVED)


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
