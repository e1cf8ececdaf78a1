"""Derivatives of answers beside the answers themselves: processor time of one thread.

    python benches/gradients.py

The table is the one in docs/gradients.md.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import agrik_fast as ik

ROBOTS = ("ur5", "puma560", "hydrolek", "panda", "redundant7", "cucumber", "iiwa14")
ROWS = 20_000
REPEATS = 15


def seconds(work: Callable[[], object]) -> float:
    """Return the least processor time of a call, s."""
    least = float("inf")
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        least = min(least, time.process_time() - begin)
    return least


def main() -> None:
    """Print a row a robot: microseconds a pose, and shares of the answer's time."""
    ik.set_num_threads(1)
    print(f"{ik.simd_level()}, one thread, {ROWS} poses")
    print("| robot | `ik` us | dq/dT us | share | dq/d(DH) us | share |")
    print("|---|---|---|---|---|---|")
    for name in ROBOTS:
        arm = ik.Robot.load(name)
        goals = arm.fk(arm.random_q(ROWS, seed=1))
        result = arm.ik(goals)
        # Bound here: the next robot's are others.
        answer = 1e6 / ROWS * seconds(lambda arm=arm, goals=goals: arm.ik(goals))
        cells = [f"{answer:.2f}"]
        for wrt in ("target", "dh"):
            if wrt == "dh" and arm.dh is None:
                cells += ["-", "-"]
                continue
            took = 1e6 / ROWS * seconds(lambda r=result, wrt=wrt: r.jacobian_of_q(wrt))
            cells += [f"{took:.2f}", f"{took / answer:.2f}"]
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
