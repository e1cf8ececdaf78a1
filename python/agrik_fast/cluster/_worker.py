"""A process that works on one partition after the other, told by pipes; see `_local`.

It lives only as long as whoever started it: when the pipe from there ends, work is given up and
the process leaves, whatever became of the other end.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import struct
import sys
import threading
from typing import Any, BinaryIO

from ..errors import AgrikError
from ..jobs import (
    Assignment,
    Cancelled,
    Partition,
    Store,
    about_process,
    change_threads,
    run_partition,
    using_threads,
)

GRACE_S = 1.0
"""Seconds that work which is given up has to leave nothing behind."""
_SIZE = struct.Struct(">Q")
READY = "ready"
ENDED = "ended"


def send(stream: BinaryIO, message: Any) -> None:
    """Write a message to a pipe."""
    data = pickle.dumps(message)
    stream.write(_SIZE.pack(len(data)) + data)
    stream.flush()


def receive(stream: BinaryIO) -> Any:
    """Read a message from a pipe; None where it has ended."""
    try:
        head = stream.read(_SIZE.size)
        if len(head) < _SIZE.size:
            return None
        (size,) = _SIZE.unpack(head)
        data = stream.read(size)
    except (OSError, ValueError):
        return None
    return pickle.loads(data) if len(data) == size else None


def reason_of(error: BaseException) -> str:
    """Return what went wrong with a partition, on one line."""
    text = " ".join(str(error).split())
    if isinstance(error, AgrikError):
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


class _Worker:
    def __init__(self, orders: BinaryIO, answers: BinaryIO) -> None:
        self._orders = orders
        self._answers = answers
        self._waiting: queue.Queue[Partition | None] = queue.Queue()
        self._cancelled = threading.Event()
        self._working = False

    def run(self) -> None:
        setup = receive(self._orders)
        if setup is None:
            return
        with using_threads(setup[0].threads):
            self._work(*setup)

    def _work(self, assignment: Assignment, store: Store) -> None:
        signal.signal(signal.SIGINT, self._interrupted)
        signal.signal(signal.SIGTERM, self._terminated)
        threading.Thread(target=self._listen, name="agrik-fast-orders", daemon=True).start()
        send(self._answers, (READY, about_process()["simd"]))
        while (partition := self._waiting.get()) is not None:
            outcome: Any
            try:
                self._working = True
                outcome = run_partition(assignment, partition, store, self._at_step)
            except Cancelled:
                return
            except BaseException as error:
                if self._cancelled.is_set():
                    return
                outcome = reason_of(error)
            finally:
                self._working = False
            try:
                send(self._answers, (ENDED, outcome))
            except OSError:
                return

    def _listen(self) -> None:
        while True:
            order = receive(self._orders)
            if isinstance(order, Partition):
                self._waiting.put(order)
                continue
            if isinstance(order, int):
                # For the calls of the job that follow.
                change_threads(order)
                continue
            # "cancel", or nobody is there any more.
            self._cancelled.set()
            self._waiting.put(None)
            if self._working:
                # The compiled core looks for signals; it gives up within a fraction of a second.
                signal.raise_signal(signal.SIGINT)
            timer = threading.Timer(GRACE_S, os._exit, (1,))
            timer.daemon = True
            timer.start()
            return

    def _at_step(self, step: str) -> None:
        if self._cancelled.is_set():
            raise Cancelled

    def _interrupted(self, number: int, frame: object) -> None:
        # Ctrl-C is the starter's business, which tells its workers.
        if self._cancelled.is_set() and self._working:
            self._working = False
            raise Cancelled

    def _terminated(self, number: int, frame: object) -> None:
        self._cancelled.set()
        self._waiting.put(None)
        self._interrupted(number, frame)


def main() -> None:
    """Work until the orders end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    orders = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "wb")
    # What anybody prints must not get between the messages.
    os.dup2(2, 1)
    with open(os.devnull, "rb") as nothing:  # noqa: PTH123
        os.dup2(nothing.fileno(), 0)
    _Worker(orders, answers).run()
    sys.stderr.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
