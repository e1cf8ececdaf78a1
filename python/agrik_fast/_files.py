"""Reading of files that may hold anything: one line for what is wrong, limits on what they claim.

Whatever a library raises while it reads leaves `reading` as an error of ours. Texts are read
up to a limit, and nothing in them makes the parsers take the square of their length.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from .errors import AgrikError

Refusal = Callable[[str], AgrikError]
"""Makes the error of a file from what is wrong with it."""

TEXT_BYTES = 512 << 10
"""Largest TOML or JSON file; those of robots and gains have some thousand bytes."""
KEY_PARTS = 64
"""Parts of a dotted TOML key, whose reading takes the square of them."""
_SHOWN = 60
_LISTED = 12


def shown(value: object) -> str:
    """Return a value's `repr` on one line, shortened where it is long."""
    # A cut before the repr: that of a long text takes several times its memory.
    text = repr(value[: 2 * _SHOWN]) if isinstance(value, str) else repr(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def listing(names: Iterable[str]) -> str:
    """Return names in a row, each shortened where it is long, and no more than a dozen."""
    every = list(names)
    head = ", ".join(
        name if len(name) <= _SHOWN and name.isprintable() else shown(name)
        for name in every[:_LISTED]
    )
    more = len(every) - _LISTED
    return f"{head} and {more} more" if more > 0 else head


def os_reason(error: OSError) -> str:
    """Return the operating system's reason in lower case, without errno and path."""
    return (error.strerror or brief(error)).lower()


def brief(error: BaseException) -> str:
    """Return a library's message on one line, shortened where it is long."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= 2 * _SHOWN else f"{text[: 2 * _SHOWN]}..."


@contextlib.contextmanager
def reading(refuse: Refusal, what: str) -> Iterator[None]:
    """Turn every error of a library into one of ours.

    Damaged bytes come out of the libraries as anything: `TypeError`, `zlib.error`,
    `NotImplementedError`, `OverflowError`. So nothing but calls of them belongs in here.

    Parameters
    ----------
    refuse : callable
        Makes the file's error from a text.
    what : str
        What the file or a place in it turned out not to be; the library's own words follow.
    """
    try:
        yield
    except (AgrikError, AssertionError, AttributeError, NameError):
        # The last three are faults of this program, not of a file.
        raise
    except MemoryError as error:
        raise refuse("needs more memory than there is") from error
    except RecursionError as error:
        raise refuse(f"{what}: nested too deep") from error
    except Exception as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise refuse(f"cannot be read: {os_reason(error)}") from error
        raise refuse(f"{what}: {brief(error)}") from error


def read_bytes(path: Path, refuse: Refusal, limit: int = TEXT_BYTES) -> bytes:
    """Return a file's content.

    Raises
    ------
    AgrikError
        By `refuse`: the file is longer than `limit` bytes, is no regular file or cannot be
        read.
    """
    with reading(refuse, "cannot be read"):
        if path.exists() and not path.is_file():
            raise refuse("is a folder, expected a file" if path.is_dir() else "is no regular file")
        with path.open("rb") as stream:
            data = stream.read(limit + 1)
    if len(data) > limit:
        raise refuse(f"is longer than {limit} bytes")
    return data


def decode(data: bytes, refuse: Refusal) -> str:
    """Return bytes as text; `refuse` hears of the line that is not UTF-8."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise refuse(f"line {line}: is not UTF-8 text ({error.reason})") from None


def parse_toml(text: str, refuse: Refusal) -> dict[str, Any]:
    """Return a TOML text's tables; `refuse` hears of the line that cannot be read."""
    import tomllib

    for number, line in enumerate(text.splitlines(), start=1):
        bare = _QUOTED.sub("", line).partition("#")[0]
        if any(piece.count(".") >= KEY_PARTS for piece in re.split("[=,]", bare)):
            raise refuse(
                f"not a TOML file: a key of more than {KEY_PARTS} parts (at line {number})"
            )
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise refuse(f"not a TOML file: {brief(error)}") from None
    except (ValueError, RecursionError) as error:
        raise refuse(f"not a TOML file: {_number_or_depth(text, error)}") from None


def parse_json(text: str, refuse: Refusal) -> Any:
    """Return a JSON text's value; `refuse` hears of the line that cannot be read."""
    import json

    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise refuse(f"not a JSON file: {brief(error)}") from None
    except (ValueError, RecursionError) as error:
        raise refuse(f"not a JSON file: {_number_or_depth(text, error)}") from None


_QUOTED = re.compile(r"\"[^\"\n]*\"|'[^'\n]*'")


def _number_or_depth(text: str, error: Exception) -> str:
    """Say where the parser gave up, which it does not for long numbers and deep brackets."""
    lines = text.splitlines()
    if isinstance(error, RecursionError):
        depth, deepest, place = 0, 0, 1
        for number, line in enumerate(lines, start=1):
            bare = _QUOTED.sub("", line)
            depth += bare.count("[") + bare.count("{") - bare.count("]") - bare.count("}")
            highest = depth + bare.count("]") + bare.count("}")
            if highest > deepest:
                deepest, place = highest, number
        return f"brackets nested too deep (at line {place})"
    runs = [max(map(len, re.findall(r"[\d_]+", line)), default=0) for line in lines]
    place = runs.index(max(runs)) + 1
    return f"a number of {max(runs)} digits (at line {place})"
