"""Instructions per solved target, counted by callgrind and held against committed numbers.

Unlike times, they do not depend on how busy the machine is, so that a change which makes the
solver do more work shows in the continuous integration:

    python benches/instructions.py            # exit status 1 above the bound
    python benches/instructions.py --update   # write the present numbers

What is counted is one call of the installed module, so that no other build is needed; with
PYTHONPATH, that of another checkout. Needs valgrind. AVX-512 is left out: valgrind does not
know it.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

BASELINE = Path(__file__).parent / "data" / "instructions.json"
# One compiler gives the same count within a few thousandths, whatever the machine. Compilers
# differ from release to release; a step more per target is about a tenth.
BOUND = 1.01
BOUND_OF_OTHER_COMPILERS = 1.30
# Robot, task, targets, and how many of them at least are solved: all, but for the published
# differential evolution, which is no such solver.
CASES = (
    ("redundant7", "pose", 500, 500),
    ("puma560", "pose", 500, 500),
    ("puma560", "position", 500, 500),
    ("redundant7", "evolution", 20, 16),
)
LEVELS = ("scalar", "avx2")
# A function of the C library that nobody else calls: the counts up to each call of it are one
# dump, so that the second of a pair holds what lies between the two.
MARK = "getpgid"


def work() -> None:
    """Solve every case between two marks, and say what came of it; runs under valgrind."""
    import agrik_fast as ik

    recipe = ik.solvers.DifferentialEvolution.paper()
    for robot, task, targets, _ in CASES:
        arm = ik.Robot.load(robot)
        poses = arm.fk(arm.random_q(targets, seed=6))
        goals = poses[:, :3, 3] if task == "position" else poses
        solver = recipe if task == "evolution" else "lm"
        arm.ik(goals[:1], solver=solver, threads=1)  # what is done once per robot
        os.getpgid(0)
        result = arm.ik(goals, solver=solver, threads=1)
        os.getpgid(0)
        print(ik.simd_level(), int(result.success.sum()), flush=True)


def count(level: str) -> list[int]:
    """Return the instructions of each case.

    Raises
    ------
    SystemExit
        If too few targets are solved, or the machine lacks the instruction set.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind.out"
        command = [
            *("valgrind", "--tool=callgrind", f"--dump-before={MARK}*"),
            *(f"--callgrind-out-file={out}", sys.executable, __file__, "--worker"),
        ]
        environment = {**os.environ, "AGRIK_SIMD": level, "PYTHONHASHSEED": "0"}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        lines = done.stdout.splitlines()
        if done.returncode or len(lines) != len(CASES):
            sys.exit(f"{level}: {done.stdout}{done.stderr}")
        for line, (robot, task, targets, least) in zip(lines, CASES, strict=True):
            used, solved = line.split()
            if used != level or int(solved) < least:
                sys.exit(
                    f"{robot}, {task}: level {used} solved {solved} of {targets}, "
                    f"expected: level {level}, {least} or more"
                )
        counts = []
        for index in range(len(CASES)):
            dump = out.with_name(f"{out.name}.{2 * index + 2}")
            text = dump.read_text(encoding="utf-8") if dump.exists() else ""
            total = re.search(r"^summary: (\d+)", text, re.MULTILINE)
            if f"Trigger: --dump-before={MARK}" not in text or total is None:
                sys.exit(f"{level}: callgrind made no dump at call {2 * index + 2} of {MARK}")
            counts.append(int(total[1]))
        if out.with_name(f"{out.name}.{2 * len(CASES) + 1}").exists():
            sys.exit(f"{level}: others call {MARK} too")
    return counts


def compiler() -> str:
    """Return the first line of `rustc --version`."""
    command = ["rustc", "--version"]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout.strip()


def main() -> int:
    """Count, print a table, and compare or update."""
    parser = argparse.ArgumentParser(description="Instructions per target, by callgrind.")
    parser.add_argument("--update", action="store_true", help=f"write {BASELINE.name}")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        work()
        return 0
    if shutil.which("valgrind") is None:
        sys.exit("valgrind is not installed (Debian: apt-get install valgrind)")
    committed = json.loads(BASELINE.read_text(encoding="utf-8"))
    bound = BOUND if committed["compiler"] == compiler() else BOUND_OF_OTHER_COMPILERS
    with ThreadPoolExecutor() as pool:
        counts = dict(zip(LEVELS, pool.map(count, LEVELS), strict=True))
    found: dict[str, int] = {}
    over = []
    print(f"{'robot, task, level':32} {'instructions per target':>24} {'to the baseline':>16}")
    for index, (robot, task, targets, _) in enumerate(CASES):
        for level in LEVELS:
            name = f"{robot}, {task}, {level}"
            found[name] = round(counts[level][index] / targets)
            before = committed["instructions"].get(name)
            ratio = found[name] / before if before else None
            shown = "new" if ratio is None else f"{100 * (ratio - 1):+.2f} %"
            print(f"{name:32} {found[name]:24} {shown:>16}")
            if ratio is None or ratio > bound:
                over.append(name)
    if options.update:
        content = {"compiler": compiler(), "instructions": found}
        BASELINE.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    elif over:
        print(f"more than {100 * (bound - 1):.0f} % above the baseline, or new: {'; '.join(over)}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
