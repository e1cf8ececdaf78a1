"""For graphs of one's own in Dask: jobs on the partitions of collections, and futures of parts."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from .._checks import whole_number
from ..errors import ArgumentError
from ..jobs import (
    MIXED,
    PARTITION_ROWS,
    Assignment,
    Finished,
    Job,
    JobError,
    Partition,
    Source,
    Store,
    open_store,
    run_partition,
    using_threads,
)
from ._calls import Place, open_source
from ._dask import check_workers


def map_partitions(
    collection: Any,
    job: Job,
    *,
    columns: Sequence[str] | None = None,
    lengths: Sequence[int] | None = None,
) -> Any:
    """Do a job on every partition of a Dask collection, lazily.

    Rows get the answers of the whole, however it is cut: every partition is told the index of its
    first row. Where the lengths of the partitions are not known, they are counted first, within
    the same graph.

    Parameters
    ----------
    collection : dask.dataframe.DataFrame or dask.array.Array
        Rows with the columns that the job reads; of an array, shape (n, k), in chunks of whole
        rows.
    job : Job
        What to do.
    columns : sequence of k str, optional
        Names of an array's columns.
    lengths : sequence of int, optional
        Rows of each partition. With them, no partition waits for those before it to be counted.

    Returns
    -------
    dask.dataframe.DataFrame
        The job's results, with the index of the rows where they keep it.

    Raises
    ------
    ArgumentError
        No such collection, or lengths of another number of partitions.
    JobError
        Columns that the job cannot read; Dask's data frames are missing.

    Examples
    --------
    >>> from agrik_fast.cluster import map_partitions
    >>> import dask.array, numpy as np
    >>> import agrik_fast as ik
    >>> from agrik_fast.jobs import SolveJob
    >>> arm = ik.Robot.load("puma560")
    >>> points = arm.fk(arm.random_q(100, seed=1))[:, :3, 3]
    >>> rows = dask.array.from_array(points, chunks=(30, 3))
    >>> found = map_partitions(rows, SolveJob(arm), columns=["x_m", "y_m", "z_m"])
    >>> bool(found.success.all().compute())
    True
    """
    try:
        import dask
        import dask.array
        import dask.dataframe
        import pyarrow
    except ImportError as error:
        reason = "collections need Dask's data frames: pip install 'dask[dataframe]'"
        raise JobError("collection", reason) from error
    if isinstance(collection, dask.array.Array):
        if columns is None or collection.ndim != 2 or collection.shape[1] != len(columns):
            raise ArgumentError(
                "columns",
                f"{columns!r} for an array of shape {collection.shape}",
                "a name for each column of an array of shape (n, k)",
            )
        if lengths is None and not any(map(_is_nan, collection.chunks[0])):
            lengths = collection.chunks[0]
        collection = dask.dataframe.from_dask_array(collection, columns=list(columns))
    elif not isinstance(collection, dask.dataframe.DataFrame):
        kind = type(collection).__name__
        raise ArgumentError("collection", f"a {kind}", "a Dask data frame or array")
    schema = pyarrow.Schema.from_pandas(collection._meta, preserve_index=False)
    used = job.columns(schema, partial(JobError, "collection"))
    meta = job.schema(schema).empty_table().to_pandas()
    parts = collection.to_delayed()
    if lengths is None:
        counts = [dask.delayed(len)(part) for part in parts]
        firsts = [dask.delayed(0)]
        for count in counts[:-1]:
            firsts.append(dask.delayed(operator.add)(firsts[-1], count))
    else:
        if len(lengths) != len(parts):
            raise ArgumentError("lengths", f"{len(lengths)} numbers", f"{len(parts)}")
        firsts = [0]
        for count in lengths[:-1]:
            firsts.append(firsts[-1] + whole_number("lengths", count, 0))
    work = dask.delayed(partial(_frame, job, used))
    done = [work(part, first) for part, first in zip(parts, firsts, strict=True)]
    return dask.dataframe.from_delayed(
        done, meta=meta, divisions=collection.divisions, verify_meta=False
    )


def _is_nan(number: float) -> bool:
    return number != number


def _frame(job: Job, columns: tuple[str, ...], frame: Any, first: int) -> Any:
    """Do the job on a pandas data frame."""
    import pyarrow

    batch = pyarrow.RecordBatch.from_pandas(frame[list(columns)], preserve_index=False)
    done = job.work(batch, int(first)).table.to_pandas()
    if len(done) == len(frame):
        done.index = frame.index
    return done


def futures(
    client: Any,
    job: Job,
    source: Place | Source,
    target: Place,
    *,
    threads: int = 1,
    allow_mixed: bool = False,
    storage_options: Mapping[str, Any] | None = None,
) -> list[Any]:
    """Start a job on all partitions of a source and return a future for each.

    Each is done by the same function as in `run`, so it is skipped where its results are there,
    and `run` skips what was done so. No description of the whole and no manifest is written.

    Parameters
    ----------
    client : distributed.Client
    job : Job
    source : str, path or Source
        As for `run`.
    target : str or path
        Where results go.
    threads : int, default 1
        Threads of each worker.
    allow_mixed : bool
        As for `run`.
    storage_options : mapping, optional
        For fsspec.

    Returns
    -------
    list of distributed.Future
        In the order of the rows; the result of each is an `agrik_fast.jobs.Finished`, with its
        record.

    Raises
    ------
    AgrikError
        As for `run`.

    Examples
    --------
    >>> import dask.distributed
    >>> from agrik_fast import cluster, jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=5)
    >>> with dask.distributed.Client(processes=False, dashboard_address=None) as client:
    ...     job = jobs.SolveJob(ik.Robot.load("ur5"))
    ...     found = cluster.futures(client, job, "parts", "out")
    ...     print([future.result().record.rows for future in found])
    [5, 5]
    """
    rows = open_source(source, None, PARTITION_ROWS, storage_options)
    columns = rows.check(job)
    simd = check_workers(client, Assignment(job, columns), allow_mixed=allow_mixed)
    assignment = Assignment(job, columns, MIXED if allow_mixed else simd, threads)
    store = open_store(target, storage_options)
    store.prepare()
    return [
        client.submit(_one, assignment, rows.partition(number), store, pure=False)
        for number in range(rows.count)
    ]


def _one(assignment: Assignment, partition: Partition, store: Store) -> Finished:
    with using_threads(assignment.threads):
        return run_partition(assignment, partition, store)
