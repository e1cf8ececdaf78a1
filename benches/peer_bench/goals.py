"""What the comparison is asked to show, beside what it showed. Misses are printed like the rest."""

from __future__ import annotations

from typing import Any

from .libraries import LIBRARIES, OURS
from .measure import TWO_PROCESSES
from .tables import percent, render, times

# What was asked on R7 of the first stage: the batch without SIMD lanes, and single calls.
SCALAR_BATCH_RATIO_R7 = 4.0
SCALAR_SINGLE_RATIO_R7 = 2.0
# Least batch ratio (best peer's mean over ours) by robot, with SIMD lanes.
BATCH_RATIO = {"R7": 30.0, "H6": 15.0, "P6": 15.0, "UR5": 15.0, "Panda": 15.0}
BATCH_SUCCESS = 0.9999
SINGLE_RATIO_R7 = 4.0
POSITION_RATIO_H6 = 10.0
CLOSED_BATCH_RATIO_P6 = 10.0
CLOSED_SINGLE_RATIO_P6 = 3.0
CLOSED_BATCH_US_R7 = 1.0
THREADS_RATIO = 1.8
FK_OVER_NUMPY_BATCH = 25.0
FK_OVER_PINOCCHIO = 15.0
JACOBIAN_OVER_PINOCCHIO = 12.0
TAIL_RATIO = 8.0
MEMORY_RATIO = 3.0

Row = tuple[str, str, str, bool]


def goal_rows(results: dict[str, Any]) -> str:
    """Return the table of goals for the tasks that were run."""
    rows = [
        [name, asked, got, "yes" if met else "no"]
        for part in (_pose, _closed, _position, _threads, _evaluations, _latency, _memory)
        for name, asked, got, met in part(results)
    ]
    return render(["measure", "goal", "measured", "met"], rows) if rows else ""


def _best(table: dict[str, dict[str, Any]], key: str) -> tuple[str, float] | None:
    """Find the numeric peer that is nearest to us (the least ratio)."""
    ratios = [
        (row[key], name)
        for name, row in table.items()
        if name != OURS and key in row and LIBRARIES[name].numeric
    ]
    return (min(ratios)[1], min(ratios)[0]) if ratios else None


def _ratio(name: str, best: tuple[str, float] | None, least: float) -> list[Row]:
    if best is None:
        return []
    peer, value = best
    return [(name, f">= {least:g}x", f"{times(value)} ({peer})", value >= least)]


def _pose(results: dict[str, Any]) -> list[Row]:
    rows: list[Row] = []
    for robot, table in results.get("pose", {}).items():
        if OURS not in table:
            continue
        name = f"{robot} pose, batch, 1 thread: best peer's mean / ours"
        rows += _ratio(name, _best(table, "batch_ratio"), BATCH_RATIO.get(robot, 15.0))
        if robot == "R7":
            rows += _scalar_batch(table, results)
            best = _best(table, "single_ratio")
            name = "R7 pose, single call: best peer's median / ours"
            rows += _ratio(name, best, SINGLE_RATIO_R7)
            rows += _ratio(f"{name} (first stage)", best, SCALAR_SINGLE_RATIO_R7)
        rows += _success_of_singles(robot, table)
        batch = table[OURS].get("batch")
        if batch:
            got = f"{percent(batch['success'])} of {batch['n']:,}"
            met = batch["success"] >= BATCH_SUCCESS
            rows.append((f"{robot} pose, success", f">= {percent(BATCH_SUCCESS)}", got, met))
            false = batch["false_claims"]
            rows.append((f"{robot} pose, claimed but not solved", "0", f"{false}", false == 0))
    return rows


def _scalar_batch(table: dict[str, dict[str, Any]], results: dict[str, Any]) -> list[Row]:
    """The batch ratio without SIMD lanes, from the `simd` task's scalar row where it ran."""
    scalar = results.get("simd", {}).get("R7", {}).get("scalar")
    best = _best(table, "batch_ratio")
    if scalar is None or best is None:
        return []
    peer = best[0]
    name = "R7 pose, batch, 1 thread, AGRIK_SIMD=scalar: best peer's mean / ours"
    return _ratio(name, (peer, table[peer]["mean"] / scalar["mean"]), SCALAR_BATCH_RATIO_R7)


def _success_of_singles(robot: str, table: dict[str, dict[str, Any]]) -> list[Row]:
    """Speed counts only at no lower success than any numeric peer on the same targets."""
    peers = [
        (row["success"], name)
        for name, row in table.items()
        if name != OURS and LIBRARIES[name].numeric
    ]
    if not peers:
        return []
    value, peer = max(peers)
    ours = table[OURS]["success"]
    asked = f">= {percent(value)} ({peer})"
    return [(f"{robot} pose, success of single calls", asked, percent(ours), ours >= value)]


def _position(results: dict[str, Any]) -> list[Row]:
    rows: list[Row] = []
    for robot, table in results.get("position", {}).items():
        name = f"{robot} position, batch: best peer's mean / ours"
        rows += _ratio(name, _best(table, "batch_ratio"), POSITION_RATIO_H6)
        batch = table.get(OURS, {}).get("batch")
        if batch:
            got = f"{percent(batch['success'])} of {batch['n']:,}"
            rows.append((f"{robot} position, success", "100 %", got, batch["success"] == 1.0))
    return rows


def _closed(results: dict[str, Any]) -> list[Row]:
    rows: list[Row] = []
    for robot, table in results.get("closed", {}).items():
        eaik = table.get("eaik")
        if robot == "P6" and eaik and "batch_ratio" in eaik:
            for name, key, least in (
                ("every branch, batch: EAIK's mean / ours", "batch_ratio", CLOSED_BATCH_RATIO_P6),
                (
                    "every branch, single: EAIK's median / ours",
                    "single_ratio",
                    CLOSED_SINGLE_RATIO_P6,
                ),
                (
                    "every branch, single calls in a row: EAIK's mean / ours",
                    "in_a_row_ratio",
                    CLOSED_SINGLE_RATIO_P6,
                ),
            ):
                rows += _ratio(f"P6 {name}", ("eaik", eaik[key]), least)
            same = eaik["same_count"]
            rows.append(("P6 branches: same count as EAIK", "100 %", percent(same), same == 1.0))
        if robot == "R7" and "batch" in table.get(OURS, {}):
            spent = table[OURS]["batch"]["mean"]
            asked = f"<= {CLOSED_BATCH_US_R7:g} us"
            name = "R7 every branch at an arm angle, batch"
            rows.append((name, asked, f"{spent:.3g} us", spent <= CLOSED_BATCH_US_R7))
    return rows


def _threads(results: dict[str, Any]) -> list[Row]:
    rows: list[Row] = []
    for robot, table in results.get("threads", {}).items():
        if "2" in table:
            row = table["2"]
            value = row["while_free"]
            name = f"{robot} pose, 2 threads over 1, while 2 processors are free"
            ceiling = times(table[TWO_PROCESSES]["while_free"])
            got = (
                f"{times(value)} in {row['free_repeats']} of {row['repeats']} repeats "
                f"(two separate processes: {ceiling}; best rates: {times(row['over_first'])})"
            )
            met = value is not None and value >= THREADS_RATIO
            rows.append((name, f">= {THREADS_RATIO:g}x", got, met))
    return rows


def _evaluations(results: dict[str, Any]) -> list[Row]:
    rows: list[Row] = []
    for task, robot, peer, kind, least in (
        ("fk", "R7", "numpy", "batch", FK_OVER_NUMPY_BATCH),
        ("fk", "R7", "pinocchio", "single", FK_OVER_PINOCCHIO),
        ("jacobian", "R7", "pinocchio", "single", JACOBIAN_OVER_PINOCCHIO),
    ):
        table = results.get(task, {}).get(robot, {})
        ours, theirs = table.get(OURS, {}).get("batch"), table.get(peer, {}).get(kind)
        if ours and theirs:
            name = f"{robot} {task}, {peer} {kind} / our batch"
            rows += _ratio(name, (peer, theirs / ours), least)
    return rows


def _latency(results: dict[str, Any]) -> list[Row]:
    rows: list[Row] = []
    for robot, table in results.get("single", {}).items():
        if robot in ("P6", "UR5"):
            value = table["cpu"]["p99_over_p50"]
            name = f"{robot} pose, single call: p99 / median (CPU)"
            rows.append((name, f"<= {TAIL_RATIO:g}x", times(value), value <= TAIL_RATIO))
    return rows


def _memory(results: dict[str, Any]) -> list[Row]:
    rows: list[Row] = []
    for robot, row in results.get("memory", {}).items():
        name = f"{robot} pose, memory of {row['n']:,} targets over inputs + outputs"
        value = row["ratio"]
        rows.append((name, f"< {MEMORY_RATIO:g}x", times(value), value < MEMORY_RATIO))
    return rows
