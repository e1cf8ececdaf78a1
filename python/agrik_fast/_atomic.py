"""A file that appears under its name only when it is complete."""

from __future__ import annotations

import contextlib
import os
import secrets
from pathlib import Path
from typing import BinaryIO

from ._errors import ResultFileError, os_reason


class AtomicFile:
    """A new file beside its destination, moved there by `commit`.

    The temporary file is in the destination's own folder, because a rename is atomic only
    within one file system.

    Parameters
    ----------
    path : Path
        The destination; a symbolic link is followed.
    force : bool
        Replace an existing file.

    Raises
    ------
    ResultFileError
        If the file exists and `force` is False, or the folder cannot be written.
    """

    stream: BinaryIO

    def __init__(self, path: Path, *, force: bool) -> None:
        self.path = path
        self._force = force
        self._target = Path(os.path.realpath(path))
        if self._target.is_dir():
            raise ResultFileError(path, "is a folder, expected a file name")
        if self._target.exists():
            if not force:
                raise self._exists()
            if not os.access(self._target, os.W_OK):
                raise ResultFileError(path, "cannot be written: the file is read-only")
        # A hidden name of its own: two runs with one destination do not meet.
        name = f".{self._target.name}.{os.getpid()}-{secrets.token_hex(4)}.partial"
        self.temporary = self._target.with_name(name)
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        try:
            self.stream = os.fdopen(os.open(self.temporary, flags, 0o666), "w+b")
        except OSError as error:
            raise ResultFileError(path, f"cannot be written: {os_reason(error)}") from error

    def _exists(self) -> ResultFileError:
        return ResultFileError(self.path, "exists already (use --force to replace it)")

    def commit(self) -> None:
        """Flush to the disk and move the file to its name.

        Raises
        ------
        ResultFileError
            If another program made the destination meanwhile, or the disk refuses.
        """
        try:
            self.stream.flush()
            os.fsync(self.stream.fileno())
            self.stream.close()
            self._move()
        except OSError as error:
            self.discard()
            raise ResultFileError(self.path, f"cannot be written: {os_reason(error)}") from error
        except BaseException:
            self.discard()
            raise
        self._sync_folder()

    def _move(self) -> None:
        if self._force:
            self.temporary.replace(self._target)
            return
        try:
            # Unlike a rename, a hard link never replaces a file made since the start.
            os.link(self.temporary, self._target)
        except FileExistsError:
            raise self._exists() from None
        except OSError:
            if self._target.exists():
                raise self._exists() from None
            self.temporary.replace(self._target)
        else:
            self.temporary.unlink()

    def _sync_folder(self) -> None:
        # The file is complete; only the folder entry's way to the disk is left, and
        # not every system lets a folder be opened.
        with contextlib.suppress(OSError):
            folder = os.open(self._target.parent, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)

    def discard(self) -> None:
        """Remove the temporary file; the destination stays as it was."""
        with contextlib.suppress(OSError):
            self.stream.close()
        with contextlib.suppress(OSError):
            self.temporary.unlink()
