"""Instructions per solved target, counted by callgrind and held against committed numbers.

Unlike times, they do not depend on how busy the machine is, so that a change which makes the
solver do much more work shows in the continuous integration:

    python benches/instructions.py            # exit status 1 above the bound
    python benches/instructions.py --update   # write the present numbers

Needs valgrind and cargo. AVX-512 is left out: valgrind does not know it.
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
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BASELINE = ROOT / "benches" / "data" / "instructions.json"
# Compilers differ from release to release; a step more per target is about a tenth.
BOUND = 1.30
# Robot, task, targets, and how many of them at least are solved: all, but for the published
# differential evolution, which is no such solver.
CASES = (
    ("redundant7", "pose", 500, 500),
    ("puma560", "pose", 500, 500),
    ("puma560", "position", 500, 500),
    ("redundant7", "evolution", 20, 16),
)
LEVELS = ("scalar", "avx2")
# The function of rust/agrik/benches/instructions.rs that is counted.
COUNTED = "*measured*"


def build() -> Path:
    """Return the program that is counted, built as `cargo bench` builds it."""
    locked = ["--locked"] if os.environ.get("CI") else []
    command = ["cargo", "bench", *locked, "-p", "agrik", "--bench", "instructions", "--no-run"]
    done = subprocess.run(
        [*command, "--message-format=json"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    )
    messages = (json.loads(line) for line in done.stdout.splitlines() if line.startswith("{"))
    (path,) = (
        message["executable"]
        for message in messages
        if message.get("executable") and message["target"]["name"] == "instructions"
    )
    return Path(path)


def count(program: Path, level: str, robot: str, task: str, targets: int, least: int) -> float:
    """Return the instructions per target of one call.

    Raises
    ------
    SystemExit
        If too few targets are solved, or the machine lacks the instruction set.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind.out"
        command = [
            *("valgrind", "--tool=callgrind", "--collect-atstart=no"),
            *(f"--toggle-collect={COUNTED}", f"--callgrind-out-file={out}"),
            *(str(program), robot, task, str(targets)),
        ]
        environment = {**os.environ, "AGRIK_SIMD": level}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        said = re.fullmatch(rf"level {level} solved (\d+) of {targets}", done.stdout.strip())
        if done.returncode or said is None or int(said[1]) < least:
            expected = f"level {level} solved {least} or more of {targets}"
            sys.exit(f"{robot}, {task}: {done.stdout}{done.stderr}\nexpected: {expected}")
        total = re.search(r"^summary: (\d+)", out.read_text(encoding="utf-8"), re.MULTILINE)
    if total is None or int(total[1]) == 0:
        sys.exit(f"callgrind found no function {COUNTED} in {program}")
    return int(total[1]) / targets


def main() -> int:
    """Count, print a table, and compare or update."""
    parser = argparse.ArgumentParser(description="Instructions per target, by callgrind.")
    parser.add_argument("--update", action="store_true", help=f"write {BASELINE.name}")
    update = parser.parse_args().update
    if shutil.which("valgrind") is None:
        sys.exit("valgrind is not installed (Debian: apt-get install valgrind)")
    baseline = json.loads(BASELINE.read_text(encoding="utf-8")) if BASELINE.exists() else {}
    program = build()
    found: dict[str, int] = {}
    over = []
    print(f"{'robot, task, level':32} {'instructions per target':>24} {'to the baseline':>16}")
    for robot, task, targets, least in CASES:
        for level in LEVELS:
            name = f"{robot}, {task}, {level}"
            found[name] = round(count(program, level, robot, task, targets, least))
            before = baseline.get(name)
            ratio = found[name] / before if before else None
            shown = "new" if ratio is None else f"{100 * (ratio - 1):+.1f} %"
            print(f"{name:32} {found[name]:24} {shown:>16}")
            if ratio is None or ratio > BOUND:
                over.append(name)
    if update:
        BASELINE.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
        return 0
    if over:
        print(f"more than {100 * (BOUND - 1):.0f} % above {BASELINE.name}: {'; '.join(over)}")
        print("if that is meant: python benches/instructions.py --update")
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())
