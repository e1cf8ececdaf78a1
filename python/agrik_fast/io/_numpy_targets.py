"""Targets from NPY and NPZ, read as streams of rows."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _rotations
from .._files import listing, reading
from .._npy import Archive, Header, Rows, read_header
from ._columns import RADIANS_PER_UNIT, UNITS_PER_METRE
from ._errors import TargetFileError
from ._extras import Extra, column_of, kind_of
from ._ids import check_width, checked
from ._reader import DEFAULT_CHUNK, TargetReader, rows_within
from ._records import TargetChunk

_POSITION_KEYS = {f"position_{unit}": scale for unit, scale in UNITS_PER_METRE.items()}
_ANGLE_KEYS = {
    f"{kind}_{unit}": (kind, scale)
    for kind in ("zyz", "rpy")
    for unit, scale in RADIANS_PER_UNIT.items()
}
_ORIENTATION_KEYS = ("quaternion_xyzw", *_ANGLE_KEYS)
_POSE_BYTES = 128


def _check_kind(path: Path, what: str, header: Header) -> None:
    if header.dtype.kind not in "fiu":
        raise TargetFileError(path, f"{what} holds {header.kind}, expected numbers")


def _doubles(rows: NDArray[Any]) -> NDArray[np.float64]:
    # What is beyond float64 becomes infinite, and its row bad_input.
    with np.errstate(over="ignore", invalid="ignore"):
        return np.array(rows, dtype=np.float64, order="C")


def _poses(rows: NDArray[Any]) -> NDArray[np.float64]:
    return _doubles(rows)


class NpyReader(TargetReader):
    """An array of points (n, 3) or poses (n, 4, 4), in m."""

    WHAT = "is not a NumPy array of numbers"

    def __init__(self, path: Path) -> None:
        self.path = path
        self._refuse = partial(TargetFileError, path)
        with reading(self._refuse, self.WHAT), path.open("rb") as stream:
            self._header = read_header(stream, os.fstat(stream.fileno()).st_size)
        _check_kind(path, "the array", self._header)
        shape = self._header.shape
        if shape[1:] not in ((3,), (4, 4)):
            raise TargetFileError(path, f"array of shape {shape}, expected (n, 3) or (n, 4, 4)")
        if shape[0] == 0:
            raise TargetFileError(path, "no targets in the array")
        self.is_pose = len(shape) == 3
        self.count = self._count = shape[0]

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        size = rows_within(size, max(self._header.row_bytes, _POSE_BYTES))
        with reading(self._refuse, self.WHAT):
            rows = Rows(lambda: self.path.open("rb"), self._header)
        with contextlib.closing(rows):
            for first in range(0, self._count, size):
                with reading(self._refuse, self.WHAT):
                    taken = rows.take(min(size, self._count - first))
                targets = _poses(taken) if self.is_pose else _doubles(taken)
                ids = np.arange(first + 1, first + len(targets) + 1, dtype=np.int64)
                yield TargetChunk(first, targets, ids)


class NpzReader(TargetReader):
    """An archive of arrays that hold targets; see `read_targets` for its keys."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._refuse = partial(TargetFileError, path)
        with Archive(path, self._refuse) as archive:
            used = _used_keys(path, archive.names)
            self._headers = {key: archive.header(key) for key in used}
            self.ignored = tuple(key for key in archive.names if key not in used)
            others = _headers(archive, self.ignored)
        numbers = {key: header for key, header in self._headers.items() if key != "id"}
        for key, header in numbers.items():
            _check_kind(path, f"'{key}'", header)
        place = next(iter(numbers))
        inner = (4, 4) if place == "T" else (3,)
        shape = numbers[place].shape
        if len(shape) == 0 or shape[1:] != inner:
            expected = ", ".join(map(str, ("n", *inner)))
            raise TargetFileError(path, f"'{place}' of shape {shape}, expected ({expected})")
        self.count = self._count = shape[0]
        for key in list(numbers)[1:]:
            expected_shape = (self._count, 4 if key == "quaternion_xyzw" else 3)
            self._check_shape(key, expected_shape)
        if self._count == 0:
            raise TargetFileError(path, "no targets in the file")
        if "id" in self._headers:
            self._check_shape("id", (self._count,))
            check_width(self._headers["id"].dtype, "'id'", self._refuse)
            self.has_text_ids = self._headers["id"].dtype.kind == "U"
        self.is_pose = place == "T" or len(numbers) > 1
        kinds = [(key, header, kind_of(header.dtype)) for key, header in others.items()]
        fit = [
            (Extra(key, kind), header)
            for key, header, kind in kinds
            if kind is not None and header.shape == (self._count,)
        ]
        self.extras = tuple(extra for extra, _ in fit)
        self._headers |= {extra.name: header for extra, header in fit}

    def _check_shape(self, key: str, expected: tuple[int, ...]) -> None:
        shape = self._headers[key].shape
        if shape != expected:
            raise TargetFileError(self.path, f"'{key}' of shape {shape}, expected {expected}")

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        row_bytes = sum(header.row_bytes for header in self._headers.values())
        size = rows_within(size, max(row_bytes, _POSE_BYTES))
        with Archive(self.path, self._refuse) as archive:
            streams = {key: archive.rows(key, header) for key, header in self._headers.items()}
            for first in range(0, self._count, size):
                count = min(size, self._count - first)
                arrays = {}
                for key, rows in streams.items():
                    with archive.reading(key):
                        arrays[key] = rows.take(count)
                yield self._chunk(first, arrays)
            for key, rows in streams.items():
                with archive.reading(key):
                    rows.finish()

    def _chunk(self, first: int, arrays: dict[str, NDArray[Any]]) -> TargetChunk:
        extras = {name: column_of(kind, arrays.pop(name)) for name, kind in self.extras}
        ids = arrays.pop("id", None)
        targets = _targets(arrays)
        if ids is None:
            ids = np.arange(first + 1, first + len(targets) + 1, dtype=np.int64)
        return TargetChunk(first, targets, checked(ids, first, self._refuse), extras)


def _headers(archive: Archive, keys: Sequence[str]) -> dict[str, Header]:
    """Return the headers of arrays, as far as they can be read."""
    found = {}
    for key in keys:
        # Nobody asked for it, so that it may be anything.
        with contextlib.suppress(TargetFileError):
            found[key] = archive.header(key)
    return found


def _used_keys(path: Path, keys: list[str]) -> list[str]:
    places = [key for key in ("T", *_POSITION_KEYS) if key in keys]
    if not places:
        found = listing(keys) or "nothing"
        raise TargetFileError(path, f"missing key 'T' or 'position_m'; found {found}")
    orientations = [key for key in _ORIENTATION_KEYS if key in keys]
    if len(places) > 1:
        raise TargetFileError(path, f"two positions ({' and '.join(places)}), expected one")
    if len(orientations) + (places == ["T"]) > 1:
        both = " and ".join((["T"] if places == ["T"] else []) + orientations)
        raise TargetFileError(path, f"two orientations ({both}), expected at most one")
    return places + orientations + (["id"] if "id" in keys else [])


def _targets(arrays: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
    if "T" in arrays:
        return _poses(arrays["T"])
    place, *turn = arrays
    position = _doubles(arrays[place]) / _POSITION_KEYS[place]
    if not turn:
        return position
    values = _doubles(arrays[turn[0]])
    if turn[0] == "quaternion_xyzw":
        rotation = _rotations.from_quaternion(values)
    else:
        kind, scale = _ANGLE_KEYS[turn[0]]
        rotation = (_rotations.from_zyz if kind == "zyz" else _rotations.from_rpy)(values * scale)
    return _rotations.transforms(position, rotation)
