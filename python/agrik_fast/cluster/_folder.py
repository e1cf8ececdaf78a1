"""A folder of results as a whole: whose it is, how far, whether it is intact, what is left over."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import PathLike
from typing import Any

from .._checks import real_number
from ..jobs import MANIFEST, Assignment, JobError, Record, Source, Store, difference, open_store

DESCRIPTION = "_job.json"
FAILED = "_failed"
LEFTOVER_S = 3600.0
"""Age from which a temporary file counts as left over."""
_READERS = 16


def check_description(store: Store, assignment: Assignment, source: Source, *, force: bool) -> None:
    """Refuse a folder that holds results of another job or of another source.

    Raises
    ------
    JobError
        It does, and `force` is False.
    """
    found = _description(store)
    if found is None or force:
        return
    refuse = store.refuse()
    how = "choose another folder, or replace them (force=True, --force)"
    if found.get("hash") != assignment.hash:
        theirs = found.get("identity", {})
        words = difference(theirs, assignment.identity())
        if {**theirs, "simd": ""} == {**json.loads(json.dumps(assignment.identity())), "simd": ""}:
            raise refuse(
                f"mixed SIMD levels: holds results made with {theirs.get('simd')}, this machine "
                f"uses {assignment.simd}; set simd= (--simd), allow it (allow_mixed=True, "
                f"--allow-mixed) from the beginning, or {how}"
            )
        raise refuse(f"holds results of another job: {words}; {how}")
    if found.get("source") != source.summary():
        words = difference(found.get("source", {}), source.summary())
        raise refuse(f"holds results of another source: {words}; {how}")


def write_description(store: Store, assignment: Assignment, source: Source) -> None:
    """Write whose results a folder holds, if it does not say so yet."""
    content = {
        "hash": assignment.hash,
        "identity": assignment.identity(),
        "source": source.summary(),
        "success": assignment.job.success,
    }
    data = _json(content)
    if store.read(DESCRIPTION) != data:
        store.write(DESCRIPTION, data)


def _description(store: Store) -> dict[str, Any] | None:
    data = store.read(DESCRIPTION)
    if data is None:
        return None
    try:
        content = json.loads(data)
    except ValueError:
        content = None
    if not isinstance(content, dict) or not isinstance(content.get("source"), dict):
        raise store.refuse(DESCRIPTION)("is damaged; remove it to go on")
    return content


def write_manifest(
    store: Store, assignment: Assignment, source: Source, records: Sequence[Record]
) -> None:
    """Write the list of all parts: the same bytes, whoever did the work."""
    counts: Counter[str] = Counter()
    for record in records:
        counts.update(record.counts)
    schema = assignment.job.schema(source.schema)
    content = {
        "hash": assignment.hash,
        "identity": assignment.identity(),
        "schema": [[field.name, str(field.type)] for field in schema],
        "totals": {
            "partitions": len(records),
            "rows": sum(record.rows for record in records),
            "bytes": sum(record.size for record in records),
            "counts": dict(sorted(counts.items())),
        },
        "partitions": [record.entry() for record in records],
    }
    data = _json(content)
    if store.read(MANIFEST) != data:
        store.write(MANIFEST, data)


def _json(content: Any) -> bytes:
    return (json.dumps(content, indent=1) + "\n").encode()


def _records(store: Store) -> dict[str, Record | None]:
    """Return all records by the names of their partitions; None for those that are damaged."""
    names = sorted(store.recorded())
    with ThreadPoolExecutor(_READERS) as pool:
        read = pool.map(lambda name: Record.of(store.read(store.record_of(name))), names)
        return dict(zip(names, read, strict=True))


def forget_stale(store: Store, assignment: Assignment, names: set[str]) -> None:
    """Remove records and parts of a former job that this one has not replaced."""
    records = _records(store)
    kept = {record.part for name, record in records.items() if record and name in names}
    for name in records:
        if name not in names:
            store.remove(store.record_of(name))
    for part in store.parts() - kept:
        store.remove(part)


def _existing(place: str | PathLike[str], storage_options: dict[str, Any] | None) -> Store:
    store = open_store(place, storage_options)
    if not store.exists():
        raise JobError(store.place, "no such folder of results")
    if store.read(DESCRIPTION) is None and not store.recorded():
        raise JobError(store.place, "holds no results of a cluster job")
    return store


# ---- status ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FolderStatus:
    """How far a folder of results is.

    Attributes
    ----------
    place : str
    partitions, rows : int
        Of the whole source.
    done, rows_done : int
        Those with a record and a part of the right size.
    good : int
        Rows that went well.
    counts : dict of str to int
        How rows ended.
    failures : tuple of dict
        Partitions that were given up, as in ``_failed.json``.
    complete : bool
        There is a manifest.
    leftovers : int
        Temporary files that have not been written to for an hour.

    Examples
    --------
    >>> from agrik_fast import cluster, jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=5)
    >>> _ = cluster.solve("parts", "folder_2", ik.Robot.load("ur5"), workers=1)
    >>> found = cluster.status("folder_2")
    >>> found.rows_done, found.leftovers
    (10, 0)
    """

    place: str
    partitions: int
    rows: int
    done: int
    rows_done: int
    good: int
    counts: dict[str, int]
    failures: tuple[dict[str, Any], ...]
    complete: bool
    leftovers: int


def status(
    place: str | PathLike[str], *, storage_options: dict[str, Any] | None = None
) -> FolderStatus:
    """Return how far a folder of results is; it works while a job runs, and without a scheduler.

    Parameters
    ----------
    place : str or path
        Folder or URL.
    storage_options : dict, optional
        For fsspec.

    Raises
    ------
    JobError
        No such folder, or none with results of a cluster job.

    Examples
    --------
    >>> from agrik_fast import cluster, jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=5)
    >>> _ = cluster.solve("parts", "folder", ik.Robot.load("ur5"), workers=1)
    >>> cluster.status("folder").complete
    True
    """
    store = _existing(place, storage_options)
    described = _description(store) or {}
    source = described.get("source", {})
    counts: Counter[str] = Counter()
    done = rows = 0
    for record in _records(store).values():
        stale = record is None or record.job != described.get("hash", record.job)
        if record is None or stale or store.size(record.part) != record.size:
            continue
        done += 1
        rows += record.rows
        counts.update(record.counts)
    failures: list[dict[str, Any]] = []
    for name in store.notes(FAILED):
        try:
            failures += json.loads(store.read(name) or b"[]")
        except ValueError:
            raise store.refuse(name)("is damaged") from None
    return FolderStatus(
        place=store.place,
        partitions=int(source.get("partitions", done)),
        rows=int(source.get("rows", rows)),
        done=done,
        rows_done=rows,
        good=counts[str(described.get("success", ""))],
        counts=dict(sorted(counts.items())),
        failures=tuple(failures),
        complete=store.read(MANIFEST) is not None,
        leftovers=len(store.leftovers(LEFTOVER_S)),
    )


# ---- verify ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Verified:
    """What `verify` found.

    Attributes
    ----------
    place : str
    parts, bytes : int
        Parts that were read, and their bytes.
    damaged : dict of str to str
        What is wrong, by the name of the file.
    complete : bool
        There was a manifest, and all of it is there.

    Examples
    --------
    >>> from agrik_fast.cluster import Verified
    >>> found = Verified("out", 2, bytes=9000, damaged={"part-000001": "hash"}, complete=False)
    >>> list(found.damaged)
    ['part-000001']
    """

    place: str
    parts: int
    bytes: int
    damaged: dict[str, str]
    complete: bool


def verify(
    place: str | PathLike[str],
    *,
    keep: bool = False,
    storage_options: dict[str, Any] | None = None,
) -> Verified:
    """Read all parts and compare them with the hashes in their records.

    The record of a part that is not as it was written is withdrawn, and with it the manifest, so
    that the next start of the job makes the part anew.

    Parameters
    ----------
    place : str or path
        Folder or URL.
    keep : bool
        Only look: withdraw nothing.
    storage_options : dict, optional
        For fsspec.

    Raises
    ------
    JobError
        No such folder, or a file that cannot be read or removed.

    Examples
    --------
    >>> from agrik_fast import cluster, jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=5)
    >>> _ = cluster.solve("parts", "folder_3", ik.Robot.load("ur5"), workers=1)
    >>> cluster.verify("folder_3").damaged
    {}
    """
    store = _existing(place, storage_options)
    described = _description(store) or {}
    records = _records(store)
    damaged: dict[str, str] = {}
    sizes = 0

    def look(item: tuple[str, Record | None]) -> tuple[str, str, int]:
        name, record = item
        if record is None:
            return store.record_of(name), "the record is damaged", 0
        size = store.size(record.part)
        if size is None:
            return record.part, "is missing", 0
        if size != record.size:
            return record.part, f"has {size} bytes, its record says {record.size}", size
        if store.sha256(record.part) != record.sha256:
            return record.part, "is not what was written (its sha256 differs from its record)", size
        return record.part, "", size

    own = {
        name: record
        for name, record in records.items()
        if record is None or record.job == described.get("hash", record.job)
    }
    with ThreadPoolExecutor(4) as pool:
        for (name, _), (file, wrong, size) in zip(
            own.items(), pool.map(look, own.items()), strict=True
        ):
            sizes += size
            if wrong:
                damaged[file] = wrong
                if not keep:
                    store.remove(store.record_of(name))
    complete = _check_manifest(store, own, damaged)
    if damaged and not keep:
        store.remove(MANIFEST)
    return Verified(store.place, len(own), sizes, damaged, complete and not damaged)


def _check_manifest(
    store: Store, records: dict[str, Record | None], damaged: dict[str, str]
) -> bool:
    data = store.read(MANIFEST)
    if data is None:
        return False
    try:
        listed = {entry["name"]: entry for entry in json.loads(data)["partitions"]}
    except (ValueError, KeyError, TypeError):
        damaged[MANIFEST] = "is damaged"
        return False
    known = {name: record.entry() for name, record in records.items() if record is not None}
    for name, entry in listed.items():
        if name in records and records[name] is None:
            continue
        if json.loads(json.dumps(known.get(name))) != entry:
            what = "has no record" if name not in known else "has another record"
            damaged[MANIFEST] = f"{name} {what}"
            break
    return True


# ---- clean -------------------------------------------------------------------------------------


def clean(
    place: str | PathLike[str],
    *,
    older_s: float = LEFTOVER_S,
    storage_options: dict[str, Any] | None = None,
) -> tuple[str, ...]:
    """Remove what killed processes left behind; returns the names of what was removed.

    Those are temporary files; of uploads that were not finished a store keeps account itself.

    Parameters
    ----------
    place : str or path
        Folder or URL.
    older_s : float
        Only what has not been written to for so many seconds. While a job runs it must be longer
        than a partition takes.
    storage_options : dict, optional
        For fsspec.

    Raises
    ------
    JobError
        No such folder, or one that cannot be written.

    Examples
    --------
    >>> from agrik_fast import cluster, jobs
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = jobs.split_file("points.npy", "parts", rows=5)
    >>> _ = cluster.solve("parts", "folder_5", ik.Robot.load("ur5"), workers=1)
    >>> cluster.clean("folder_5")
    ()
    """
    real_number("older_s", older_s, 0.0)
    store = _existing(place, storage_options)
    names = store.leftovers(older_s)
    for name in names:
        store.remove(name)
    return tuple(names)
