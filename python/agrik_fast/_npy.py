"""Arrays in NumPy's form, single (NPY) or in an archive (NPZ), read without belief in them.

A header is held against the bytes that are there before anything is made of it, and rows are
read in order from a stream, so that memory is bounded by what is asked for.

References
----------
NumPy enhancement proposal 1, "A simple file format for NumPy arrays".
"""

from __future__ import annotations

import ast
import contextlib
import math
import os
import re
import struct
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Self

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from ._files import Refusal, reading, shown

_MAGIC = b"\x93NUMPY"
# By version: how the header's length is written, and its text.
_FORMS = {1: ("<H", "latin1"), 2: ("<I", "latin1"), 3: ("<I", "utf-8")}
_HEADER_BYTES = 1 << 16
_AXES = 8
# What is refused of an archive: more than so many bytes in so little. Grids of points, the
# most regular targets, shrink to a hundredth.
BOMB_BYTES = 64 << 20
BOMB_RATIO = 500
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENCRYPTED = 1


@dataclass(frozen=True)
class Header:
    """What an array's header says.

    Attributes
    ----------
    shape : tuple of int
    fortran : bool
        True if the first index runs fastest.
    dtype : numpy.dtype
    size : int
        Bytes before the array's own.
    """

    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype[Any]
    size: int

    @property
    def rows(self) -> int:
        """Length of the first axis; 1 for a single number."""
        return self.shape[0] if self.shape else 1

    @property
    def row_bytes(self) -> int:
        """Bytes of a row."""
        return math.prod(self.shape[1:]) * self.dtype.itemsize

    @property
    def kind(self) -> str:
        """The type in words."""
        text = str(self.dtype)
        return text if len(text) < 40 else shown(text)


def read_header(stream: IO[bytes], total: int) -> Header:
    """Read an array's header.

    Parameters
    ----------
    stream : binary stream
    total : int
        Bytes of the whole.

    Raises
    ------
    ValueError
        There is none, it is damaged, or it claims other bytes than there are. Damaged ones
        raise other exceptions too.
    """
    start = _exactly(stream, len(_MAGIC) + 2)
    if not start.startswith(_MAGIC):
        raise ValueError("no NPY header")
    if start[6] not in _FORMS or start[7] != 0:
        raise ValueError(f"version {start[6]}.{start[7]} of the form, expected 1.0, 2.0 or 3.0")
    form, encoding = _FORMS[start[6]]
    (length,) = struct.unpack(form, _exactly(stream, struct.calcsize(form)))
    if length > _HEADER_BYTES:
        raise ValueError(f"a header of {length} bytes, expected at most {_HEADER_BYTES}")
    text = _exactly(stream, length).decode(encoding)
    # Python 2 wrote long integers as 3L.
    fields = ast.literal_eval(re.sub(r"(?<=\d)L\b", "", text).strip())
    if not isinstance(fields, dict) or set(fields) != {"descr", "fortran_order", "shape"}:
        raise ValueError("a header without descr, fortran_order and shape alone")
    shape, fortran = fields["shape"], fields["fortran_order"]
    if not (
        isinstance(shape, tuple)
        and len(shape) <= _AXES
        and all(type(axis) is int and axis >= 0 for axis in shape)
        and isinstance(fortran, bool)
    ):
        raise ValueError(f"shape {shown(shape)} with order {shown(fortran)}")
    dtype = npy_format.descr_to_dtype(fields["descr"])
    if dtype.hasobject:
        raise ValueError("Python objects, expected numbers or text")
    header = Header(shape, fortran, dtype, len(start) + struct.calcsize(form) + length)
    claimed = header.size + math.prod(shape) * dtype.itemsize
    if claimed > total:
        raise ValueError(f"shape {shown(shape)} needs {claimed} bytes, there are {total}")
    return header


def header_bytes(dtype: np.dtype[Any], rows: int) -> bytes:
    """Return the header of an array of records, of one length for any number of rows."""
    fields = {"descr": npy_format.dtype_to_descr(dtype), "fortran_order": False}
    text = f"{repr(fields)[:-1]}, 'shape': ({rows},), }}"
    encoded = text.encode("utf-8")
    version, form = (2, "<I") if text.isascii() else (3, "<I")
    used = len(_MAGIC) + 2 + struct.calcsize(form) + len(encoded) - len(str(rows))
    # Room for the largest count, and the array's own bytes at a multiple of 64.
    padding = 20 + -(used + 20 + 1) % 64 - len(str(rows))
    encoded += b" " * padding + b"\n"
    return _MAGIC + bytes((version, 0)) + struct.pack(form, len(encoded)) + encoded


def _exactly(stream: IO[bytes], count: int) -> bytes:
    data = stream.read(count)
    if len(data) < count:
        raise ValueError("ends early")
    return data


class Rows:
    """The rows of an array, in order.

    Parameters
    ----------
    open_stream : callable
        Returns a stream of the whole, from its first byte.
    header : Header
    """

    def __init__(self, open_stream: Callable[[], IO[bytes]], header: Header) -> None:
        self._header = header
        self._inner = header.shape[1:]
        # An array whose first index runs fastest has its columns one after the other: each
        # is a stream of its own.
        columns = math.prod(self._inner) if header.fortran else 1
        step = header.rows * header.dtype.itemsize
        self._streams: list[IO[bytes]] = []
        try:
            for k in range(columns):
                stream = open_stream()
                self._streams.append(stream)
                stream.seek(header.size + k * step)
        except BaseException:
            self.close()
            raise

    def take(self, count: int) -> NDArray[Any]:
        """Return the next rows, in the machine's order of bytes."""
        dtype = self._header.dtype
        if not self._header.fortran:
            data = _exactly(self._streams[0], count * self._header.row_bytes)
            rows = np.frombuffer(data, dtype).reshape(count, *self._inner)
        else:
            rows = np.empty((count, len(self._streams)), dtype)
            for k, stream in enumerate(self._streams):
                rows[:, k] = np.frombuffer(_exactly(stream, count * dtype.itemsize), dtype)
            axes = range(1, len(self._inner) + 1)
            rows = rows.reshape(count, *self._inner[::-1]).transpose(0, *reversed(axes))
        return rows.astype(dtype.newbyteorder("="), copy=False)

    def finish(self) -> None:
        """Come to the end, where an archive compares its checksum."""
        for stream in self._streams[-1:]:
            stream.read(1)

    def close(self) -> None:
        """Close the streams."""
        for stream in self._streams:
            stream.close()


class Archive:
    """An NPZ file.

    Parameters
    ----------
    path : path
    refuse : callable
        Makes the file's error from what is wrong.
    """

    WHAT = "is not an NPZ file of plain arrays"

    def __init__(self, path: Path, refuse: Refusal) -> None:
        self._refuse = refuse
        with reading(refuse, self.WHAT):
            self._zip = zipfile.ZipFile(path)
            entries = self._zip.infolist()
        self._rows: list[Rows] = []
        self._entries = {entry.filename.removesuffix(".npy"): entry for entry in entries}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for rows in self._rows:
            rows.close()
        self._zip.close()

    @property
    def names(self) -> list[str]:
        """Names of the arrays."""
        return list(self._entries)

    @contextlib.contextmanager
    def reading(self, name: str) -> Iterator[None]:
        """Turn errors into those of the file that name an array."""
        with reading(lambda reason: self._refuse(f"'{name}': {reason}"), "is damaged"):
            yield

    def header(self, name: str) -> Header:
        """Return the header of an array; refuses entries that claim too much."""
        entry = self._entries[name]
        with self.reading(name):
            if entry.flag_bits & _ENCRYPTED:
                raise ValueError("encrypted")
            if entry.compress_type not in _METHODS:
                raise ValueError(
                    f"compression method {entry.compress_type}, expected 0 (none) or 8 (deflate)"
                )
            if entry.file_size > max(BOMB_BYTES, BOMB_RATIO * entry.compress_size):
                raise ValueError(
                    f"{entry.compress_size} bytes claim to unpack to {entry.file_size}, "
                    f"more than {BOMB_RATIO} times as many"
                )
            with self._zip.open(entry) as stream:
                return read_header(stream, entry.file_size)

    def rows(self, name: str, header: Header) -> Rows:
        """Return the rows of an array."""
        with self.reading(name):
            self._rows.append(Rows(lambda: self._zip.open(self._entries[name]), header))
        return self._rows[-1]

    def array(self, name: str) -> NDArray[Any]:
        """Return a whole array."""
        if name not in self._entries:
            raise self._refuse(f"{self.WHAT}: missing '{name}'")
        header = self.header(name)
        rows = self.rows(name, header)
        with self.reading(name):
            found = rows.take(header.rows)
            rows.finish()
            return found.reshape(header.shape)


def read_array(path: Path, refuse: Refusal, what: str) -> NDArray[Any]:
    """Return the whole array of an NPY file."""
    with reading(refuse, what), path.open("rb") as stream:
        header = read_header(stream, os.fstat(stream.fileno()).st_size)
        with contextlib.closing(Rows(lambda: path.open("rb"), header)) as rows:
            return rows.take(header.rows).reshape(header.shape)
