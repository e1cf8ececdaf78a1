"""Time the strawberry and tomato closed forms beside SciPy's SLSQP and plain Python.

All in one run, on one core, garbage collector off. Times are CPU time; of each group of
repeats the least, the middle and the 95th percentile are printed, and ratios of medians.

    .venv/bin/python benches/closed_forms.py [--repeats 15] [--json FILE]
"""

from __future__ import annotations

import argparse
import gc
import json
import math
import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from peer_bench.machine import describe, measuring_core

from agrik_fast.arms import StrawberryArm, TomatoArm
from agrik_fast.papers import strawberry

# Limits of issue 5, ns a target.
GOALS_NS = {
    "strawberry exact, free branch": 100,
    "strawberry AS, table 3": 300,
    "strawberry SSAS, table 3": 300,
    "strawberry exact, constrained": 5000,
}


def plain_python_as(target: list[float]) -> tuple[float, ...] | None:
    """AS as one would write it from the paper, mm and rad, without any library."""
    l1, l2, l3, dx, dy, dz = 90.0, 102.0, 60.0, 0.0, -68.5, -27.3036
    x, y, z = target
    low = max(75.0, y - l3 * math.sin(math.radians(73)) - l1 + dy)
    high = min(660.0, y - l1 + dy)
    if low > high:
        return None
    s10 = 0.5 * (low + high)
    beta = math.asin(max(-1.0, min(1.0, (y - s10 - l1 + dy) / l3)))
    r = l2 + l3 * math.cos(beta)
    u0, u1 = (80.0 + dx - x) / r, (920.0 + dx - x) / r
    k0, k1 = (dz - z - 251.0) / r, (dz - z - 61.0) / r
    if u0 > 1 or u1 < -1 or k0 > 1 or k1 < -1:
        return None
    s21 = (math.asin(max(-1.0, u0)), math.asin(min(1.0, u1)))
    near, far = math.acos(min(1.0, k1)), math.acos(max(-1.0, k0))
    joint = (math.radians(-58), math.radians(52))
    sets = []
    for a, b in ((-far, -near), (near, far)):
        a, b = max(a, s21[0], joint[0]), min(b, s21[1], joint[1])
        if a <= b:
            sets.append((a, b))
    if not sets:
        return None
    theta = min((max(a, min(b, 0.0)) for a, b in sets), key=abs)
    if theta == 0.0:
        theta = 0.01
    return s10, x - dx + r * math.sin(theta), dz - z - r * math.cos(theta), theta, beta


def plain_python_tomato(target: list[float]) -> tuple[float, float, float] | None:
    """The corrected closed form, elbow up, without any library."""
    x, y, z = target
    link = 0.16
    rho = math.hypot(x, y)
    cos = (rho * rho + z * z) / (2 * link * link) - 1
    if abs(cos) > 1:
        return None
    phi2 = -math.acos(cos)
    lean = math.atan2(link * math.sin(phi2), link + link * math.cos(phi2))
    return math.atan2(z, rho) - lean, phi2, math.atan2(y, x)


def nanoseconds(work: Callable[[], object], targets: int, repeats: int) -> list[float]:
    """Return the CPU time of one target, ns, of each repeat."""
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time_ns()
        work()
        times.append((time.process_time_ns() - start) / targets)
    return sorted(times)


def sphere(count: int) -> np.ndarray:
    """Return targets on the upper half of the plant sphere, m."""
    random = np.random.default_rng(0)
    direction = random.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    direction[:, 2] = np.abs(direction[:, 2])
    return strawberry.SPHERE_CENTRE + strawberry.SPHERE_RADIUS * direction


def in_box(arm: StrawberryArm, count: int) -> np.ndarray:
    """Return targets of the whole box in which a slide's limit is active, m."""
    low, high = arm.target_box
    points = low + np.random.default_rng(1).random((3 * count, 3)) * (high - low)
    solved = arm.solve(points)
    at_limit = solved.success & (solved.q[:, 3] != arm.free_pose[0])
    return points[at_limit][:count]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--targets", type=int, default=50_000)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    core = measuring_core()
    if core >= 0:
        os.sched_setaffinity(0, {core})
    gc.disable()

    arm, pointing = StrawberryArm(), TomatoArm()
    many, table = sphere(options.targets), np.tile(strawberry.targets(), (2500, 1))
    box = in_box(arm, options.targets // 2)
    aims = pointing.fk(
        np.random.default_rng(2).uniform(
            pointing.lower + 0.1, pointing.upper - 0.1, (options.targets, 3)
        )
    )
    few_mm = (1000 * many[:2000]).tolist()
    few_aims = aims[:2000].tolist()
    ncos = many[:20]
    cases: dict[str, tuple[Callable[[], object], int]] = {
        "strawberry exact, free branch": (lambda: arm.solve(many), len(many)),
        "strawberry AS, table 3": (lambda: arm.solve(table, "as"), len(table)),
        "strawberry SSAS, table 3": (lambda: arm.solve(table, "ssas"), len(table)),
        "strawberry exact, constrained": (lambda: arm.solve(box), len(box)),
        "strawberry AS, constrained": (lambda: arm.solve(box, "as"), len(box)),
        "strawberry SSAS, constrained": (lambda: arm.solve(box, "ssas"), len(box)),
        "SciPy SLSQP (NCOS)": (lambda: arm.solve(ncos, "ncos"), len(ncos)),
        "plain Python AS": (lambda: [plain_python_as(t) for t in few_mm], len(few_mm)),
        "tomato, closed form": (lambda: pointing.solve(aims), len(aims)),
        "tomato, all branches": (lambda: pointing.branches(aims), len(aims)),
        "plain Python tomato": (lambda: [plain_python_tomato(t) for t in few_aims], 2000),
    }
    measured = {name: nanoseconds(*case, options.repeats) for name, case in cases.items()}
    ours = arm.solve(1e-3 * np.array(few_mm[:200]), "as").q * [1000, 1000, 1000, 1, 1]
    plain = np.array([plain_python_as(t) for t in few_mm[:200]])
    assert np.abs(ours - plain).max() < 1e-9, "plain Python and Rust disagree"

    machine = describe()
    print(f"{machine['cpu']}, {machine['system']}, Python {machine['python']}, one core")
    print(f"solved: sphere {arm.solve(many).success.mean():.4f}, ", end="")
    print(f"at limits, AS {arm.solve(box, 'as').success.mean():.4f}, ", end="")
    print(f"tomato {pointing.solve(aims).success.mean():.4f}\n")
    print(f"{'ns a target':34}{'min':>12}{'p50':>12}{'p95':>12}{'goal':>8}")
    for name, times in measured.items():
        p50, p95 = np.percentile(times, [50, 95])
        goal = GOALS_NS.get(name)
        verdict = "" if goal is None else f"{goal:>8} {'met' if p50 <= goal else 'MISSED'}"
        print(f"{name:34}{times[0]:12.1f}{p50:12.1f}{p95:12.1f}{verdict}")
    middle = {name: float(np.median(times)) for name, times in measured.items()}
    ratios = {
        "SciPy SLSQP : exact, free branch": ("SciPy SLSQP (NCOS)", "strawberry exact, free branch"),
        "SciPy SLSQP : exact, constrained": ("SciPy SLSQP (NCOS)", "strawberry exact, constrained"),
        "plain Python AS : AS": ("plain Python AS", "strawberry AS, table 3"),
        "plain Python AS : exact": ("plain Python AS", "strawberry exact, free branch"),
        "plain Python tomato : closed form": ("plain Python tomato", "tomato, closed form"),
    }
    print("\nratio (above 1: ours is quicker)")
    for name, (slow, fast) in ratios.items():
        print(f"{name:38}{middle[slow] / middle[fast]:12,.1f}")
    if options.json:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps({"machine": machine, "ns": measured}, indent=1))


if __name__ == "__main__":
    main()
