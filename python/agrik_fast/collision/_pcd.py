"""The points of a PCD file, in text, binary or compressed, read without belief in its header.

References
----------
Point Cloud Library, "The PCD (Point Cloud Data) file format", version 0.7.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal, shown
from ._text_rows import numbers_of_lines

_KINDS = {"F": "f", "I": "i", "U": "u"}
_HEADER_LINES = 40
_KEYS = (
    "VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA",
)  # fmt: skip


def read_pcd(data: bytes, refuse: Refusal) -> dict[str, NDArray[Any]]:
    """Return the fields of the points by name, each of shape (n,).

    Parameters
    ----------
    data : bytes
        The file.
    refuse : callable
        Makes the file's error from what is wrong.

    Raises
    ------
    AgrikError
        By `refuse`: no PCD file, a form or a type that is unknown, fewer points than the
        header claims.
    """
    header, start = _header(data, refuse)
    names, dtype = _record(header, refuse)
    count = _whole(header, "POINTS", refuse)
    body = data[start:]
    form = " ".join(header["DATA"])
    single = [name for name in names if dtype[name].shape == ()]
    if form == "ascii":
        sizes = [max(1, int(np.prod(dtype[name].shape))) for name in names]
        rows = numbers_of_lines(body, count, sum(sizes), refuse, what="points")
        starts = np.cumsum([0, *sizes])
        where = {name: int(starts[k]) for k, name in enumerate(names)}
        return {name: rows[:, where[name]] for name in single}
    if form == "binary_compressed":
        body = _unpacked(body, count * dtype.itemsize, refuse)
        # Compressed files hold one field after the other.
        found, at = {}, 0
        for name in names:
            size = dtype[name].itemsize * count
            if name in single:
                found[name] = np.frombuffer(body, dtype[name], count, at)
            at += size
        return found
    if form != "binary":
        raise refuse(f"DATA {shown(form)}, expected ascii, binary or binary_compressed")
    there = len(body) // dtype.itemsize
    if there < count:
        raise refuse(f"ends early: {there} of the {count} points that it claims")
    packed = np.frombuffer(body, dtype, count)
    return {name: packed[name].copy() for name in single}


def _header(data: bytes, refuse: Refusal) -> tuple[dict[str, list[str]], int]:
    header: dict[str, list[str]] = {}
    at = 0
    for number in range(1, _HEADER_LINES + 1):
        end = data.find(b"\n", at, at + 4096)
        if end < 0:
            break
        line = data[at:end].decode("latin1").strip()
        at = end + 1
        if not line or line.startswith("#"):
            continue
        key, *words = line.split()
        if key not in _KEYS or key in header:
            raise refuse(f"line {number}: {shown(line)} is no line of a PCD header")
        header[key] = words
        if key == "DATA":
            break
    if "DATA" not in header:
        raise refuse("is no PCD file: its header has no DATA")
    missing = [key for key in ("FIELDS", "SIZE", "TYPE", "POINTS") if key not in header]
    if missing:
        raise refuse(f"is no PCD file: its header has no {', '.join(missing)}")
    return header, at


def _whole(header: dict[str, list[str]], key: str, refuse: Refusal) -> int:
    words = header[key]
    if len(words) != 1 or not (words[0].isascii() and words[0].isdigit() and len(words[0]) < 16):
        raise refuse(f"{key} {shown(' '.join(words))}, expected a whole number")
    return int(words[0])


def _record(header: dict[str, list[str]], refuse: Refusal) -> tuple[list[str], np.dtype[Any]]:
    names, sizes, kinds = header["FIELDS"], header["SIZE"], header["TYPE"]
    counts = header.get("COUNT", ["1"] * len(names))
    if not len(names) == len(sizes) == len(kinds) == len(counts) or not names:
        raise refuse("FIELDS, SIZE, TYPE and COUNT are not as many")
    fields: list[tuple[str, str, tuple[int, ...]]] = []
    for k, (name, size, kind, count) in enumerate(zip(names, sizes, kinds, counts, strict=True)):
        # Padding is called _, as often as there is any.
        own = f"_{k}" if name == "_" else name
        try:
            dtype = np.dtype(f"<{_KINDS[kind]}{int(size)}")
            length = int(count)
        except (KeyError, TypeError, ValueError):
            raise refuse(f"field {shown(name)}: type {kind} {size} {count} is unknown") from None
        if not 1 <= length <= 4096:
            raise refuse(f"field {shown(name)}: COUNT {length}, expected 1 to 4096")
        fields.append((own, dtype.str, () if length == 1 else (length,)))
    try:
        record = np.dtype(fields)
    except ValueError:
        raise refuse("two fields of one name") from None
    return [name for name, _, _ in fields], record


def _unpacked(body: bytes, size: int, refuse: Refusal) -> bytes:
    """Undo the compression of M. Lehmann's LZF: runs of letters, and copies of earlier ones."""
    if len(body) < 8:
        raise refuse("ends early: within the sizes of its compressed points")
    packed, claimed = struct.unpack("<II", body[:8])
    if claimed != size:
        raise refuse(f"claims {claimed} bytes for points that take {size}")
    if len(body) - 8 < packed:
        raise refuse(f"ends early: {len(body) - 8} of the {packed} compressed bytes that it claims")
    source = body[8 : 8 + packed]
    out = bytearray()
    at = 0
    try:
        while at < packed:
            control = source[at]
            at += 1
            if control < 32:
                out += source[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += source[at]
                at += 1
            start = len(out) - ((control & 31) << 8) - source[at] - 1
            at += 1
            if start < 0:
                raise refuse("compressed points are damaged")
            length += 2
            while length > 0:
                # A copy may go on into what it has just written.
                part = out[start : start + length]
                out += part
                start += len(part)
                length -= len(part)
            if len(out) > size:
                break
    except IndexError:
        raise refuse("compressed points are damaged") from None
    if len(out) != size:
        raise refuse("compressed points are damaged")
    return bytes(out)
