"""Proofs of ways, plans, and postures with their paths: times and shares.

    python benches/motion.py [--crop-fruits 1000] [--seeds 50] [--output FILE.json]

Prints one table a part: certified segments in the example scene; posture and path of one fruit;
a crop on two threads with its memory (stations of four plants, 640 points round each), a tenth of
it with ten times the points; the greenhouse generator with both recipes; the same plans on 1, 2
and 7 threads. Processor time, one thread, unless said.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from agrik_fast import Robot, harvest, motion, simd_level
from agrik_fast.collision import Scene, greenhouse
from agrik_fast.errors import ArgumentError

START = [0.75, 1.21107, -1.390711, 0.720078, -1.544961, 1.591286, 5.612817]
RECIPES: dict[str, dict[str, Any]] = {
    "stripped": {"plants": 4, "leaves": 8, "clear_band": (0.65, 1.3)},
    "dense": {"plants": 5, "leaves": 12},
}
PITCH = 0.35


def timed(work: Any) -> tuple[float, Any]:
    """Return the processor time of a call, s, and its answer."""
    start = time.process_time()
    answer = work()
    return time.process_time() - start, answer


def segments(arm: Robot, scene: Scene, count: int) -> dict[str, float]:
    """Time straight ways between free postures, one call each."""
    q = arm.random_q(8 * count, seed=1)
    q = q[~scene.collides(arm, q, clear=0.002)]
    a, b = q[:-1][:count], q[1:][:count]
    b = a + 0.25 * (b - a)
    found = motion.check_segments(arm, a, b, scene, clear=0.002, cap=0.002, threads=1)
    out = {}
    for outcome in (motion.Outcome.SAFE, motion.Outcome.HIT):
        rows = np.flatnonzero(found.outcome == outcome)
        times = []
        for k in rows:
            ends = (a[k : k + 1], b[k : k + 1])
            ask = lambda ends=ends: motion.check_segments(  # noqa: E731
                arm, *ends, scene, clear=0.002, cap=0.002, threads=1
            )
            times.append(min(timed(ask)[0] for _ in range(3)))
        batch = timed(
            lambda rows=rows: motion.check_segments(
                arm, a[rows], b[rows], scene, clear=0.002, cap=0.002, threads=1
            )
        )[0]
        name = outcome.name
        out[f"{name} ways"] = float(len(rows))
        out[f"{name} median us a call"] = 1e6 * float(np.median(times))
        out[f"{name} mean us in a batch"] = 1e6 * batch / len(rows)
        out[f"{name} median checks"] = float(np.median(found.checks[rows]))
    return out


def fruits(arm: Robot, seeds: int) -> dict[str, Any]:
    """Plan posture and path for every fruit of generated rows, one call each."""
    out: dict[str, Any] = {}
    for name, recipe in RECIPES.items():
        words: Counter[str] = Counter()
        times = []
        for seed in range(1, seeds + 1):
            scene = greenhouse(seed, **recipe)
            for target in scene.targets:
                try:
                    seconds, found = timed(
                        lambda scene=scene, target=target: harvest.plan(
                            arm, scene, [target], path=True, start=START, threads=1
                        )
                    )
                except ArgumentError:  # a target inside a leaf
                    words["inside a leaf"] += 1
                    continue
                if not found.ok[0]:
                    words[f"no posture: {harvest.Status(found.status[0]).name}"] += 1
                    continue
                times.append(1e3 * seconds)
                words[found.paths[0].status.name] += 1
        with_posture = len(times)
        decided = words["OK"] + words["PATH_IMPOSSIBLE"]
        out[name] = {
            **words,
            "decided, share": decided / max(1, with_posture),
            "median ms": float(np.median(times)),
            "p95 ms": float(np.percentile(times, 95)),
        }
    return out


def crop(arm: Robot, count: int, points: int) -> dict[str, Any]:
    """Plan a whole crop on two threads: fruits of rows side by side, one call a row."""
    begin, cpu = time.perf_counter(), time.process_time()
    done, words, used = 0, Counter[str](), 0
    seed = 1000
    while done < count:
        scene = greenhouse(seed, plants=4, leaves=8, points=points, clear_band=(0.65, 1.3))
        seed += 1
        names = list(scene.targets)[: count - done]
        try:
            found = harvest.plan(arm, scene, names, path=True, start=START, threads=2)
        except ArgumentError:
            continue
        used += sum(len(one.spheres) for one in scene.objects)
        done += len(names)
        words.update(path.status.name for path in found.paths)
    return {
        "fruits": done,
        "points": used,
        "seconds": time.perf_counter() - begin,
        "cpu seconds of two threads": time.process_time() - cpu,
        "cpu ms a fruit": 1e3 * (time.process_time() - cpu) / done,
        "peak MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        **words,
    }


def threads(arm: Robot) -> bool:
    """Plan the same rows on 1, 2 and 7 threads; true where all bytes are the same."""

    def of(count: int) -> list[bytes]:
        out = []
        for seed in range(1, 11):
            scene = greenhouse(seed, **RECIPES["stripped"])
            found = harvest.plan(arm, scene, path=True, start=START, threads=count)
            out += [path.path.tobytes() + path.clearance.tobytes() for path in found.paths]
        return out

    one = of(1)
    return one == of(2) == of(7)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--crop-fruits", type=int, default=1000)
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--segments", type=int, default=400)
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    arm = Robot.load("cucumber")
    parts: dict[str, Any] = {"instructions": simd_level()}
    parts["segments"] = segments(arm, harvest.example_scene(), options.segments)
    parts["fruits"] = fruits(arm, options.seeds)
    parts["crop"] = crop(arm, options.crop_fruits, 20)
    some = options.crop_fruits // 10
    parts["a tenth of it"] = crop(arm, some, 20)
    parts["a tenth, ten times the points"] = crop(arm, some, 200)
    parts["growth"] = (
        parts["a tenth, ten times the points"]["cpu ms a fruit"]
        / parts["a tenth of it"]["cpu ms a fruit"]
    )
    parts["same bytes for 1, 2 and 7 threads"] = threads(arm)
    print(json.dumps(parts, indent=2))
    if options.output is not None:
        options.output.write_text(json.dumps(parts, indent=2) + "\n")


if __name__ == "__main__":
    main()
