"""Where results are: a folder. What every store offers, and which one a name means."""

from __future__ import annotations

import abc
import contextlib
import hashlib
import os
import re
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from os import PathLike, fspath
from pathlib import Path
from typing import Any, BinaryIO

from .._atomic import AtomicFile, temporary_prefix, write_bytes
from .._files import os_reason, reading
from ._job import JobError

PART = ".parquet"
RECORD = ".parquet.json"
_READ_BYTES = 1 << 20
_TEMPORARY = re.compile(r"^\..*\.\d+-[0-9a-f]{8}\.partial$")


class HashingStream:
    """A stream to write to, which counts and hashes what goes through it."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._digest = hashlib.sha256()
        self.bytes = 0
        self.closed = False

    def write(self, data: Any) -> int:
        """Write, all of it."""
        view = memoryview(data)
        self._digest.update(view)
        self._stream.write(view)
        self.bytes += view.nbytes
        return view.nbytes

    def tell(self) -> int:
        """Return how many bytes were written."""
        return self.bytes

    def flush(self) -> None:
        """Pass on what is buffered."""
        self._stream.flush()

    def sha256(self) -> str:
        """Return the hash of all that was written, in hex digits."""
        return self._digest.hexdigest()


class PartFile(abc.ABC):
    """A part on its way into a store: nobody sees it before `commit`."""

    stream: HashingStream

    @abc.abstractmethod
    def commit(self) -> str:
        """Put the part in place; returns the name that it has in the store."""

    @abc.abstractmethod
    def discard(self) -> None:
        """Give up and leave nothing."""


class Store(abc.ABC):
    """A place for parts, their records and what is known of all of them.

    Whatever is written appears complete or not at all. A store can be pickled and is used by many
    processes at a time.

    Attributes
    ----------
    place : str
        Path or URL.
    """

    place: str

    @abc.abstractmethod
    def prepare(self) -> None:
        """Make the place if it is not there, and try whether it can be written.

        Raises
        ------
        JobError
            It cannot.
        """

    @abc.abstractmethod
    def exists(self) -> bool:
        """Return whether the place is there."""

    @abc.abstractmethod
    def read(self, name: str) -> bytes | None:
        """Return a small file's content; None if there is none of that name."""

    @abc.abstractmethod
    def write(self, name: str, data: bytes) -> None:
        """Write a small file, replacing it if it is there."""

    @abc.abstractmethod
    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""

    @abc.abstractmethod
    def size(self, name: str) -> int | None:
        """Return a file's size in bytes; None if there is no such file."""

    @abc.abstractmethod
    def open(self, name: str) -> BinaryIO:
        """Open a file to be read."""

    @abc.abstractmethod
    def new_part(self, name: str) -> PartFile:
        """Start the part of a partition."""

    @abc.abstractmethod
    def record_of(self, name: str) -> str:
        """Return the file's name of a partition's record."""

    @abc.abstractmethod
    def recorded(self) -> set[str]:
        """Return the names of the partitions that have a record."""

    @abc.abstractmethod
    def parts(self) -> set[str]:
        """Return the names of all files with parts, recorded or not."""

    @abc.abstractmethod
    def notes(self, prefix: str) -> list[str]:
        """Return names of small files of the whole that begin so, sorted."""

    @abc.abstractmethod
    def leftovers(self, older_s: float, name: str = "", process: int | None = None) -> list[str]:
        """Return names of temporary files that have not been written to for so long.

        Parameters
        ----------
        older_s : float
        name : str
            Only those of this partition, if one is named.
        process : int, optional
            Only those of this process of this machine.
        """

    def sha256(self, name: str) -> str:
        """Return the hash of a file's content."""
        digest = hashlib.sha256()
        with reading(self.refuse(name), "cannot be read"), self.open(name) as stream:
            while piece := stream.read(_READ_BYTES):
                digest.update(piece)
        return digest.hexdigest()

    def refuse(self, name: str = "") -> Any:
        """Return what makes errors of a file in here."""
        return partial(JobError, f"{self.place.rstrip('/')}/{name}" if name else self.place)


class _FolderPart(PartFile):
    def __init__(self, path: Path, name: str) -> None:
        self._name = name
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = AtomicFile(path, partial(JobError, str(path)), force=True)
        self.stream = HashingStream(self._file.stream)

    def commit(self) -> str:
        self._file.commit()
        return self._name

    def discard(self) -> None:
        self._file.discard()


@dataclass(frozen=True)
class FolderStore(Store):
    """A folder: parts ``NAME.parquet``, each with its record ``NAME.parquet.json`` beside it."""

    place: str

    @property
    def _folder(self) -> Path:
        return Path(self.place)

    def prepare(self) -> None:
        """Make the folder and write a file into it for trial."""
        refuse = self.refuse()
        with self._writing(refuse):
            if self._folder.exists() and not self._folder.is_dir():
                raise refuse("is a file, expected a folder")
            self._folder.mkdir(parents=True, exist_ok=True)
        trial = AtomicFile(self._folder / "_trial", refuse, force=True)
        trial.discard()

    def exists(self) -> bool:
        """Return whether the folder is there."""
        return self._folder.is_dir()

    def read(self, name: str) -> bytes | None:
        """Return a file's content; None if there is none."""
        try:
            return (self._folder / name).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self.refuse(name)(f"cannot be read: {os_reason(error)}") from error

    def write(self, name: str, data: bytes) -> None:
        """Write a file by a rename."""
        path = self._folder / name
        with self._writing(self.refuse(name)):
            path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, data, self.refuse(name), force=True)

    def remove(self, name: str) -> None:
        """Remove a file."""
        try:
            (self._folder / name).unlink(missing_ok=True)
        except OSError as error:
            raise self.refuse(name)(f"cannot be removed: {os_reason(error)}") from error

    def size(self, name: str) -> int | None:
        """Return a file's size; None if there is none."""
        try:
            return (self._folder / name).stat().st_size
        except OSError:
            return None

    def open(self, name: str) -> BinaryIO:
        """Open a file."""
        return (self._folder / name).open("rb")

    def new_part(self, name: str) -> PartFile:
        """Start ``NAME.parquet``."""
        with self._writing(self.refuse(name + PART)):
            return _FolderPart(self._folder / (name + PART), name + PART)

    def record_of(self, name: str) -> str:
        """Return ``NAME.parquet.json``."""
        return name + RECORD

    def recorded(self) -> set[str]:
        """Return names of partitions with a record."""
        return {name.removesuffix(RECORD) for name in self._files() if name.endswith(RECORD)}

    def parts(self) -> set[str]:
        """Return names of parts."""
        return {name for name in self._files() if name.endswith(PART)}

    def _files(self) -> Iterator[str]:
        for folder, _, names in os.walk(self._folder):
            inner = Path(folder).relative_to(self._folder)
            for name in names:
                if not name.startswith((".", "_")):
                    yield (inner / name).as_posix()

    def notes(self, prefix: str) -> list[str]:
        """Return names of files at the top."""
        return sorted(path.name for path in self._folder.glob(f"{prefix}*"))

    def leftovers(self, older_s: float, name: str = "", process: int | None = None) -> list[str]:
        """Return names of temporary files."""
        found = []
        before = time.time() - older_s
        where = (self._folder / name).parent if name else self._folder
        begin = temporary_prefix(Path(name).name + PART, process) if name else ""
        for folder, _, names in os.walk(where):
            for each in names:
                if not (_TEMPORARY.match(each) and each.startswith(begin)):
                    continue
                path = Path(folder) / each
                # Another process may have ended its work meanwhile.
                with contextlib.suppress(OSError):
                    if path.stat().st_mtime <= before:
                        found.append(path.relative_to(self._folder).as_posix())
        return sorted(found)

    @contextlib.contextmanager
    def _writing(self, refuse: Any) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise refuse(f"cannot be written: {os_reason(error)}") from error


def is_url(place: str) -> bool:
    """Return whether a place is no path of the file system."""
    return "://" in place


def open_store(
    place: str | PathLike[str], storage_options: Mapping[str, Any] | None = None
) -> Store:
    """Return the store at a path or a URL.

    Parameters
    ----------
    place : str or path
        A folder, or a URL that fsspec knows (``s3://bucket/results``; extra `objects`).
    storage_options : mapping, optional
        What fsspec's file system is made with: endpoint, keys.

    Raises
    ------
    JobError
        fsspec, or what it needs for the URL, is missing.
    """
    text = fspath(place)
    if text.startswith("file://"):
        text = text.removeprefix("file://")
    if not is_url(text):
        return FolderStore(text)
    from ._object_store import ObjectStore

    return ObjectStore(text.rstrip("/"), tuple(sorted((storage_options or {}).items())))
