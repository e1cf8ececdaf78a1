"""What the tests of cluster jobs share: small sources, processes that are surely ended, hashes."""

import contextlib
import hashlib
import itertools
import json
import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pyarrow
from pyarrow import parquet

import agrik_fast as ik
from cli_runner import run_command

TESTS = Path(__file__).parent
ROBOT = "redundant7"
TAG = "AGRIK_FAST_TEST_TAG"
# Random poses in a box: some solve at once, some are out of reach, some take all restarts, so
# that a partition lasts some tenths of a second.
FORMULA = """\
rows = {rows}
seed = 1
rows_per_partition = {size}

[[random]]
column = "x_m"
from = -0.45
to = 0.45

[[random]]
column = "y_m"
from = -0.45
to = 0.45

[[random]]
column = "z_m"
from = 0.2
to = 0.8

[[random]]
rotation = true
"""


def write_formula(path: Path, rows: int = 1_800, size: int = 300) -> Path:
    path.write_text(FORMULA.format(rows=rows, size=size))
    return path


def pose_table(rows: int, seed: int = 1) -> pyarrow.Table:
    """Return reachable poses of the robot as columns that a job reads."""
    arm = ik.Robot.load(ROBOT)
    poses = arm.fk(arm.random_q(rows, seed=seed))
    numbers = np.hstack([poses[:, :3, 3], ik.rotations.quat_of(poses)])
    names = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
    return pyarrow.table({name: numbers[:, k].copy() for k, name in enumerate(names)})


def write_parts(folder: Path, table: pyarrow.Table, pieces: int) -> Path:
    """Write a table as some files of unequal length."""
    folder.mkdir(parents=True, exist_ok=True)
    ends = np.unique(np.linspace(0, table.num_rows, pieces + 1).astype(int) // 7 * 7)
    ends[-1] = table.num_rows
    for k, (begin, end) in enumerate(itertools.pairwise(ends)):
        parquet.write_table(table.slice(begin, end - begin), folder / f"in-{k:03d}.parquet")
    return folder


def hashes(folder: Path) -> dict[str, str]:
    """Return the hashes of all results and of the manifest, by their names."""
    files = [path for path in folder.rglob("*.parquet") if not path.name.startswith(".")]
    files += [path for path in (folder / "_manifest.json",) if path.exists()]
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in files
    }


def temporaries(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob(".*.partial"))


class Processes:
    """Starts programs that end, with all of theirs, when the test does."""

    def __init__(self) -> None:
        self.tag = uuid.uuid4().hex
        self._started: list[subprocess.Popen[str]] = []

    def environment(self, **more: str) -> dict[str, str]:
        paths = [str(TESTS), *(path for path in sys.path if path)]
        return {**os.environ, TAG: self.tag, "PYTHONPATH": os.pathsep.join(paths), **more}

    def start(
        self, *words: object, set_up: Callable[[], None] | None = None, **more: str
    ) -> subprocess.Popen[str]:
        """Start a Python program in a session of its own."""

        def before() -> None:
            # A background shell ignores Ctrl-C, and its children after it.
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            if set_up is not None:
                set_up()

        process = subprocess.Popen(
            [sys.executable, *map(str, words)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
            text=True,
            env=self.environment(**more),
            start_new_session=True,
            preexec_fn=before,
        )
        self._started.append(process)
        return process

    def cluster(
        self, *words: object, set_up: Callable[[], None] | None = None, **more: str
    ) -> subprocess.Popen[str]:
        """Start `agrik-fast cluster`."""
        return self.start("-m", "agrik_fast.cli", "cluster", *words, set_up=set_up, **more)

    def alive(self, tag: str | None = None) -> dict[int, str]:
        """Return all processes that were started here, or by those, and live."""
        found = {}
        for folder in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if f"{TAG}={tag or self.tag}".encode() in (folder / "environ").read_bytes():
                    words = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                    found[int(folder.name)] = words
        return found

    def workers(self) -> list[int]:
        """Return the processes of the pool."""
        found = self.alive()
        return sorted(number for number, words in found.items() if "cluster._worker" in words)

    def gone(self, timeout_s: float = 10.0) -> dict[int, str]:
        """Wait until none lives, and return those that live all the same."""
        wait_for(lambda: not self.alive(), timeout_s, fail=False)
        return self.alive()

    def close(self) -> None:
        for number in self.alive():
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
        for process in self._started:
            process.kill()
            process.communicate()


def run_cluster(*words: object, code: int = 0) -> tuple[str, str]:
    """Run `agrik-fast cluster` in this process and return what it printed."""
    done = run_command("cluster", *words)
    assert done.exit_code == code, (done.exit_code, done.stdout, done.stderr)
    assert "Traceback" not in done.output
    return done.stdout, done.stderr


def ended(process: subprocess.Popen[str], code: int) -> tuple[str, str]:
    """Wait for a program, which must end with this status and without a traceback."""
    out, err = process.communicate(timeout=100)
    assert process.returncode == code, (process.returncode, out, err)
    assert "Traceback" not in err, err
    return out, err


def wait_for(condition: Callable[[], object], timeout_s: float = 60.0, fail: bool = True) -> None:
    end = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > end:
            assert not fail, "it did not come to pass"
            return
        time.sleep(0.02)


def scheduler_address(file: Path) -> str:
    """Return the address in a scheduler's file, which is there before it is written."""
    wait_for(lambda: file.exists() and file.stat().st_size > 0)
    address: str = json.loads(file.read_text())["address"]
    return address


@contextlib.contextmanager
def processes() -> Iterator[Processes]:
    started = Processes()
    try:
        yield started
    finally:
        started.close()
