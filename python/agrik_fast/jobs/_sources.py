"""Where the rows of a job come from, and how they are cut into partitions."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from os import PathLike, fspath
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from .._checks import whole_number
from .._files import listing, os_reason, reading
from ..io import check_parquet_sizes, import_pyarrow, open_parquet
from ._job import Job, JobError
from ._places import is_url

PARTITION_ROWS = 1_000_000
"""Rows of a partition, where the source leaves a choice."""
MANIFEST = "_manifest.json"
_SUFFIX = ".parquet"
_READERS = 16
# What stores call that which changes with the content.
_TAGS = ("ETag", "etag", "LastModified", "created")
# More files than this in one folder are slow to list.
FOLDER_FILES = 1_000


class Rows(Protocol):
    """Reads the rows of one partition; small, and can be pickled."""

    def batches(self, columns: tuple[str, ...], size: int) -> Iterator[Any]:
        """Yield `pyarrow.RecordBatch` of at most `size` rows, in order."""


@dataclass(frozen=True)
class Partition:
    """Some consecutive rows of a source, the unit of work.

    Attributes
    ----------
    number : int
        From 0, in the order of rows.
    name : str
        What its results are called, without suffix.
    first, rows : int
        Index of its first row within the source, and how many.
    origin : mapping
        What tells its input from another; kept in its record.
    data : Rows

    Examples
    --------
    >>> from agrik_fast.jobs import FileSource, split_file
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = split_file("points.npy", "parts", rows=4)
    >>> one = FileSource("parts", partition_rows=4).partition(0)
    >>> one.number, one.rows
    (0, 4)
    """

    number: int
    name: str
    first: int
    rows: int
    origin: Mapping[str, Any]
    data: Rows


class Source(Protocol):
    """All rows of a job.

    Attributes
    ----------
    place : str
        Path or URL.
    schema : pyarrow.Schema
        Its columns: those that all of its files have.
    count, rows : int
        Number of partitions, and of rows.

    Examples
    --------
    >>> from agrik_fast.jobs import FileSource, split_file
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = split_file("points.npy", "parts", rows=4)
    >>> FileSource("parts").place
    'parts'
    """

    @property
    def place(self) -> str: ...
    @property
    def schema(self) -> Any: ...
    @property
    def count(self) -> int: ...
    @property
    def rows(self) -> int: ...

    def partition(self, number: int) -> Partition:
        """Return a partition by its number.

        Examples
        --------
        >>> from agrik_fast.jobs import FileSource, split_file
        >>> np.save("points.npy", np.full((10, 3), 0.3))
        >>> _ = split_file("points.npy", "parts", rows=4)
        >>> FileSource("parts", partition_rows=4).partition(1).first
        4
        """

    def summary(self) -> dict[str, Any]:
        """Return what tells the source from another that gives other partitions.

        Examples
        --------
        >>> from agrik_fast.jobs import FileSource, split_file
        >>> np.save("points.npy", np.full((10, 3), 0.3))
        >>> _ = split_file("points.npy", "parts", rows=4)
        >>> sorted(FileSource("parts").summary())
        ['names', 'partitions', 'rows']
        """

    def check(self, job: Job) -> tuple[str, ...]:
        """Return the columns that a job reads, or raise if some partition has others.

        Examples
        --------
        >>> from agrik_fast.jobs import FileSource, SolveJob, split_file
        >>> np.save("points.npy", np.full((10, 3), 0.3))
        >>> _ = split_file("points.npy", "parts", rows=4)
        >>> FileSource("parts").check(SolveJob(ik.Robot.load("ur5")))
        ('x_m', 'y_m', 'z_m', 'id')
        """


class _Footer(NamedTuple):
    schema: Any
    rows: tuple[int, ...]
    """Of each row group."""
    origin: dict[str, Any]


@dataclass(frozen=True)
class FileRows:
    """Consecutive row groups of a Parquet file."""

    place: str
    options: tuple[tuple[str, Any], ...]
    groups: tuple[int, int]

    def batches(self, columns: tuple[str, ...], size: int) -> Iterator[Any]:
        """Yield the rows."""
        refuse = partial(JobError, self.place)
        with _opened(self.place, self.options) as (file, _):
            groups = list(range(*self.groups))
            with reading(refuse, "is damaged"):
                batches = file.iter_batches(
                    size, row_groups=groups, columns=list(columns), use_threads=False
                )
            while True:
                with reading(refuse, "is damaged"):
                    batch = next(batches, None)
                if batch is None:
                    return
                yield batch


class FileSource:
    """Parquet files of one or several folders, each cut into runs of its row groups.

    Parameters
    ----------
    place : str or path
        A Parquet file, a folder of them (taken in the order of their names, those in folders
        inside too), or a folder of results of another job; path or URL.
    partition_rows : int
        A file with more rows is cut between row groups into pieces of at most so many rows, if
        its row groups are not larger.
    storage_options : mapping, optional
        For fsspec.

    Raises
    ------
    JobError
        No such place, no Parquet file in it, or a damaged one.

    Examples
    --------
    >>> from agrik_fast.jobs import FileSource, split_file
    >>> np.save("points.npy", np.full((10, 3), 0.3))
    >>> _ = split_file("points.npy", "parts", rows=4)
    >>> source = FileSource("parts", partition_rows=4)
    >>> source.count, source.rows
    (3, 10)
    """

    def __init__(
        self,
        place: str | PathLike[str],
        partition_rows: int = PARTITION_ROWS,
        storage_options: Mapping[str, Any] | None = None,
    ) -> None:
        self.place = fspath(place).removeprefix("file://")
        self._options = tuple(sorted((storage_options or {}).items()))
        self._limit = whole_number("partition_rows", partition_rows, 1)
        self._names = _listed(self.place, self._options)
        with ThreadPoolExecutor(_READERS) as pool:
            self._footers = list(pool.map(self._footer, self._names))
        self._pieces: list[tuple[int, int, int, int, int]] = []
        """File, first and end of row groups, first row, rows."""
        self.rows = 0
        for k, footer in enumerate(self._footers):
            for begin, end in _runs(footer.rows, self._limit):
                rows = sum(footer.rows[begin:end])
                if rows:
                    self._pieces.append((k, begin, end, self.rows, rows))
                    self.rows += rows
        if not self._pieces:
            raise JobError(self.place, "no rows in any file")
        self.count = len(self._pieces)
        self.schema = _shared([footer.schema for footer in self._footers])
        taken: dict[str, int] = {}
        for number in range(self.count):
            name = self._name(number)
            other = taken.setdefault(name, self._pieces[number][0])
            if other != self._pieces[number][0]:
                both = f"{self._names[other]} and {self._names[self._pieces[number][0]]}"
                raise JobError(self.place, f"{both} would both give {name}.parquet")

    def _path(self, name: str) -> str:
        return f"{self.place.rstrip('/')}/{name}" if name else self.place

    def _footer(self, name: str) -> _Footer:
        path = self._path(name)
        with _opened(path, self._options) as (file, origin):
            with reading(partial(JobError, path), "is not a Parquet file"):
                groups = [file.metadata.row_group(k) for k in range(file.metadata.num_row_groups)]
                rows = tuple(int(group.num_rows) for group in groups)
            check_parquet_sizes(file, origin["bytes"], partial(JobError, path))
            return _Footer(file.schema_arrow, rows, {"name": name or Path(path).name, **origin})

    def _name(self, number: int) -> str:
        k, begin, end, _, _ = self._pieces[number]
        stem = self._footers[k].origin["name"].removesuffix(_SUFFIX).replace("_parts/", "")
        groups = len(self._footers[k].rows)
        if (begin, end) == (0, groups):
            return str(stem)
        middle = f"{begin // FOLDER_FILES:03d}/" if groups > FOLDER_FILES else ""
        return f"{stem}/{middle}{begin:06d}"

    def partition(self, number: int) -> Partition:
        """Return a partition by its number."""
        k, begin, end, first, rows = self._pieces[number]
        origin = {**self._footers[k].origin, "row_groups": [begin, end]}
        data = FileRows(self._path(self._names[k]), self._options, (begin, end))
        return Partition(number, self._name(number), first, rows, origin, data)

    def summary(self) -> dict[str, Any]:
        """Return how many partitions and rows there are, and a hash of their names."""
        digest = hashlib.sha256()
        for number in range(self.count):
            digest.update(self._name(number).encode() + b"\n")
        return {"partitions": self.count, "rows": self.rows, "names": digest.hexdigest()}

    def check(self, job: Job) -> tuple[str, ...]:
        """Return the columns that a job reads; every file must have the same."""
        known: list[tuple[Any, tuple[str, ...]]] = []
        first: tuple[tuple[str, ...], list[str]] | None = None
        for name, footer in zip(self._names, self._footers, strict=True):
            place = self._path(name)
            refuse = partial(JobError, place)
            bare = footer.schema.remove_metadata()
            columns = next((columns for schema, columns in known if schema.equals(bare)), None)
            if columns is None:
                columns = self._columns(job, footer.schema, refuse, first)
                known.append((bare, columns))
            kinds = [str(bare.field(column).type) for column in columns]
            if first is None:
                first = columns, kinds
            elif first != (columns, kinds):
                raise refuse(f"{_words(columns, kinds)}; the files before have {_words(*first)}")
        assert first is not None
        return first[0]

    def _columns(
        self, job: Job, schema: Any, refuse: Any, first: tuple[tuple[str, ...], list[str]] | None
    ) -> tuple[str, ...]:
        try:
            return job.columns(schema, refuse)
        except JobError as error:
            if first is None:
                raise
            raise refuse(f"{error.reason}; the files before have {_words(*first)}") from None


def _refuse(reason: str) -> JobError:
    return JobError("source", reason)


def _shared(schemas: list[Any]) -> Any:
    """Return the columns of the first schema that all of them have with the same type."""
    first = schemas[0]
    different = {id(schema): schema for schema in schemas[1:] if not schema.equals(first)}
    shared = [
        field
        for field in first
        if all(
            field.name in schema.names and schema.field(field.name).type == field.type
            for schema in different.values()
        )
    ]
    return import_pyarrow(_refuse).schema(shared, metadata=first.metadata)


def _words(columns: tuple[str, ...], kinds: list[str]) -> str:
    return "columns " + listing(
        f"{name} ({kind})" for name, kind in zip(columns, kinds, strict=True)
    )


def _runs(rows: tuple[int, ...], limit: int) -> Iterator[tuple[int, int]]:
    """Yield runs of row groups of at most `limit` rows, or of one row group."""
    begin, held = 0, 0
    for k, count in enumerate(rows):
        if k > begin and held + count > limit:
            yield begin, k
            begin, held = k, 0
        held += count
    if rows:
        yield begin, len(rows)


@contextlib.contextmanager
def _opened(
    place: str, options: tuple[tuple[str, Any], ...]
) -> Iterator[tuple[Any, dict[str, Any]]]:
    """Open a Parquet file of a path or a URL; gives what tells it from another, too."""
    refuse = partial(JobError, place)
    if not is_url(place):
        try:
            entry = Path(place).stat()
        except OSError as error:
            raise refuse(f"cannot be read: {os_reason(error)}") from error
        origin = {"bytes": entry.st_size, "modified_ns": entry.st_mtime_ns}
        with contextlib.closing(open_parquet(Path(place), refuse)) as file:
            yield file, origin
        return
    from ._object_store import file_system

    fs, path = file_system(place, options, refuse)
    with reading(refuse, "cannot be read"):
        entry = fs.info(path)
        stream = fs.open(path, "rb")
    origin = {"bytes": int(entry["size"])}
    tag = (
        entry.get("ETag") or entry.get("etag") or entry.get("LastModified") or entry.get("created")
    )
    with stream, contextlib.closing(open_parquet(stream, refuse)) as file:
        yield file, {**origin, "tag": str(tag).strip('"')}


def _listed(place: str, options: tuple[tuple[str, Any], ...]) -> list[str]:
    """Return the names of the files of a source, below its place; one that is empty for a file."""
    refuse = partial(JobError, place)
    if is_url(place):
        from ._object_store import file_system

        fs, root = file_system(place.rstrip("/"), options, refuse)
        with reading(refuse, "cannot be listed"):
            if place.endswith(_SUFFIX) and fs.isfile(root):
                return [""]
            found = [str(path)[len(root) + 1 :] for path in fs.find(root)]
            text = fs.cat_file(f"{root}/{MANIFEST}") if MANIFEST in found else None
    else:
        path = Path(place)
        if path.is_file():
            return [""]
        if not path.is_dir():
            raise refuse("no such file or folder")
        with reading(refuse, "cannot be listed"):
            found = [each.relative_to(path).as_posix() for each in path.rglob("*")]
            text = (path / MANIFEST).read_bytes() if MANIFEST in found else None
    if text is not None:
        with reading(refuse, f"{MANIFEST} is damaged"):
            return [str(entry["part"]) for entry in json.loads(text)["partitions"]]
    names = [
        name
        for name in found
        if name.endswith(_SUFFIX) and not any(part[:1] in "._" for part in name.split("/"))
    ]
    if not names:
        others = sorted(name for name in found if not name.startswith((".", "_")))
        hint = f"; found {listing(others)}" if others else ""
        split = ": cut other kinds with `agrik-fast cluster split` first" if others else ""
        raise refuse(f"no .parquet file in it{hint}{split}")
    return sorted(names)
