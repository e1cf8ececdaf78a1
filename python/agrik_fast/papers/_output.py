"""Files of a reproduced paper: tables as CSV, figures as PNG and SVG."""

from __future__ import annotations

import csv
import functools
import io
import time
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from .._atomic import write_bytes
from ..errors import AgrikError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PNG_DPI = 130
PAGE_WIDTH = 6.5
"""Width of a page's text, in; figures as wide are shown at their own size."""

PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Colours that the colour-blind tell apart too (Okabe and Ito)."""

GREY = "#888888"
_STYLE = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "figure.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}
_KeyT = TypeVar("_KeyT", bound=Hashable)
_P = ParamSpec("_P")
_T = TypeVar("_T")


def styled(draw: Callable[_P, _T]) -> Callable[_P, _T]:
    """Return a function that draws in the style of this package's figures."""

    @functools.wraps(draw)
    def drawn(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        figure(1.0, 1.0)  # says what is missing
        import matplotlib as mpl
        from cycler import cycler

        style: Any = {**_STYLE, "axes.prop_cycle": cycler(color=PALETTE)}
        with mpl.rc_context(style):
            return draw(*args, **kwargs)

    return drawn


def figure(width: float, height: float) -> Figure:
    """Return an empty figure (inches) that belongs to no window."""
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError:
        raise AgrikError("figures need Matplotlib; install the extra: agrik_fast[papers]") from None
    # The same drawing has the same bytes, whoever makes it.
    mpl.rcParams["svg.hashsalt"] = "agrik_fast"
    return Figure(figsize=(width, height), layout="constrained")


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
