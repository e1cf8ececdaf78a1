"""The vertices of a PLY file, in text or binary, read without belief in its header.

References
----------
G. Turk, "The PLY polygon file format", 1994.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import Refusal, shown
from ._text_rows import numbers_of_lines

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_HEADER_BYTES = 1 << 16


@dataclass
class _Element:
    name: str
    count: int
    properties: list[tuple[str, str]] = field(default_factory=list)
    lists: bool = False


def read_ply(data: bytes, refuse: Refusal) -> dict[str, NDArray[Any]]:
    """Return the properties of the vertices by name, each of shape (n,).

    Parameters
    ----------
    data : bytes
        The file.
    refuse : callable
        Makes the file's error from what is wrong.

    Raises
    ------
    AgrikError
        By `refuse`: no PLY file, a form or a type that is unknown, no vertices, fewer of them
        than the header claims.
    """
    form, elements, start = _header(data, refuse)
    body = memoryview(data)[start:]
    before = []
    for element in elements:
        if element.name == "vertex":
            break
        before.append(element)
    else:
        raise refuse("has no element 'vertex'")
    if element.lists or any(one.lists for one in before):
        raise refuse("has lists before or among its vertices, expected numbers alone")
    if form == "ascii":
        return _from_text(bytes(body), element, sum(one.count for one in before), refuse)
    order = _ORDERS[form]
    skipped = sum(one.count * _record(one, order).itemsize for one in before)
    dtype = _record(element, order)
    there = max(0, len(body) - skipped) // max(1, dtype.itemsize)
    if there < element.count:
        raise refuse(f"ends early: {there} of the {element.count} vertices that it claims")
    rows = np.frombuffer(body, dtype, element.count, skipped)
    return {name: rows[name].astype(dtype[name].newbyteorder("=")) for name in dtype.names or ()}


def _record(element: _Element, order: str) -> np.dtype[Any]:
    return np.dtype([(name, order + kind) for name, kind in element.properties])


def _from_text(
    body: bytes, element: _Element, before: int, refuse: Refusal
) -> dict[str, NDArray[Any]]:
    rows = numbers_of_lines(
        body, element.count, len(element.properties), refuse, skip=before, what="vertices"
    )
    return {name: rows[:, k] for k, (name, _) in enumerate(element.properties)}


def _header(data: bytes, refuse: Refusal) -> tuple[str, list[_Element], int]:
    if not re.match(rb"ply\r?\n", data):
        raise refuse("is no PLY file: it does not begin with 'ply'")
    end = re.search(rb"\nend_header\r?\n", data[:_HEADER_BYTES])
    if end is None:
        raise refuse("is no PLY file: its header has no end")
    form = ""
    elements: list[_Element] = []
    for number, line in enumerate(data[: end.start()].decode("latin1").splitlines(), start=1):
        words = line.split()
        match words:
            case ["ply"] | ["comment", *_] | ["obj_info", *_] | []:
                pass
            case ["format", kind, "1.0"] if kind in _ORDERS:
                form = kind
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append(_Element(name, int(count)))
            case ["property", "list", size, kind, _] if {size, kind} <= set(_TYPES) and elements:
                elements[-1].lists = True
            case ["property", kind, name] if kind in _TYPES and elements:
                if name in dict(elements[-1].properties):
                    raise refuse(f"line {number}: {shown(name)} is there twice")
                elements[-1].properties.append((name, _TYPES[kind]))
            case _:
                raise refuse(f"line {number}: {shown(line)} is no line of a PLY header")
    if not form:
        raise refuse("is no PLY file: its header has no format")
    return form, elements, end.end()
