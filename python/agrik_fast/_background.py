"""Work in threads of its own, a bounded way ahead of whoever needs it.

The threads are daemons and do the waiting with time-outs: the caller's thread stays open to
Ctrl-C, and a process that ends does not wait for the compiled code to return.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")

# A bare get() or join() ignores Ctrl-C on Windows.
POLL_S = 0.25


@dataclass(frozen=True)
class _Failure:
    error: BaseException


class _End:
    pass


def ahead(items: Iterable[T], depth: int, name: str) -> Generator[T]:
    """Yield the items, which a thread makes while the caller is busy with others.

    Nested calls make a pipeline: each stage runs in a thread, and no stage gets further ahead
    of the next than its depth, so that memory stays bounded. An error in a stage ends the
    stages before it and is raised to the caller; so does closing the generator.

    Parameters
    ----------
    items : iterable
        Consumed, and closed if it is a generator, in the thread.
    depth : int
        How many finished items may wait.
    name : str
        The thread's.

    Yields
    ------
    object
        The items in order.
    """
    ready: queue.Queue[T | _Failure | _End] = queue.Queue(depth)
    stop = threading.Event()

    def put(item: T | _Failure | _End) -> bool:
        while not stop.is_set():
            try:
                ready.put(item, timeout=POLL_S)
            except queue.Full:
                continue
            return True
        return False

    def work() -> None:
        try:
            for item in items:
                if not put(item):
                    break
            put(_End())
        except BaseException as error:
            put(_Failure(error))
        finally:
            if isinstance(items, Generator):
                items.close()

    threading.Thread(target=work, name=name, daemon=True).start()
    try:
        while True:
            try:
                item = ready.get(timeout=POLL_S)
            except queue.Empty:
                continue
            if isinstance(item, _End):
                return
            if isinstance(item, _Failure):
                raise item.error
            yield item
    finally:
        stop.set()


class Started(Generic[T]):
    """A call that runs in a thread of its own from now on.

    Parameters
    ----------
    work : callable
        Called without arguments.
    name : str
        The thread's.
    """

    def __init__(self, work: Callable[[], T], name: str) -> None:
        self._outcome: list[T | _Failure] = []

        def run() -> None:
            try:
                self._outcome.append(work())
            except BaseException as error:
                self._outcome.append(_Failure(error))

        self._thread = threading.Thread(target=run, name=name, daemon=True)
        self._thread.start()

    def result(self) -> T:
        """Wait for the call to end; return what it returned or raise what it raised."""
        while self._thread.is_alive():
            self._thread.join(POLL_S)
        (outcome,) = self._outcome
        if isinstance(outcome, _Failure):
            raise outcome.error
        return outcome
