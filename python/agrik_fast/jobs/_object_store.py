"""Results in an object store, through fsspec.

There is no rename in such a store. A part's name holds the hash of its content, so that whoever
writes it again writes the same bytes to the same name; its record, written after it, points there.
"""

from __future__ import annotations

import contextlib
import secrets
import shutil
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from typing import Any, BinaryIO, cast

from .._files import Refusal, reading
from ._job import JobError
from ._store import PART, HashingStream, PartFile, Store

_PARTS = "_parts/"
_RECORDS = "_records/"
_JSON = ".json"
_TRIAL = "_trial-"
_COPY_BYTES = 8 << 20


def file_system(url: str, options: tuple[tuple[str, Any], ...], refuse: Refusal) -> tuple[Any, str]:
    """Return fsspec's file system of a URL, and the path in it."""
    try:
        import fsspec
    except ImportError as error:
        raise refuse("URLs need fsspec: pip install 'agrik-fast[objects]'") from error
    with reading(refuse, "cannot be opened"):
        # Other processes write here too: what was listed before says nothing.
        fs, path = fsspec.core.url_to_fs(url, use_listings_cache=False, **dict(options))
    return fs, str(path)


class _ObjectPart(PartFile):
    """Written to a file of this machine that has no name, and sent when it is complete."""

    def __init__(self, store: ObjectStore, name: str) -> None:
        self._store = store
        self._name = name
        # Closed by whoever commits or discards the part.
        self._file = cast("BinaryIO", tempfile.TemporaryFile())  # noqa: SIM115
        self.stream = HashingStream(self._file)

    def commit(self) -> str:
        key = f"{_PARTS}{self._name}-{self.stream.sha256()[:16]}{PART}"
        try:
            self._file.flush()
            self._file.seek(0)
            self._store.send(key, self._file)
        finally:
            self.discard()
        return key

    def discard(self) -> None:
        # What is left in the buffer may not fit on the disk.
        with contextlib.suppress(OSError, ValueError):
            self._file.close()


@dataclass(frozen=True)
class ObjectStore(Store):
    """A prefix of an object store: parts in ``_parts/``, records in ``_records/``."""

    place: str
    options: tuple[tuple[str, Any], ...] = ()

    def _opened(self) -> tuple[Any, str]:
        return file_system(self.place, self.options, partial(JobError, self.place))

    def _at(self, name: str) -> tuple[Any, str]:
        fs, root = self._opened()
        return fs, f"{root}/{name}"

    def prepare(self) -> None:
        """Write a small object for trial, and remove it."""
        name = _TRIAL + secrets.token_hex(8)
        self.write(name, b"")
        self.remove(name)

    def exists(self) -> bool:
        """Return whether there is anything."""
        fs, path = self._at("")
        with reading(self.refuse(), "cannot be read"):
            return bool(fs.exists(path.rstrip("/")))

    def read(self, name: str) -> bytes | None:
        """Return an object's content; None if there is none."""
        fs, path = self._at(name)
        with reading(self.refuse(name), "cannot be read"):
            try:
                return bytes(fs.cat_file(path))
            except FileNotFoundError:
                return None

    def write(self, name: str, data: bytes) -> None:
        """Put a small object."""
        fs, path = self._at(name)
        with reading(self.refuse(name), "cannot be written"):
            fs.pipe_file(path, data)

    def send(self, name: str, stream: BinaryIO) -> None:
        """Put an object, in pieces that become visible all at once."""
        fs, path = self._at(name)
        with reading(self.refuse(name), "cannot be written"):
            # Not as a context: leaving it on an error would make half an object visible.
            target = fs.open(path, "wb", autocommit=False)
            try:
                shutil.copyfileobj(stream, target, _COPY_BYTES)
                target.close()
            except BaseException:
                with contextlib.suppress(Exception):
                    target.discard()
                raise
            target.commit()

    def remove(self, name: str) -> None:
        """Remove an object."""
        fs, path = self._at(name)
        with (
            reading(self.refuse(name), "cannot be removed"),
            contextlib.suppress(FileNotFoundError),
        ):
            fs.rm_file(path)

    def size(self, name: str) -> int | None:
        """Return an object's size; None if there is none."""
        fs, path = self._at(name)
        with reading(self.refuse(name), "cannot be read"):
            try:
                return int(fs.info(path)["size"])
            except FileNotFoundError:
                return None

    def open(self, name: str) -> BinaryIO:
        """Open an object."""
        fs, path = self._at(name)
        return cast("BinaryIO", fs.open(path, "rb"))

    def new_part(self, name: str) -> PartFile:
        """Start a part."""
        try:
            return _ObjectPart(self, name)
        except OSError as error:
            raise JobError(tempfile.gettempdir(), f"cannot be written: {error}") from error

    def record_of(self, name: str) -> str:
        """Return ``_records/NAME.json``."""
        return f"{_RECORDS}{name}{_JSON}"

    def recorded(self) -> set[str]:
        """Return names of partitions with a record."""
        return {name.removesuffix(_JSON) for name in self._listed(_RECORDS)}

    def parts(self) -> set[str]:
        """Return names of parts."""
        return {_PARTS + name for name in self._listed(_PARTS)}

    def _listed(self, prefix: str) -> list[str]:
        fs, root = self._at(prefix)
        with reading(self.refuse(prefix), "cannot be listed"):
            try:
                return [str(path)[len(root) :] for path in fs.find(root.rstrip("/"))]
            except FileNotFoundError:
                return []

    def notes(self, prefix: str) -> list[str]:
        """Return names of objects at the top."""
        return sorted(name for name in self._top() if name.startswith(prefix))

    def leftovers(self, older_s: float, name: str = "", process: int | None = None) -> list[str]:
        """Return names of trials; a store does not show uploads that were not finished."""
        if name:
            return []
        before = time.time() - older_s
        found = []
        for each, entry in self._top().items():
            written = entry.get("LastModified") or entry.get("created")
            if each.startswith(_TRIAL) and (written is None or written.timestamp() <= before):
                found.append(each)
        return sorted(found)

    def _top(self) -> dict[str, Any]:
        fs, root = self._at("")
        with reading(self.refuse(), "cannot be listed"):
            try:
                listed = fs.find(root.rstrip("/"), maxdepth=1, detail=True)
            except FileNotFoundError:
                return {}
            return {str(path)[len(root) :]: entry for path, entry in listed.items()}
