"""Differential evolution beside SciPy's and beside hand-vectorised NumPy, in one run.

All three run the published recipe for redundant7 (100 individuals, 200 generations, best/1/bin)
on the same random targets with one thread; SciPy redraws genes out of range and keeps a constant
crossover rate of 0.75, since it cannot do otherwise. Ours is timed as a batch and as single calls.

    .venv/bin/python -m pip install --group bench
    .venv/bin/python benches/population.py
"""

from __future__ import annotations

import argparse
import gc
import os
import sys
import time

# One thread everywhere; has to be said before NumPy is loaded.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
import scipy  # noqa: E402
from numpy_evolution import LIMITS, Cost, evolve, forward  # noqa: E402
from peer_bench import machine  # noqa: E402
from scipy.optimize import differential_evolution  # noqa: E402

import agrik_fast as ik  # noqa: E402

WANTED = {"SciPy": 200, "NumPy": 50}
"""Ratios that the project aims at."""


def scipy_evolve(pose: np.ndarray, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    result = differential_evolution(
        Cost(pose),
        list(zip(-LIMITS, LIMITS, strict=True)),
        strategy="best1bin",
        maxiter=200,
        mutation=0.5,
        recombination=0.75,
        init=rng.uniform(-LIMITS, LIMITS, (100, 7)),
        rng=rng,
        tol=0.0,
        polish=False,
        updating="deferred",
        vectorized=True,
    )
    return result.x


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=8, help="targets of the peers, each timed")
    arguments = parser.parse_args()

    arm = ik.Robot.load("redundant7")
    poses = arm.fk(arm.random_q(256, seed=7))
    check = np.abs(
        np.stack(forward(arm.random_q(64, seed=8).T)[3:])[0].T
        - arm.fk(arm.random_q(64, seed=8))[:, :3, 3]
    ).max()
    assert check < 1e-12, f"the yardstick's kinematics differ by {check}"
    recipe = ik.solvers.DifferentialEvolution.paper()

    def good(pose: np.ndarray, q: np.ndarray) -> bool:
        found = arm.fk(q)
        turn = found[:3, :3] @ pose[:3, :3].T
        angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
        return bool(np.linalg.norm(found[:3, 3] - pose[:3, 3]) <= 1e-4 and angle <= 1e-3)

    def ours_batch() -> list[float]:
        started = time.thread_time()
        answers.append(arm.ik(poses, solver=recipe, threads=1).q)
        return [(time.thread_time() - started) / len(poses)]

    def ours_single() -> list[float]:
        times = []
        for pose in poses[:32]:
            started = time.thread_time()
            arm.ik(pose, solver=recipe, threads=1)
            times.append(time.thread_time() - started)
        return times

    answers: list[np.ndarray] = []
    rows: dict[str, list[float]] = {"ours, batch": [], "ours, single": [], "NumPy": [], "SciPy": []}
    solved = {"NumPy": 0, "SciPy": 0}
    ratios: dict[str, list[float]] = {"NumPy": [], "SciPy": []}
    ours_batch()
    gc.disable()
    for i in range(arguments.targets):
        # In turns, so that a busy machine slows all alike.
        ours = ours_batch()
        rows["ours, batch"] += ours
        rows["ours, single"] += ours_single()
        for name, run in (
            ("NumPy", lambda i=i: evolve(poses[i], i)[0]),
            ("SciPy", lambda i=i: scipy_evolve(poses[i], i)),
        ):
            started = time.thread_time()
            q = run()
            spent = time.thread_time() - started
            rows[name].append(spent)
            ratios[name].append(spent / ours[0])
            solved[name] += good(poses[i], q)
    gc.enable()

    about = machine.describe()
    print(
        f"{about['cpu']}, {about['system']}, load {about['load_before']:.1f}; "
        f"SIMD {ik.simd_level()}"
    )
    print(
        f"agrik_fast {ik.__version__}, Python {sys.version.split()[0]}, NumPy {np.__version__}, "
        f"SciPy {scipy.__version__}; one thread, CPU time, collector off"
    )
    print(f"\n{'':14} {'min ms':>9} {'p50 ms':>9} {'p95 ms':>9}  success")
    own = sum(good(pose, q) for pose, q in zip(poses, answers[-1], strict=True)) / len(poses)
    shares = {"ours, batch": own, "ours, single": own}
    shares |= {name: count / arguments.targets for name, count in solved.items()}
    for name, times in rows.items():
        low, middle, high = 1e3 * np.percentile(times, [0, 50, 95])
        print(f"{name:14} {low:9.3f} {middle:9.3f} {high:9.3f}  {shares[name]:7.1%}")
    print()
    for name, values in ratios.items():
        ratio = float(np.median(values))
        print(
            f"{name} / ours (batch): {ratio:.0f} (wanted: at least {WANTED[name]}) "
            f"{'met' if ratio >= WANTED[name] else 'MISSED'}"
        )


if __name__ == "__main__":
    main()
