"""Hits of postures beside VAMP, whose robots are compiled: never part of the checks.

    .venv/bin/python benches/vamp.py --sources FOLDER [--scenes 2]

FOLDER holds the sources of VAMP (Apache-2.0; the public repository KavrakiLab/vamp, or the sdist
`vamp-planner` of PyPI) with `src/impl`, in it the headers of KavrakiLab/nigh, orlp/pdqsort and
lemire/SIMDxorshift, and `resources/panda/problems.tar.bz2`. They and Debian's libeigen3-dev are
built by g++ -O2 into a folder that is thrown away. CPU time of one thread, of some repeats the
least.

Panda: the same edges of eight near postures in VAMP's own scenes, all free for both; VAMP has 59
spheres on its links, ours 12 capsules and boxes of other sizes that are chosen at run time, and the
pairs of its own bodies. Points: VAMP's Panda among a list of spheres, our cucumber arm with exact
boxes among as many, free postures alone.
"""

from __future__ import annotations

import argparse
import gc
import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from peer_bench import vamp_problems
from peer_bench.machine import describe, measuring_core
from peer_bench.scenes import Arm, Things
from peer_bench.vamp_problems import Problem

import agrik_fast as ik
from agrik_fast import _native

STEP = 1 / 32  # rad, between two postures of an edge, as VAMP has them


def ours(rows: dict[str, np.ndarray]) -> _native.Scene:
    """Return the same scene as ours, all of it one object."""
    boxes = rows["boxes"]
    turns = boxes[:, 6:].reshape(-1, 3, 3).transpose(0, 2, 1).reshape(-1, 9)
    as_ours = np.concatenate([boxes[:, :6], turns, np.zeros((len(boxes), 1))], axis=1)
    given = {"spheres": rows["spheres"], "capsules": rows["capsules"], "boxes": as_ours}
    labels = {
        f"{kind[:-2] if kind == 'boxes' else kind[:-1]}_labels": np.zeros(len(row))
        for kind, row in given.items()
    }
    return _native.Scene(["things"], **given, **labels)


def edges(arm: Arm, count: int, seed: int) -> np.ndarray:
    """Return edges of eight postures, shape (count, 8, 7)."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(arm.chain.lower, arm.chain.upper, (count, 7))
    way = rng.normal(size=(count, 7))
    way *= STEP / np.linalg.norm(way, axis=1, keepdims=True)
    return start[:, None] + np.arange(8)[:, None] * way[:, None]


class Vamp:
    """VAMP's check as a program."""

    def __init__(self, sources: Path, folder: Path) -> None:
        self.folder = folder
        self.program = vamp_problems.build("vamp_blocks", sources, folder)

    def ask(
        self, cases: list[tuple[dict[str, np.ndarray], np.ndarray]], repeats: int
    ) -> list[tuple[float, np.ndarray]]:
        """Return the time of a posture, s, and which blocks are free, of each case."""
        numbers = []
        for rows, blocks in cases:
            counts = [len(rows["spheres"]), len(rows["capsules"]), len(rows["boxes"]), len(blocks)]
            numbers += [np.array(counts, float), *(rows[kind].ravel() for kind in rows)]
            numbers.append(blocks.ravel())
        data = self.folder / "cases"
        data.write_bytes(np.concatenate(numbers).astype(float).tobytes())
        command = [str(self.program), str(data), str(repeats)]
        said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        rows = [line.split() for line in said.splitlines()]
        return [(float(row[0]), np.array(row[1:], int).astype(bool)) for row in rows]


def least(repeats: int, collider: _native.Collider, q: np.ndarray) -> float:
    times = []
    for _ in range(repeats):
        start = time.process_time()
        collider.collides(q, threads=1)
        times.append((time.process_time() - start) / len(q))
    return min(times)


def panda(vamp: Vamp, chosen: list[Problem]) -> None:
    arm = Arm.of("panda")
    blocks = edges(arm, 3000, 1)
    first = vamp.ask([(one.rows, blocks) for one in chosen], 1)
    cases, colliders = [], []
    for one, (_, free) in zip(chosen, first, strict=True):
        collider = _native.Collider(arm.bodies, ours(one.rows))
        both = free & ~collider.collides(blocks).any(1)
        cases.append((one.rows, blocks[both]))
        colliders.append(collider)
    timed = vamp.ask(cases, 15)
    print("\n| VAMP's scene | things | edges | VAMP, ns | ours, ns | ours is |")
    print("|---|---|---|---|---|---|")
    ratios = []
    for one, (_, free), collider, (theirs, _) in zip(chosen, cases, colliders, timed, strict=True):
        took = least(9, collider, free.reshape(-1, 7))
        ratios.append(theirs / took)
        print(
            f"| {one.name} | {one.things} | {len(free)} | {1e9 * theirs:.0f} |"
            f" {1e9 * took:.0f} | {theirs / took:.2f} x |"
        )
    print(f"median {np.median(ratios):.2f} x")


def points(vamp: Vamp) -> None:
    arm, cucumber = Arm.of("panda"), Arm.of("cucumber")
    q = cucumber.postures(50_000)
    print("\n| points | VAMP's list, M/s | our boxes, M/s | ours is | blocks, postures |")
    print("|---|---|---|---|---|")
    scene = Things.of(cucumber, "scene")
    made = {"": scene, ", in a row": scene.in_a_row(10), ", as dense": scene.denser(10)}
    for where, things in made.items():
        collider = cucumber.among(things.made())
        spheres = np.array(things.rows["sphere"])
        # Where the Panda stands there is no crop: its base is where the other arm's is.
        moved = spheres - np.array([0.0, 0.0, 0.6, 0.0])
        rows = {"spheres": moved, "capsules": np.zeros((0, 7)), "boxes": np.zeros((0, 15))}
        rng = np.random.default_rng(3)
        blocks = rng.uniform(arm.chain.lower, arm.chain.upper, (4000, 1, 7))
        blocks = blocks + rng.normal(scale=0.01, size=(4000, 8, 7))
        # A hit ends a block of eight at once, and says nothing of the other seven: those that
        # are free are answered for.
        blocks = blocks[vamp.ask([(rows, blocks)], 1)[0][1]]
        theirs = vamp.ask([(rows, blocks)], 9)[0][0]
        free = q[~collider.collides(q)]
        took = least(7, collider, free)
        print(
            f"| {len(spheres)}{where} | {1e-6 / theirs:.2f} | {1e-6 / took:.2f} |"
            f" {theirs / took:.2f} x | {len(blocks)}, {len(free)} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--sources", type=Path, required=True, help="sources of VAMP")
    parser.add_argument("--scenes", type=int, default=2, help="how many of each of its sets")
    options = parser.parse_args()
    chosen = vamp_problems.of_sources(options.sources, options.scenes)
    print(describe(), ik.simd_level())
    core = measuring_core()
    if core >= 0:
        os.sched_setaffinity(0, {core})
    gc.disable()
    with tempfile.TemporaryDirectory() as folder:
        vamp = Vamp(options.sources, Path(folder))
        panda(vamp, chosen)
        points(vamp)


if __name__ == "__main__":
    main()
