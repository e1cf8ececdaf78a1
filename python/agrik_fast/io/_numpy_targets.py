"""Targets from NPY (read as a stream) and NPZ (read whole)."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _rotations
from ._columns import RADIANS_PER_UNIT, UNITS_PER_METRE
from ._errors import TargetFileError
from ._reader import DEFAULT_CHUNK, TargetReader
from ._records import TargetChunk


def _check_kind(path: Path, what: str, dtype: np.dtype[Any]) -> None:
    if dtype.kind not in "fiu":
        raise TargetFileError(path, f"{what} holds {dtype}, expected numbers")


def _is_target_shape(shape: tuple[int, ...]) -> bool:
    return (len(shape) == 2 and shape[1] == 3) or (len(shape) == 3 and shape[1:] == (4, 4))


class NpyReader(TargetReader):
    """An array of points (n, 3) or poses (n, 4, 4), in m, read piece by piece."""

    def __init__(self, path: Path) -> None:
        self.path = path
        array = self._map()
        _check_kind(path, "the array", array.dtype)
        shape = array.shape
        if not _is_target_shape(shape):
            raise TargetFileError(path, f"array of shape {shape}, expected (n, 3) or (n, 4, 4)")
        if shape[0] == 0:
            raise TargetFileError(path, "no targets in the array")
        self.is_pose = len(shape) == 3
        self.count = self._count = int(shape[0])

    def _map(self) -> NDArray[Any]:
        try:
            # A map holds no copy: memory stays bounded however long the file is.
            array: NDArray[Any] = np.load(self.path, mmap_mode="r", allow_pickle=False)
        except (ValueError, EOFError) as error:
            raise TargetFileError(self.path, "is not a NumPy array of numbers") from error
        return array

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        for first in range(0, self._count, size):
            # A fresh map per chunk lets the pages of the chunks before be given back.
            targets = np.array(self._map()[first : first + size], dtype=np.float64, order="C")
            if targets.ndim == 3:
                targets = _rotations.blank_non_rigid(targets)
            ids = np.arange(first + 1, first + len(targets) + 1, dtype=np.int64)
            yield TargetChunk(first, targets, ids)


class ArrayReader(TargetReader):
    """Targets held in memory, handed out in chunks."""

    def __init__(
        self,
        path: Path,
        targets: NDArray[np.float64],
        ids: NDArray[Any] | None,
        ignored: tuple[str, ...],
    ) -> None:
        self.path = path
        self.is_pose = targets.ndim == 3
        self.count = len(targets)
        self.ignored = ignored
        self._targets = targets
        self._ids = np.arange(1, len(targets) + 1, dtype=np.int64) if ids is None else ids
        self.has_text_ids = self._ids.dtype.kind == "U"

    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time."""
        for first in range(0, len(self._targets), size):
            part = slice(first, first + size)
            yield TargetChunk(first, self._targets[part], self._ids[part])


def open_npz(path: Path) -> ArrayReader:
    """Read an NPZ file of targets; see `read_targets` for its keys.

    Raises
    ------
    TargetFileError
        For a file that is no NPZ, unknown or competing keys, wrong shapes.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            keys = list(archive.files)
            used = _used_keys(path, keys)
            arrays: dict[str, NDArray[Any]] = {key: archive[key] for key in used}
    except (ValueError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, TargetFileError):
            raise
        raise TargetFileError(path, "is not an NPZ file of plain arrays") from error
    ids = arrays.pop("id", None)
    for key, array in arrays.items():
        _check_kind(path, f"'{key}'", array.dtype)
    targets = _targets(path, arrays)
    if len(targets) == 0:
        raise TargetFileError(path, "no targets in the file")
    if ids is not None:
        ids = _ids(path, ids, len(targets))
    return ArrayReader(path, targets, ids, tuple(key for key in keys if key not in used))


_POSITION_KEYS = {f"position_{unit}": scale for unit, scale in UNITS_PER_METRE.items()}
_ANGLE_KEYS = {
    f"{kind}_{unit}": (kind, scale)
    for kind in ("zyz", "rpy")
    for unit, scale in RADIANS_PER_UNIT.items()
}
_ORIENTATION_KEYS = ("quaternion_xyzw", *_ANGLE_KEYS)


def _used_keys(path: Path, keys: list[str]) -> list[str]:
    places = [key for key in ("T", *_POSITION_KEYS) if key in keys]
    if not places:
        found = ", ".join(keys) or "nothing"
        raise TargetFileError(path, f"missing key 'T' or 'position_m'; found {found}")
    orientations = [key for key in _ORIENTATION_KEYS if key in keys]
    if len(places) > 1:
        raise TargetFileError(path, f"two positions ({' and '.join(places)}), expected one")
    if len(orientations) + (places == ["T"]) > 1:
        both = " and ".join((["T"] if places == ["T"] else []) + orientations)
        raise TargetFileError(path, f"two orientations ({both}), expected at most one")
    return places + orientations + (["id"] if "id" in keys else [])


def _targets(path: Path, arrays: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
    if "T" in arrays:
        pose = np.array(arrays["T"], dtype=np.float64, order="C")
        if pose.ndim != 3 or pose.shape[1:] != (4, 4):
            raise TargetFileError(path, f"'T' of shape {pose.shape}, expected (n, 4, 4)")
        return _rotations.blank_non_rigid(pose)
    key = next(key for key in arrays if key in _POSITION_KEYS)
    position = np.array(arrays[key], dtype=np.float64, order="C")
    if position.ndim != 2 or position.shape[1] != 3:
        raise TargetFileError(path, f"'{key}' of shape {position.shape}, expected (n, 3)")
    position /= _POSITION_KEYS[key]
    rotation = _rotation(path, arrays, len(position))
    return position if rotation is None else _rotations.transforms(position, rotation)


def _rotation(
    path: Path, arrays: Mapping[str, NDArray[Any]], count: int
) -> NDArray[np.float64] | None:
    key = next((key for key in arrays if key in _ORIENTATION_KEYS), None)
    if key is None:
        return None
    values = np.asarray(arrays[key], dtype=np.float64)
    expected = (count, 4 if key == "quaternion_xyzw" else 3)
    if values.shape != expected:
        raise TargetFileError(path, f"'{key}' of shape {values.shape}, expected {expected}")
    if key == "quaternion_xyzw":
        return _rotations.from_quaternion(values)
    kind, scale = _ANGLE_KEYS[key]
    return (_rotations.from_zyz if kind == "zyz" else _rotations.from_rpy)(values * scale)


def _ids(path: Path, ids: NDArray[Any], count: int) -> NDArray[Any]:
    if ids.shape != (count,):
        raise TargetFileError(path, f"'id' of shape {ids.shape}, expected ({count},)")
    if ids.dtype.kind in "iu":
        return ids.astype(np.int64)
    if ids.dtype.kind == "U":
        return ids
    raise TargetFileError(path, f"'id' holds {ids.dtype}, expected integers or text")
