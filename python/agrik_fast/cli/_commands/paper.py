"""The papers' tables and figures."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from ...papers import PAPERS
from .._exits import exit_codes, say, telling


def paper(
    name: Annotated[
        str, typer.Argument(help=f"Whose paper: {', '.join(PAPERS)}, or all of them: all.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")],
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds files.")
    ] = False,
    experiments: Annotated[
        str | None,
        typer.Option(
            help="Strawberry: its 24 experiments by a model of their times (model, the default), "
            "or also on the board's program in a simulator (firmware)."
        ),
    ] = None,
) -> None:
    """Compute a paper's tables and figures anew and write them to a folder.

    Published values, where there are any, stand beside ours. `all` gives each paper a folder,
    and one page, index.html, with every table and picture. Needs the extra `papers`.
    """
    with exit_codes() as kept:
        from .._paper import ALL, check, reproduce
        from ..progress import for_stream

        check(name, output, force=force, experiments=experiments)
        kept.what = lambda: f"files that were finished are in {output}"
        if name == ALL:
            with for_stream(sys.stderr) as bar:
                bar.start("papers", len(PAPERS))
                files = reproduce(
                    name,
                    output,
                    bar.note,
                    done=lambda _: bar.advance(1),
                )
        else:
            files = reproduce(
                name,
                output,
                lambda line: say(f"{name}: {line}"),
                experiments=experiments,
            )
        with telling(f"files: {output}"):
            for file in files:
                typer.echo(str(file))
