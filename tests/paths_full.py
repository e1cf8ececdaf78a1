"""Paths of all kinds before a judge that shares nothing with the library; run as a program.

    PYTHONPATH=tests python tests/paths_full.py [--paths 10000] [--seed 1] [--processes 2]

Cucumber6 into the fruits of generated rows, with both recipes; the Panda in the three scenes of
the reference, and six more arms in generated crops, from random free postures to others. Each
path is sampled so that nothing moves more than 2 mm from one sample to the next, and the
distances of all bodies from all things, and from each other, are measured by the judge: none may
be less than what was certified.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import path_checker
import spec_scenes
from agrik_fast import Robot, harvest, motion
from agrik_fast.collision import Scene, greenhouse
from agrik_fast.errors import ArgumentError

START = [0.75, 1.21107, -1.390711, 0.720078, -1.544961, 1.591286, 5.612817]
"""Drawn back from the crop."""
RECIPES: tuple[dict[str, Any], ...] = (
    {"plants": 4, "leaves": 8, "clear_band": (0.65, 1.3)},
    {"plants": 5, "leaves": 12},
)
ARMS = ("ur5", "iiwa14", "redundant7", "puma560", "ur10e", "gen3")
CLEAR = 0.002
EACH = 8
"""Paths of one arm in one scene."""
PROVEN_BY_ROUNDING = 1e-9


@dataclass(frozen=True)
class Returned:
    """A path that was returned, and where it is."""

    arm: Robot
    path: motion.Plan
    scene: Scene
    aim: Any = None


def into_fruits(seed: int) -> Iterator[Returned]:
    """Yield the paths into the fruits of two rows."""
    arm = Robot.load("cucumber")
    for recipe in RECIPES:
        scene = greenhouse(seed, **recipe)
        for name, target in scene.targets.items():
            try:
                found = harvest.plan(arm, scene, [name], path=True, start=START, threads=1)
            except ArgumentError:  # a target inside a leaf
                continue
            path = found[name].path
            if path is not None and path.ok:
                yield Returned(arm, path, scene, target)


def between_postures(arm: Robot, scene: Scene, seed: int) -> Iterator[Returned]:
    """Yield paths from free postures to others that are drawn."""
    q = arm.random_q(40 * EACH, seed=seed)
    q = q[~scene.collides(arm, q, clear=CLEAR)][: 2 * EACH]
    for start, goal in zip(q[::2], q[1::2], strict=False):
        path = motion.plan(arm, start, goal, scene, settings=motion.Settings(seed=seed))
        if path.ok:
            yield Returned(arm, path, scene)


def returned(seed: int) -> Iterator[Returned]:
    """Yield the paths of one seed."""
    yield from into_fruits(seed)
    panda = Robot.load("panda")
    scenes = spec_scenes.scenes("panda")
    names = ("bench", "wall", "greenhouse5")
    yield from between_postures(panda, scenes[names[seed % 3]], seed)
    crop = greenhouse(seed, 2, 4, points=12, stem_x=0.75, y0=-0.7, y1=0.7, machine=False)
    yield from between_postures(Robot.load(ARMS[seed % len(ARMS)]), crop, seed)


def fault(one: Returned) -> str | None:
    """Return what a second judge says against a path."""
    certified = one.path.certified
    pairs = one.arm.self_pairs.asked
    judged = path_checker.judge(
        one.arm.name,
        one.path.path,
        one.scene,
        pairs,
        one.aim,
        # No need to know how far what is farther than was certified is.
        near=certified + 1e-4,
    )
    if not judged.within_limits:
        return "beyond the limits"
    if certified < CLEAR - PROVEN_BY_ROUNDING:
        return f"{1e3 * certified:.3f} mm certified, {1e3 * CLEAR:g} asked"
    if judged.least < certified - PROVEN_BY_ROUNDING:
        return f"{1e3 * judged.least:.6f} mm where {1e3 * certified:.6f} mm are certified"
    return None


def of_seed(seed: int) -> tuple[int, list[tuple[str, str]], list[str]]:
    """Return the arms and forms of the paths of a seed, and all faults."""
    kinds, faults = [], []
    for one in returned(seed):
        kinds.append((one.arm.name, one.path.how))
        said = fault(one)
        if said is not None:
            faults.append(f"seed {seed}, {one.arm.name}, {one.path.how}: {said}")
    return seed, kinds, faults


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--paths", type=int, default=10_000, help="how many, at least")
    parser.add_argument("--seed", type=int, default=1, help="the first seed")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    arms: Counter[str] = Counter()
    forms: Counter[str] = Counter()
    faults: list[str] = []
    begin, seed = time.perf_counter(), given.seed
    with multiprocessing.Pool(given.processes) as pool:
        while arms.total() < given.paths:
            batch = range(seed, seed + 4 * given.processes)
            seed = batch.stop
            for done, kinds, found in pool.imap(of_seed, batch):
                arms.update(arm for arm, _ in kinds)
                forms.update(form for _, form in kinds)
                faults += found
                minutes = (time.perf_counter() - begin) / 60
                said = f"{arms.total()} paths, {len(faults)} rejected, {minutes:.1f} min"
                print(f"seed {done}: {said}", flush=True)
    print(f"seeds {given.seed} to {seed - 1}")
    for title, counts in (("arm", arms), ("form", forms)):
        print(f"\n| {title} | paths |\n|---|---|")
        for name, count in counts.most_common():
            print(f"| {name} | {count} |")
    for said in faults:
        print(said)
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
