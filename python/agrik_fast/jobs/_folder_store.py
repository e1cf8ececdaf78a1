"""Results in a folder: files that appear by renames."""

from __future__ import annotations

import contextlib
import os
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from .._atomic import AtomicFile, temporary_prefix, write_bytes
from .._files import os_reason
from ._job import JobError
from ._store import PART, HashingStream, PartFile, Store

RECORD = ".parquet.json"
_TEMPORARY = re.compile(r"^\..*\.\d+-[0-9a-f]{8}\.partial$")


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
