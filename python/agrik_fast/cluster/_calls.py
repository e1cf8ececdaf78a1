"""What users call: a job over a source, by whichever runner."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .._checks import truth_value, whole_number, word
from ..errors import ArgumentError
from ..jobs import (
    MIXED,
    PARTITION_ROWS,
    Assignment,
    FileSource,
    FormulaSource,
    ForwardJob,
    Job,
    JobError,
    SolveJob,
    Source,
    Store,
    is_url,
    load_robot,
    open_store,
)
from ._dask import SCHEDULER_S, DaskRunner, Tls, check_workers, connect
from ._folder import check_description
from ._local import LocalRunner
from ._run import Report, Run, Summary
from ._runner import Runner

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Place = str | PathLike[str]
Near = float | tuple[float, float, float]
_LEVELS = ("scalar", "neon", "avx2", "avx512")
_MOST_SHARDS = 10**9


def run(
    job: Job,
    source: Place | Source | None,
    target: Place,
    *,
    generate: Place | None = None,
    workers: int | None = None,
    threads: int = 1,
    scheduler: Any = None,
    tls: Tls | None = None,
    insecure: bool = False,
    scheduler_timeout: float = SCHEDULER_S,
    shard: tuple[int, int] | None = None,
    partition_rows: int = PARTITION_ROWS,
    retries: int = 2,
    simd: str | None = None,
    allow_mixed: bool = False,
    force: bool = False,
    storage_options: Mapping[str, Any] | None = None,
    report: Report | None = None,
) -> Summary:
    """Run a job over all partitions of a source; what is there already is not done again.

    Killed at any moment and called again, it leaves the same parts, byte for byte, as a run that
    nothing disturbed. Every argument is checked, and whether source, target and workers can be
    used, before anything starts.

    Parameters
    ----------
    job : Job
        What to do, see `agrik_fast.jobs.Job`.
    source : str, path or Source
        A folder of Parquet files, a Parquet file, or the results of another job; path or URL.
    target : str or path
        Where results go; path or URL.
    generate : str or path, optional
        In place of `source`: a TOML file with a formula, whose rows are made by the workers.
    workers : int, optional
        Processes of the pool on this machine; default one per core.
    threads : int, default 1
        Threads of each worker.
    scheduler : str or distributed.Client, optional
        A Dask scheduler's address, or a client of one, in place of the pool.
    tls : Tls, optional
        Certificates for a scheduler at ``tls://``.
    insecure : bool
        Allow a scheduler of another machine without TLS.
    scheduler_timeout : float, default 10
        Seconds that the scheduler has to answer.
    shard : tuple of 2 int, optional
        (i, N): do only the partitions whose number leaves i when divided by N, for arrays of a
        batch system. The last shard to end writes the manifest.
    partition_rows : int, default 1,000,000
        Rows of a partition, for files with more rows (cut between row groups).
    retries : int, default 2
        Further attempts at a partition that fails.
    simd : str, optional
        Instruction set to work with ("scalar", "neon", "avx2", "avx512"); default this machine's
        or the workers'. Bits agree only on one set.
    allow_mixed : bool
        Let workers use whatever sets they have; last bits then depend on who did a partition.
    force : bool
        Replace results of another job or another source in `target`.
    storage_options : mapping, optional
        For fsspec: what the file systems of URLs are made with.
    report : callable, optional
        Called with a `Progress` at every event, and about every second.

    Returns
    -------
    Summary

    Raises
    ------
    AgrikError
        An argument, the source, the target or the cluster cannot be used; the scheduler was lost.
    KeyboardInterrupt
        Ctrl-C: work underway is given up within a second and leaves nothing behind.

    Examples
    --------
    >>> from agrik_fast import cluster, jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=5)
    >>> job = jobs.SolveJob(ik.Robot.load("ur5"))
    >>> summary = cluster.run(job, "parts", "run", workers=1, partition_rows=5)
    >>> summary.complete, summary.rows
    (True, 10)
    """
    workers = whole_number("workers", os.cpu_count() or 1 if workers is None else workers, 1)
    threads = whole_number("threads", threads, 1)
    retries = whole_number("retries", retries, 0)
    for name, value in (("force", force), ("allow_mixed", allow_mixed), ("insecure", insecure)):
        truth_value(name, value)
    if shard is not None:
        shard = _checked_shard(shard)
    if simd is not None:
        if allow_mixed:
            raise ArgumentError("simd", f"{simd!r} and allow_mixed", "one of them")
        word("simd", simd, _LEVELS)
    if scheduler is not None and shard is not None:
        raise ArgumentError("shard", "a shard and a scheduler", "one of them")
    if scheduler is None and tls is not None:
        raise ArgumentError("tls", "files of TLS without a scheduler", "a scheduler as well")
    rows = open_source(source, generate, partition_rows, storage_options)
    store = open_store(target, storage_options)
    _check_apart(rows, store)
    columns = rows.check(job)
    level = {"simd": MIXED} if allow_mixed else {} if simd is None else {"simd": simd}
    assignment = Assignment(job, columns, threads=threads, **level)
    client, owned = None, isinstance(scheduler, str)
    if scheduler is not None:
        client = scheduler
        if owned:
            client = connect(scheduler, tls, insecure=insecure, timeout_s=scheduler_timeout)
    try:
        if client is not None:
            found = check_workers(client, assignment, allow_mixed=allow_mixed)
            if simd not in (None, found):
                raise JobError(
                    str(client.scheduler.address),
                    f"its workers use {found}, not {simd}; start them with AGRIK_SIMD={simd}",
                )
            assignment = Assignment(job, columns, found, threads)
        store.prepare()
        check_description(store, assignment, rows, force=force)
        state = Run(assignment, rows, store, shard, retries, report)
        runner: Runner = LocalRunner(assignment, store, min(workers, len(state.numbers) or 1))
        if client is not None:
            runner = DaskRunner(client, assignment, store, len(state.numbers), owned=False)
        return state.go(runner, force=force)
    finally:
        if client is not None and owned:
            _close(client)


def solve(
    source: Place | Source | None,
    target: Place,
    robot: Any,
    *,
    task: str | None = None,
    solver: Any = "lm",
    position_tolerance: Near = 1e-6,
    orientation_tolerance: Near = 1e-6,
    tolerance_frame: Literal["base", "tool"] | None = None,
    tool_axis: tuple[float, float, float] = (0.0, 0.0, 1.0),
    direction: tuple[float, float, float] | None = None,
    mask: tuple[float, ...] | None = None,
    mask_frame: Literal["base", "tool"] = "base",
    q0: tuple[float, ...] | None = None,
    seed: int = 0,
    tool: ArrayLike | None = None,
    **options: Any,
) -> Summary:
    """Solve all targets of a source, see `run`.

    Rows get the answers that one call of `Robot.ik` with all of them would give, however they are
    cut into partitions. Columns that say nothing to the solver, and that all files have, are
    passed on behind the results' own.

    Parameters
    ----------
    source : str, path or Source
        Parquet files with the columns of `agrik_fast.io.read_targets`; None with `generate`.
    target : str or path
        Where results go.
    robot : Robot, str or path
        A robot, or what `Robot.load` takes.
    task, solver, position_tolerance, orientation_tolerance, tolerance_frame, tool_axis
        As for `agrik_fast.jobs.SolveJob`.
    direction, mask, mask_frame, q0, seed, tool
        As for `agrik_fast.jobs.SolveJob`.
    **options
        As for `run`: `generate`, `workers`, `threads`, `scheduler`, `tls`, `shard`, `report`, ...

    Returns
    -------
    Summary

    Raises
    ------
    AgrikError
        As for `run`.
    KeyboardInterrupt
        Ctrl-C.

    Examples
    --------
    >>> from agrik_fast.cluster import solve
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = (folder / "grid.toml").write_text('''
    ... [[axis]]
    ... column = "x_m"
    ... from = 0.2
    ... to = 0.4
    ... count = 5
    ... [[axis]]
    ... column = "y_m"
    ... from = -0.1
    ... to = 0.1
    ... count = 4
    ... [[axis]]
    ... column = "z_m"
    ... values = [0.3, 0.4]
    ... ''')
    >>> end = solve(None, folder / "out", "redundant7", generate=folder / "grid.toml", workers=1)
    >>> end.complete, end.rows, end.counts
    (True, 40, {'converged': 26, 'out_of_reach': 14})
    """
    job = SolveJob(
        robot=load_robot(robot),
        task=task,
        solver=solver,
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
        tolerance_frame=tolerance_frame,
        tool_axis=tool_axis,
        direction=direction,
        mask=mask,
        mask_frame=mask_frame,
        q0=q0,
        seed=seed,
        tool=tool,
    )
    rows = open_source(
        source,
        options.pop("generate", None),
        options.get("partition_rows", PARTITION_ROWS),
        options.get("storage_options"),
    )
    rows.check(job)  # what is wrong with a file is told with its name
    return run(job.passing_on(rows.schema), rows, target, **options)


def forward(source: Place | Source | None, target: Place, robot: Any, **options: Any) -> Summary:
    """Work out the tool's pose for all joint values of a source, see `run`.

    Parameters
    ----------
    source : str, path or Source
        Parquet files with a column a joint, as result files have them; None with `generate`.
    target : str or path
        Where poses go, in columns that `solve` reads.
    robot : Robot, str or path
        A robot, or what `Robot.load` takes.
    **options
        As for `run`.

    Returns
    -------
    Summary

    Raises
    ------
    AgrikError
        As for `run`.
    KeyboardInterrupt
        Ctrl-C.

    Examples
    --------
    >>> import pyarrow, pyarrow.parquet
    >>> from agrik_fast import cluster
    >>> from agrik_fast.io import ResultLayout
    >>> arm = ik.Robot.load("tomato")
    >>> names = ResultLayout.joint_names(arm.joint_names, arm.joint_types)
    >>> pyarrow.parquet.write_table(pyarrow.table(dict.fromkeys(names, [0.1])), "q.parquet")
    >>> cluster.forward("q.parquet", "poses", arm, workers=1).rows
    1
    """
    return run(ForwardJob(load_robot(robot)), source, target, **options)


def harvest(
    source: Place | Source | None, target: Place, job: Job | None = None, **options: Any
) -> Summary:
    """Decide for the fruits of many crops which can be picked, see `run`.

    Parameters
    ----------
    source : str, path or Source
        Parquet files with a row for each crop: a column ``scene`` with the paths of scene files,
        or arguments of made-up greenhouses; None with `generate`.
    target : str or path
        Where results go: a row for each crop.
    job : agrik_fast.harvest.CropsJob
        Robot, settings, and how distances are measured.
    **options
        As for `run`.

    Returns
    -------
    Summary

    Raises
    ------
    AgrikError
        As for `run`, and where there is no job.
    KeyboardInterrupt
        Ctrl-C.

    Examples
    --------
    >>> from agrik_fast.cluster import harvest
    >>> import pathlib, tempfile
    >>> from agrik_fast.harvest import CropsJob
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = (folder / "crops.toml").write_text('''
    ... rows_per_partition = 2
    ... [[axis]]
    ... column = "leaves"
    ... values = [4, 8]
    ... [[axis]]
    ... column = "seed"
    ... from = 1
    ... to = 2
    ... count = 2
    ... ''')
    >>> crops = folder / "crops.toml"
    >>> end = harvest(None, folder / "out", CropsJob("cucumber"), generate=crops, workers=1)
    >>> end.rows, end.counts
    (4, {'evaluated': 4})
    """
    if job is None:
        raise ArgumentError("job", "nothing", "an agrik_fast.harvest.CropsJob")
    return run(job, source, target, **options)


def open_source(
    source: Place | Source | None,
    generate: Place | None,
    partition_rows: int,
    storage_options: Mapping[str, Any] | None,
) -> Source:
    """Return the source that is meant by a place or a formula."""
    if (source is None) == (generate is None):
        received = "neither" if source is None else "both"
        raise ArgumentError("source", received, "a source or generate=, one of them")
    if generate is not None:
        return FormulaSource(generate)
    if isinstance(source, str | PathLike):
        return FileSource(source, partition_rows, storage_options)
    assert source is not None
    return source


def _check_apart(source: Source, store: Store) -> None:
    """Refuse results within their own source: the next start would read them."""
    if is_url(source.place) or is_url(store.place):
        inside = f"{store.place.rstrip('/')}/".startswith(f"{source.place.rstrip('/')}/")
    else:
        place, target = Path(source.place).resolve(), Path(fspath(store.place)).resolve()
        inside = place.is_dir() and (target == place or place in target.parents)
    if inside:
        raise ArgumentError("target", f"{store.place!r}, within the source", "another folder")


def _checked_shard(shard: Any) -> tuple[int, int]:
    try:
        index, count = shard
    except (TypeError, ValueError):
        raise ArgumentError("shard", repr(shard), "two whole numbers i, N") from None
    count = whole_number("shard", count, 1, _MOST_SHARDS)
    return whole_number("shard", index, 0, count - 1), count


def _close(client: Any) -> None:
    with contextlib.suppress(Exception):
        client.close(timeout=1.0)
