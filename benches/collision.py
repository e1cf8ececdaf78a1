"""Time collisions, distances and inverse kinematics among things, beside coal and python-fcl.

All in one run, on one core, one thread, garbage collector off; CPU time, of some repeats the
least. The peers get the poses of the bodies ready-made; ours works them out.

    .venv/bin/python benches/collision.py [--only rates,growth,build,ik,coal,fcl] [--quick]

coal's pairs are asked in C++: the wheel `coal` has its headers and library, Debian's
libeigen3-dev the rest, and g++ builds `peer_bench/coal_pairs.cpp` in a folder that is thrown
away. A peer that is not installed is left out, and said to be.
"""

from __future__ import annotations

import argparse
import gc
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from peer_bench.machine import describe, measuring_core
from peer_bench.scenes import BUNDLED, SCENES, Arm, Things

import agrik_fast as ik
from agrik_fast import _native

CAP = 0.075  # m, of the cucumber paper's cost
HERE = Path(__file__).parent


def seconds(repeats: int, call: Callable[..., object], *given: object, **named: object) -> float:
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call(*given, **named)
        times.append(time.process_time() - start)
    return min(times)


def rates(quick: bool) -> None:
    count = 20_000 if quick else 100_000
    print("\n| arm, scene | free | hits and itself, M/s | capped 75 mm, us | distance, us |")
    print("|---|---|---|---|---|")
    for name, scenes in SCENES.items():
        arm = Arm.of(name)
        for scene in scenes:
            collider = arm.among(Things.of(arm, scene).made())
            q = arm.postures(count)
            few = q[: count // 5]
            hits = seconds(5, collider.collides, q, threads=1)
            capped = seconds(3, collider.clearance, few, CAP, threads=1)
            full = seconds(3, collider.clearance, few, threads=1, own=False)
            free = 1 - collider.collides(q).mean()
            row = [free, count / hits / 1e6, capped / len(few) * 1e6, full / len(few) * 1e6]
            print(f"| {name}, {scene} | " + " | ".join(f"{x:.2f}" for x in row) + " |")


def growth(quick: bool) -> None:
    arm = Arm.of("cucumber")
    things = Things.of(arm, "scene")
    q = arm.postures(4_000 if quick else 20_000)
    print("\n| points | hits, ns | capped 75 mm, ns | distance, ns | times the first |")
    print("|---|---|---|---|---|")
    first: list[float] = []
    for label, made in [
        ("scene", things),
        ("ten in a row", things.in_a_row(10)),
        ("thirty in a row", things.in_a_row(30)),
        ("ten times as dense", things.denser(10)),
    ]:
        collider = arm.among(made.made())
        each = [
            seconds(5, collider.collides, q, threads=1),
            seconds(3, collider.clearance, q, CAP, threads=1, own=False),
            seconds(3, collider.clearance, q, threads=1, own=False),
        ]
        each = [1e9 * x / len(q) for x in each]
        first = first or each
        times = " ".join(f"{x / y:.2f}" for x, y in zip(each, first, strict=True))
        row = " | ".join(f"{x:.0f}" for x in each)
        print(f"| {len(made.rows['sphere'])} {label} | {row} | {times} |")


def build(quick: bool) -> None:
    rng = np.random.default_rng(0)
    for count in (1_000, 100_000) if quick else (1_000, 100_000, 1_000_000):
        points = rng.uniform([0.4, -0.7, 0.1, 0.005], [0.9, 0.8, 1.9, 0.005], (count, 4))
        labels = np.arange(count) % 50
        names = [f"leaf{i}" for i in range(50)]
        took = seconds(5, _native.Scene, names, spheres=points, sphere_labels=labels)
        print(f"scene of {count} points built: {1e3 * took:.2f} ms")


def inverse(quick: bool) -> None:
    count = 1_000 if quick else 10_000
    print("\n| arm, scene | solver, prefer | plain, us | of it | free and exact | false |")
    print("|---|---|---|---|---|---|")
    for name in [*SCENES, *BUNDLED]:
        arm = Arm.bundled(name) if name in BUNDLED else Arm.of(name)
        for scene in SCENES.get(name, SCENES["panda"]):
            collider = arm.among(Things.of(arm, scene).made())
            q = arm.postures(30 * count, seed=2)
            q = q[~collider.collides(q)][:count]
            targets = arm.chain.fk(q)
            for solver, prefer in [
                ("lm", "first"),
                ("auto", "first"),
                ("lm", "near"),
                ("lm", "clearance"),
            ]:
                some = targets if prefer == "first" else targets[: count // 10]
                asked = (some, None, solver)
                guard = {"collider": collider, "prefer": prefer}
                plain = seconds(3, arm.chain.ik, *asked, threads=1)
                took = seconds(3, arm.chain.ik, *asked, threads=1, **guard)
                result = arm.chain.ik(*asked, **guard)
                off = np.abs(arm.chain.fk(result.q) - some).max((1, 2))
                hits = collider.distances(result.q)
                hits = np.minimum(hits.distance.min(1), hits.own_distance) <= 0
                good = result.success & (off < 1e-5)
                false = int((result.success & hits).sum())
                print(
                    f"| {name}, {scene} | {solver}, {prefer} | {1e6 * plain / len(some):.2f} |"
                    f" {took / plain:.2f} x | {good.mean():.4%} | {false} |"
                )


def box_poses(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Return poses of the boxes' centres, shape (postures, boxes, 4, 4)."""
    poses = arm.chain.fk_links(q)[:, [frame - 1 for frame in arm.bodies.frames]]
    _, cores = arm_boxes(arm)
    centres = np.tile(np.eye(4), (len(cores), 1, 1))
    centres[:, :3, 3] = [centre for centre, _ in cores]
    return poses @ centres


def arm_boxes(arm: Arm) -> tuple[list[str], list[tuple[np.ndarray, np.ndarray]]]:
    from peer_bench.scenes import read

    boxes = read(arm.name)["bodies"]
    sizes = [(np.array(b["centre"]) * arm.unit, np.array(b["half"]) * arm.unit) for b in boxes]
    return [box["name"] for box in boxes], sizes


def points_alone(arm: Arm) -> Things:
    things = Things.of(arm, "scene")
    only = Things([], 1.0)
    only.names = things.names
    only.rows = {"sphere": things.rows["sphere"]}
    only.labels = {"sphere": things.labels["sphere"]}
    return only


def coal(quick: bool) -> None:
    spec = importlib.util.find_spec("coal")
    if spec is None or not Path("/usr/include/eigen3").exists():
        print("coal: not measured; needs the wheel `coal` and Debian's libeigen3-dev")
        return
    prefix = next(p for p in Path(str(spec.origin)).parents if p.name == "cmeel.prefix")
    arm = Arm.of("cucumber")
    q = arm.postures(20 if quick else 200)
    things = points_alone(arm)
    poses = box_poses(arm, q)
    halves = [half for _, half in arm_boxes(arm)[1]]
    spheres = np.array(things.rows["sphere"])
    with tempfile.TemporaryDirectory() as folder:
        program, data = Path(folder) / "coal_pairs", Path(folder) / "data"
        numbers = [[len(q), len(halves), len(spheres)], np.ravel(halves), spheres.ravel()]
        flat = np.concatenate([*map(np.asarray, numbers), poses[:, :, :3].ravel()])
        data.write_bytes(flat.astype(float).tobytes())
        subprocess.run(
            [
                *("g++", "-O2", "-std=c++17", str(HERE / "peer_bench/coal_pairs.cpp")),
                *(f"-I{prefix}/include", "-I/usr/include/eigen3", f"-L{prefix}/lib", "-lcoal"),
                *(f"-Wl,-rpath,{prefix}/lib", f"-Wl,-rpath-link,{prefix}/lib"),
                *("-o", str(program)),
            ],
            check=True,
        )
        said = subprocess.run(
            [str(program), str(data)], check=True, capture_output=True, text=True
        ).stdout.split("\n")
    pairs, tree = map(float, said[0].split())
    least = np.array([float(line.split()[0]) for line in said[1 : len(q) + 1]])
    hits = np.array([int(line.split()[1]) for line in said[1 : len(q) + 1]], bool)
    collider = _native.Collider(arm.bodies, things.made())
    ours = seconds(9, collider.clearance, q, threads=1, own=False) / len(q)
    distance = collider.clearance(q, own=False)
    free = distance > 0
    off = np.abs(distance - least)[free] / least[free]
    print(f"\ncoal, all {len(halves) * len(spheres)} pairs of a posture: {1e6 * pairs:.0f} us")
    print(f"ours, distance of the posture: {1e6 * ours:.2f} us, {pairs / ours:.0f} x less")
    print(f"largest relative difference of {free.sum()} free postures: {off.max():.1e}")
    ours = seconds(9, collider.collides, q, threads=1) / len(q)
    print(
        f"coal, hits by its tree of boxes: {1e6 * tree:.2f} us;"
        f" ours, with itself: {1e6 * ours:.2f} us"
    )
    print(f"disagreements about hits: {(hits != ~free).sum()} of {len(q)}")


def fcl(quick: bool) -> None:
    if importlib.util.find_spec("fcl") is None:
        print("python-fcl: not installed, not measured")
        return
    import fcl as peer

    arm = Arm.of("cucumber")
    q = arm.postures(20 if quick else 200)
    things = points_alone(arm)
    spheres = np.array(things.rows["sphere"])
    objects = [
        peer.CollisionObject(peer.Sphere(row[3]), peer.Transform(np.eye(3), row[:3]))
        for row in spheres
    ]
    manager = peer.DynamicAABBTreeCollisionManager()
    manager.registerObjects(objects)
    manager.setup()
    boxes = [peer.Box(*(2 * half)) for _, half in arm_boxes(arm)[1]]
    placed = [
        [
            peer.CollisionObject(box, peer.Transform(pose[:3, :3], pose[:3, 3]))
            for box, pose in zip(boxes, row, strict=True)
        ]
        for row in box_poses(arm, q)
    ]

    def distances() -> list[float]:
        least = []
        for row in placed:
            best = np.inf
            for body in row:
                data = peer.DistanceData()
                manager.distance(body, data, peer.defaultDistanceCallback)
                best = min(best, data.result.min_distance)
            least.append(best)
        return least

    took = seconds(3, distances) / len(q)
    collider = _native.Collider(arm.bodies, things.made())
    ours = seconds(9, collider.clearance, q, threads=1, own=False) / len(q)
    free = collider.clearance(q, own=False) > 0
    off = np.abs(np.array(distances()) - collider.clearance(q, own=False))[free].max()
    print(f"\npython-fcl, distance by its manager: {1e6 * took:.0f} us a posture")
    print(f"ours: {1e6 * ours:.2f} us, {took / ours:.0f} x less; largest difference {off:.1e} m")


def main() -> None:
    parts = {
        "rates": rates,
        "growth": growth,
        "build": build,
        "ik": inverse,
        "coal": coal,
        "fcl": fcl,
    }
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--only", default=",".join(parts), help="parts, comma between them")
    parser.add_argument("--quick", action="store_true", help="fewer postures")
    options = parser.parse_args()
    wanted = options.only.split(",")
    if unknown := sorted(set(wanted) - set(parts)):
        sys.exit(
            f"collision.py: --only: no part {', '.join(unknown)}; there are {', '.join(parts)}"
        )
    print(describe(), ik.simd_level())
    gc.disable()
    core = measuring_core()
    if core >= 0:
        os.sched_setaffinity(0, {core})
    for part in wanted:
        parts[part](options.quick)


if __name__ == "__main__":
    main()
