"""Ten million targets from file to file by the command line: peak memory, time, rate.

    .venv/bin/python benches/streaming.py                 # 5 GB of disk, a few minutes
    .venv/bin/python benches/streaming.py --rows 1000000

Each run is a process of its own; its peak resident memory is what the system reports when it
ends (as ``/usr/bin/time -v`` does), its rate counts the rows over the whole run, start of
Python included.
"""

# NumPy stays out of this process: a child's peak starts from its parent's.
from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROBOT = "puma560"
LIMIT_MB = 500
# Input, output, and what the input holds.
RUNS = (
    ("points.npy", "points_out.npy"),
    ("poses.npy", "poses_out.npy"),
    ("points.parquet", "points_out.parquet"),
)
MAKE = """
import sys
import numpy as np
import pyarrow
from numpy.lib.format import open_memmap
from pyarrow import parquet
import agrik_fast as ik

folder, robot, rows = sys.argv[1], sys.argv[2], int(sys.argv[3])
arm = ik.Robot.load(robot)
points = open_memmap(f"{folder}/points.npy", "w+", np.float64, (rows, 3))
poses = open_memmap(f"{folder}/poses.npy", "w+", np.float64, (rows, 4, 4))
for first in range(0, rows, 100_000):
    part = slice(first, min(first + 100_000, rows))
    poses[part] = arm.fk(arm.random_q(part.stop - first, seed=first))
    points[part] = poses[part, :3, 3]
columns = {name: points[:, k].copy() for k, name in enumerate(("x_m", "y_m", "z_m"))}
parquet.write_table(pyarrow.table(columns), f"{folder}/points.parquet", row_group_size=rows)
"""


def measure(folder: Path, targets: str, output: str, threads: int | None) -> tuple[float, ...]:
    """Return wall clock and CPU seconds, and peak MB of one run."""
    command = [
        *(sys.executable, "-m", "agrik_fast.cli", "solve", ROBOT, targets),
        *("-o", output, "--force"),
        *(("--threads", str(threads)) if threads else ()),
    ]
    with (folder / "log.txt").open("w+") as log:
        started = time.perf_counter()
        process = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)
        _, status, usage = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - started
        process.returncode = os.waitstatus_to_exitcode(status)
        log.seek(0)
        if process.returncode:
            sys.exit(log.read())
        print(log.read().splitlines()[-2])
    return wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6


def main() -> int:
    """Make the files, run, print a table; 1 if a run took more memory than is allowed."""
    parser = argparse.ArgumentParser(description="Files of many targets, from end to end.")
    parser.add_argument("--rows", type=int, default=10_000_000)
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    lines = []
    worst_mb = 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = [sys.executable, "-c", MAKE, name, ROBOT, str(options.rows)]
        subprocess.run(made, check=True)
        for targets, output in RUNS:
            wall_s, cpu_s, peak_mb = measure(folder, targets, output, options.threads)
            worst_mb = max(worst_mb, peak_mb)
            sizes = [(folder / file).stat().st_size / 1e6 for file in (targets, output)]
            (folder / output).unlink()
            lines.append(
                f"| {targets} | {sizes[0]:.0f} | {sizes[1]:.0f} | {peak_mb:.0f} | {wall_s:.1f} "
                f"| {cpu_s:.1f} | {options.rows / wall_s:,.0f} |"
            )
    load = os.getloadavg()[0]
    print(f"\n{options.rows:,} targets, {os.cpu_count()} cores, load at the end {load:.1f}")
    print("| targets | MB in | MB out | peak MB | time s | CPU s | rows/s |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    print("\n".join(lines))
    return int(worst_mb >= LIMIT_MB)


if __name__ == "__main__":
    sys.exit(main())
