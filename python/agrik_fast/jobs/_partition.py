"""The unit of work: one partition, done once however often it is asked for."""

from __future__ import annotations

import contextlib
import platform
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from .._files import os_reason
from .._native import simd_level
from ..io import import_pyarrow, parquet_writer
from ._job import MIXED, Assignment, JobError
from ._process import peak_mb, versions
from ._record import Record
from ._sources import Partition
from ._store import PartFile, Store

BATCH_ROWS = 65_536
"""Rows that are read, and written as a row group, at a time."""
# A piece of a batch is what one call of the job gets: short enough that a cancelled partition
# ends within a second, long enough that calls cost nothing. Results do not depend on it.
_PIECE_S = 0.25
_FIRST_PIECE = 64

AtStep = Callable[[str], None]
"""Hears of every step of a partition; may raise to end it."""


class Cancelled(BaseException):
    """A partition was given up because its result is no longer wanted now."""


@dataclass(frozen=True)
class Finished:
    """How a partition ended.

    Attributes
    ----------
    record : Record
    skipped : bool
        It was there already.

    Examples
    --------
    >>> from agrik_fast import jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=4)
    >>> source, job = jobs.FileSource("parts"), jobs.SolveJob(ik.Robot.load("ur5"))
    >>> assignment = jobs.Assignment(job, source.check(job))
    >>> work = assignment, source.partition(0), jobs.open_store("finished")
    >>> jobs.run_partition(*work).skipped, jobs.run_partition(*work).skipped
    (False, True)
    """

    record: Record
    skipped: bool


def _no_step(step: str) -> None:
    return


def run_partition(
    assignment: Assignment, partition: Partition, store: Store, at_step: AtStep = _no_step
) -> Finished:
    """Do the work on a partition, unless its results are there.

    Idempotent: it can be called any number of times, by several processes at once, and be
    killed at any moment; the part is the same bytes after every call that returns. The part is
    written beside its place and moved there, then the record is: so a record is never false, and
    a kill between the two costs one repetition.

    Parameters
    ----------
    assignment : Assignment
        The job.
    partition : Partition
        Of a source.
    store : Store
        Where results go.
    at_step : callable, optional
        Called with "begin", "rows" (often), "written", "placed", "recorded"; what it raises ends
        the work and leaves nothing behind.

    Returns
    -------
    Finished

    Raises
    ------
    JobError
        The source is damaged, has other columns than it had, or the store cannot be written; this
        process uses other instructions than the job's.

    Examples
    --------
    >>> from agrik_fast import jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=4)
    >>> source, job = jobs.FileSource("parts"), jobs.SolveJob(ik.Robot.load("ur5"))
    >>> assignment = jobs.Assignment(job, source.check(job))
    >>> store = jobs.open_store("solved")
    >>> jobs.run_partition(assignment, source.partition(0), store).record.rows
    4
    """
    here = simd_level()
    if assignment.simd not in (here, MIXED):
        raise JobError(
            f"host {platform.node()}",
            f"uses {here}, the job {assignment.simd}; results would differ in their last bits",
        )
    at_step("begin")
    started = time.perf_counter()
    known = finished(assignment, partition, store)
    if known is not None:
        return Finished(known, skipped=True)
    counts: Counter[str] = Counter()
    part = store.new_part(partition.name)
    try:
        _write(assignment, partition, part, counts, at_step)
        at_step("written")
        size, digest = part.stream.bytes, part.stream.sha256()
        key = part.commit()
    except BaseException:
        part.discard()
        raise
    at_step("placed")
    record = Record(
        job=assignment.hash,
        name=partition.name,
        source=dict(partition.origin),
        first=partition.first,
        rows=partition.rows,
        counts=dict(sorted(counts.items())),
        part=key,
        size=size,
        sha256=digest,
        seconds=round(time.perf_counter() - started, 6),
        host=platform.node(),
        simd=here,
        versions=versions(),
        peak_mb=peak_mb(),
    )
    store.write(store.record_of(partition.name), record.to_bytes())
    at_step("recorded")
    return Finished(record, skipped=False)


def finished(assignment: Assignment, partition: Partition, store: Store) -> Record | None:
    """Return the record of a partition whose results are there; None if it is to be done.

    Sizes are compared, contents are not: `agrik-fast cluster verify` does that.
    """
    record = Record.of(store.read(store.record_of(partition.name)))
    if record is None or record.job != assignment.hash or record.name != partition.name:
        return None
    if (record.first, record.rows) != (partition.first, partition.rows):
        return None
    if dict(record.source) != dict(partition.origin):
        return None
    return record if store.size(record.part) == record.size else None


def _write(
    assignment: Assignment,
    partition: Partition,
    part: PartFile,
    counts: Counter[str],
    at_step: AtStep,
) -> None:
    job = assignment.job
    pyarrow = import_pyarrow(lambda reason: JobError(partition.name, reason))
    writer: Any = None
    pieces = _Pieces()
    rows = 0
    try:
        for batch in _full(partition, assignment.columns, BATCH_ROWS):
            if writer is None:
                writer = parquet_writer(part.stream, job.schema(batch.schema))
            tables = []
            for piece, first in pieces.of(batch, partition.first + rows):
                done = job.work(piece, first)
                tables.append(done.table)
                counts.update(done.counts)
                at_step("rows")
            # One row group of the batch, however its pieces were cut.
            writer.write_table(pyarrow.concat_tables(tables).combine_chunks())
            rows += batch.num_rows
        if rows != partition.rows:
            raise JobError(partition.name, f"has {rows} rows, not {partition.rows} as before")
        writer.close()
        part.stream.flush()
    except OSError as error:
        raise JobError(partition.name, f"cannot be written: {os_reason(error)}") from error
    finally:
        if writer is not None:
            # Of one that failed, the disk may refuse the rest as well.
            with contextlib.suppress(OSError):
                writer.close()


def _full(partition: Partition, columns: tuple[str, ...], size: int) -> Iterator[Any]:
    """Yield batches of exactly `size` rows, but for the last, whatever the reader gives.

    So row groups, and with them the bytes of a part, follow from the partition alone.
    """
    pyarrow = import_pyarrow(lambda reason: JobError(partition.name, reason))
    waiting: list[Any] = []
    held = 0
    for batch in partition.data.batches(columns, size):
        at = 0
        while at < batch.num_rows:
            part = batch.slice(at, size - held)
            waiting.append(part)
            held += part.num_rows
            at += part.num_rows
            if held == size:
                yield _joined(pyarrow, waiting)
                waiting, held = [], 0
    if waiting:
        yield _joined(pyarrow, waiting)


def _joined(pyarrow: Any, batches: list[Any]) -> Any:
    if len(batches) == 1:
        return batches[0]
    (joined,) = pyarrow.Table.from_batches(batches).combine_chunks().to_batches()
    return joined


class _Pieces:
    """Cuts batches into pieces that take about the same time each."""

    def __init__(self) -> None:
        self._size = _FIRST_PIECE

    def of(self, batch: Any, first: int) -> Iterator[tuple[Any, int]]:
        at = 0
        while at < batch.num_rows:
            piece = batch.slice(at, self._size)
            started = time.perf_counter()
            yield piece, first + at
            took = max(time.perf_counter() - started, 1e-6)
            at += piece.num_rows
            fit = int(piece.num_rows * _PIECE_S / took)
            self._size = max(1, min(fit, 8 * self._size, BATCH_ROWS))
