"""Options that all jobs of ``agrik-fast cluster`` share, and commands made of them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ._exits import NOT_ALL_SOLVED, PARTITIONS_FAILED, exit_codes, say, telling
from ._options import robot_names
from ._usage import refuses

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
    str,
    typer.Option(
        "--robot",
        "-r",
        help="A robot's name (see `agrik-fast robots`), or a .toml, .urdf or .xacro file.",
        autocompletion=robot_names,
    ),
]

# Names, kinds and defaults, in the order of the help.
_RUN: dict[str, tuple[Any, Any]] = {
    "generate": (
        Annotated[
            Path | None,
            typer.Option(help="Make the rows from this TOML file, where they are needed."),
        ],
        None,
    ),
    "workers": (
        Annotated[
            int | None,
            typer.Option(min=1, help="Processes on this machine; by default one per core."),
        ],
        None,
    ),
    "threads": (Annotated[int, typer.Option(min=1, help="Threads of each worker.")], 1),
    "scheduler": (
        Annotated[
            str | None,
            typer.Option(
                help="Work on a Dask cluster: its scheduler, tcp://HOST:PORT or tls://HOST:PORT."
            ),
        ],
        None,
    ),
    "tls_ca": (
        Annotated[Path | None, typer.Option(help="TLS: certificate of the authority (PEM).")],
        None,
    ),
    "tls_cert": (
        Annotated[Path | None, typer.Option(help="TLS: certificate of this side (PEM).")],
        None,
    ),
    "tls_key": (Annotated[Path | None, typer.Option(help="TLS: key of this side (PEM).")], None),
    "insecure": (
        Annotated[
            bool,
            typer.Option("--insecure", help="Allow a scheduler of another machine without TLS."),
        ],
        False,
    ),
    "timeout": (
        Annotated[float, typer.Option(help="Seconds that the scheduler has to answer.")],
        10.0,
    ),
    "shard": (
        Annotated[
            str | None,
            typer.Option(help="i/N: only partitions whose number leaves i when divided by N."),
        ],
        None,
    ),
    "rows": (
        Annotated[
            int,
            typer.Option(
                min=1, help="Rows of a partition; larger files are cut between row groups."
            ),
        ],
        1_000_000,
    ),
    "retries": (
        Annotated[int, typer.Option(min=0, help="Further attempts at a partition that fails.")],
        2,
    ),
    "simd": (
        Annotated[str | None, typer.Option(help="Instruction set: scalar, neon, avx2 or avx512.")],
        None,
    ),
    "allow_mixed": (
        Annotated[
            bool,
            typer.Option("--allow-mixed", help="Let workers differ in their instruction sets."),
        ],
        False,
    ),
    "force": (
        Annotated[
            bool, typer.Option("--force", help="Replace results of another job or source in OUT.")
        ],
        False,
    ),
    "strict": (
        Annotated[bool, typer.Option("--strict", help="Exit with 3 unless every row went well.")],
        False,
    ),
    "log": (
        Annotated[
            Path | None, typer.Option(help="Append every event to this file, as JSON lines.")
        ],
        None,
    ),
}

Job = Callable[..., Any]
"""Runs a job: called with the source, the target and options of `agrik_fast.cluster.run`."""


def job_command(
    app: typer.Typer, success: str, **unfit: str
) -> Callable[[Callable[..., Job]], Any]:
    """Make a command of a function that makes a job of the options that are its own.

    Parameters
    ----------
    app : Typer
        Where the command goes, by the function's name.
    success : str
        Which of the job's counts is the number of rows that went well.
    **unfit : str
        Options of other commands that mean nothing here, and why, as for `refuses`.
    """

    def command(make: Callable[..., Job]) -> Any:
        def run(paths: list[str], **given: Any) -> None:
            with exit_codes() as kept:
                from ._cluster import options_of, run_words

                common = {name: given.pop(name) for name in _RUN}
                strict, log = common.pop("strict"), common.pop("log")
                tls = tuple(common.pop(f"tls_{name}") for name in ("ca", "cert", "key"))
                common["scheduler_timeout"] = common.pop("timeout")
                common["partition_rows"] = common.pop("rows")
                options = options_of(tls=tls, **common)
                summary = run_words(lambda: make(**given), paths, options, log, kept)
                _tell(summary, success, strict)

        kind = inspect.Parameter.KEYWORD_ONLY
        own = inspect.signature(make, eval_str=True).parameters.values()
        parameters = [
            inspect.Parameter("paths", kind, annotation=Paths),
            *(each.replace(kind=kind) for each in own),
            *(
                inspect.Parameter(name, kind, annotation=annotation, default=default)
                for name, (annotation, default) in _RUN.items()
            ),
        ]
        # What typer reads options from.
        vars(run)["__signature__"] = inspect.Signature(parameters)
        run.__annotations__ = {each.name: each.annotation for each in parameters}
        run.__doc__, run.__name__ = make.__doc__, make.__name__
        return app.command(make.__name__)(refuses(**unfit)(run))

    return command


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
