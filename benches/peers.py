"""Times agrik_fast beside other inverse-kinematics libraries, in one run on one core.

Run it with the project's environment: ``.venv/bin/python benches/peers.py --quick``. Environments
of the peers are made on first use (``.venv-peers-*`` in the project's root). See README.md here.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

from peer_bench import goals, machine, measure, tables
from peer_bench.libraries import LIBRARIES, OURS, BenchError, Process
from peer_bench.robots import POSE_ANGLE_RAD, POSE_POSITION_M, load_robots

TASKS = ("pose", "closed", "position", "fk", "jacobian", "single", "threads", "simd", "memory")
SOLVING = ("pose", "position")
POSITION_M = 1e-4
MEMORY_TARGETS_PER_BATCH_TARGET = 10
SIMD_LEVELS = ("scalar", "avx2", "avx512")
EVALUATION_BATCH = 10_000


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    robots = load_robots()
    parser.add_argument("--robots", default=",".join(robots), help="default: %(default)s")
    parser.add_argument("--tasks", default=",".join(TASKS), help="default: %(default)s")
    parser.add_argument("--libraries", default=",".join(LIBRARIES), help="default: %(default)s")
    parser.add_argument("--n", type=int, default=1000, help="targets of single calls (%(default)s)")
    parser.add_argument(
        "--batch-n", type=int, default=100_000, help="targets of our batch calls (%(default)s)"
    )
    parser.add_argument("--repeats", type=int, default=3, help="repeats of each (%(default)s)")
    parser.add_argument("--quick", action="store_true", help="--n 200 --batch-n 5000 --repeats 2")
    parser.add_argument("--json", type=Path, help="also write every figure to this file")
    chosen = parser.parse_args()
    for option, known in (("robots", robots), ("tasks", TASKS), ("libraries", LIBRARIES)):
        names = [name for name in getattr(chosen, option).split(",") if name]
        unknown = [name for name in names if name not in known]
        if unknown or not names:
            parser.error(f"--{option}: {', '.join(unknown) or 'empty'}; known: {', '.join(known)}")
        setattr(chosen, option, names)
    if chosen.quick:
        chosen.n, chosen.batch_n, chosen.repeats = 200, 5000, 2
    if min(chosen.n, chosen.batch_n, chosen.repeats) < 1:
        parser.error("--n, --batch-n and --repeats: expected at least 1")
    return chosen


def start_workers(names: list[str], tasks: list[str]) -> dict[str, Process]:
    """Start a pinned worker for each library that one of the tasks needs."""
    core = machine.measuring_core()
    workers = {}
    for name in names:
        only_ours = not set(tasks) & {*SOLVING, "closed", "fk", "jacobian"}
        if name != OURS and (only_ours or (name == "numpy" and not {"fk"} & set(tasks))):
            continue
        workers[name] = Process(LIBRARIES[name], core)
    return workers


def print_setting(about: dict[str, Any], chosen: argparse.Namespace, peers: dict[str, Any]) -> None:
    print(f"machine: {about['cpu']}, {about['cores']} cores usable, {about['system']}")
    print(f"load average before the run: {about['load_before']}; Python {about['python']}")
    for name, item in peers.items():
        notes = f"; {item['notes']}" if item["notes"] else ""
        print(f"  {name} {item['version']} (NumPy {item['numpy']}{notes})")
    print(
        f"one core, one thread each unless said; GC off while timing; {chosen.repeats} repeats, "
        f"medians of them; CPU time of the process\n"
        f"success: independent NumPy FK within {POSE_POSITION_M:g} m and {POSE_ANGLE_RAD:g} rad, "
        f"inside the limits; peers start from an independent random start, ours from none"
    )


def run_solving(task: str, workers: dict[str, Process], chosen: argparse.Namespace) -> Any:
    out = {}
    robots = chosen.robots
    position_m = None
    if task == "position":
        # The comparison's position task is the HydroLek's, 0.1 mm.
        robots, position_m = [r for r in robots if r == "H6"], POSITION_M
    plan = measure.Plan(chosen.n, chosen.batch_n, chosen.repeats)
    for robot in robots:
        table = measure.solve_table(workers, robot, plan, position_m)
        out[robot] = table
        what = "full pose" if position_m is None else f"position only, {1e3 * position_m:g} mm"
        print(f"\n## {robot}, {what}: CPU us a solve through the Python API\n")
        print(tables.solve_rows(table))
    settings = {name: row["settings"] for table in out.values() for name, row in table.items()}
    print("\nsettings:")
    for name, setting in settings.items():
        print(f"  {name}: {setting}")
    return out


def run_closed(workers: dict[str, Process], chosen: argparse.Namespace) -> Any:
    """Every branch of arms with a closed form, beside the libraries that have it too."""
    plan = measure.Plan(chosen.n, chosen.batch_n, chosen.repeats)
    out = {
        robot: measure.solve_table(workers, robot, plan, None, "closed_form")
        for robot in chosen.robots
    }
    out = {robot: table for robot, table in out.items() if table}
    print("\n## closed forms: every branch, CPU us a pose through the Python API\n")
    print(tables.closed_form_rows(out))
    return out


def run_evaluation(task: str, workers: dict[str, Process], chosen: argparse.Namespace) -> Any:
    out = {
        robot: measure.evaluation_table(workers, robot, task, EVALUATION_BATCH, chosen.repeats)
        for robot in chosen.robots
    }
    print(f"\n## {task}: CPU us a configuration, single call and batch of {EVALUATION_BATCH:,}\n")
    print(tables.evaluation_rows(out))
    for robot, table in out.items():
        for name, row in table.items():
            worst = max(row.get(f"{kind}_worst_error") or 0.0 for kind in ("single", "batch"))
            if worst > 1e-9:
                print(f"note: {name} on {robot} differs from NumPy FK by {worst:.1e}")
    return out


def run_ours(task: str, workers: dict[str, Process], chosen: argparse.Namespace) -> Any:
    """Measure what needs no peer."""
    if task == "single":
        out: dict[str, Any] = {
            robot: measure.latency_table(workers[OURS], robot, 5 * chosen.n, chosen.repeats)
            for robot in chosen.robots
        }
        for robot, row in out.items():
            # What the calls above reuse (tables of a robot, say) is paid here.
            fresh = Process(LIBRARIES[OURS], machine.measuring_core())
            row |= fresh.ask("first_call", robot=robot)
            fresh.close()
        print("\n## single calls, arm.ik(T): microseconds\n")
        print(tables.latency_rows(out))
        return out
    if task == "memory":
        if not Path("/proc/self/clear_refs").exists():
            print("\nmemory: only measured on Linux")
            return {}
        # A process of its own, so that nothing freed earlier hides what the call takes.
        free = Process(LIBRARIES[OURS], -1)
        count = MEMORY_TARGETS_PER_BATCH_TARGET * chosen.batch_n
        out = {robot: measure.memory_row(free, robot, count) for robot in chosen.robots[:1]}
        free.close()
        print("\n## memory of one batch call, all cores\n")
        print(tables.memory_rows(out))
        return out
    if task == "threads":
        pair = (Process(LIBRARIES[OURS], -1), Process(LIBRARIES[OURS], -1))
        counts = tuple(dict.fromkeys((1, 2, machine.available_cores())))
        out = {
            robot: measure.thread_table(pair, robot, chosen.batch_n, 5 * chosen.repeats, counts)
            for robot in chosen.robots
        }
        for free in pair:
            free.close()
        print("\n## threads: one batch call, full pose, all cores allowed\n")
        print(tables.thread_rows(out))
        return out
    levels = {
        level: Process(LIBRARIES[OURS], machine.measuring_core(), {"AGRIK_SIMD": level})
        for level in SIMD_LEVELS
    }
    out = {
        robot: measure.simd_table(levels, robot, chosen.batch_n, chosen.repeats)
        for robot in chosen.robots
    }
    for worker in levels.values():
        worker.close()
    print("\n## SIMD levels: one batch call, full pose, 1 thread\n")
    print(tables.simd_rows(out))
    return out


def run(chosen: argparse.Namespace) -> None:
    about = machine.describe()
    begun = time.perf_counter()
    workers = start_workers(chosen.libraries, chosen.tasks)
    peers = {name: worker.about for name, worker in workers.items()}
    print_setting(about, chosen, peers)
    results: dict[str, Any] = {"machine": about, "libraries": peers}
    for task in chosen.tasks:
        if task in SOLVING:
            results[task] = run_solving(task, workers, chosen)
        elif task == "closed":
            results[task] = run_closed(workers, chosen)
        elif task in ("fk", "jacobian"):
            results[task] = run_evaluation(task, workers, chosen)
        elif OURS in workers:
            results[task] = run_ours(task, workers, chosen)
    if OURS in workers:
        print("\n## goals\n")
        print(goals.goal_rows(results))
    load = machine.describe()["load_before"]
    print(f"\n{time.perf_counter() - begun:.0f} s; load average after the run: {load}")
    for worker in workers.values():
        worker.close()
    if chosen.json:
        chosen.json.parent.mkdir(parents=True, exist_ok=True)
        chosen.json.write_text(json.dumps(results, indent=1) + "\n")


def main() -> int:
    try:
        run(arguments())
    except BenchError as error:
        print(f"peers.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
