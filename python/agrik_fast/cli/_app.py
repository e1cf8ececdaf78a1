"""The program ``agrik-fast``: its commands in the order of its help."""

from __future__ import annotations

from typing import Annotated

import typer

from . import _commands
from ._cluster_app import app as cluster_app
from ._exits import run, telling
from ._usage import OneLineGroup

app = typer.Typer(
    name="agrik-fast",
    cls=OneLineGroup,
    help="Fast, verified inverse kinematics for serial robot arms.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.add_typer(cluster_app, name="cluster")


def main() -> None:
    """Run the command line and exit with its status.

    Examples
    --------
    >>> import subprocess, sys
    >>> command = [sys.executable, "-m", "agrik_fast.cli", "robots"]
    >>> "ur5" in subprocess.run(command, capture_output=True, text=True).stdout
    True
    """
    run(lambda: app(prog_name="agrik-fast"))


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        with telling():
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


app.command(cls=_commands.SolveCommand)(_commands.solve)
for _each in (
    _commands.info,
    _commands.robots,
    _commands.solvers,
    _commands.convert,
    _commands.schema,
    _commands.tune,
    _commands.harvest,
    _commands.view,
    _commands.plan,
    _commands.paper,
    _commands.detect,
    _commands.drive,
):
    app.command()(_each)
