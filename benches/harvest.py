"""Harvest decisions: times, shares and costs of the two-step method, the scan and the searches.

    python benches/harvest.py [--crop-fruits 1000] [--seeds 20] [--output FILE.json]

Prints one table a part: decisions of the example scene on one thread, with spheres and exact,
with and without refinement; scans of everything; a crop of the greenhouse generator on two
threads, with the memory it took; the same with ten times the points; the programme of the
thinned-out scene by genetic algorithm, differential evolution and null-space scan.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from agrik_fast import harvest, simd_level
from agrik_fast.collision import Scene, greenhouse

ROBOT = "cucumber"
PITCH = 0.35


def best_ms(work: Callable[[], Any], repeats: int = 15) -> tuple[float, Any]:
    """Return the least of several times of a call, ms, and its answer."""
    times, answer = [], None
    for _ in range(repeats):
        start = time.perf_counter()
        answer = work()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times), answer


def inner_ms(scene: Scene, name: str, **options: Any) -> tuple[float, harvest.Decision]:
    """Return the time of one decision, ms, from many of the same in one call on one thread."""
    target = scene.targets[name]
    many = {f"{name}_{k}": target for k in range(50)}
    ms, found = best_ms(lambda: harvest.plan(ROBOT, scene, many, threads=1, **options), 5)
    return ms / len(many), found[0]


def decisions(scene: Scene) -> list[dict[str, Any]]:
    rows = []
    for distance in ("tree", "exact"):
        for name in scene.targets:
            row: dict[str, Any] = {"distance": distance, "target": name}
            for label, options in {
                "ms": {},
                "refined_ms": {"settings": harvest.Settings(refine=True)},
                "full_ms": {"method": "full"},
            }.items():
                row[label], one = inner_ms(scene, name, distance=distance, **options)
                if label != "full_ms":
                    row["status"] = one.status.name
                    row["distance_mm"] = 1e3 * one.distance
            row["call_ms"], _ = best_ms(
                lambda name=name, distance=distance: harvest.plan(
                    ROBOT, scene, name, distance=distance, threads=1
                )
            )
            rows.append(row)
    return rows


def crop_of(fruits: int, points: int) -> Scene:
    """Return a row of plants, four fruits and eight leaves each, 0.35 m apart."""
    plants = max(1, fruits // 4)
    return greenhouse(
        seed=1,
        plants=plants,
        leaves=8,
        points=max(1, round(points / (8 * plants))),
        fruits=4,
        y0=0.0,
        y1=PITCH * plants,
    )


def crop(fruits: int, points: int, threads: int) -> dict[str, Any]:
    scene = crop_of(fruits, points)
    length = PITCH * max(1, fruits // 4)
    stops = np.arange(0.4, length, 0.8)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    options = {"stops": stops, "threads": threads, "blockers": False}
    harvest.evaluate(scene, ROBOT, **options)
    start = time.perf_counter()
    found = harvest.evaluate(scene, ROBOT, **options)
    seconds = time.perf_counter() - start
    start = time.perf_counter()
    blocked = harvest.evaluate(scene, ROBOT, **{**options, "blockers": True})
    with_blockers = time.perf_counter() - start
    return {
        "fruits": len(found.decisions),
        "points": sum(len(one.spheres) for one in scene.objects),
        "threads": threads,
        "stops": len(stops),
        "seconds": seconds,
        "seconds_with_blockers": with_blockers,
        "peak_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "peak_before_MB": before / 1024,
        "statuses": found.decisions.shares(),
        **{f"share_{name}": share for name, share in found.shares().items()},
        "blocked_named": sum(one is not None for one in blocked.blockers.values()),
    }


def searches(seeds: int, threads: int) -> list[dict[str, Any]]:
    programme = harvest.Programme(ROBOT, harvest.example_scene("cucumber_thin"), "C1")
    rows = []
    for name, search in (("ga", programme.genetic), ("de", programme.differential)):
        start = time.perf_counter()
        runs = search(range(seeds), threads=threads)
        seconds = time.perf_counter() - start
        terms = runs.terms
        rows.append(
            {
                "search": name,
                "seeds": seeds,
                "seconds_a_run": seconds * min(threads, seeds) / seeds,
                "cost_median": float(np.median(terms.cost)),
                "cost_best": float(terms.cost.min()),
                "cost_worst": float(terms.cost.max()),
                "position_mm_median": 1e3 * float(np.median(terms.position)),
                "orientation_median": float(np.median(terms.orientation)),
                "distance_mm_median": 1e3 * float(np.median(terms.distance)),
                "below_1.5e-4": int((terms.cost < 1.5e-4).sum()),
                "below_1e-6": int((terms.cost < 1e-6).sum()),
                "generations_median": float(np.median(runs.generations)),
            }
        )
    ms, best = best_ms(programme.null_space, 5)
    terms = programme.terms(best.q)
    rows.append(
        {
            "search": "null-space scan",
            "seeds": 1,
            "seconds_a_run": ms / 1e3,
            "cost_best": float(terms.cost),
            "distance_mm_median": 1e3 * float(terms.distance),
            "below_1e-6": int(terms.cost < 1e-6),
        }
    )
    return rows


def show(title: str, rows: list[dict[str, Any]]) -> None:
    print(f"\n{title}")
    for row in rows:
        words = (
            f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
            for key, value in row.items()
        )
        print("  " + ", ".join(words))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--crop-fruits", type=int, default=1000)
    parser.add_argument("--points", type=int, default=20_000)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", type=Path)
    given = parser.parse_args()
    machine = {
        "cpu": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "simd": simd_level(),
        "python": platform.python_version(),
    }
    parts = {
        "machine": [machine],
        "decisions, one thread": decisions(harvest.example_scene()),
        "crop": [
            crop(given.crop_fruits, given.points, given.threads),
            crop(given.crop_fruits, 10 * given.points, given.threads),
        ],
        "programme, thinned-out scene": searches(given.seeds, given.threads),
    }
    for title, rows in parts.items():
        show(title, rows)
    if given.output is not None:
        given.output.write_text(json.dumps(parts, indent=1) + "\n")


if __name__ == "__main__":
    main()
