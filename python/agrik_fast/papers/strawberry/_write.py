"""Files of the strawberry paper's tables."""

from __future__ import annotations

from pathlib import Path

from ...arms import StrawberryArm
from .._output import write_csv, write_text
from ._experiments import experiments
from ._problem1 import problem1, write_problem1
from ._quadrants import quadrant_report, quadrant_times
from ._starts import guess_report, guesses, write_guesses
from ._tables import (
    experiment_report,
    match_report,
    table3,
    table3_rows,
    table4_rows,
)
from ._times import Times, time_columns, time_report, times_ns


def write_tables(directory: Path, arm: StrawberryArm) -> list[Path]:
    """Write tables 3 and 4, the experiments and the report; return the files."""
    cells = table3(arm)
    times = times_ns(arm)
    runs = experiments()
    steps = []
    for run in runs:
        shown = [f"{step.axis}={step.target:.5f}" for step in run.steps]
        point = [f"{1000 * x:.1f}" for x in run.target]
        steps.append((run.number, *point, run.quadrant, run.column, f"{run.seconds:.3f}", *shown))
    columns = time_columns(times)
    guessed, readings = guesses(arm), problem1(arm)
    report = [
        *match_report(cells, times),
        "",
        *time_report(columns),
        "",
        *guess_report(guessed),
        "",
        *experiment_report(runs),
        "",
        *quadrant_report(quadrant_times(runs)),
    ]
    energies = ["J_mJ", "J_published_mJ", "residual_mJ", "matches"]
    more = ["above_ncos_percent", "above_ncos_published_percent", "time_s", "time_published_s"]
    more += ["time_saved_percent", "time_saved_published_percent"]
    pose = ["s10_mm", "s21_mm", "s32_mm", "theta_deg", "beta_deg"]
    return [
        write_csv(
            directory / "table3.csv",
            ["row", "x_mm", "y_mm", "z_mm", "column", *energies, *more],
            table3_rows(cells, times),
        ),
        write_csv(
            directory / "table4.csv",
            ["x_mm", "y_mm", "z_mm", "column", *pose, "J_mJ", "time_s", "time_published_s"],
            table4_rows(arm),
        ),
        write_csv(
            directory / "experiments.csv",
            [
                *("run", "x_mm", "y_mm", "z_mm", "quadrant", "column", "time_s"),
                *(f"step{i}_m_or_rad" for i in range(1, 10)),
            ],
            steps,
        ),
        write_csv(
            directory / "table3_times.csv",
            Times._fields,
            [(row.column, *(f"{x:.6g}" for x in row[1:])) for row in columns],
        ),
        write_csv(
            directory / "quadrants.csv",
            ["quadrant", "column", "distance_m", "time_s"],
            [
                (row.quadrant, row.column, f"{row.distance:.4f}", f"{row.seconds:.3f}")
                for row in quadrant_times(runs)
            ],
        ),
        write_problem1(directory, readings),
        *write_guesses(directory, guessed),
        write_text(directory / "report.md", report),
    ]
