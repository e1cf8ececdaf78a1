"""All files of the paper on redundant7."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from . import _figures, _tables
from ._field_jobs import write_jobs
from ._scalability import scalability, verdict, write_scalability
from ._tables import write_report, write_table

REPEATS = 1000
"""Seeds of the long repetitive test, targets of the comparison, runs a row of the ablation."""

SCALED = 200
"""Most targets an arm in the table of scalability."""


def reproduce(
    directory: str | Path, repeats: int = REPEATS, report: Callable[[str], None] | None = None
) -> list[Path]:
    """Write the tables (CSV), figures (PNG, SVG) and the report of the paper.

    Parameters
    ----------
    directory : str or path
        Where to; made if it does not exist.
    repeats : int, default 1000
        Runs behind each share of successes, >= 30; fewer are quicker and less certain.
    report : callable, optional
        Called with a line of text for each part that is done.

    Returns
    -------
    list of path
        The files written.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    say = report or (lambda _: None)
    files: list[Path] = []

    lengths = _tables.lengths()
    files += write_table(folder, "lengths", lengths)
    say("lengths and angles of the published joint vector (section 2)")

    single = _tables.single_point()
    files += write_table(folder, "single_point", single.table)
    files += _figures.convergence(folder, single)
    files += _figures.postures(folder, single.q)
    say(f"single-point test (figure 3): cost {single.costs[-1]:.2e} after 200 generations")

    repeated = _tables.repeated(max(repeats, 30))
    files += write_table(folder, "repeated", repeated.table)
    files += _figures.thirty(folder, repeated)
    files += _figures.histogram(folder, repeated)
    say(f"repetitive test (figure 4): {repeated.share:.1%} of {len(repeated.costs)} runs succeed")

    ablation = _tables.ablation(repeats)
    files += write_table(folder, "ablation", ablation)
    say("ablation of the recipe")
    comparison = _tables.comparison(repeats)
    files += write_table(folder, "comparison", comparison)
    say("differential evolution beside the step solver on random targets")
    scaled = scalability(min(repeats, SCALED))
    files += write_scalability(folder, scaled)
    say(f"scalability: {verdict(scaled)}")
    files += write_jobs(folder)
    say("a spray pass and cotton topping")
    tables = (lengths, single.table, repeated.table, ablation, comparison)
    files.append(write_report(folder, tables, [f"Scalability: {verdict(scaled)}"]))
    return files
