"""Every solver on every robot: share of goals reached and time a goal, as one matrix.

    python benches/solvers.py [--goals 1000] [--tolerance 1e-3] [-o results.csv]

Goals are tool points (or poses, with --poses) of postures drawn uniformly in the joint
limits, so all can be reached. Feedback solvers run untuned, from a frozen pseudo-inverse; arms
without a closed form have a dash in its column.
"""

from __future__ import annotations

import argparse
import csv
import gc
import platform
import time
from pathlib import Path

import numpy as np

import agrik_fast as ik
from agrik_fast.tuning import goals

POSITION = (
    "lm",
    "dls",
    "pinv",
    "pinv-closed",
    "transpose",
    "broyden",
    "ccd",
    "ik-pid",
    "static-gain",
    "state-space",
    "de",
    "ga",
)
POSE = (*(name for name in POSITION if name != "ccd"), "closed_form")


def prismatic_arm() -> ik.Robot:
    """A gantry with a wrist: three slides and three turns."""
    quarter = np.pi / 2
    return ik.Robot.from_dh(
        [
            [0, -quarter, 0, 0],
            [0, quarter, 0, quarter],
            [0, 0, 0, 0],
            [0, quarter, 0, 0],
            [0, -quarter, 0, 0],
            [0.1, 0, 0.1, 0],
        ],
        joint_types=["prismatic"] * 3 + ["revolute"] * 3,
        limits=[(0, 1)] * 3 + [(-2.5, 2.5)] * 3,
        name="gantry",
    )


def measure(arm: ik.Robot, targets: np.ndarray, solver: str, tolerance: float) -> dict[str, object]:
    times = []
    gc.disable()
    for _ in range(3):
        begin = time.perf_counter()
        result = arm.ik(
            targets,
            solver=solver,
            position_tolerance=tolerance,
            orientation_tolerance=tolerance,
            threads=1,
        )
        times.append(time.perf_counter() - begin)
    gc.enable()
    return {
        "robot": arm.name,
        "solver": solver,
        "reached": float(result.success.mean()),
        "iterations": float(result.iterations.mean()),
        "restarts": float(result.restarts.mean()),
        "us_min": min(times) / len(targets) * 1e6,
        "us_max": max(times) / len(targets) * 1e6,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--goals", type=int, default=1000)
    parser.add_argument("--tolerance", type=float, default=1e-3, help="m and rad")
    parser.add_argument("--poses", action="store_true")
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    solvers = POSE if options.poses else POSITION
    print(f"# {platform.processor() or platform.machine()}, {ik.simd_level()}, one thread,")
    print(f"# agrik_fast {ik.__version__}, {options.goals} goals, {options.tolerance} m or rad")
    print(f"{'robot':12}" + "".join(f"{name:>20}" for name in solvers))
    rows = []
    arms = [ik.Robot.load(name) for name in ik.Robot.names()] + [prismatic_arm()]
    for arm in arms:
        poses = arm.fk(goals.joint_uniform_q(arm, options.goals, 1))
        targets = poses if options.poses else poses[:, :3, 3]
        line = f"{arm.name:12}"
        for solver in solvers:
            if solver == "closed_form" and arm.closed_form is None:
                line += f"{'-':>20}"
                continue
            row = measure(arm, targets, solver, options.tolerance)
            rows.append(row)
            line += f"{100 * row['reached']:8.1f} % {row['us_min']:7.2f} us"
        print(line, flush=True)
    if options.output:
        with options.output.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, rows[0])
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
