"""What every store of results offers."""

from __future__ import annotations

import abc
import hashlib
from functools import partial
from typing import Any, BinaryIO

from .._files import reading
from ._job import JobError

PART = ".parquet"
_READ_BYTES = 1 << 20


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
