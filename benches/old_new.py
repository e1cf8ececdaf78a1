"""Times of two builds in turns, as ratios old to new: above 1 means the new one is quicker.

    python benches/old_new.py OLD NEW [--rounds 5]

OLD and NEW are the folders that hold `agrik_fast` with its compiled module, such as
`../before/python` and `python`. Each round starts a process of either build, pinned to one core,
in alternating order; a ratio is that of two neighbours, and the median of the rounds is printed
beside its spread. A first call is the quickest of five processes. Differences under a few per
cent are noise.
"""

from __future__ import annotations

import argparse
import gc
import itertools
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

SINGLE = ("puma560", "redundant7", "ur5")
CLOSED = ("puma560", "redundant7")
BATCH = ("redundant7", "hydrolek", "puma560", "ur5", "panda")
BATCH_SIZE = 20_000
CALLS = 300
FIRST_REPEATS = 5


def first_branches() -> dict[str, Any]:
    """Time the first and the second `ik_all` of two poses; the process has done nothing else."""
    import numpy as np

    import agrik_fast as ik

    name = os.environ["OLD_NEW_ROBOT"]
    arm = ik.Robot.load(name)
    poses = arm.fk(np.array([np.linspace(0.2, 0.7, arm.dof), np.linspace(0.6, 0.1, arm.dof)]))
    times = []
    for _ in range(2):
        begin = time.perf_counter()
        branches = arm.ik_all(poses)
        times.append((time.perf_counter() - begin) * 1e6)
    reached = float(branches.valid.any(axis=-1).mean())
    return {
        f"first ik_all of two poses, {name}": (times[0], reached),
        f"second ik_all of two poses, {name}": (times[1], reached),
    }


def best_of(work: Callable[[], object], repeats: int) -> float:
    """Return the shortest time, us."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times) * 1e6


def warm() -> dict[str, Any]:
    """Time single calls and batches."""
    import numpy as np

    import agrik_fast as ik

    found: dict[str, Any] = {}
    gc.disable()
    for name in SINGLE:
        arm = ik.Robot.load(name)
        poses = list(arm.fk(arm.random_q(CALLS, seed=1)))
        solved = np.mean([bool(arm.ik(pose).success) for pose in poses])
        time_us = best_of(lambda a=arm, p=poses: [a.ik(one) for one in p], 7) / CALLS
        found[f"single ik, {name}"] = (time_us, float(solved))
        if arm.closed_form is not None:
            solved = np.mean([arm.ik_all(pose).valid.any() for pose in poses])
            time_us = best_of(lambda a=arm, p=poses: [a.ik_all(one) for one in p], 7) / CALLS
            found[f"single ik_all, {name}"] = (time_us, float(solved))
    for name in BATCH:
        arm = ik.Robot.load(name)
        poses = arm.fk(arm.random_q(BATCH_SIZE, seed=2))
        solved = arm.ik(poses, threads=1).success.mean()
        time_us = best_of(lambda a=arm, p=poses: a.ik(p, threads=1), 5) / BATCH_SIZE
        found[f"batch of {BATCH_SIZE}, {name}"] = (time_us, float(solved))
    return found


def ask(folder: Path, part: str, robot: str = "") -> dict[str, tuple[float, float]]:
    """Return microseconds and shares of success by name, measured in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "OLD_NEW_ROBOT": robot}
    command = [sys.executable, __file__, "--worker", part]
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    answer = json.loads(done.stdout)
    if not Path(answer["from"]).is_relative_to(folder):
        sys.exit(f"{folder} holds no agrik_fast: Python took {answer['from']}")
    return {name: (time_us, share) for name, (time_us, share) in answer["found"].items()}


def both(old: Path, new: Path, index: int) -> list[dict[str, tuple[float, float]]]:
    """Return one round: what the old and the new build took, asked in alternating order."""
    order = (0, 1) if index % 2 == 0 else (1, 0)
    found: list[dict[str, tuple[float, float]]] = [{}, {}]
    for which in order:
        found[which] |= ask((old, new)[which], "warm")
    for robot, _, which in itertools.product(CLOSED, range(FIRST_REPEATS), order):
        for name, answer in ask((old, new)[which], "first", robot).items():
            found[which][name] = min(answer, found[which].get(name, answer))
    return found


def main() -> None:
    if sys.argv[1:2] == ["--worker"]:
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
        found = warm() if sys.argv[2] == "warm" else first_branches()
        import agrik_fast

        json.dump({"from": agrik_fast.__file__, "found": found}, sys.stdout)
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    old, new = options.old.resolve(), options.new.resolve()
    rounds = [both(old, new, index) for index in range(options.rounds)]
    print(f"{'':36} {'old us':>9} {'new us':>9} {'old/new':>8} {'least':>6} {'most':>6}   solved")
    for name in rounds[0][0]:
        times = [[one[which][name][0] for one in rounds] for which in (0, 1)]
        ratios = [before / after for before, after in zip(*times, strict=True)]
        before, after = map(statistics.median, times)
        shares = " ".join(f"{100 * rounds[0][which][name][1]:.2f} %" for which in (0, 1))
        print(
            f"{name:36} {before:9.2f} {after:9.2f} {statistics.median(ratios):8.3f} "
            f"{min(ratios):6.3f} {max(ratios):6.3f}   {shares}"
        )


if __name__ == "__main__":
    main()
