"""What a job over partitions is, and the hash by which its results are known."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from .._files import Refusal
from .._native import __version__, simd_level
from ..errors import AgrikError

MIXED = "mixed"
"""Instruction set of a job whose workers may use different ones."""


class JobError(AgrikError, ValueError):
    """A source, a folder of results or a cluster cannot be used.

    Attributes
    ----------
    place : str
        Path, URL or address.
    reason : str
        What is wrong.

    Examples
    --------
    >>> from agrik_fast.jobs import FileSource, JobError
    >>> try:
    ...     FileSource("nowhere")
    ... except JobError as error:
    ...     print(error.place)
    nowhere
    """

    def __init__(self, place: str, reason: str) -> None:
        self.place = str(place)
        self.reason = reason
        super().__init__(f"{self.place}: {reason}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.place, self.reason)


@dataclass(frozen=True)
class Done:
    """What a job makes of some consecutive rows.

    Attributes
    ----------
    table : pyarrow.Table
        Results, of the job's schema.
    counts : mapping of str to int
        How many rows ended how; added up over a partition and over all.

    Examples
    --------
    >>> from agrik_fast.jobs import Done
    >>> import pyarrow
    >>> Done(pyarrow.table({"x": [1.0]}), {"CONVERGED": 1}).counts
    {'CONVERGED': 1}
    """

    table: Any
    counts: Mapping[str, int] = field(default_factory=dict)


class Job(Protocol):
    """Work on the rows of partitions, which any runner can do.

    A job is small, can be pickled, and is pure: equal rows with equal indices give equal results,
    bit for bit, in whatever pieces and processes they come. `run_partition` does the rest:
    reading, writing, records, resuming.

    Attributes
    ----------
    name : str
        What the job is called in records and messages.
    success : str
        Which of the counts is the number of rows that went well.

    Examples
    --------
    >>> from agrik_fast.jobs import ForwardJob
    >>> job = ForwardJob(ik.Robot.load("ur5"))
    >>> job.name, job.success
    ('forward', 'finite')
    """

    @property
    def name(self) -> str: ...

    @property
    def success(self) -> str: ...

    def identity(self) -> Mapping[str, Any]:
        """Return all that decides the results, as what JSON has words for.

        Examples
        --------
        >>> from agrik_fast.jobs import SolveJob
        >>> "robot" in SolveJob(ik.Robot.load("ur5")).identity()
        True
        """

    def columns(self, schema: Any, refuse: Refusal) -> tuple[str, ...]:
        """Return which columns of a source are read.

        Parameters
        ----------
        schema : pyarrow.Schema
            Of the source.
        refuse : callable
            Makes the error from what is wrong with the columns.

        Examples
        --------
        >>> from agrik_fast.jobs import SolveJob
        >>> import pyarrow
        >>> schema = pyarrow.schema([(name, pyarrow.float64()) for name in ("x_m", "y_m", "z_m")])
        >>> SolveJob(ik.Robot.load("ur5")).columns(schema, ValueError)
        ('x_m', 'y_m', 'z_m')
        """

    def schema(self, source: Any) -> Any:
        """Return the `pyarrow.Schema` of results for that of a source.

        Examples
        --------
        >>> from agrik_fast.jobs import SolveJob
        >>> import pyarrow
        >>> schema = pyarrow.schema([(name, pyarrow.float64()) for name in ("x_m", "y_m", "z_m")])
        >>> "status" in SolveJob(ik.Robot.load("ur5")).schema(schema).names
        True
        """

    def work(self, batch: Any, first: int) -> Done:
        """Return the results of a `pyarrow.RecordBatch`, the index of whose first row is given.

        Examples
        --------
        >>> from agrik_fast.jobs import SolveJob
        >>> import pyarrow
        >>> batch = pyarrow.RecordBatch.from_pydict({"x_m": [0.4], "y_m": [0.2], "z_m": [0.3]})
        >>> done = SolveJob(ik.Robot.load("ur5")).work(batch, first=0)
        >>> done.table.num_rows
        1
        """


@dataclass(frozen=True)
class Assignment:
    """A job with what it depends on besides itself.

    Attributes
    ----------
    job : Job
    columns : tuple of str
        Columns of the source that are read.
    simd : str
        Instruction set that results are made with, or "mixed": bits agree only on one set.
    threads : int
        Threads of a worker.

    Examples
    --------
    >>> from agrik_fast.jobs import Assignment, SolveJob
    >>> job = SolveJob(ik.Robot.load("ur5"))
    >>> Assignment(job, columns=("x_m", "y_m", "z_m")).threads
    1
    """

    job: Job
    columns: tuple[str, ...]
    simd: str = field(default_factory=simd_level)
    threads: int = 1

    def identity(self) -> dict[str, Any]:
        """Return what two results must share to belong together.

        Examples
        --------
        >>> from agrik_fast.jobs import Assignment, SolveJob
        >>> job = SolveJob(ik.Robot.load("ur5"))
        >>> sorted(Assignment(job, columns=("x_m", "y_m", "z_m")).identity())[:2]
        ['agrik_fast', 'columns']
        """
        own = {"job": self.job.name, **self.job.identity()}
        more = {"columns": list(self.columns), "simd": self.simd, "agrik_fast": __version__}
        return {**own, **more}

    @property
    def hash(self) -> str:
        """SHA-256 of the identity, 64 hex digits."""
        return hashlib.sha256(canonical(self.identity()).encode()).hexdigest()


def canonical(value: Any) -> str:
    """Return a value as JSON in one form: sorted keys, no blanks, floats with all their digits."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"))


def difference(found: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    """Say in which of their entries two identities differ."""
    from .._files import shown

    wanted = json.loads(canonical(wanted))
    words = [
        f"{key} {shown(found.get(key))}, not {shown(wanted.get(key))}"
        for key in sorted({*found, *wanted})
        if found.get(key) != wanted.get(key)
    ]
    return "; ".join(words[:4])
