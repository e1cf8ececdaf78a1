"""Which libraries take part, their environments, and the worker process of each."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

BENCHES = Path(__file__).resolve().parent.parent
ROOT = BENCHES.parent
OURS = "agrik_fast"


@dataclass(frozen=True)
class Library:
    """An adapter module and the environment it runs in; None is the project's own."""

    name: str
    module: str
    group: str | None
    numeric: bool = True


LIBRARIES = {
    library.name: library
    for library in (
        Library(OURS, "agrik_fast_api", None),
        Library("dynibo", "dynibo_api", "rust"),
        Library("roboticstoolbox", "roboticstoolbox_api", "rtb"),
        Library("cartan", "cartan_api", "rust"),
        Library("optik", "optik_api", "rust"),
        Library("pinocchio", "pinocchio_api", "pin"),
        Library("eaik", "eaik_api", "eaik", numeric=False),
        Library("numpy", "numpy_api", "pin"),
    )
}


class BenchError(Exception):
    """A worker or an environment that does not work; the message is for the user."""


def interpreter(group: str | None) -> Path:
    """Return the Python of a group's environment, which is made on first use."""
    if group is None:
        return Path(sys.executable)
    environment = ROOT / f".venv-peers-{group}"
    folder, suffix = ("Scripts", ".exe") if os.name == "nt" else ("bin", "")
    python = environment / folder / f"python{suffix}"
    wanted = (BENCHES / "requirements" / f"{group}.txt").read_text()
    stamp = environment / "installed.txt"
    if stamp.exists() and stamp.read_text() == wanted:
        return python
    print(f"making {environment.name} ({', '.join(wanted.split())}) ...", flush=True)
    _run([sys.executable, "-m", "venv", str(environment)])
    requirements = str(BENCHES / "requirements" / f"{group}.txt")
    _run([str(python), "-m", "pip", "install", "--quiet", "-r", requirements])
    stamp.write_text(wanted)
    return python


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise BenchError(f"{' '.join(command)} failed:\n{done.stderr[-2000:]}")


class Process:
    """A library's worker: one request at a time, so that idle workers cost no CPU."""

    def __init__(
        self, library: Library, cpu: int, environment: dict[str, str] | None = None
    ) -> None:
        self.library = library
        variables = {
            **os.environ,
            # One thread each, except where a call names its threads.
            **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
            "AGRIK_NUM_THREADS": "1" if cpu >= 0 else str(os.cpu_count() or 1),
            **(environment or {}),
        }
        # A file, because a library that prints much would fill a pipe and stop.
        self._log = tempfile.TemporaryFile("w+")  # noqa: SIM115 - closed with the worker
        self._process = subprocess.Popen(
            [
                str(interpreter(library.group)),
                "-W",
                "ignore",
                "-m",
                "peer_bench.worker",
                library.module,
                str(cpu),
            ],
            cwd=BENCHES,
            env=variables,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
        )
        self.about = self.ask("about")

    def ask(self, op: str, **arguments: Any) -> dict[str, Any]:
        self.send(op, **arguments)
        return self.receive()

    def send(self, op: str, **arguments: Any) -> None:
        """Make a request without waiting, so that another worker can be busy meanwhile."""
        assert self._process.stdin is not None
        # A worker that has ended says why when it is asked for its answer.
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(json.dumps({"op": op, **arguments}) + "\n")
            self._process.stdin.flush()

    def receive(self) -> dict[str, Any]:
        """Wait for the answer to the request made last."""
        process = self._process
        assert process.stdout is not None
        line = process.stdout.readline()
        if not line:
            process.wait(timeout=30)
            self._log.seek(0)
            raise BenchError(f"{self.library.name}: worker ended:\n{self._log.read()[-2000:]}")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise BenchError(f"{self.library.name}: {answer['error']}")
        return answer

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(timeout=30)
        self._log.close()
