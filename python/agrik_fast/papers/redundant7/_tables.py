"""The runs behind the tables and figures, and the tables as files."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..._checks import FloatArray
from ...robot import Robot
from ...rotations import pose as pose_of
from ...rotations import zyz_differences, zyz_of
from ...solvers import DifferentialEvolution, GeneticAlgorithm, LevenbergMarquardt, Solver
from .._output import write_csv, write_text
from ._published import (
    ANGLES,
    FITTED_LENGTHS,
    POSITION,
    PUBLISHED_COST,
    PUBLISHED_MEAN,
    PUBLISHED_Q,
)

TOLERANCE: dict[str, Any] = {"position_tolerance": 1e-4, "orientation_tolerance": 1e-3}
"""A run succeeds within 0.1 mm and 1e-3 rad."""
NEAR_LIMIT = 1e-3
"""A joint within so much of a limit, rad, counts as at the limit."""


@dataclass(frozen=True)
class Table:
    """Rows of text under a heading each."""

    title: str
    columns: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


@dataclass(frozen=True)
class SinglePoint:
    """The single-point test: best cost by generation, of one run and of the median run.

    Attributes
    ----------
    costs, median : ndarray, shape (generations + 1,)
        Cost of the run that is shown, and the median of all runs.
    q : ndarray, shape (7,), rad
        Joint values of the run that is shown.
    table : Table
        Beside the paper's numbers.
    """

    costs: FloatArray
    median: FloatArray
    q: FloatArray
    table: Table


@dataclass(frozen=True)
class Repeated:
    """The repetitive test: final costs in the order of the seeds, and which succeeded."""

    costs: FloatArray
    success: NDArray[np.bool_]
    table: Table

    @property
    def share(self) -> float:
        """Share of runs that succeeded."""
        return float(self.success.mean())


def arm() -> Robot:
    """Return the arm of Table I."""
    return Robot.load("redundant7")


def fitted_arm() -> Robot:
    """Return the arm with the lengths that fit the published answer."""
    table = arm()
    rows = table.dh or ()
    lengths = dict(zip((0, 2, 4, 6), FITTED_LENGTHS, strict=True))
    dh = [(row.a, row.alpha, lengths.get(i, row.d), row.theta) for i, row in enumerate(rows)]
    limits = np.stack([table.lower, table.upper], axis=1)
    return Robot.from_dh(dh, limits=limits, name="redundant7-fitted")


def target() -> FloatArray:
    """Return the paper's target as a pose."""
    return pose_of(POSITION, zyz=ANGLES)


def cost(robot: Robot, q: ArrayLike, pose: FloatArray) -> FloatArray:
    """Return the published cost (9) in the adopted weights: mm + 100 rad of ZYZ angles."""
    found = robot.fk(q)
    distance = np.linalg.norm(found[..., :3, 3] - pose[:3, 3], axis=-1)
    angles = zyz_differences(zyz_of(found).angles, zyz_of(pose).angles)
    total: FloatArray = 1000.0 * distance + 100.0 * np.linalg.norm(angles, axis=-1)
    return total


def lengths() -> Table:
    """Return where the published joint vector leads, with both sets of lengths."""
    rows: list[tuple[str, ...]] = [
        ("the paper", "334.000", "471.000", "539.000", "1.57080", "0.78540", "0.52360")
    ]
    for name, robot in (("Table I", arm()), ("d = 400, 450, 450, 200 mm", fitted_arm())):
        pose = robot.fk(PUBLISHED_Q)
        position = [f"{1000 * x:.3f}" for x in pose[:3, 3]]
        angles = [f"{x:.5f}" for x in zyz_of(pose).angles]
        rows.append((name, *position, *angles))
    columns = ("lengths", "x [mm]", "y [mm]", "z [mm]", "alpha", "beta", "gamma")
    return Table("Where the published joint vector leads", columns, [tuple(r) for r in rows])


def single_point(curves: int = 30) -> SinglePoint:
    """Run the single-point test, and some more for the median curve."""
    robot, pose, recipe = arm(), target(), DifferentialEvolution.paper()
    all_costs = np.stack([robot.cost_history(pose, recipe, seed=seed) for seed in range(curves)])
    final = all_costs[:, -1]
    # The run that stands for the others: the median one.
    seed = int(np.argsort(final)[curves // 2])
    shown = all_costs[seed]
    q = robot.ik(pose, solver=recipe, seed=seed).q
    median = np.median(all_costs, axis=0)

    def first_below(share: float) -> str:
        return str(int(np.argmax(median < share * median[0])))

    started = time.thread_time()
    robot.ik(np.broadcast_to(pose, (100, 4, 4)), solver=recipe, threads=1)
    each = (time.thread_time() - started) / 100
    rows = [
        ("cost after 200 generations", f"{PUBLISHED_COST:.2e}", f"{shown[-1]:.2e}"),
        ("generations to 1 % of the first cost", "about 80 (by eye)", first_below(1e-2)),
        ("generations to 1e-4 of the first cost", "", first_below(1e-4)),
        ("time of a solve", "0.93 s (i7-8700K)", f"{1000 * each:.2f} ms (one thread)"),
        ("joint values [rad]", _list(np.array(PUBLISHED_Q)), _list(q)),
        (
            "fitness of these joint values",
            *(f"{cost(robot, x, pose):.2e}" for x in (PUBLISHED_Q, q)),
        ),
        ("position by Table I [mm]", *(_list(1000 * robot.fk(x)[:3, 3]) for x in (PUBLISHED_Q, q))),
        (
            "ZYZ angles by Table I [rad]",
            *(_list(zyz_of(robot.fk(x)).angles) for x in (PUBLISHED_Q, q)),
        ),
        (
            "the same as the paper prints them",
            "334.0000, 471.0000, 539.0000; 1.5708, 0.7854, 0.5236",
            "",
        ),
    ]
    return SinglePoint(
        shown, median, q, Table("Single-point test", ("measure", "paper", "here"), rows)
    )


def _list(values: FloatArray) -> str:
    """Return numbers to four places, as the paper prints them."""
    return ", ".join(f"{value:.4f}" for value in values)


def repeated(runs: int) -> Repeated:
    """Run the repetitive test on as many seeds."""
    robot, pose = arm(), target()
    result = robot.ik(
        np.broadcast_to(pose, (runs, 4, 4)), solver=DifferentialEvolution.paper(), **TOLERANCE
    )
    costs, good = cost(robot, result.q, pose), result.success
    stuck = result.q[~good]
    edge = np.minimum(stuck - robot.lower, robot.upper - stuck) < NEAR_LIMIT
    by_joint = ", ".join(f"q{i + 1}: {n}" for i, n in enumerate(edge.sum(axis=0).tolist()) if n)
    thirty, fine = costs[:30], good[:30]
    rows = [
        ("mean cost of 30 runs", f"{PUBLISHED_MEAN:.2e}", f"{thirty.mean():.2e}"),
        ("of those that succeed", "", f"{thirty[fine].mean():.2e}"),
        ("stuck among 30", "0", str(int((~fine).sum()))),
        (f"success of {runs} runs", "", f"{good.mean():.1%}"),
        ("median cost", "", f"{np.median(costs):.2e}"),
        ("mean cost of those that succeed", "", f"{costs[good].mean():.2e}"),
        ("stuck with a joint at a limit", "", f"{int(edge.any(axis=1).sum())} of {len(stuck)}"),
        ("joints at their limit", "", by_joint or "none"),
        ("chance that 30 runs succeed", "", f"{good.mean() ** 30:.0%}"),
    ]
    return Repeated(costs, good, Table("Repetitive test", ("measure", "paper", "here"), rows))


def variants() -> list[tuple[str, DifferentialEvolution, str]]:
    """Return the rows of the ablation: name, solver, share by an independent program in %."""
    paper = DifferentialEvolution.paper()
    base = dataclasses.replace(paper, redraw="individual")

    def varied(**changes: Any) -> DifferentialEvolution:
        return dataclasses.replace(base, **changes)

    def per_mm(weight: float) -> DifferentialEvolution:
        return varied(position_weight=1000.0 * weight, orientation_weight=1.0)

    high: dict[str, Any] = {"crossover": (0.9, 0.9)}
    return [
        ("published: rate per gene, median", paper, "93.4"),
        ("rate per individual (base of the rows below)", base, "92.9"),
        ("rate per generation", varied(redraw="generation"), "92.3"),
        ("constant rate 0.75", varied(crossover=(0.75, 0.75)), "92.3"),
        ("constant rate 0.9", varied(crossover=(0.9, 0.9)), "88.0"),
        ("constant rate 1", varied(crossover=(1.0, 1.0)), "47.7"),
        ("boundary: clamp", varied(boundary="clamp"), "78.7"),
        ("boundary: reflect", varied(boundary="reflect"), "89.0"),
        ("boundary: redraw", varied(boundary="redraw"), "95.7"),
        ("rand/1, 200 generations", varied(mutation="rand1"), "0.0"),
        ("rand/1, 600 generations", varied(mutation="rand1", generations=600), "95.0"),
        ("current-to-best/1", varied(mutation="current-to-best1"), "97.7"),
        ("jDE from rate 0.9, best/1", varied(adaptation="jde", **high), "89.7"),
        (
            "jDE from rate 0.9, current-to-best/1",
            varied(adaptation="jde", mutation="current-to-best1", **high),
            "76.7",
        ),
        ("L-SHADE, 20,100 evaluations", varied(adaptation="lshade"), ""),
        ("50 individuals", varied(population=50), "91.3"),
        ("200 individuals", varied(population=200), "92.0"),
        ("weights 1 per mm, 1 per rad", per_mm(1.0), "0.7"),
        ("weights 0.1 per mm, 1 per rad", per_mm(0.1), "22.7"),
        ("weights 0.001 per mm, 1 per rad", per_mm(0.001), "89.3"),
        ("rotation vector", varied(orientation="rotation-vector"), "94.0"),
    ]


def ablation(runs: int) -> Table:
    """Return the share of runs that succeed for each variation of the recipe."""
    pose = target()
    poses = np.broadcast_to(pose, (runs, 4, 4))
    robot, fitted = arm(), fitted_arm()
    rows = []
    cases: list[tuple[str, Robot, DifferentialEvolution, str]] = [
        (name, robot, solver, reference) for name, solver, reference in variants()
    ]
    base = dataclasses.replace(DifferentialEvolution.paper(), redraw="individual")
    cases.append(("d = 400, 450, 450, 200 mm", fitted, base, "89.3"))
    for name, machine, solver, reference in cases:
        result = machine.ik(poses, solver=solver, **TOLERANCE)
        share = 100 * float(result.success.mean())
        deviation = math.sqrt(share * (100 - share) / runs)
        median = float(np.median(cost(machine, result.q, pose)))
        rows.append((name, reference, f"{share:.1f} ± {deviation:.1f}", f"{median:.1e}"))
    columns = ("variant", "reference [%]", "success [%]", "median cost")
    return Table(f"Ablation, {runs} runs each", columns, rows)


def comparison(count: int) -> Table:
    """Return success and time of several solvers on random reachable targets."""
    robot = arm()
    poses = robot.fk(robot.random_q(count, seed=20))
    paper = DifferentialEvolution.paper()
    fine: dict[str, Any] = {"position_tolerance": 1e-6, "orientation_tolerance": 1e-6}
    cases: Sequence[tuple[str, Solver, dict[str, Any], str]] = [
        ("published, to 0.1 mm and 1e-3 rad", paper, TOLERANCE, "91.7"),
        ("published, to 1e-6 m and 1e-6 rad", paper, fine, ""),
        ("L-SHADE, to 0.1 mm and 1e-3 rad", _lshade(paper), TOLERANCE, "77.3"),
        ("step solver, one start", LevenbergMarquardt(max_restarts=0), fine, "63.4"),
        ("step solver (default)", LevenbergMarquardt(), fine, "99.9"),
        ("memetic differential evolution", DifferentialEvolution(), fine, "99.8"),
        ("memetic genetic algorithm", GeneticAlgorithm(), fine, ""),
    ]
    rows = []
    for name, solver, tolerance, reference in cases:
        started = time.thread_time()
        result = robot.ik(poses, solver=solver, threads=1, **tolerance)
        each = (time.thread_time() - started) / count
        rows.append(
            (
                name,
                reference,
                f"{100 * result.success.mean():.1f}",
                f"{result.restarts.mean():.2f}",
                f"{1e6 * each:.0f}",
            )
        )
    columns = ("solver", "reference [%]", "success [%]", "restarts", "us a target, one thread")
    return Table(f"{count} random targets", columns, rows)


def _lshade(paper: DifferentialEvolution) -> DifferentialEvolution:
    return dataclasses.replace(paper, adaptation="lshade", orientation="rotation-vector")


def write_table(folder: Path, name: str, content: Table) -> list[Path]:
    """Write a table; return its files."""
    return [write_csv(folder / f"{name}.csv", content.columns, content.rows)]


def write_report(folder: Path, tables: Sequence[Table], remarks: Sequence[str]) -> Path:
    """Write all tables as Markdown, and remarks, into the paper's report."""
    lines: list[str] = []
    for content in tables:
        lines += [f"# {content.title}", ""]
        lines += [_row(content.columns), _row(("---",) * len(content.columns))]
        lines += [*(_row(row) for row in content.rows), ""]
    return write_text(folder / "report.md", [*lines, *remarks])


def _row(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"
