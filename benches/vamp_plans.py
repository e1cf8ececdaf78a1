"""VAMP's 700 problems for the Panda: plans beside VAMP's own, and their goals as IK targets.

    .venv/bin/python benches/vamp_plans.py --sources FOLDER [--each 100] [--repeats 3]

FOLDER is that of `vamp.py`. VAMP plans with RRT-Connect, buffers for 20,000 nodes and without
making paths shorter, on a Panda of 59 spheres whose code was generated; ours plans with certified
edges on the bundled Panda, its fingers open as VAMP's are, once without making paths shorter and
once as it is by default but for its budget. Only problems whose start and goal are free in both
models count, and within our limits. CPU time of one thread, of some repeats the least.

Then the goals as poses of the flange: `Robot.ik` in the scene, one call a target.
"""

from __future__ import annotations

import argparse
import gc
import os
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from peer_bench import vamp_problems
from peer_bench.machine import describe, measuring_core
from peer_bench.vamp_problems import Problem

from agrik_fast import Robot, motion, simd_level
from agrik_fast.collision import Body, Box, Capsule, CollisionRules, Scene, SceneObject, Sphere

NODES = 20_000
BUDGET = {"rounds": 20_000, "max_checks": 20_000_000}
# How far VAMP's fingers are open, m, to either side.
OPEN = 0.065


def with_open_hand(arm: Robot) -> Robot:
    """Return the Panda with two fingers instead of one box round the way of both."""
    both = next(body for body in arm.bodies if body.name == "fingers")
    assert isinstance(both.shape, Box)
    turn, centre = np.array(both.shape.rotation), np.array(both.shape.centre)
    half = np.array([0.0105, 0.0095, both.shape.half[2] - 0.002])
    side = turn[:, 1] * (OPEN + half[1] + 0.002)
    fingers = [
        Body(name, both.frame, Box(centre + sign * side, half, rotation=turn, radius=0.002))
        for name, sign in (("left", 1), ("right", -1))
    ]
    pairs = []
    for a, b in arm.self_pairs.asked:
        if b == both.name:
            pairs += [(a, finger.name) for finger in fingers]
        else:
            pairs.append((a, b))
    kept = [body for body in arm.bodies if body.name != both.name]
    return arm.with_bodies([*kept, *fingers], CollisionRules(pairs=pairs))


def scene_of(problem: Problem) -> Scene:
    """Return the things of a problem as one object."""
    rows = problem.rows
    shapes: list[Any] = [Sphere(row[:3], row[3]) for row in rows["spheres"]]
    shapes += [Capsule(row[:3], row[3:6], row[6]) for row in rows["capsules"]]
    shapes += [Box(row[:3], row[3:6], rotation=row[6:].reshape(3, 3).T) for row in rows["boxes"]]
    return Scene([SceneObject.of("things", *shapes)])


def least(repeats: int, work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the least time of some calls, us, and the answer."""
    best, answer = np.inf, None
    for _ in range(repeats):
        start = time.process_time()
        answer = work()
        best = min(best, time.process_time() - start)
    return 1e6 * best, answer


def theirs(sources: Path, problems: list[Problem], repeats: int) -> np.ndarray:
    """Return of each problem whether it is free, whether it is solved, and the time, us."""
    numbers: list[np.ndarray] = []
    for one in problems:
        numbers.append(np.array([len(rows) for rows in one.rows.values()], float))
        numbers += [*(rows.ravel() for rows in one.rows.values()), one.start, one.goal]
    with tempfile.TemporaryDirectory() as name:
        program = vamp_problems.build("vamp_plans", sources, Path(name))
        data = Path(name) / "cases"
        data.write_bytes(np.concatenate(numbers).astype(float).tobytes())
        command = [str(program), str(data), str(repeats), str(NODES)]
        said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = np.array([line.split() for line in said.splitlines()], float)
    rows[:, 2] *= 1e-3
    return rows


def told(name: str, times: np.ndarray, solved: int) -> None:
    median, p95 = np.percentile(times, [50, 95])
    print(f"| {name} | {len(times)} | {solved} | {median:.0f} | {times.mean():.0f} | {p95:.0f} |")


def plans(arm: Robot, cases: list[tuple[Problem, Scene]], peer: np.ndarray, repeats: int) -> None:
    print("\n| plans | problems | solved | median, us | mean, us | p95, us |")
    print("|---|---|---|---|---|---|")
    told("VAMP", peer[:, 2], int(peer[:, 1].sum()))
    keep: dict[str, Any] = {"clear": 0.0, "own_clear": 0.0, "cap": 0.0, **BUDGET}
    unsolved: Counter[str] = Counter()
    for name, more in (("ours, not shortened", {"shortcuts": 0}), ("ours, shortened", {})):
        settings = motion.Settings(**keep, **more)
        times, solved = [], 0
        for problem, scene in cases:
            took, found = least(
                repeats,
                lambda problem=problem, scene=scene, settings=settings: motion.plan(
                    arm, problem.start, problem.goal, scene, settings=settings
                ),
            )
            times.append(took)
            solved += found.ok
            if not found.ok:
                unsolved[f"{name}: {problem.name} {found.status.name}"] += 1
        told(name, np.array(times), solved)
        print(f"| | {np.median(times) / np.median(peer[:, 2]):.1f} x VAMP's median | | | | |")
    for row in unsolved:
        print(row)


def inverse(arm: Robot, goals: list[tuple[Problem, Scene]], all_goals: int, repeats: int) -> None:
    times, solved, statuses = [], 0, Counter[str]()
    by_set: dict[str, list[float]] = {}
    for problem, scene in goals:
        pose = arm.fk(problem.goal)
        took, found = least(
            repeats, lambda pose=pose, scene=scene: arm.ik(pose, scene=scene, seed=1)
        )
        q = np.asarray(found.q).reshape(-1)
        right = bool(np.all(found.success)) and not bool(scene.collides(arm, q))
        right = right and bool(np.abs(arm.fk(q) - pose).max() < 1e-5)
        statuses["free" if right else str(found.status)] += 1
        solved += right
        times.append(took)
        by_set.setdefault(problem.family, []).append(took)
    print(f"\ngoals free in our model: {len(goals)} of {all_goals}")
    print("\n| IK in the scene | targets | solved | median, us | mean, us | p95, us |")
    print("|---|---|---|---|---|---|")
    for name, some in sorted(by_set.items()):
        told(name, np.array(some), len(some))
    told("all", np.array(times), solved)
    print(dict(statuses))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--sources", type=Path, required=True, help="sources of VAMP")
    parser.add_argument("--each", type=int, default=100, help="problems of each of the 7 sets")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    problems = vamp_problems.of_sources(options.sources, options.each)
    print(describe(), simd_level())
    core = measuring_core()
    if core >= 0:
        os.sched_setaffinity(0, {core})
    gc.disable()
    arm = with_open_hand(Robot.load("panda"))
    peer = theirs(options.sources, problems, options.repeats)
    scenes = [scene_of(one) for one in problems]

    def is_free(scene: Scene, q: np.ndarray) -> bool:
        within = bool(((q >= arm.lower) & (q <= arm.upper)).all())
        return within and not bool(scene.collides(arm, q))

    each = list(zip(problems, scenes, strict=True))
    starts = np.array([is_free(scene, one.start) for one, scene in each])
    ends = np.array([is_free(scene, one.goal) for one, scene in each])
    both = starts & ends & (peer[:, 0] > 0)
    print(f"{len(problems)} problems, {int(peer[:, 0].sum())} free in VAMP's model")
    print(f"{both.sum()} in ours as well (starts {starts.sum()}, goals {ends.sum()})")
    hit = Counter(one.family for one, free in zip(problems, both, strict=True) if not free)
    print("not free:", dict(hit))
    plans(arm, [each[k] for k in np.flatnonzero(both)], peer[both], options.repeats)
    inverse(arm, [each[k] for k in np.flatnonzero(ends)], len(problems), options.repeats)


if __name__ == "__main__":
    main()
