"""A file that appears under its name only when it is complete: the writer of every file here."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
from pathlib import Path
from typing import BinaryIO

from ._files import Refusal, os_reason

# Letters of the name that the temporary file's begins with: a name may have 255 bytes.
_STEM = 40


def temporary_prefix(name: str, process: int | None) -> str:
    """Return what the names of temporary files begin with: of a file, by a process or any."""
    return f".{name[:_STEM]}." + ("" if process is None else f"{process}-")


class AtomicFile:
    """A new file beside its destination, moved there by `commit`.

    The temporary file is in the destination's own folder, because a rename is atomic only
    within one file system, and has a name that no other run chooses.

    Parameters
    ----------
    path : path
        The destination; a symbolic link is followed.
    refuse : callable
        Makes the file's error from what is wrong.
    force : bool
        Replace an existing file, which lends its permissions.

    Raises
    ------
    AgrikError
        By `refuse`: the file exists and `force` is False, is read-only or no regular file, or
        the folder cannot be written.
    """

    stream: BinaryIO

    def __init__(self, path: Path, refuse: Refusal, *, force: bool) -> None:
        self._refuse = refuse
        self._force = force
        self._target = Path(os.path.realpath(path))
        try:
            mode = self._replaced_mode()
            begin = temporary_prefix(self._target.name, os.getpid())
            self.temporary = self._target.with_name(f"{begin}{secrets.token_hex(4)}.partial")
            flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
            self.stream = os.fdopen(os.open(self.temporary, flags, 0o666), "w+b")
            if mode is not None:
                with contextlib.suppress(OSError):
                    self.temporary.chmod(mode)
        except OSError as error:
            raise refuse(f"cannot be written: {os_reason(error)}") from error

    def _replaced_mode(self) -> int | None:
        """Return the permissions of the file that is to be replaced; None if there is none."""
        try:
            mode = self._target.stat().st_mode
        except FileNotFoundError:
            return None
        if stat.S_ISDIR(mode):
            raise self._refuse("is a folder, expected a file name")
        if not stat.S_ISREG(mode):
            raise self._refuse("is no regular file")
        if not self._force:
            raise self._exists()
        # The administrator may write everything; a read-only file is meant to stay all the same.
        if not mode & 0o222 or not os.access(self._target, os.W_OK):
            raise self._refuse("cannot be written: the file is read-only")
        return stat.S_IMODE(mode)

    def _exists(self) -> Exception:
        return self._refuse("exists already (use --force to replace it)")

    def commit(self) -> None:
        """Flush to the disk and move the file to its name.

        Raises
        ------
        AgrikError
            By `refuse`: another program made the destination meanwhile, or the disk refuses.
        """
        try:
            self.stream.flush()
            os.fsync(self.stream.fileno())
            self.stream.close()
            self._move()
        except OSError as error:
            self.discard()
            raise self._refuse(f"cannot be written: {os_reason(error)}") from error
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
        # What is left in the buffer may not fit on the disk.
        with contextlib.suppress(OSError, ValueError):
            self.stream.close()
        with contextlib.suppress(OSError):
            self.temporary.unlink()


def write_bytes(path: Path, data: bytes, refuse: Refusal, *, force: bool) -> None:
    """Write a file that appears when it is complete.

    Raises
    ------
    AgrikError
        By `refuse`; the destination is then as it was.
    """
    file = AtomicFile(path, refuse, force=force)
    try:
        file.stream.write(data)
    except BaseException as error:
        file.discard()
        if isinstance(error, OSError):
            raise refuse(f"cannot be written: {os_reason(error)}") from error
        raise
    file.commit()
