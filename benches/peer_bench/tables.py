"""Plain-text tables of the measurements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from .libraries import LIBRARIES, OURS


def render(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Lay out a Markdown table with aligned columns; the first column is left-aligned."""
    widths = [max(len(row[i]) for row in (header, *rows)) for i in range(len(header))]

    def line(cells: Sequence[str]) -> str:
        first, *rest = (
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(cells, widths, strict=True))
        )
        return "| " + " | ".join([first, *rest]) + " |"

    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join([line(header), line(rule), *(line(row) for row in rows)])


def number(value: float | None, digits: int = 3) -> str:
    if value is None:
        return "-"
    if value >= 10 ** (digits - 1):
        return f"{value:,.0f}"
    return f"{value:.{digits}g}"


def percent(value: float) -> str:
    """Success in percent, rounded down: only all of the targets are 100 %."""
    # The small term undoes the binary error of decimal fractions such as 0.999.
    floored = math.floor(value * 1e6 + 1e-6) / 1e4
    return f"{floored:.4f}".rstrip("0").rstrip(".") + " %"


def times(value: float | None) -> str:
    return "-" if value is None else f"{number(value)}x"


def solve_rows(table: dict[str, dict[str, Any]]) -> str:
    """One robot: ours first, then the peers from quick to slow."""
    header = [
        "library", "targets", "success", "median us", "mean us", "p99 us", "p99/median",
        "single: median/ours", "single: mean/ours", "mean/our batch",
    ]  # fmt: skip
    rows = []
    names = sorted(table, key=lambda name: (name != OURS, table[name]["mean"]))
    for name in names:
        row = table[name]
        label = f"{name} (arm.ik(T))" if name == OURS else name
        if name != OURS and not LIBRARIES[name].numeric:
            label += " (closed form, all solutions)"
        rows.append(
            [
                label, f"{row['n']:,}", percent(row["success"]), number(row["median"]),
                number(row["mean"]), number(row["p99"]), number(row["p99"] / row["median"], 2),
                times(row.get("single_ratio")), times(row.get("single_mean_ratio")),
                times(row.get("batch_ratio")),
            ]
        )  # fmt: skip
        if "batch" in row:
            batch = row["batch"]
            rows.append(
                [
                    f"{name} (batch, threads=1)", f"{batch['n']:,}", percent(batch["success"]),
                    "-", number(batch["mean"]), "-", "-", "-", "-", "-",
                ]
            )  # fmt: skip
    return render(header, rows)


def closed_form_rows(tables: dict[str, dict[str, dict[str, Any]]]) -> str:
    """Every branch of each pose: single calls, our batch, and how many branches there are."""
    header = [
        "robot", "library", "success", "branches a pose", "same count as ours", "single median us",
        "single mean us", "in a row us", "batch us", "single: median/ours", "in a row/ours",
        "mean/our batch",
    ]  # fmt: skip
    rows = []
    for robot, table in tables.items():
        for name in sorted(table, key=_ours_first):
            row = table[name]
            rows.append(
                [
                    robot, name, percent(row["success"]), number(row["branches"]),
                    percent(row["same_count"]), number(row["median"]), number(row["mean"]),
                    number(row.get("in_a_row")), number(row.get("batch", {}).get("mean")),
                    times(row.get("single_ratio")), times(row.get("in_a_row_ratio")),
                    times(row.get("batch_ratio")),
                ]
            )  # fmt: skip
    return render(header, rows)


def evaluation_rows(tables: dict[str, dict[str, dict[str, Any]]]) -> str:
    """FK or Jacobian: microseconds a configuration, one pair of columns a robot."""
    robots = list(tables)
    header = ["library"]
    for robot in robots:
        header += [f"{robot} single", f"{robot} batch"]
    names = sorted({name for table in tables.values() for name in table}, key=_ours_first)
    rows = []
    for name in names:
        cells = [name]
        for robot in robots:
            row = tables[robot].get(name, {})
            cells += [number(row.get("single")), number(row.get("batch"))]
        rows.append(cells)
    return render(header, rows)


def _ours_first(name: str) -> tuple[bool, str]:
    return name != OURS, name


def thread_rows(tables: dict[str, dict[str, dict[str, Any]]]) -> str:
    header = [
        "robot",
        "threads",
        "targets/s (wall)",
        "over 1 thread",
        "the same while 2 processors are free",
        "free repeats",
        "2 processes' matrix products over 1's",
        "cores got",
        "CPU us/target",
        "success",
    ]
    rows = [
        [
            robot, threads, number(row["targets_per_second"], 6), f"{row['over_first']:.2f}x",
            times(row["while_free"]), f"{row['free_repeats']} of {row['repeats']}",
            f"{row['products']:.2f}x", f"{row['cores']:.2f}", number(row["cpu_us"]),
            percent(row["success"]),
        ]
        for robot, table in tables.items()
        for threads, row in table.items()
    ]  # fmt: skip
    return render(header, rows)


def simd_rows(tables: dict[str, dict[str, dict[str, Any]]]) -> str:
    header = ["robot", "asked", "in use", "CPU us/target", "success"]
    rows = [
        [robot, level, row["notes"], number(row["mean"]), percent(row["success"])]
        for robot, table in tables.items()
        for level, row in table.items()
    ]
    return render(header, rows)


def memory_rows(table: dict[str, dict[str, Any]]) -> str:
    header = ["robot", "targets", "inputs MB", "outputs MB", "rise MB", "in + rise / in + out"]
    rows = [
        [
            robot, f"{row['n']:,}",
            *(number(row[key] / 1e6) for key in ("inputs", "outputs", "rise")),
            f"{row['ratio']:.2f}x",
        ]
        for robot, row in table.items()
    ]  # fmt: skip
    return render(header, rows)


def latency_rows(table: dict[str, dict[str, Any]]) -> str:
    header = [
        "robot", "clock", "calls", "min us", "p50", "p95", "p99", "max", "p99/p50",
        "start = solution, p50", "load", "first call",
    ]  # fmt: skip
    rows = []
    for robot, row in table.items():
        for clock in ("cpu", "wall"):
            points = row[clock]
            rows.append(
                [
                    robot, clock, f"{row['n']:,}",
                    *(number(points[key]) for key in ("min", "p50", "p95", "p99", "max")),
                    number(points["p99_over_p50"], 2),
                    *(
                        number(value) if clock == "wall" else "-"
                        for value in (row["call_us"], row["load_ns"] / 1e3, row["solve_ns"] / 1e3)
                    ),
                ]
            )  # fmt: skip
    return render(header, rows)
