"""Files of a reproduced paper: tables as CSV, figures as PNG and SVG."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from .._atomic import write_bytes
from ..errors import AgrikError
from ..plots import PNG_DPI

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_KeyT = TypeVar("_KeyT", bound=Hashable)


def save(drawing: Figure, directory: Path, name: str) -> list[Path]:
    """Write a figure as PNG and SVG and return the files."""
    png, svg = io.BytesIO(), io.BytesIO()
    drawing.savefig(png, format="png", dpi=PNG_DPI, metadata={"Software": None})
    drawing.savefig(svg, format="svg", metadata={"Date": None})
    return [
        _write(directory / f"{name}.{suffix}", stream.getvalue())
        for suffix, stream in (("png", png), ("svg", svg))
    ]


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> Path:
    """Write a table; floats as they come."""
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return _write(path, stream.getvalue().encode())


def write_text(path: Path, lines: Iterable[str]) -> Path:
    """Write lines of text."""
    return _write(path, ("\n".join(lines) + "\n").encode())


def _write(path: Path, data: bytes) -> Path:
    write_bytes(path, data, lambda reason: AgrikError(f"{path}: {reason}"), force=True)
    return path


def best_seconds(work: Callable[[], object], repeats: int = 5) -> float:
    """Return the least of several times of a call, s."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def seconds_in_turns(
    works: Mapping[_KeyT, Callable[[], object]], rounds: int = 30
) -> dict[_KeyT, float]:
    """Return the least processor time of each of several calls, s.

    Every round runs all of them, so that a busy machine slows all alike; only what the
    calling thread itself does is counted.
    """
    least = dict.fromkeys(works, float("inf"))
    for _ in range(rounds):
        for key, work in works.items():
            start = time.thread_time()
            work()
            least[key] = min(least[key], time.thread_time() - start)
    return least
