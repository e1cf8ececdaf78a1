"""Tuning of the HydroLek's gains: wall time, and one evaluation beside plain NumPy's.

Times the published swarm (40 particles, 15 numbers, 3,000 training goals, 4,840 gain sets) and
what a user gets by default (three swarms, a refinement on 12,000 goals), each from start to the
gain file; then one evaluation of a gain set on 3,000 goals, on one thread, beside the same cost
in NumPy, which moves all goals at once and drops those that are done.

    .venv/bin/python benches/tuning.py [--threads 2] [--swarm-only]
"""

from __future__ import annotations

import argparse
import os
import time

# One thread for NumPy; has to be said before it is loaded.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
from peer_bench import machine  # noqa: E402

import agrik_fast as ik  # noqa: E402
from agrik_fast._native import Tuner  # noqa: E402
from agrik_fast.solvers import StateSpace  # noqa: E402
from agrik_fast.tuning import (  # noqa: E402
    Tuning,
    goals,
    tune,
)

WANTED_S = 120.0
"""Limit for the swarm on two cores."""
# a, cos alpha, sin alpha, d, offset of Table I, in m and rad.
ROWS = (
    (0.0700, 0, 1, 0.0, 0.0),
    (0.5234, 1, 0, 0.0, 0.0),
    (0.1650, 0, -1, 0.0, 0.0),
    (0.04445, 0, 1, -0.2120, 0.0),
    (0.1840, 0, -1, 0.0, -np.pi / 2),
    (0.0, 1, 0, 0.2848, -np.pi / 2),
)
STEPS = 400
TOLERANCE_M = 1e-3


def tool_points(q: np.ndarray) -> np.ndarray:
    """Return tool points, shape (3, n), of joint values, shape (6, n): from tool to base."""
    p = np.zeros((3, q.shape[1]))
    for i in range(5, -1, -1):
        a, cosine, sine, d, offset = ROWS[i]
        x, y, z = p[0] + a, cosine * p[1] - sine * p[2], sine * p[1] + cosine * p[2] + d
        c, s = np.cos(q[i] + offset), np.sin(q[i] + offset)
        p = np.stack([c * x - s * y, s * x + c * y, z])
    return p


def numpy_cost(arm: ik.Robot, gains: StateSpace, points: np.ndarray) -> tuple[float, int]:
    """Return the tuner's cost and the goals reached; `points` has the shape (3, n)."""
    degree, centimetre = np.pi / 180, 0.01
    A, C = np.array(gains.A), degree * np.array(gains.C)
    B = np.array(gains.B) @ np.array(gains.frame) / centimetre
    lower, upper = arm.lower[:, None], arm.upper[:, None]
    n = points.shape[1]
    q = np.clip(np.zeros((6, n)), lower, upper)
    x = np.zeros((6, n))
    error = points - tool_points(q)
    cost, solved = 0.0, 0
    for step in range(STEPS + 1):
        going = np.sqrt((error * error).sum(0)) >= TOLERANCE_M
        done = int(going.size - going.sum())
        solved += done
        cost += done * 0.1 * step / 100
        points, q, x, error = points[:, going], q[:, going], x[:, going], error[:, going]
        if step == STEPS or not going.any():
            break
        move = C @ x
        x = A @ x + B @ error
        q = np.clip(q + move, lower, upper)
        error = points - tool_points(q)
    left = np.minimum(np.sqrt((error * error).sum(0)), 1.0)
    cost += (0.1 * STEPS / 100 + 10.0) * left.size + 20.0 * left.sum()
    return cost / n, solved


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--swarm-only", action="store_true", help="leave the default run out")
    options = parser.parse_args()
    arm = ik.Robot.load("hydrolek")
    about = machine.describe()
    print(f"{about['cpu']}, load {about['load_before']:.1f}; SIMD {ik.simd_level()}")
    print(f"agrik_fast {ik.__version__}, NumPy {np.__version__}, {options.threads} threads")

    gains = StateSpace.load("hydrolek_k15_cma", as_tuned=True)
    points = goals.joint_uniform(arm, 3000, 100)
    judge = Tuner(arm._chain, gains, points, "full", "pso", 40, 0.3, 0, "zero", STEPS, 1e-3, 1)
    ours: list[float] = []
    theirs: list[float] = []
    columns = np.ascontiguousarray(points.T)
    vector = judge.best
    for _ in range(7):
        begin = time.thread_time()
        cost, solved, _ = judge.score(vector)
        ours.append(time.thread_time() - begin)
        begin = time.thread_time()
        numpy_answer = numpy_cost(arm, gains, columns)
        theirs.append(time.thread_time() - begin)
    # Roundings decide over a goal or two that just arrive, or just do not.
    if abs(solved - numpy_answer[1]) > 3:
        raise SystemExit(f"the yardstick reaches {numpy_answer[1]} goals, ours {solved}")
    ratio = float(np.median(np.array(theirs) / np.array(ours)))
    print("\none gain set on 3,000 goals, one thread, CPU time: median ms")
    print(
        f"ours {1e3 * np.median(ours):.2f}, NumPy {1e3 * np.median(theirs):.1f}: ratio {ratio:.0f}"
    )
    print(f"cost {cost:.4f} and {numpy_answer[0]:.4f}, reached {solved} and {numpy_answer[1]}")

    runs = {"one swarm": Tuning(runs=1, refinement=0, threads=options.threads)}
    if not options.swarm_only:
        runs["default"] = Tuning(threads=options.threads)
    print(f"\n{'tuning':12} {'sets':>7} {'wall s':>8} {'CPU s':>8} {'training':>9} {'set J':>6}")
    for name, tuning in runs.items():
        begin, cpu = time.perf_counter(), time.process_time()
        content = tune(arm, tuning)
        wall, spent = time.perf_counter() - begin, time.process_time() - cpu
        reached = content.success.solved if content.success is not None else 0
        line = f"{name:12} {content.training.evaluations:7} {wall:8.1f} {spent:8.1f}"
        print(f"{line} {content.training.solved:9} {reached:6}")
        if name == "one swarm":
            met = "met" if wall <= WANTED_S else "MISSED"
            print(f"{'':12} wanted: at most {WANTED_S:.0f} s on two cores: {met}")


if __name__ == "__main__":
    main()
