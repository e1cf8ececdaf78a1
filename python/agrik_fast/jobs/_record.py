"""The record of a partition: what was done, by which job, and what the part has to be."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ._job import canonical


@dataclass(frozen=True)
class Record:
    """What is known of a finished partition.

    Attributes
    ----------
    job : str
        Hash of the job, see `Assignment`.
    name : str
        Of the partition.
    source : mapping
        What the rows were read from: name, size, time or tag; or the formula.
    first, rows : int
        Index of the first row in the whole, and how many.
    counts : mapping of str to int
        How rows ended.
    part, size, sha256
        Name, size and hash of the file with the results.
    seconds : float
        Wall clock.
    host, simd, versions, peak_mb
        Where, with which instructions and libraries, and the largest memory of the process.

    Examples
    --------
    >>> from agrik_fast import jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=4)
    >>> source, job = jobs.FileSource("parts"), jobs.SolveJob(ik.Robot.load("ur5"))
    >>> assignment = jobs.Assignment(job, source.check(job))
    >>> work = assignment, source.partition(0), jobs.open_store("recorded")
    >>> record = jobs.run_partition(*work).record
    >>> record.first, record.rows, len(record.sha256)
    (0, 4, 64)
    """

    job: str
    name: str
    source: Mapping[str, Any]
    first: int
    rows: int
    counts: Mapping[str, int]
    part: str
    size: int
    sha256: str
    seconds: float
    host: str
    simd: str
    versions: Mapping[str, str]
    peak_mb: float

    def to_bytes(self) -> bytes:
        """Return the record as a JSON file with a checksum."""
        content = dataclasses.asdict(self)
        return (json.dumps({**content, "check": _check(content)}, indent=1) + "\n").encode()

    @classmethod
    def of(cls, data: bytes | None) -> Record | None:
        """Return a record from its file; None where it is damaged or no record at all."""
        try:
            content = json.loads(data or b"")
            if content.pop("check") != _check(content):
                return None
            return cls(**content)
        except (AttributeError, KeyError, RecursionError, TypeError, ValueError):
            return None

    def entry(self) -> dict[str, Any]:
        """Return what the manifest has of it: all that is the same whoever does the work."""
        left_out = ("job", "seconds", "host", "versions", "peak_mb")
        content = dataclasses.asdict(self)
        return {key: value for key, value in content.items() if key not in left_out}


def _check(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(canonical(content).encode()).hexdigest()
