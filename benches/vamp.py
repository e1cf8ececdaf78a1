"""Hits of postures beside VAMP, whose robots are compiled: never part of the checks.

    .venv/bin/python benches/vamp.py --sources FOLDER [--scenes 10]

FOLDER holds the sources of VAMP (Apache-2.0; the public repository KavrakiLab/vamp, or the sdist
`vamp-planner` of PyPI) with `src/impl` and `resources/panda/problems.tar.bz2`. Its headers and
Debian's libeigen3-dev are built by g++ -O2 into a folder that is thrown away. CPU time of one
thread, of some repeats the least.

Panda: the same edges of eight near postures in VAMP's own scenes, all free for both; VAMP has 59
spheres on its links, ours 12 capsules and boxes of other sizes that are chosen at run time, and the
pairs of its own bodies. Points: VAMP's Panda among a list of spheres, our cucumber arm with exact
boxes among as many.
"""

from __future__ import annotations

import argparse
import gc
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml
from peer_bench.machine import describe, measuring_core
from peer_bench.scenes import Arm, Things
from scipy.spatial.transform import Rotation

import agrik_fast as ik
from agrik_fast import _native

HERE = Path(__file__).parent
STEP = 1 / 32  # rad, between two postures of an edge, as VAMP has them


def transform(given: dict) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(given["orientation"]).as_matrix()
    matrix[:3, 3] = given["position"]
    return matrix


def scenes(problems: Path, count: int) -> list[tuple[str, dict[str, np.ndarray]]]:
    """Read some scenes of each family of VAMP's problems for the Panda."""
    found = []
    with tarfile.open(problems) as archive:
        members = sorted(m.name for m in archive if "/scene0" in m.name)
        families = sorted({name.split("/")[-2] for name in members})
        chosen = []
        for family in families:
            own = [name for name in members if name.split("/")[-2] == family]
            chosen += own[: max(1, count // len(families))]
        for name in chosen:
            file = archive.extractfile(name)
            world = yaml.safe_load(file)["world"]["collision_objects"] if file else []
            rows: dict[str, list] = {"spheres": [], "capsules": [], "boxes": []}
            for thing in world:
                base = transform(thing["pose"]) if "pose" in thing else np.eye(4)
                shape = thing["primitives"][0]
                at = base @ transform(thing["primitive_poses"][0])
                size = shape["dimensions"]
                if shape["type"] == "sphere":
                    rows["spheres"].append([*at[:3, 3], size[0]])
                elif shape["type"] == "cylinder":
                    half = 0.5 * size[0] * at[:3, 2]
                    rows["capsules"].append([*(at[:3, 3] - half), *(at[:3, 3] + half), size[1]])
                else:
                    halves = 0.5 * np.array(size)
                    rows["boxes"].append([*at[:3, 3], *halves, *at[:3, :3].T.ravel()])
            widths = {"spheres": 4, "capsules": 7, "boxes": 15}
            arrays = {kind: np.reshape(rows[kind], (-1, widths[kind])) for kind in rows}
            found.append((name.split("/", 1)[-1], arrays))
    return found


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
        self.program, self.folder = folder / "vamp_blocks", folder
        subprocess.run(
            [
                *("g++", "-O2", "-std=c++17", "-march=native", "-ffast-math"),
                *(str(HERE / "peer_bench/vamp_blocks.cpp"), f"-I{sources / 'src/impl'}"),
                *("-I/usr/include/eigen3", "-o", str(self.program)),
            ],
            check=True,
        )

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


def panda(vamp: Vamp, problems: Path, count: int) -> None:
    arm = Arm.of("panda")
    chosen = scenes(problems, count)
    blocks = edges(arm, 3000, 1)
    first = vamp.ask([(rows, blocks) for _, rows in chosen], 1)
    cases, colliders = [], []
    for (_, rows), (_, free) in zip(chosen, first, strict=True):
        collider = _native.Collider(arm.bodies, ours(rows))
        both = free & ~collider.collides(blocks).any(1)
        cases.append((rows, blocks[both]))
        colliders.append(collider)
    timed = vamp.ask(cases, 15)
    print("\n| VAMP's scene | things | edges | VAMP, ns | ours, ns | ours is |")
    print("|---|---|---|---|---|---|")
    ratios = []
    for (name, rows), (_, free), collider, (theirs, _) in zip(
        chosen, cases, colliders, timed, strict=True
    ):
        took = least(9, collider, free.reshape(-1, 7))
        ratios.append(theirs / took)
        things = sum(map(len, rows.values()))
        print(
            f"| {name} | {things} | {len(free)} | {1e9 * theirs:.0f} | {1e9 * took:.0f} |"
            f" {theirs / took:.2f} x |"
        )
    print(f"median {np.median(ratios):.2f} x")


def points(vamp: Vamp) -> None:
    arm, cucumber = Arm.of("panda"), Arm.of("cucumber")
    q = cucumber.postures(50_000)
    print("\n| points | VAMP's list, M/s | our boxes, M/s | ours is |")
    print("|---|---|---|---|")
    for times in (1, 10):
        things = Things.of(cucumber, "scene")
        things = things if times == 1 else things.in_a_row(times)
        collider = cucumber.among(things.made())
        spheres = np.array(things.rows["sphere"])
        # Where the Panda stands there is no crop: its base is where the other arm's is.
        moved = spheres - np.array([0.0, 0.0, 0.6, 0.0])
        rows = {"spheres": moved, "capsules": np.zeros((0, 7)), "boxes": np.zeros((0, 15))}
        rng = np.random.default_rng(3)
        blocks = rng.uniform(arm.chain.lower, arm.chain.upper, (4000, 1, 7))
        blocks = blocks + rng.normal(scale=0.01, size=(4000, 8, 7))
        theirs = vamp.ask([(rows, blocks)], 9)[0][0]
        took = least(7, collider, q)
        print(
            f"| {len(spheres)} | {1e-6 / theirs:.2f} | {1e-6 / took:.2f} | {theirs / took:.2f} x |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--sources", type=Path, required=True, help="sources of VAMP")
    parser.add_argument("--scenes", type=int, default=14, help="how many of its scenes")
    options = parser.parse_args()
    problems = options.sources / "resources/panda/problems.tar.bz2"
    if not (options.sources / "src/impl/vamp").is_dir() or not problems.is_file():
        sys.exit(
            f"vamp.py: --sources: {options.sources} has no src/impl/vamp or no {problems.name}"
        )
    print(describe(), ik.simd_level())
    core = measuring_core()
    if core >= 0:
        os.sched_setaffinity(0, {core})
    gc.disable()
    with tempfile.TemporaryDirectory() as folder:
        vamp = Vamp(options.sources, Path(folder))
        panda(vamp, problems, options.scenes)
        points(vamp)


if __name__ == "__main__":
    main()
