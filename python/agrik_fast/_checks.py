"""Checks of arguments that several modules share; each raises `ArgumentError`."""

from __future__ import annotations

import contextlib
import math
import operator
import os
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import ArgumentError, UnknownNameError

# As in the compiled core.
_MOST_DIMENSIONS = 32

FloatArray = NDArray[np.float64]

Matrix: TypeAlias = tuple[tuple[float, ...], ...]
"""A matrix as rows of numbers."""


def shown(value: object) -> str:
    """Return a value as an error message has it, whatever its own words do."""
    try:
        return repr(value)
    except Exception:
        return f"a {type(value).__name__}"


def text(argument: str, value: object) -> str:
    """Return `value` if it is a text that can be written."""
    if not isinstance(value, str):
        raise ArgumentError(argument, shown(value), "a text")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ArgumentError(argument, shown(value), "a text in Unicode") from None
    return value


def path(argument: str, value: object) -> Path:
    """Return `value`, a text or a path, as a path."""
    if not isinstance(value, str | os.PathLike):
        raise ArgumentError(argument, shown(value), "a path")
    name = os.fsdecode(value)
    if "\0" in name or not name:
        raise ArgumentError(argument, shown(value), "a path")
    return Path(text(argument, name))


def word(kind: str, value: object, known: Collection[str]) -> str:
    """Return `value` if it is one of a few words."""
    if not isinstance(value, str):
        raise ArgumentError(kind, shown(value), f"one of {', '.join(known)}")
    if value not in known:
        raise UnknownNameError(kind, value, known)
    return value


def items(argument: str, value: object, expected: str) -> tuple[Any, ...]:
    """Return the items of anything that can be gone through, but for a text."""
    if not isinstance(value, str | bytes) and isinstance(value, Iterable):
        with contextlib.suppress(TypeError):  # an array without dimensions
            return tuple(value)
    raise ArgumentError(argument, shown(value), expected)


def float_array(argument: str, value: ArrayLike) -> FloatArray:
    """Return `value` as a float64 array; anything but real numbers is refused."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        raise ArgumentError(argument, "rows of unequal length", "an array of numbers") from None
    if array.dtype.kind not in "fiu":
        raise ArgumentError(argument, f"an array of {array.dtype}", "an array of numbers")
    if array.ndim > _MOST_DIMENSIONS:
        expected = f"at most {_MOST_DIMENSIONS} dimensions"
        raise ArgumentError(argument, f"{array.ndim} dimensions", expected)
    return array.astype(np.float64, copy=False)


def frame_of(argument: str, value: ArrayLike) -> FloatArray:
    """Return the matrix of a frame; a place alone, shape (3,), is a frame that is not turned.

    What else is no rigid transform is refused where it is used.
    """
    given = float_array(argument, value)
    if given.shape == (4, 4):
        return given
    if given.shape != (3,):
        raise ArgumentError(argument, f"shape {given.shape}", "shape (4, 4) or (3,)")
    matrix = np.eye(4)
    matrix[:3, 3] = given
    return matrix


def whole_number(argument: str, value: object, low: int, high: int | None = None) -> int:
    """Return `value` as an int in [low, high]."""
    expected = f"a whole number >= {low}" if high is None else f"a whole number, {low} to {high}"
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise ArgumentError(argument, shown(value), expected) from None
    if isinstance(value, bool) or number < low or (high is not None and number > high):
        raise ArgumentError(argument, shown(value), expected)
    return number


def real_number(
    argument: str,
    value: object,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    open_low: bool = False,
    unit: str = "",
) -> float:
    """Return `value` as a finite float in [low, high], or (low, high] if `open_low`."""
    expected = "a finite number"
    if math.isfinite(low):
        expected += f" {'>' if open_low else '>='} {low:g}"
    if math.isfinite(high):
        expected += f" and <= {high:g}"
    if unit:
        expected += f" {unit}"
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ArgumentError(argument, shown(value), expected)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    inside = number > low if open_low else number >= low
    if not (math.isfinite(number) and inside and number <= high):
        raise ArgumentError(argument, f"{number!r}", expected)
    return number


def truth_value(argument: str, value: object) -> bool:
    """Return `value`, True or False and nothing that merely counts as one."""
    if not isinstance(value, (bool, np.bool_)):
        raise ArgumentError(argument, shown(value), "True or False")
    return bool(value)


def finite_array(argument: str, value: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return `value` as a float64 array of one shape, every number of it finite."""
    array = float_array(argument, value)
    if array.shape != shape:
        raise ArgumentError(argument, f"shape {array.shape}", f"shape {shape}")
    if not np.isfinite(array).all():
        raise ArgumentError(argument, str(array.tolist()), "finite numbers")
    return array


def matrix(argument: str, value: ArrayLike) -> Matrix:
    """Return a matrix of finite numbers as rows of floats."""
    array = float_array(argument, value)
    if array.ndim != 2 or array.size == 0:
        raise ArgumentError(argument, f"shape {array.shape}", "a matrix")
    if not np.isfinite(array).all():
        raise ArgumentError(argument, "NaN or infinity", "finite numbers")
    return tuple(tuple(row) for row in array.tolist())


def direction(argument: str, value: object) -> tuple[float, float, float]:
    """Return three numbers as a unit vector."""
    vector = float_array(argument, value)  # type: ignore[arg-type]
    if vector.shape != (3,):
        raise ArgumentError(argument, f"shape {vector.shape}", "shape (3,)")
    length = float(np.linalg.norm(vector))
    if not (math.isfinite(length) and length > 0):
        received = "zero" if length == 0 else str(vector.tolist())
        raise ArgumentError(argument, received, "a finite direction of non-zero length")
    x, y, z = (vector / length).tolist()
    return x, y, z
