"""Postures returned for targets out of reach, beside the best of many SciPy starts.

    python benches/nearest.py [--targets 20] [--starts 1000] [--arms puma560 ur5] [--tasks position]

For each arm and task: targets that cannot be reached, drawn in a ball of 1.6 times the reach; the
least error that `scipy.optimize` finds from so many random starts within the limits (L-BFGS-B
for positions, `least_squares` for poses, where orientations count a thousandth of the length
that they are compared by, so that the place comes first); and how much farther away the posture
is that `Robot.ik` returns. A miss is more than 1e-4 of the reach; a turned one is as near, and
its orientation more than 0.01 rad worse. Exit status 1 if there are any misses.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.spatial.transform import Rotation

import agrik_fast as ik

BUNDLED = (
    "strawberry",
    "cucumber",
    "hydrolek",
    "tomato",
    "redundant7",
    "puma560",
    "ur5",
    "panda",
)
MISS = 1e-4
"""Of the reach."""
TURNED = 0.01
"""Radians."""
LITTLE = 1e-3
"""What orientations count beside places."""
FREE = np.pi
"""Where joints without limits start, rad."""


def stretched() -> ik.Robot:
    """Return three joints in space whose far targets stretch the arm."""
    rows = [[0, np.pi / 2, 0.3, 0], [0.5, 0, 0, 0], [0.4, 0, 0, 0]]
    return ik.Robot.from_dh(rows, limits=[[-np.pi, np.pi], [-2.5, 2.5], [-2.8, 2.8]])


def bounds(arm: ik.Robot) -> tuple[np.ndarray, np.ndarray]:
    """Limits, and for joints without them a turn and a half on either side."""
    free = ~(np.abs(arm.lower) < 1e4) | ~(np.abs(arm.upper) < 1e4)
    return np.where(free, -3 * FREE, arm.lower), np.where(free, 3 * FREE, arm.upper)


def unreachable(arm: ik.Robot, task: str, count: int, seed: int) -> np.ndarray:
    """Targets that `ik` does not solve, shape (count, 4, 4)."""
    rng = np.random.default_rng(seed)
    found: list[np.ndarray] = []
    while sum(map(len, found)) < count:
        poses = np.tile(np.eye(4), (4 * count, 1, 1))
        way = rng.normal(size=(len(poses), 3))
        way *= (rng.random(len(poses)) ** (1 / 3) / np.linalg.norm(way, axis=1))[:, None]
        poses[:, :3, 3] = arm.reach_center + 1.6 * arm.reach_radius * way
        poses[:, :3, :3] = Rotation.random(len(poses), rng=rng).as_matrix()
        found.append(poses[~arm.ik(poses, task=task).success])
    return np.concatenate(found)[:count]


def errors(arm: ik.Robot, q: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Way and rotation vector to the target, shape (6,)."""
    pose = arm.fk(q)
    turn = Rotation.from_matrix(target[:3, :3] @ pose[:3, :3].T).as_rotvec()
    return np.concatenate([target[:3, 3] - pose[:3, 3], turn])


def by_place(arm: ik.Robot, target: np.ndarray, starts: np.ndarray) -> Iterator[np.ndarray]:
    """Postures of least distance from each start."""
    low, high = bounds(arm)

    def cost(q: np.ndarray) -> tuple[float, np.ndarray]:
        way = target[:3, 3] - arm.fk(q)[:3, 3]
        return 0.5 * float(way @ way), -(arm.jacobian(q)[:3].T @ way)

    options = {"ftol": 1e-15, "gtol": 1e-9, "maxiter": 300}
    for start in starts:
        found = minimize(
            cost,
            start,
            jac=True,
            method="L-BFGS-B",
            bounds=list(zip(low, high, strict=True)),
            options=options,
        )
        yield np.clip(found.x, arm.lower, arm.upper)


def by_pose(arm: ik.Robot, target: np.ndarray, starts: np.ndarray) -> Iterator[np.ndarray]:
    """Postures of least distance, then of least angle, from each start."""
    low, high = bounds(arm)
    scale = LITTLE * 0.3 * arm.reach_radius
    weights = np.array([1, 1, 1, scale, scale, scale])

    def rows(q: np.ndarray) -> np.ndarray:
        return weights * errors(arm, q, target)

    for start in starts:
        inside = np.clip(start, low + 1e-9, high - 1e-9)
        # Differences: the rotation vector's own derivative, not its approximation.
        found = least_squares(rows, inside, bounds=(low, high), xtol=1e-12, ftol=1e-12, gtol=1e-12)
        yield np.clip(found.x, arm.lower, arm.upper)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=20)
    parser.add_argument("--starts", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--arms", nargs="*", default=[*BUNDLED, "stretched"])
    parser.add_argument("--tasks", nargs="*", default=["position"])
    options = parser.parse_args()
    misses = 0
    print("arm, task: targets, starts | misses, worst excess / reach | turned, worst rad | seconds")
    for name in options.arms:
        arm = stretched() if name == "stretched" else ik.Robot.load(name)
        for task in options.tasks:
            missed = _arm(arm, task, options)
            misses += missed
    return int(misses > 0)


def _arm(arm: ik.Robot, task: str, options: Any) -> int:
    begin = time.perf_counter()
    targets = unreachable(arm, task, options.targets, options.seed)
    answers = arm.ik(targets, task=task)
    low, high = bounds(arm)
    rng = np.random.default_rng(options.seed + 1)
    excess, turned = [], []
    for target, q in zip(targets, answers.q, strict=True):
        starts = low + (high - low) * rng.random((options.starts, arm.dof))
        search = by_place if task == "position" else by_pose
        ends = np.array([errors(arm, end, target) for end in search(arm, target, starts)])
        ways, turns = (np.linalg.norm(part, axis=1) for part in (ends[:, :3], ends[:, 3:]))
        ours = errors(arm, q, target)
        way = np.linalg.norm(ours[:3])
        excess.append((way - ways.min()) / arm.reach_radius)
        near = ways <= max(ways.min(), way) + 1e-6 * arm.reach_radius
        turned.append(np.linalg.norm(ours[3:]) - turns[near].min() if task == "pose" else 0.0)
    missed = int(np.sum(np.array(excess) > MISS))
    worse = int(np.sum(np.array(turned) > TURNED))
    print(
        f"{arm.name}, {task}: {len(targets)}, {options.starts} | {missed}, {max(excess):.1e} | "
        f"{worse}, {max(turned):.2g} | {time.perf_counter() - begin:.0f}",
        flush=True,
    )
    return missed


if __name__ == "__main__":
    raise SystemExit(main())
