"""The runner on a Dask cluster that somebody has started."""

from __future__ import annotations

import contextlib
import ipaddress
import logging
import queue
import secrets
import threading
import time
import urllib.parse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ArgumentError
from ..jobs import (
    Assignment,
    Cancelled,
    Finished,
    JobError,
    Partition,
    Store,
    about_process,
    change_threads,
    run_partition,
    using_threads,
)
from ._runner import Ended
from ._worker import reason_of

# Beyond that many tasks a scheduler has more to remember than to do.
_MOST_TASKS = 10_000
# Tasks that are handed over for each thread: one at work, one to begin with at once.
_AHEAD = 2
# That Dask may need after its own time is over.
_MORE_S = 1.0
SCHEDULER_S = 10.0
"""Seconds that a scheduler has to answer."""


class LostError(JobError):
    """A scheduler that worked on a job does not answer any more; the job can be started again.

    Examples
    --------
    >>> from agrik_fast.cluster import LostError
    >>> from agrik_fast.jobs import JobError
    >>> issubclass(LostError, JobError)
    True
    """


@dataclass(frozen=True)
class Tls:
    """Files for encrypted connections: the authority, this side's certificate and key.

    Examples
    --------
    >>> from agrik_fast.cluster import Tls
    >>> Tls(ca="ca.pem", cert="worker.pem", key="worker.key").ca
    'ca.pem'
    """

    ca: Path | str
    cert: Path | str
    key: Path | str


def connect(address: str, tls: Tls | None, *, insecure: bool, timeout_s: float) -> Any:
    """Return a `distributed.Client` of a scheduler.

    Raises
    ------
    ArgumentError
        No address of a scheduler, one of another machine without TLS, or TLS files that are
        missing.
    JobError
        The scheduler does not answer; Dask is missing.
    """
    _check_address(address, tls, insecure=insecure)
    try:
        import distributed
        from distributed.security import Security
    except ImportError as error:
        reason = "a scheduler needs Dask: pip install 'agrik-fast[cluster]'"
        raise JobError(address, reason) from error
    security = None
    if tls is not None:
        for name in ("ca", "cert", "key"):
            path = Path(getattr(tls, name))
            if not path.is_file():
                raise ArgumentError(f"tls_{name}", f"{str(path)!r}, which is no file", "a PEM file")
        security = Security(
            tls_ca_file=str(tls.ca),
            tls_client_cert=str(tls.cert),
            tls_client_key=str(tls.key),
            require_encryption=True,
        )
    # A lost scheduler is told once, in our words.
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    made: queue.Queue[Any] = queue.Queue()

    def make() -> None:
        try:
            made.put(
                distributed.Client(
                    address, security=security, timeout=timeout_s, set_as_default=False
                )
            )
        except Exception as error:
            made.put(error)

    # In a thread, for Dask waits forever for one that takes the call and says nothing.
    threading.Thread(target=make, name="agrik-fast-connect", daemon=True).start()
    reason = f"the scheduler does not answer within {timeout_s:g} s"
    try:
        client = made.get(timeout=timeout_s + _MORE_S)
    except queue.Empty:
        raise JobError(address, reason) from None
    if isinstance(client, Exception):
        detail = " ".join(str(client.__cause__ or client).split())
        raise JobError(address, f"{reason} ({detail[:120]})" if detail else reason)
    return client


def _check_address(address: str, tls: Tls | None, *, insecure: bool) -> None:
    parts = urllib.parse.urlsplit(address)
    try:
        port = parts.port
    except ValueError:
        port = None
    if parts.scheme not in ("tcp", "tls") or not parts.hostname or port is None:
        raise ArgumentError("scheduler", repr(address), "tcp://HOST:PORT or tls://HOST:PORT")
    if (parts.scheme == "tls") != (tls is not None):
        expected = "tls:// together with the files of TLS (ca, cert, key), tcp:// without them"
        raise ArgumentError("scheduler", repr(address), expected)
    if parts.scheme == "tcp" and not insecure and not _is_loopback(parts.hostname):
        raise ArgumentError(
            "scheduler",
            repr(address),
            "tls:// for another machine, as its port runs any code that it is sent "
            "(insecure=True, --insecure: within a network of your own)",
        )


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def run_task(
    assignment: Assignment, partitions: Sequence[Partition], store: Store
) -> list[Finished | str]:
    """Work on partitions one after the other, in a worker; what fails is told, not raised."""
    wanted = _wanted()

    def at_step(step: str) -> None:
        if not wanted():
            raise Cancelled

    ended: list[Finished | str] = []
    with using_threads(assignment.threads):
        for partition in partitions:
            try:
                ended.append(run_partition(assignment, partition, store, at_step))
            except Cancelled:
                ended.append("cancelled")
                break
            except Exception as error:
                ended.append(reason_of(error))
    return ended


def _wanted() -> Any:
    """Return what tells whether the task of this thread is still waited for."""
    from distributed.worker import get_worker

    try:
        worker = get_worker()
        key = worker.get_current_task()
    except ValueError:
        return lambda: True

    def wanted() -> bool:
        task = worker.state.tasks.get(key)
        return task is not None and task.state != "cancelled"

    return wanted


class DaskRunner:
    """Tasks on the workers of a Dask scheduler.

    Only partitions, which are small, and records travel through the scheduler.
    """

    def __init__(
        self, client: Any, assignment: Assignment, store: Store, partitions: int, *, owned: bool
    ) -> None:
        self._client = client
        self._owned = owned
        self._assignment = assignment
        self._store = store
        self._address = str(client.scheduler.address if client.scheduler else "scheduler")
        self.group = -(-partitions // _MOST_TASKS)
        self._underway: dict[Any, Sequence[Partition]] = {}
        self._done: queue.Queue[Any] = queue.Queue()
        self._looked = 0.0
        self.workers = 1
        self._run = secrets.token_hex(6)
        self._number = 0
        self._shared: dict[str, int] = {}

    def room(self) -> bool:
        """Return whether workers may soon have nothing to do."""
        if time.monotonic() - self._looked > 1.0:
            # Workers come and go.
            self.workers = max(1, sum(self._client.nthreads().values()))
            self._looked = time.monotonic()
        return len(self._underway) < _AHEAD * self.workers

    def busy(self) -> bool:
        """Return whether any task is underway."""
        return bool(self._underway)

    def submit(self, partitions: Sequence[Partition]) -> None:
        """Hand a task over."""
        self._number += 1
        future = self._client.submit(
            run_task,
            self._assignment,
            tuple(partitions),
            self._store,
            key=f"agrik-fast-{self._run}-{self._number}",
            pure=False,
        )
        self._underway[future] = partitions
        future.add_done_callback(self._done.put)

    def share_out(self) -> None:
        """Let workers at work have the threads that others of their machine leave idle."""
        if self._client.status != "running" or len(self._underway) >= self.workers:
            return
        try:
            threads = self._client.nthreads()
            at_work = [
                worker
                for worker, keys in self._client.processing().items()
                if any(self._run in str(key) for key in keys)
            ]
            for worker in at_work:
                host = urllib.parse.urlsplit(worker).hostname
                beside = [w for w in threads if urllib.parse.urlsplit(w).hostname == host]
                sharing = sum(w in at_work for w in beside)
                wanted = self._assignment.threads * sum(threads[w] for w in beside) // sharing
                if self._shared.get(worker, self._assignment.threads) != wanted:
                    self._shared[worker] = wanted
                    self._client.run(change_threads, wanted, workers=[worker], wait=False)
        except Exception:
            # It would have been quicker; what is wrong is told by `wait`.
            return

    def wait(self, timeout_s: float) -> list[Ended]:
        """Return what ended."""
        ended: list[Ended] = []
        deadline = time.monotonic() + timeout_s
        while True:
            if self._client.status != "running":
                raise self._lost()
            left = 0.0 if ended else max(deadline - time.monotonic(), 0.0)
            try:
                future = self._done.get(timeout=left)
            except queue.Empty:
                return ended
            if future.status in ("cancelled", "lost"):
                raise self._lost()
            partitions = self._underway.pop(future, None)
            if partitions is not None:
                ended += self._ended(future, partitions)
                future.release()

    def _ended(self, future: Any, partitions: Sequence[Partition]) -> list[Ended]:
        try:
            failed = future.exception()
            outcomes = [] if failed is not None else future.result()
        except Exception:
            # Tasks do not raise: it is the way to them that is cut.
            raise self._lost() from None
        if failed is not None:
            reason = reason_of(failed)
            return [Ended(partition, reason) for partition in partitions]
        missing = ["not reached"] * (len(partitions) - len(outcomes))
        both = zip(partitions, [*outcomes, *missing], strict=True)
        return [Ended(partition, outcome) for partition, outcome in both]

    def _lost(self) -> LostError:
        return LostError(self._address, "the scheduler does not answer any more")

    def close(self, *, cancel: bool) -> None:
        """Give up what is underway, and leave the cluster as it was."""
        if cancel and self._underway and self._client.status == "running":
            with contextlib.suppress(Exception):
                self._client.cancel(list(self._underway), asynchronous=False)
        self._underway.clear()
        if self._owned:
            with contextlib.suppress(Exception):
                self._client.close(timeout=1.0)


def check_workers(client: Any, assignment: Assignment, *, allow_mixed: bool) -> str:
    """Return the instruction set that results are made with on these workers.

    Raises
    ------
    JobError
        There are none, one lacks the library or has another version, or they differ in their
        instruction sets.
    """
    address = str(client.scheduler.address)
    try:
        client.wait_for_workers(1, timeout=SCHEDULER_S)
    except TimeoutError:
        raise JobError(address, f"has no workers within {SCHEDULER_S:g} s") from None
    try:
        found: dict[str, dict[str, str]] = client.run(about_process)
    except Exception as error:
        reason = f"a worker cannot import agrik_fast: {reason_of(error)}"
        raise JobError(address, reason) from None
    mine = about_process()
    for worker, theirs in found.items():
        for name in ("agrik_fast", "pyarrow"):
            if theirs[name] != mine[name]:
                raise JobError(
                    worker, f"the worker has {name} {theirs[name]}, expected {mine[name]} as here"
                )
    if allow_mixed:
        return assignment.simd
    levels = sorted({theirs["simd"] for theirs in found.values()})
    if len(levels) > 1:
        first = {level: next(w for w, t in found.items() if t["simd"] == level) for level in levels}
        words = ", ".join(f"{level} ({worker})" for level, worker in first.items())
        raise JobError(
            address,
            f"mixed SIMD levels: {words}; results would differ in their last bits. Start all "
            "workers with the same AGRIK_SIMD, or allow it: allow_mixed=True, --allow-mixed",
        )
    return levels[0]
