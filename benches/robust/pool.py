"""Processes that do cases, and the watchdog that ends those that hang."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

BENCHES = Path(__file__).resolve().parent.parent


class Worker:
    """One process; its lines come in by a thread, since a process that hangs says nothing."""

    def __init__(self, seed: int, replies: queue.Queue[tuple[Worker, dict[str, Any] | None]]):
        handle, name = tempfile.mkstemp(prefix="fuzz-", suffix=".txt")
        os.close(handle)
        self.noise = Path(name)
        command = [
            sys.executable,
            "-c",
            f"import sys; sys.path.insert(0, {str(BENCHES)!r})\n"
            "from pathlib import Path\n"
            "from robust.worker import main\n"
            f"main({seed}, Path({str(self.noise)!r}))",
        ]
        with self.noise.open("ab") as noise:
            self.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=noise, text=True
            )
        self.case: int | None = None
        self.doing = ""
        self.since = time.monotonic()
        self._replies = replies
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._replies.put((self, json.loads(line)))
        self._replies.put((self, None))

    def give(self, case: int) -> None:
        assert self.process.stdin is not None
        self.case, self.doing, self.since = case, "start", time.monotonic()
        self.process.stdin.write(f"{case}\n")
        self.process.stdin.flush()

    def end(self) -> str:
        """Kill the process; return the end of what it wrote."""
        self.process.kill()
        self.process.wait()
        self._listener.join()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()
        text = self.noise.read_text(errors="replace")[-1500:] if self.noise.exists() else ""
        self.noise.unlink(missing_ok=True)
        return text


def work(
    seed: int, cases: Iterator[int], workers: int, seconds_a_call: float
) -> Iterator[dict[str, Any]]:
    """Do cases until there are no more; give what each found, in the order they end.

    Parameters
    ----------
    seed : int
        Of all cases.
    cases : iterator of int
        Numbers of cases; asked for the next one whenever a process is free.
    workers : int
        Processes.
    seconds_a_call : float
        A call that takes longer is a hang: its process is killed and replaced.
    """
    replies: queue.Queue[tuple[Worker, dict[str, Any] | None]] = queue.Queue()
    busy: set[Worker] = set()

    def employ(worker: Worker) -> None:
        case = next(cases, None)
        if case is None:
            busy.discard(worker)
            worker.end()
        else:
            busy.add(worker)
            worker.give(case)

    for _ in range(workers):
        employ(Worker(seed, replies))
    try:
        while busy:
            try:
                worker, reply = replies.get(timeout=0.5)
            except queue.Empty:
                pass
            else:
                if worker not in busy:
                    continue
                if reply is None:
                    yield _lost(worker, "crash", _how(worker))
                    busy.discard(worker)
                    employ(Worker(seed, replies))
                elif "done" in reply:
                    yield reply
                    employ(worker)
                else:
                    worker.doing, worker.since = reply["doing"], time.monotonic()
            for worker in [w for w in busy if time.monotonic() - w.since > seconds_a_call]:
                yield _lost(worker, "hang", f"no answer for {seconds_a_call:g} s")
                busy.discard(worker)
                employ(Worker(seed, replies))
    finally:
        for worker in busy:
            worker.end()


def _how(worker: Worker) -> str:
    code = worker.process.wait()
    return signal.Signals(-code).name if code < 0 else f"exit status {code}"


def _lost(worker: Worker, kind: str, how: str) -> dict[str, Any]:
    said = worker.end()
    fault = {
        "kind": kind,
        "case": worker.case,
        "place": worker.doing,
        "text": f"{how}; {said}".strip("; \n"),
        "code": "",
    }
    return {
        "done": worker.case,
        "counts": {f"fault: {kind}": 1},
        "tally": {},
        "faults": [fault],
    }
