"""A thread that does what was asked for last: what came before and still waits is dropped."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

Job = Callable[[], None]


class Worker:
    """Does jobs one after the other; of several of one kind that wait, the newest alone.

    Call-backs of a window come on many threads. All that they change is changed here, on one, so
    that nothing has to be locked, and a slow solver never has a queue.

    Parameters
    ----------
    failed : callable
        Told of an exception that a job let out.
    """

    def __init__(self, failed: Callable[[Exception], None]) -> None:
        self._failed = failed
        self._waiting: dict[str, tuple[float, Job]] = {}
        self._changed = threading.Condition()
        self._ended = False
        self._busy = False
        self._thread = threading.Thread(target=self._run, name="agrik-viewer", daemon=True)
        self._thread.start()

    def submit(self, kind: str, job: Job, after: float = 0.0) -> None:
        """Have a job done; it takes the place of one of its kind that still waits.

        Parameters
        ----------
        kind : str
        job : callable
        after : float, default 0.0, s
            Time that it may wait for more of its kind.
        """
        due = time.monotonic() + after
        with self._changed:
            # The newest goes last, or an older job of another kind would undo it.
            self._waiting.pop(kind, None)
            self._waiting[kind] = (due, job)
            self._changed.notify_all()

    def waiting(self) -> bool:
        """Return whether something is to be done at once."""
        with self._changed:
            return self._next() is not None

    def _next(self) -> str | None:
        now = time.monotonic()
        return next((kind for kind, (due, _) in self._waiting.items() if due <= now), None)

    def settle(self, timeout: float) -> bool:
        """Wait until nothing is left to do; False if that took longer, s."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._waiting and not self._busy, timeout)

    def stop(self) -> None:
        """End the thread after the job that it is at."""
        with self._changed:
            self._ended = True
            self._waiting.clear()
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                self._changed.notify_all()
                kind = self._next()
                while kind is None and not self._ended:
                    dues = [due for due, _ in self._waiting.values()]
                    self._changed.wait(max(min(dues) - time.monotonic(), 0.0) if dues else None)
                    kind = self._next()
                if kind is None or self._ended:
                    return
                _, job = self._waiting.pop(kind)
                self._busy = True
            try:
                job()
            except Exception as error:
                self._failed(error)
