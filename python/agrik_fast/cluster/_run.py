"""A job over all partitions: what is left to do is done by a runner, then comes the manifest."""

from __future__ import annotations

import itertools
import json
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

from ..jobs import MANIFEST, Assignment, Partition, Record, Source, Store, finished
from ._folder import FAILED, forget_stale, write_description, write_manifest
from ._runner import Ended, Runner

TICK_S = 1.0
_RATE_S = 60.0
# More records than this are looked at by the workers, each its own.
_LOOK_UP_TO = 20_000
_READERS = 16


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes
    ----------
    partitions, rows : int
        Of the whole run, or of its shard.
    done, skipped, failed : int
        Partitions that were worked on, that were there already, that were given up.
    rows_done : int
        Rows of those that are there.
    good : int
        How many of them went well.
    rows_per_s : float
        Over the last minute; NaN before the first partition ends.
    left_s : float
        Estimated seconds to the end; NaN while nothing is known.
    seconds : float
        Since the start.
    busy_s : float
        Sum of the partitions' own wall clocks.
    workers : int
    event : str
        What gave rise to this report: "start", "done", "skipped", "retry", "failed", "tick",
        "end".
    name : str
        The partition of the event.
    error : str
        What went wrong.

    Examples
    --------
    >>> from agrik_fast.cluster import Progress
    >>> now = Progress(partitions=4, rows=1000, done=2, rows_done=500)
    >>> now.rows_done / now.rows
    0.5
    """

    partitions: int
    rows: int
    done: int = 0
    skipped: int = 0
    failed: int = 0
    rows_done: int = 0
    good: int = 0
    rows_per_s: float = float("nan")
    left_s: float = float("nan")
    seconds: float = 0.0
    busy_s: float = 0.0
    workers: int = 0
    event: str = "start"
    name: str = ""
    error: str = ""


@dataclass(frozen=True)
class Failure:
    """A partition that was given up.

    Examples
    --------
    >>> from agrik_fast.cluster import Failure
    >>> Failure("part-00001", first=1000, rows=1000, attempts=3, error="disk full").rows
    1000
    """

    name: str
    first: int
    rows: int
    attempts: int
    error: str


@dataclass(frozen=True)
class Summary:
    """How a run ended.

    Attributes
    ----------
    place : str
        Where results are.
    partitions, done, skipped : int
        Of this run: how many there are, were worked on, were there already.
    failures : tuple of Failure
        Those that were given up.
    rows : int
        Rows whose results are there.
    counts : mapping of str to int
        How they ended.
    complete : bool
        All partitions of the source are there; the folder has its manifest.
    seconds, busy_s : float
        Wall clock, and the sum of the partitions' own.

    Examples
    --------
    >>> from agrik_fast import cluster, jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=5)
    >>> summary = cluster.solve("parts", "sums", ik.Robot.load("ur5"), workers=1)
    >>> summary.partitions, summary.done, summary.rows
    (2, 2, 10)
    """

    place: str
    partitions: int
    done: int
    skipped: int
    failures: tuple[Failure, ...]
    rows: int
    counts: dict[str, int]
    complete: bool
    seconds: float
    busy_s: float


Report = Callable[[Progress], None]


@dataclass
class Run:
    """The state of a run.

    Parameters
    ----------
    assignment : Assignment
    source : Source
    store : Store
    shard : tuple of 2 int, optional
        (i, N): only partitions whose number leaves i when divided by N.
    retries : int
        Attempts after the first one.
    report : callable, optional
    """

    assignment: Assignment
    source: Source
    store: Store
    shard: tuple[int, int] | None = None
    retries: int = 2
    report: Report | None = None

    _records: dict[int, Record] = field(default_factory=dict)
    _attempts: Counter[int] = field(default_factory=Counter)
    _failures: list[Failure] = field(default_factory=list)
    _counts: Counter[str] = field(default_factory=Counter)
    _recent: deque[tuple[float, int]] = field(default_factory=deque)
    _started: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.numbers = range(self.source.count)
        if self.shard is not None:
            self.numbers = self.numbers[self.shard[0] :: self.shard[1]]
        rows = self.source.rows
        if self.shard is not None:
            rows = sum(self.source.partition(number).rows for number in self.numbers)
        self._progress = Progress(len(self.numbers), rows)

    def go(self, runner: Runner, *, force: bool) -> Summary:
        """Do what is left to do, and end the runner."""
        cancel = True
        try:
            write_description(self.store, self.assignment, self.source)
            waiting = self._pending(self._look())
            self._tell("start")
            self._work(runner, waiting)
            cancel = False
        finally:
            runner.close(cancel=cancel)
        complete = self._finish(force=force)
        self._tell("end")
        now = self._progress
        return Summary(
            place=self.store.place,
            partitions=now.partitions,
            done=now.done,
            skipped=now.skipped,
            failures=tuple(self._failures),
            rows=now.rows_done,
            counts=dict(sorted(self._counts.items())),
            complete=complete,
            seconds=now.seconds,
            busy_s=now.busy_s,
        )

    # ---- what is there already ----------------------------------------------------------------

    def _look(self) -> set[int]:
        """Return the partitions that need nothing, and count them."""
        recorded = self.store.recorded()
        if len(recorded) > _LOOK_UP_TO:
            return set()
        there = [p for p in map(self.source.partition, self.numbers) if p.name in recorded]
        known = set()
        with ThreadPoolExecutor(_READERS) as pool:
            found = pool.map(lambda p: finished(self.assignment, p, self.store), there)
            for partition, record in zip(there, found, strict=True):
                if record is not None:
                    known.add(partition.number)
                    self._count(partition, record, skipped=True)
        if len(known) < len(self.numbers):
            # What is no longer whole must not look so.
            self.store.remove(MANIFEST)
        return known

    def _pending(self, known: set[int]) -> Iterator[Partition]:
        return (self.source.partition(k) for k in self.numbers if k not in known)

    # ---- the work -----------------------------------------------------------------------------

    def _work(self, runner: Runner, waiting: Iterator[Partition]) -> None:
        again: deque[Partition] = deque()
        told = time.monotonic()
        while True:
            while runner.room():
                group = list(itertools.islice(waiting, runner.group))
                if not group and again:
                    group = [again.popleft()]
                if not group:
                    runner.share_out()
                    break
                runner.submit(group)
            if not runner.busy():
                return
            for ended in runner.wait(TICK_S):
                self._progress = replace(self._progress, workers=runner.workers)
                self._ended(ended, again)
            if time.monotonic() - told >= TICK_S:
                told = time.monotonic()
                self._tell("tick")

    def _ended(self, ended: Ended, again: deque[Partition]) -> None:
        partition, outcome = ended
        if not isinstance(outcome, str):
            self._count(partition, outcome.record, skipped=outcome.skipped)
            self._tell("skipped" if outcome.skipped else "done", partition.name)
            return
        self._attempts[partition.number] += 1
        attempts = self._attempts[partition.number]
        if attempts <= self.retries:
            again.append(partition)
            self._tell("retry", partition.name, outcome)
            return
        failure = Failure(partition.name, partition.first, partition.rows, attempts, outcome)
        self._failures.append(failure)
        self._progress = replace(self._progress, failed=self._progress.failed + 1)
        self._tell("failed", partition.name, outcome)

    def _count(self, partition: Partition, record: Record, *, skipped: bool) -> None:
        now = self._progress
        # A million records would be the largest thing in this process.
        if self.source.count <= _LOOK_UP_TO:
            self._records[partition.number] = record
        self._counts.update(record.counts)
        if not skipped:
            self._recent.append((time.monotonic(), record.rows))
        self._progress = replace(
            now,
            done=now.done + (not skipped),
            skipped=now.skipped + skipped,
            rows_done=now.rows_done + record.rows,
            good=now.good + record.counts.get(self.assignment.job.success, 0),
            busy_s=now.busy_s + (0.0 if skipped else record.seconds),
        )

    def _tell(self, event: str, name: str = "", error: str = "") -> None:
        at = time.monotonic()
        while self._recent and at - self._recent[0][0] > _RATE_S:
            self._recent.popleft()
        seconds = at - self._started
        rows = sum(rows for _, rows in self._recent)
        rate = rows / min(max(seconds, 1e-9), _RATE_S) if rows else float("nan")
        left = (self._progress.rows - self._progress.rows_done) / rate
        self._progress = replace(
            self._progress,
            rows_per_s=rate,
            left_s=left,
            seconds=seconds,
            event=event,
            name=name,
            error=error,
        )
        if self.report is not None:
            self.report(self._progress)

    # ---- the end ------------------------------------------------------------------------------

    def _finish(self, *, force: bool) -> bool:
        """Write what is known of all partitions; returns whether all are there."""
        name = FAILED + ".json"
        if self.shard is not None:
            name = f"{FAILED}-{self.shard[0]}-{self.shard[1]}.json"
        if self._failures:
            self.store.write(name, _failed_bytes(self._failures))
            return False
        self.store.remove(name)
        records = self._all_records()
        if records is None:
            return False
        write_manifest(self.store, self.assignment, self.source, records)
        if force:
            forget_stale(self.store, self.assignment, {record.name for record in records})
        return True

    def _all_records(self) -> list[Record] | None:
        """Return the records of all partitions of the source, of other shards too."""
        if len(self._records) == self.source.count:
            return [self._records[number] for number in range(self.source.count)]
        if len(self.store.recorded()) < self.source.count:
            return None

        def read(number: int) -> Record | None:
            known = self._records.get(number)
            return known or finished(self.assignment, self.source.partition(number), self.store)

        records = []
        with ThreadPoolExecutor(_READERS) as pool:
            for record in pool.map(read, range(self.source.count)):
                if record is None:
                    return None
                records.append(record)
        return records


def _failed_bytes(failures: list[Failure]) -> bytes:
    listed = [vars(failure) for failure in sorted(failures, key=lambda each: each.first)]
    return (json.dumps(listed, indent=1) + "\n").encode()
