"""The measurements: who is asked what, in which order, and the statistics of the answers.

Ours and a peer are timed in turns on the same targets (ours, peer, ours, next peer, ...), and each
ratio is formed from the two neighbours in that order, repeat by repeat, so that a machine that
slows down slows both. The median over the repeats is reported.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from .libraries import OURS, Process

Array = npt.NDArray[np.float64]

# Row of `thread_table` that says what two processes of ours do at most.
TWO_PROCESSES = "2 processes"
# Two processors count as free while two processes get so many times the matrix products of one:
# two processors of a virtual machine may be halves of one, at times.
FREE = 1.9
PRODUCT_SECONDS = 0.1


@dataclass
class Samples:
    """CPU microseconds of single solves, one row a repeat, and the success of the first repeat."""

    cpu_us: list[list[float]] = field(default_factory=list)
    wall_us: list[list[float]] = field(default_factory=list)
    ok: list[bool] = field(default_factory=list)
    in_a_row_us: list[list[float]] = field(default_factory=list)

    def begin_repeat(self) -> None:
        self.cpu_us.append([])
        self.wall_us.append([])
        self.in_a_row_us.append([])

    def add(self, answer: dict[str, Any]) -> None:
        self.cpu_us[-1] += [value / 1e3 for value in answer["cpu_ns"]]
        self.wall_us[-1] += [value / 1e3 for value in answer["wall_ns"]]
        if len(self.cpu_us) == 1:
            self.ok += answer["ok"]

    def add_in_a_row(self, answer: dict[str, Any]) -> None:
        self.in_a_row_us[-1].append(answer["cpu_ns"] / 1e3)

    def per_repeat(self, statistic: str) -> Array:
        if statistic == "in_a_row":
            return np.array([np.mean(row) for row in self.in_a_row_us])
        rows: Array = np.array(self.cpu_us)
        if statistic == "mean":
            return np.asarray(rows.mean(axis=1))
        return np.asarray(np.percentile(rows, {"median": 50, "p99": 99}[statistic], axis=1))

    def summary(self) -> dict[str, Any]:
        out: dict[str, Any] = {
            key: float(np.median(self.per_repeat(key))) for key in ("median", "mean", "p99")
        }
        if any(self.in_a_row_us):
            out["in_a_row"] = float(np.median(self.per_repeat("in_a_row")))
        return {**out, "success": float(np.mean(self.ok)), "n": len(self.ok)}


@dataclass
class Plan:
    """How much to measure."""

    count: int
    batch_count: int
    repeats: int
    slices: int = 5

    def bounds(self) -> list[tuple[int, int]]:
        edges = [round(i * self.count / self.slices) for i in range(self.slices + 1)]
        return list(pairwise(edges))


def solve_table(
    workers: dict[str, Process],
    robot: str,
    plan: Plan,
    position_only_m: float | None,
    what: str = "pose",
) -> dict[str, dict[str, Any]]:
    """One robot, every library that can: success, CPU microseconds, and ratios to ours."""
    request = {
        "robot": robot, "count": plan.count, "position_only_m": position_only_m, "what": what
    }  # fmt: skip
    opened = {name: worker.ask("open", **request) for name, worker in workers.items()}
    able = {name: workers[name] for name, answer in opened.items() if answer["able"]}
    ours = able.pop(OURS, None)
    with_batch = ours is not None and opened[OURS]["batch"]

    if what == "closed_form" and ours is None:
        return {}
    # Without a peer to alternate with, ours is still measured.
    names = list(able) or [OURS]
    peers = {name: Samples() for name in able}
    beside = {name: Samples() for name in names}
    batches: dict[str, list[dict[str, Any]]] = {name: [] for name in names}
    for repeat in range(plan.repeats):
        for samples in (*peers.values(), *beside.values()):
            samples.begin_repeat()
        for piece, (begin, end) in enumerate(plan.bounds()):
            turn = (repeat + piece) % len(names)
            for name in names[turn:] + names[:turn]:
                if ours is not None:
                    beside[name].add(ours.ask("solve", begin=begin, end=end))
                    if with_batch and piece == repeat % plan.slices:
                        batches[name].append(ours.ask("batch", count=plan.batch_count, threads=1))
                if name in able:
                    peers[name].add(able[name].ask("solve", begin=begin, end=end))
                if what == "closed_form":
                    # Calls as short as these are disturbed by the clock around each.
                    if ours is not None:
                        answer = ours.ask("in_a_row", begin=begin, end=end)
                        beside[name].add_in_a_row(answer)
                    if name in able:
                        answer = able[name].ask("in_a_row", begin=begin, end=end)
                        peers[name].add_in_a_row(answer)

    table: dict[str, dict[str, Any]] = {}
    if ours is not None:
        pooled = Samples(
            cpu_us=[row for item in beside.values() for row in item.cpu_us],
            ok=next(iter(beside.values())).ok,
            in_a_row_us=[row for item in beside.values() for row in item.in_a_row_us],
        )
        table[OURS] = {**pooled.summary(), "settings": opened[OURS]["settings"]}
        every = [answer for answers in batches.values() for answer in answers]
        if every:
            table[OURS]["batch"] = {
                "mean": float(np.median([answer["cpu_ns"] for answer in every])) / 1e3,
                "success": every[0]["solved"] / every[0]["n"],
                "n": every[0]["n"],
                "unsolved": every[0]["n"] - every[0]["solved"],
                "false_claims": every[0]["claimed"] - every[0]["solved"],
            }
    for name, samples in peers.items():
        row = {**samples.summary(), "settings": opened[name]["settings"]}
        if ours is not None:
            row["single_ratio"] = _ratio(
                samples.per_repeat("median"), beside[name].per_repeat("median")
            )
            row["single_mean_ratio"] = _ratio(
                samples.per_repeat("mean"), beside[name].per_repeat("mean")
            )
            if what == "closed_form":
                row["in_a_row_ratio"] = _ratio(
                    samples.per_repeat("in_a_row"), beside[name].per_repeat("in_a_row")
                )
            if batches[name]:
                batch_us = np.array([answer["cpu_ns"] for answer in batches[name]]) / 1e3
                row["batch_ratio"] = _ratio(samples.per_repeat("mean"), batch_us)
        table[name] = row
    if what == "closed_form":
        counts = {name: workers[name].ask("branches")["counts"] for name in table}
        for name, found in counts.items():
            table[name]["branches"] = sum(found) / len(found)
            table[name]["same_count"] = float(np.mean(np.equal(found, counts[OURS])))
    return table


def _ratio(peer: Array, ours: Array) -> float:
    return float(np.median(peer / ours))


def evaluation_table(
    workers: dict[str, Process], robot: str, what: str, batch: int, repeats: int
) -> dict[str, dict[str, Any]]:
    """FK or Jacobian: CPU microseconds a configuration, single calls and one batch call."""
    table: dict[str, dict[str, Any]] = {}
    for size, kind in ((0, "single"), (batch, "batch")):
        seen: dict[str, list[float]] = {}
        for _ in range(repeats):
            for name, worker in workers.items():
                answer = worker.ask("evaluate", what=what, robot=robot, batch=size)
                if not answer["able"]:
                    continue
                seen.setdefault(name, []).append(answer["cpu_ns"] / 1e3)
                row = table.setdefault(name, {})
                row[f"{kind}_note"] = answer["note"]
                row[f"{kind}_worst_error"] = answer["worst_error"]
        for name, values in seen.items():
            table[name][kind] = float(np.median(values))
    return table


def thread_table(
    workers: tuple[Process, Process],
    robot: str,
    batch_count: int,
    repeats: int,
    threads: tuple[int, ...],
) -> dict[str, dict[str, Any]]:
    """Wall-clock targets a second of one batch call, by thread count, in turns.

    The best of the repeats counts for rates: wall time only ever grows by what else the machine
    does. `cores` is CPU time over wall time of that repeat; less than the threads asked for means
    that the cores were not free (or the call did not use them). The last row has two processes of
    ours at once, with one thread and nothing in common.

    Each repeat also counts the matrix products of one process and of two at once. `while_free` is
    the median ratio to one thread over the repeats in which the processors were free by that.
    """
    worker = workers[0]
    for each in workers:
        each.ask("open", robot=robot, count=10, position_only_m=None)
    seen: dict[str, list[dict[str, Any]]] = {str(number): [] for number in threads}
    seen[TWO_PROCESSES] = []
    free: list[float] = []
    for _ in range(repeats):
        free.append(_free_processors(workers))
        for number in threads:
            seen[str(number)].append(worker.ask("batch", count=batch_count, threads=number))
        for each in workers:
            each.send("batch", count=batch_count, threads=1)
        one, other = (each.receive() for each in workers)
        seen[TWO_PROCESSES].append(
            {
                **one,
                # A target's time while both are at work.
                "wall_ns": max(one["wall_ns"], other["wall_ns"]) / 2.0,
                "cpu_ns": (one["cpu_ns"] + other["cpu_ns"]) / 2.0,
            }
        )
    table: dict[str, dict[str, Any]] = {}
    for name, answers in seen.items():
        best = min(answers, key=lambda answer: float(answer["wall_ns"]))
        table[name] = {
            "targets_per_second": 1e9 / best["wall_ns"],
            "cores": best["cpu_ns"] / best["wall_ns"],
            "cpu_us": best["cpu_ns"] / 1e3,
            "success": answers[0]["solved"] / answers[0]["n"],
            "n": answers[0]["n"],
        }
    first = table[str(threads[0])]["targets_per_second"]
    once = seen[str(threads[0])]
    were_free = [share >= FREE for share in free]
    for name, row in table.items():
        row["over_first"] = row["targets_per_second"] / first
        row["products"] = float(np.median(free))
        row["free_repeats"], row["repeats"] = sum(were_free), repeats
        ratios = [
            alone["wall_ns"] / answer["wall_ns"]
            for alone, answer, was_free in zip(once, seen[name], were_free, strict=True)
            if was_free
        ]
        row["while_free"] = float(np.median(ratios)) if ratios else None
    return table


def _free_processors(workers: tuple[Process, Process]) -> float:
    """Matrix products of two processes at once over those of one."""
    alone = workers[0].ask("products", seconds=PRODUCT_SECONDS)["rate"]
    for each in workers:
        each.send("products", seconds=PRODUCT_SECONDS)
    return float(sum(each.receive()["rate"] for each in workers) / alone)


def simd_table(
    workers: dict[str, Process], robot: str, batch_count: int, repeats: int
) -> dict[str, dict[str, Any]]:
    """CPU microseconds a target of one batch call with one thread, by SIMD level, in turns."""
    seen: dict[str, list[dict[str, Any]]] = {level: [] for level in workers}
    for worker in workers.values():
        worker.ask("open", robot=robot, count=10, position_only_m=None)
    for _ in range(repeats):
        for level, worker in workers.items():
            seen[level].append(worker.ask("batch", count=batch_count, threads=1))
    return {
        level: {
            "mean": float(np.median([answer["cpu_ns"] for answer in answers])) / 1e3,
            "success": answers[0]["solved"] / answers[0]["n"],
            "notes": workers[level].about["notes"],
        }
        for level, answers in seen.items()
    }


def memory_row(worker: Process, robot: str, count: int) -> dict[str, Any]:
    """Memory of one large call: inputs and what the call added, over inputs plus outputs."""
    answer = worker.ask("memory", robot=robot, count=count)
    size = answer["inputs"] + answer["outputs"]
    return {**answer, "ratio": (answer["inputs"] + answer["rise"]) / size}


def latency_table(worker: Process, robot: str, count: int, repeats: int) -> dict[str, Any]:
    """Single calls of ours: the spread of wall and CPU time, and the cost of calling alone."""
    worker.ask("open", robot=robot, count=count, position_only_m=None)
    samples = Samples()
    gaps: list[float] = []
    for _ in range(repeats):
        samples.begin_repeat()
        samples.add(worker.ask("solve", begin=0, end=count))
        gaps += worker.ask("overhead", count=min(count, 500))["wall_ns"]
    out: dict[str, Any] = {"n": count, "call_us": float(np.median(gaps)) / 1e3}
    for key, rows in (("cpu", samples.cpu_us), ("wall", samples.wall_us)):
        points = np.median(np.percentile(np.array(rows), (0, 50, 95, 99, 100), axis=1), axis=1)
        out[key] = dict(zip(("min", "p50", "p95", "p99", "max"), map(float, points), strict=True))
        out[key]["p99_over_p50"] = out[key]["p99"] / out[key]["p50"]
    return out
