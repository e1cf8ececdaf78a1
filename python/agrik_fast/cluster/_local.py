"""The default runner: a pool of processes on this machine.

A pool of the standard library ends as a whole when one of its processes is killed, and starts its
processes from the caller's main module; here a process that dies is replaced and its partition is
one failed attempt.
"""

from __future__ import annotations

import contextlib
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from typing import IO, Any, cast

from ..jobs import MIXED, Assignment, JobError, Partition, Store
from ._runner import Ended
from ._worker import GRACE_S, READY, receive, send

_TOLD_LETTERS = 300


class _Process:
    """A worker process and the partition that it is at."""

    def __init__(self, setup: Any, events: queue.Queue[tuple[_Process, Any]], simd: str) -> None:
        self.partition: Partition | None = None
        self.threads = 0
        self.ready = False
        self.errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 - closed by `end`
        environment = dict(os.environ)
        environment["PYTHONPATH"] = os.pathsep.join(path or os.getcwd() for path in sys.path)  # noqa: PTH109
        # Each process has its own core.
        environment.setdefault("OMP_NUM_THREADS", "1")
        if simd != MIXED:
            environment["AGRIK_SIMD"] = simd
        self.popen = subprocess.Popen(
            [sys.executable, "-P", "-m", "agrik_fast.cluster._worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.errors,
            env=environment,
            # The terminal's Ctrl-C is for the starter, which tells its workers.
            start_new_session=True,
        )
        self._events = events
        self.tell(setup)
        self._listener = threading.Thread(
            target=self._listen, name="agrik-fast-worker", daemon=True
        )
        self._listener.start()

    def tell(self, message: Any) -> None:
        # One that is gone is noticed by its answers.
        with contextlib.suppress(OSError, ValueError):
            send(cast("Any", self.popen.stdin), message)

    def _listen(self) -> None:
        while (message := receive(cast("Any", self.popen.stdout))) is not None:
            self._events.put((self, message))
        self._events.put((self, None))

    def last_words(self) -> str:
        """Return how the process ended, with the last line that it wrote."""
        code = self.popen.wait()
        how = f"signal {-code}" if code < 0 else f"status {code}"
        self.errors.seek(0)
        lines = self.errors.read().decode(errors="replace").strip().splitlines()
        return f"worker process ended ({how})" + (
            f": {lines[-1][:_TOLD_LETTERS]}" if lines and code > 0 else ""
        )

    def end(self) -> None:
        """Kill the process if it is there, and let go of its pipes."""
        if self.popen.poll() is None:
            self.popen.kill()
        self.popen.wait()
        # It reads to the end of the pipe, which must not be closed under its hands.
        self._listener.join(GRACE_S)
        for stream in (self.popen.stdin, self.popen.stdout, self.errors):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()


class LocalRunner:
    """Processes of this machine, one partition each at a time."""

    group = 1

    def __init__(self, assignment: Assignment, store: Store, workers: int) -> None:
        self.workers = workers
        self._setup = (assignment, store)
        self._store = store
        self._simd = assignment.simd
        self._threads = assignment.threads
        self._events: queue.Queue[tuple[_Process, Any]] = queue.Queue()
        self._processes: list[_Process] = []

    def room(self) -> bool:
        """Return whether a process has nothing to do, or may still be started."""
        idle = any(process.partition is None for process in self._processes)
        return idle or len(self._processes) < self.workers

    def busy(self) -> bool:
        """Return whether any process has a partition."""
        return any(process.partition is not None for process in self._processes)

    def submit(self, partitions: Sequence[Partition]) -> None:
        """Give a partition to a process that has none."""
        (partition,) = partitions
        process = next((each for each in self._processes if each.partition is None), None)
        if process is None:
            process = _Process(self._setup, self._events, self._simd)
            self._processes.append(process)
        process.partition = partition
        self._use(process, self._threads)
        process.tell(partition)

    def share_out(self) -> None:
        """Let processes at work have the threads of those that are not."""
        at_work = [process for process in self._processes if process.partition is not None]
        for process in at_work:
            self._use(process, self._threads * self.workers // len(at_work))

    def _use(self, process: _Process, threads: int) -> None:
        if process.threads != threads:
            process.threads = threads
            process.tell(threads)

    def wait(self, timeout_s: float) -> list[Ended]:
        """Return what ended."""
        ended: list[Ended] = []
        deadline = time.monotonic() + timeout_s
        while True:
            left = deadline - time.monotonic()
            try:
                process, message = self._events.get(timeout=max(left, 0.0) if not ended else 0.0)
            except queue.Empty:
                return ended
            if process not in self._processes:
                continue
            if message is None:
                ended += self._lost(process)
            elif message[0] == READY:
                process.ready = True
                if self._simd not in (message[1], MIXED):
                    reason = f"has no instruction set {self._simd!r}, but {message[1]!r}"
                    raise JobError("this machine", reason)
            elif process.partition is not None:
                ended.append(Ended(process.partition, message[1]))
                process.partition = None

    def _lost(self, process: _Process) -> list[Ended]:
        words = process.last_words()
        self._drop(process)
        if not process.ready and process.popen.returncode > 0:
            # It would be the same with the next one.
            raise JobError("worker", f"cannot be started: {words}")
        return [] if process.partition is None else [Ended(process.partition, words)]

    def _drop(self, process: _Process) -> None:
        """Forget a process that has ended, and what it left behind."""
        self._processes.remove(process)
        process.end()
        if process.partition is not None:
            name, number = process.partition.name, process.popen.pid
            for left in self._store.leftovers(0.0, name, number):
                self._store.remove(left)

    def close(self, *, cancel: bool) -> None:
        """End all processes; those at work within a second."""
        try:
            for process in self._processes:
                process.tell("cancel")
            deadline = time.monotonic() + (GRACE_S if cancel else 10 * GRACE_S)
            for process in self._processes:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.popen.wait(max(deadline - time.monotonic(), 0.0))
        finally:
            for process in list(self._processes):
                with contextlib.suppress(JobError):
                    self._drop(process)
