"""Random arms, solvers, tasks and options against the library's promises.

    python benches/fuzz_arms.py --rows 1e7
    python benches/fuzz_arms.py --minutes 2
    python benches/fuzz_arms.py --seed 3 --case 1234     # one case again, in this process

Forward kinematics of its own judge every answer: no success that is none, no proof that is wrong,
no limit left, no NaN, no exception that is not documented, and the same bits for a batch, its
pieces, its rows alone, any number of threads and a solver object. Processes do the work; one that
hangs or dies is found out, and the case it did is named. Everything follows from the seed and the
number of the case. Exit status 1 if a promise was broken.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from robust import pool

SHOWN = 3
"""Faults of a kind that are printed in full."""


def main() -> int:
    options = _options()
    if options.case is not None:
        return _replay(options)
    # A signal from the one who waits ends the run as its time would, with the summary.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    summary = Summary()
    stop = time.monotonic() + 60 * options.minutes if options.minutes else float("inf")

    def numbers() -> Iterator[int]:
        for number in itertools.count(options.first):
            if summary.counts["rows"] >= options.rows or time.monotonic() > stop:
                return
            yield number

    print(f"seed {options.seed}, {options.workers} processes", flush=True)
    next_word = time.monotonic() + 10
    try:
        for found in pool.work(options.seed, numbers(), options.workers, options.limit):
            summary.add(found)
            for fault in found["faults"]:
                if summary.seen[fault["kind"]] <= SHOWN:
                    print(_shown(fault, options.seed), flush=True)
            if time.monotonic() > next_word:
                next_word = time.monotonic() + 10
                print(summary.line(), flush=True)
    except KeyboardInterrupt:
        print("interrupted")
    print(summary.table())
    if options.json:
        options.json.write_text(json.dumps(summary.faults, indent=1) + "\n", encoding="utf-8")
    if not summary.counts["rows"]:
        print("nothing was solved: this run shows nothing")
        return 1
    return int(bool(summary.seen))


class Summary:
    """Counts of all cases."""

    def __init__(self) -> None:
        self.begin = time.monotonic()
        self.counts: Counter[str] = Counter()
        self.seen: Counter[str] = Counter()
        self.tally: dict[str, list[float]] = {}
        self.faults: list[dict[str, Any]] = []

    def add(self, found: dict[str, Any]) -> None:
        self.counts["cases"] += 1
        self.counts.update(found["counts"])
        for name, numbers in found["tally"].items():
            so_far = self.tally.setdefault(name, [0.0] * len(numbers))
            self.tally[name] = [a + b for a, b in zip(so_far, numbers, strict=True)]
        for fault in found["faults"]:
            self.seen[fault["kind"]] += 1
            if self.seen[fault["kind"]] <= 50:
                self.faults.append(fault)

    def line(self) -> str:
        took = time.monotonic() - self.begin
        rows = self.counts["rows"]
        faults = ", ".join(f"{kind} {number}" for kind, number in self.seen.items()) or "no fault"
        return (
            f"{took:6.0f} s  {self.counts['cases']:,} cases  {rows:,} rows  "
            f"{rows / max(took, 1e-9):,.0f} rows/s  {faults}"
        )

    def table(self) -> str:
        lines = ["", self.line(), ""]
        lines.append(
            f"{'solver, task':32} {'rows':>12} {'reachable':>12} {'solved':>10} {'us/row':>9}"
        )
        for name, (rows, reachable, solved, seconds) in sorted(self.tally.items()):
            share = f"{100 * solved / reachable:.3f} %" if reachable else "-"
            each = 1e6 * seconds / max(rows, 1)
            lines.append(f"{name:32} {rows:12,.0f} {reachable:12,.0f} {share:>10} {each:9.1f}")
        for title in ("arms", "family", "status", "refused", "refused arm"):
            parts = [
                f"{name.removeprefix(title + ': ')} {number:,}"
                for name, number in sorted(self.counts.items())
                if name.startswith(title + ": ")
            ]
            lines.append(f"{title}: {', '.join(parts) or 'none'}")
        lines.append(
            f"{self.counts['rows']:,} rows solved and judged, {self.counts['rows compared']:,} "
            f"compared bit for bit, {self.counts['calls']:,} calls"
        )
        lines.append("faults: " + (", ".join(f"{k} {n:,}" for k, n in self.seen.items()) or "none"))
        return "\n".join(lines)


def _shown(fault: dict[str, Any], seed: int) -> str:
    command = f"benches/fuzz_arms.py --seed {seed} --case {fault['case']}"
    code = "\n".join("    " + line for line in fault["code"].splitlines())
    return f"\n*** {fault['kind']} ({fault['place']})\n    {fault['text']}\n    {command}\n{code}\n"


def _replay(options: argparse.Namespace) -> int:
    from robust import cases

    say = (lambda doing: print(f"  calls: {doing}", flush=True)) if options.verbose else None
    outcome = cases.run(options.seed, options.case, *([say] if say else []))
    for fault in outcome.faults:
        print(_shown(fault, options.seed))
    for name, number in sorted(outcome.counts.items()):
        print(f"{name}: {number:,}")
    return int(bool(outcome.faults))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=_many, default=float("inf"), help="end after so many rows")
    parser.add_argument("--minutes", type=float, help="end after so many minutes")
    parser.add_argument("--seed", type=int, default=1, help="default %(default)s")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--case", type=int, help="do this case alone, in this process")
    parser.add_argument("--verbose", action="store_true", help="with --case: name every call")
    parser.add_argument("--json", type=Path, help="write up to 50 faults of each kind")
    parser.add_argument(
        "--workers", type=int, default=_processors(), help="processes (%(default)s)"
    )
    parser.add_argument(
        "--limit", type=float, default=60, help="seconds after which a call hangs (%(default)s)"
    )
    options = parser.parse_args()
    if options.case is None and options.minutes is None and options.rows == float("inf"):
        parser.error("--rows, --minutes or --case: one of them says when to end")
    if min(options.workers, options.seed + 1, options.first + 1) < 1:
        parser.error("--workers at least 1, --seed and --first at least 0")
    return options


def _many(text: str) -> float:
    number = float(text)
    if not number >= 1:
        raise argparse.ArgumentTypeError("expected at least 1, as 1e7")
    return number


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


if __name__ == "__main__":
    sys.exit(main())
