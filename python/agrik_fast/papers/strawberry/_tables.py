"""Tables 3 and 4 of the strawberry paper and its experiments, computed anew.

Tables here are in the paper's units (mm, mJ = N mm); the library's are m and J.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..._checks import FloatArray
from ...arms import Command, StrawberryArm
from ._published import (
    COLUMNS,
    EXPERIMENT_ROWS,
    GRIPPER_TIME,
    PUBLISHED_MEANS_S,
    PUBLISHED_TABLE4_S,
    SERVO_SPEED,
    SLIDE_SPEED,
    TABLE4_COLUMNS,
    TABLE4_TARGETS,
    Column,
    published,
    targets,
)


class Cell(NamedTuple):
    """One cell of table 3.

    Attributes
    ----------
    row : int
        Row, from 1.
    column : str
        ncos, ssas, as or exact.
    energy_mj : float
        Our energy index, mJ.
    published_mj : float
        The paper's; NaN for "exact".
    residual_mj : float
        Ours less the paper's.
    """

    row: int
    column: Column
    energy_mj: float
    published_mj: float
    residual_mj: float

    @property
    def matches(self) -> bool:
        """The residual is within the rounding of the print, with a little to spare."""
        return abs(self.residual_mj) <= 0.06


@dataclass(frozen=True, slots=True)
class Experiment:
    """One simulated run: out by the command sequence, and the time it takes."""

    row: int
    quadrant: int
    column: Column
    seconds: float
    steps: tuple[Command, ...]


def table3(arm: StrawberryArm | None = None, *, printed: bool = False) -> list[Cell]:
    """Return table 3 computed anew, beside the published energies."""
    arm = StrawberryArm() if arm is None else arm
    rows = published()
    cells = []
    for column in COLUMNS:
        energies = 1000 * arm.solve(targets(printed=printed), column).energy
        for number, (row, energy) in enumerate(zip(rows, energies.tolist(), strict=True), 1):
            paper = row.get(f"J_{column.upper()}", math.nan)
            cells.append(Cell(number, column, energy, paper, energy - paper))
    return cells


def execution_time(
    steps: Sequence[Command], start: FloatArray, slide_speed: float = SLIDE_SPEED
) -> float:
    """Return how long a command sequence takes, s, one step after the other."""
    at = dict(zip(("s10", "s21", "s32", "theta", "beta"), start.tolist(), strict=True))
    seconds = 0.0
    for step in steps:
        if step.axis == "gripper":
            seconds += GRIPPER_TIME
            continue
        speed = slide_speed if step.axis.startswith("s") else SERVO_SPEED
        seconds += abs(step.target - at.get(step.axis, 0.0)) / speed
        at[step.axis] = step.target
    return seconds


def experiments(slide_speed: float = SLIDE_SPEED) -> list[Experiment]:
    """Return the 24 experiments, 2 targets in each quadrant by 3 methods, as simulated."""
    arm = StrawberryArm()
    points = targets()
    runs = []
    for column in COLUMNS[:3]:
        solved = arm.solve(points, column)
        for place, row in enumerate(EXPERIMENT_ROWS):
            steps = tuple(arm.commands(solved.q[row - 1]))
            seconds = execution_time(steps, arm.reset_pose, slide_speed)
            runs.append(Experiment(row, place // 2 + 1, column, seconds, steps))
    return runs


def match_report(cells: Sequence[Cell], times: dict[Column, list[float]]) -> list[str]:
    """Return in Markdown which cells of table 3 match, which do not, and the times."""
    rows = published()
    energies = {c: np.array([x.energy_mj for x in cells if x.column == c]) for c in COLUMNS}
    lines = [
        "# Table 3: what matches and what does not",
        "",
        "| column | within 0.06 mJ | largest residual, mJ | above NCOS, ours | paper "
        "| time a target, ours | paper |",
        "|---|---|---|---|---|---|---|",
    ]
    for column in COLUMNS:
        own = [cell for cell in cells if cell.column == column]
        mean = float(np.mean(times[column]))
        time = f"{mean / 1e6:.1f} ms" if column == "ncos" else f"{mean:.0f} ns"
        above = 100 * float(np.mean(energies[column] / energies["ncos"] - 1))
        if column == "exact":
            lines.append(f"| exact | not in the paper | | {abs(above):.2f} % | | {time} | |")
            continue
        worst = max(own, key=lambda cell: abs(cell.residual_mj))
        count = sum(cell.matches for cell in own)
        paper = np.mean([row.get(f"dJ_{column.upper()}_pct", 0.0) for row in rows])
        seconds = np.mean([row[f"t_{column.upper()}"] for row in rows])
        lines.append(
            f"| {column} | {count} of {len(own)} | {worst.residual_mj:+.3f} | {above:.2f} % "
            f"| {paper:.2f} % | {time} | {1000 * seconds:.1f} ms |"
        )
    apart = np.abs(energies["exact"] - energies["ncos"]).max()
    missed = [cell.row for cell in cells if cell.column == "as" and not cell.matches]
    lines += [
        "",
        f"SLSQP and the exact minimum differ by at most {apart:.1e} mJ. AS rows that do not "
        f"match: {', '.join(map(str, missed))}: there s10 is at its lower limit, and no rule "
        "of the text gives the printed values. SSAS matches nowhere: the published values "
        "are lower by a constant a quadrant, which the text does not explain. Times are means "
        "over the targets, ours in a batch on one thread (NCOS alone); the paper's are "
        "MATLAB's on a processor of 2008 and are no measure of ours.",
        "",
        "Fitted to this table, and so no evidence for it: the friction force, the total mass, "
        "the sphere of targets, one constant of the frame (all by the NCOS column), and the "
        "mass of the outer link with theta = 0.01 rad (by AS less NCOS).",
    ]
    return lines


def table3_rows(
    cells: Sequence[Cell], times: dict[Column, list[float]]
) -> list[tuple[object, ...]]:
    """Return the lines of ``table3.csv``; what the paper does not have is empty."""
    rows, points = published(), 1000 * targets()
    least = {cell.row: cell.energy_mj for cell in cells if cell.column == "ncos"}
    lines: list[tuple[object, ...]] = []
    for cell in cells:
        i, name = cell.row - 1, cell.column.upper()
        above = 100 * (cell.energy_mj / least[cell.row] - 1)
        theirs: tuple[object, ...] = ("", "", "", "", "")
        saved = 100 * (1 - times[cell.column][i] / times["ncos"][i])
        saved_printed: object = ""
        if cell.column != "exact":
            printed = rows[i].get(f"dJ_{name}_pct", 0.0), rows[i][f"t_{name}"]
            saved_printed = rows[i].get(f"dt_{name}_pct", 0.0)
            residual = f"{cell.residual_mj:.4f}"
            theirs = cell.published_mj, residual, cell.matches, *printed
        lines.append(
            (
                cell.row,
                *(f"{x:.4f}" for x in points[i]),
                cell.column,
                f"{cell.energy_mj:.6f}",
                *theirs[:3],
                f"{above:.3f}",
                theirs[3],
                f"{times[cell.column][i] / 1e9:.3g}",
                theirs[4],
                f"{saved:.4f}",
                saved_printed,
            )
        )
    return lines


def table4_rows(arm: StrawberryArm) -> list[tuple[object, ...]]:
    """Return the lines of ``table4.csv``: the poses, and how long they take to reach."""
    lines: list[tuple[object, ...]] = []
    for target, seconds in zip(TABLE4_TARGETS, PUBLISHED_TABLE4_S, strict=True):
        for column in TABLE4_COLUMNS:
            solved = arm.solve(target, column)
            time = execution_time(arm.commands(solved.q), arm.reset_pose)
            pose = (*(1000 * solved.q[:3]), *np.degrees(solved.q[3:]))
            lines.append(
                (
                    *(f"{1000 * x:.1f}" for x in target),
                    column,
                    *(f"{x:.3f}" for x in pose),
                    f"{1000 * float(solved.energy):.3f}",
                    f"{time:.3f}",
                    seconds.get(column, ""),
                )
            )
    return lines


def experiment_report(runs: Sequence[Experiment]) -> list[str]:
    """Return in Markdown the mean times of the experiments beside the published ones."""
    slow = experiments(SLIDE_SPEED / 2)
    lines = [
        "# Experiments: simulated execution times",
        "",
        f"{len(runs)} runs, 2 targets in each of 4 quadrants by 3 methods, from home to the "
        "closed gripper. Axes move one after the other as in remark 3, slides at "
        f"{100 * SLIDE_SPEED:.1f} cm/s (the motors' highest speed), servos at 60 degrees in "
        f"{math.radians(60) / SERVO_SPEED:.2f} s, the gripper in {GRIPPER_TIME} s (assumed). The "
        "last column, half that slide speed, shows how far the published times are from the "
        "motors' limit. The order of the methods is not the paper's: NCOS moves s21 less than "
        "the others do, and nothing in the text makes it slower.",
        "",
        "| method | simulated mean, s | published mean, s | at half speed, s |",
        "|---|---|---|---|",
    ]
    for column in COLUMNS[:3]:
        full = np.mean([run.seconds for run in runs if run.column == column])
        half = np.mean([run.seconds for run in slow if run.column == column])
        lines.append(f"| {column} | {full:.2f} | {PUBLISHED_MEANS_S[column]:.3f} | {half:.2f} |")
    return lines
