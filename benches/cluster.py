"""A cluster job of ten million rows on this machine: what the runners cost, and their memory.

    .venv/bin/python benches/cluster.py                       # 2 GB of disk, some minutes
    .venv/bin/python benches/cluster.py --rows 1e6 --solver lm

Overhead is ``1 - (sum of the partitions' own wall clocks / workers) / wall``: of the run as the
library counts it (from the first look at the folder to the manifest, start of the workers
included), and of the whole command (start of Python and reading of footers included). It says
something where partitions last ten seconds or more, which is what partitions should do.
Memory is the largest of any worker, as its records have it.
"""

# NumPy stays out of this process: it is not what is measured.
from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROBOT = "redundant7"
WORKERS = 2
LIMIT = 0.03
LIMIT_MB = 300
MAKE = """
import sys
import numpy as np
import pyarrow
from pyarrow import parquet
import agrik_fast as ik

folder, robot, rows, parts = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
arm = ik.Robot.load(robot)
names = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
schema = pyarrow.schema([(name, pyarrow.float64()) for name in names])
for part in range(parts):
    path = f"{folder}/part-{part:04d}.parquet"
    with parquet.ParquetWriter(path, schema, use_dictionary=False) as w:
        left, step = rows // parts, 0
        while left:
            count = min(left, 65_536)
            T = arm.fk(arm.random_q(count, seed=1000 * part + step))
            rows_ = np.hstack([T[:, :3, 3], ik.rotations.quat_of(T)])
            w.write_table(pyarrow.table(list(rows_.T.copy()), schema=schema))
            left, step = left - count, step + 1
"""


def measure(folder: Path, name: str, solver: str, *more: str) -> dict[str, float]:
    """Run a job and return what it took."""
    log = folder / f"{name}.log"
    command = [sys.executable, "-m", "agrik_fast.cli", "cluster", "solve"]
    command += [str(folder / "in"), str(folder / name), "--robot", ROBOT, "--solver", solver]
    command += ["--rows", "100000000", "--log", str(log), *more]
    started = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    wall_s = time.perf_counter() - started
    if done.returncode:
        sys.exit(done.stderr)
    print(done.stdout.splitlines()[1])
    end = json.loads(log.read_text().splitlines()[-1])
    records = [json.loads(path.read_text()) for path in (folder / name).glob("*.parquet.json")]
    seconds = [record["seconds"] for record in records]
    return {
        "partitions": len(seconds),
        "shortest_s": min(seconds),
        "run_s": end["seconds"],
        "command_s": wall_s,
        "overhead": 1.0 - sum(seconds) / WORKERS / end["seconds"],
        "with_start": 1.0 - sum(seconds) / WORKERS / wall_s,
        "peak_mb": max(record["peak_mb"] for record in records),
    }


def dask_cluster(folder: Path, started: list[subprocess.Popen[bytes]]) -> str:
    """Start a scheduler and two workers, and return the scheduler's address."""
    file = folder / "scheduler.json"
    log = (folder / "scheduler.log").open("w")
    scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1"]
    scheduler += ["--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
    started.append(subprocess.Popen(scheduler, stdout=log, stderr=log))
    while not file.exists():
        time.sleep(0.1)
    address: str = json.loads(file.read_text())["address"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1"]
    worker += ["--nworkers", str(WORKERS), "--memory-limit", "1GiB", "--no-dashboard"]
    worker += ["--local-directory", str(folder / "scratch")]
    started.append(subprocess.Popen(worker, stdout=log, stderr=log))
    time.sleep(10)
    return address


def _end(number: int, frame: object) -> None:
    """Unwind, so that the cluster does not outlive what it was started for."""
    sys.exit(128 + number)


def main() -> int:
    """Make the rows, run them by both runners; 1 where a limit is exceeded."""
    parser = argparse.ArgumentParser(description="What runners of cluster jobs cost.")
    parser.add_argument("--rows", type=float, default=1e7)
    parser.add_argument("--partitions", type=int, default=16)
    parser.add_argument("--solver", default="pinv", help="pinv makes partitions of ten seconds")
    parser.add_argument("--runners", default="local,dask")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, _end)
    runners = options.runners.split(",")
    found = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "in").mkdir()
        rows = int(options.rows)
        made = [sys.executable, "-c", MAKE, str(folder / "in"), ROBOT, str(rows)]
        subprocess.run([*made, str(options.partitions)], check=True)
        if "local" in runners:
            found["local"] = measure(folder, "local", options.solver, "--workers", str(WORKERS))
        if "dask" in runners:
            started: list[subprocess.Popen[bytes]] = []
            try:
                address = dask_cluster(folder, started)
                found["dask"] = measure(folder, "dask", options.solver, "--scheduler", address)
            finally:
                for process in reversed(started):
                    process.terminate()
                    process.wait()
        if len(found) == 2:
            a, b = ((folder / name / "_manifest.json").read_bytes() for name in found)
            print("same manifest, byte for byte" if a == b else "THE MANIFESTS DIFFER")
    print(f"\n{rows:,} rows, {options.solver}, {WORKERS} workers, {os.cpu_count()} cores, ", end="")
    print(f"load at the end {os.getloadavg()[0]:.1f}")
    print(
        "| runner | partitions | shortest s | run s | overhead | command s | overhead | peak MB |"
    )
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for name, row in found.items():
        print(
            f"| {name} | {row['partitions']} | {row['shortest_s']:.1f} | {row['run_s']:.1f} "
            f"| {row['overhead']:.2%} | {row['command_s']:.1f} | {row['with_start']:.2%} "
            f"| {row['peak_mb']:.0f} |"
        )
    worst = max(row["overhead"] for row in found.values())
    return int(worst > LIMIT or max(row["peak_mb"] for row in found.values()) > LIMIT_MB)


if __name__ == "__main__":
    sys.exit(main())
