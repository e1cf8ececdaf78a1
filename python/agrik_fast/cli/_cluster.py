"""What the commands of ``agrik-fast cluster`` do, in the words of the command line."""

from __future__ import annotations

import json
import math
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

import typer

from .. import cluster
from .._files import os_reason
from ..cluster import FolderStatus, Progress, Summary, Tls
from ..errors import ArgumentError, UnknownNameError
from ..jobs import RobotChoice
from ..robot import Robot
from ._exits import PARTITIONS_FAILED, Kept, say, write_line

_LINE_S = 60.0
_OPTIONS = {
    "task": "--task",
    "position_tolerance": "--tol",
    "orientation_tolerance": "--tol-rad",
    "direction": "--direction",
    "scheduler": "--scheduler",
    "shard": "--shard",
    "simd": "--simd",
    "source": "IN",
    "target": "OUT",
    "tolerance_frame": "--tol-frame",
    "mask": "--mask",
    "q0": "--q0",
    "base_link": "--base-link",
    "tip_link": "--tip-link",
    "tool": "--tool",
    "tls": "--tls-ca",
    "tls_ca": "--tls-ca",
    "tls_cert": "--tls-cert",
    "tls_key": "--tls-key",
    "name_or_path": "--robot",
}


def options_of(
    *, tls: tuple[Path | None, Path | None, Path | None], shard: str | None, **options: Any
) -> dict[str, Any]:
    """Return the options of `agrik_fast.cluster.run` from those of the command line.

    Raises
    ------
    ArgumentError
        Some files of TLS without the others; a shard that is not i/N.
    """
    names = ("--tls-ca", "--tls-cert", "--tls-key")
    missing = [name for name, path in zip(names, tls, strict=True) if path is None]
    ca, cert, key = tls
    if ca is not None and cert is not None and key is not None:
        options["tls"] = Tls(ca, cert, key)
    elif len(missing) < len(names):
        raise ArgumentError(missing[0], "nothing", "all of " + ", ".join(names))
    if shard is not None:
        index, slash, count = shard.partition("/")
        good = slash and index.isdecimal() and count.isdecimal() and int(index) < int(count)
        if not good:
            raise ArgumentError("--shard", repr(shard), "i/N, with i from 0 to N - 1")
        options["shard"] = (int(index), int(count))
    return options


def load(
    robot: str,
    base_link: str | None = None,
    tip_link: str | None = None,
    tool: tuple[float, ...] | None = None,
    frame: str | None = None,
) -> Robot:
    """Return the robot that the options of a job name."""
    return RobotChoice(robot, base_link, tip_link, tool, frame).load()


def run_words(
    make: Callable[[], Callable[..., Summary]],
    paths: list[str],
    options: dict[str, Any],
    log: Path | None,
    kept: Kept,
) -> Summary:
    """Run a job that `make` makes; errors name the options that their causes were given by.

    Raises
    ------
    AgrikError
        Nothing was started.
    typer.Exit
        The scheduler was lost.
    """
    wanted = 1 if options["generate"] is not None else 2
    if len(paths) != wanted:
        expected = "OUT alone, with --generate" if wanted == 1 else "IN and OUT"
        raise ArgumentError("paths", f"{len(paths)} ({', '.join(paths)})", expected)
    source, target = (None, paths[0]) if wanted == 1 else paths
    last: list[Progress] = []

    def how_far() -> str:
        if not last:
            return "nothing was started"
        there = last[-1].done + last[-1].skipped
        again = shlex.join(["agrik-fast", *sys.argv[1:]])
        return f"{there} of {last[-1].partitions} partitions are there; go on with: {again}"

    kept.what = how_far
    with _reporting(sys.stderr, log) as report:

        def note(progress: Progress) -> None:
            last.append(progress)
            del last[:-1]
            report(progress)

        try:
            return make()(source, target, report=note, **options)
        except UnknownNameError:
            raise
        except ArgumentError as error:
            option = _OPTIONS.get(error.argument, error.argument)
            raise ArgumentError(option, error.received, error.expected) from None
        except cluster.LostError as error:
            say(f"agrik-fast: {error}; {how_far()}")
            raise typer.Exit(PARTITIONS_FAILED) from None


# ---- progress ----------------------------------------------------------------------------------


@contextmanager
def _reporting(stream: TextIO, log: Path | None) -> Iterator[Callable[[Progress], None]]:
    """Give what shows progress: a line that changes on a terminal, a line a minute elsewhere."""
    shown = _Terminal(stream) if stream.isatty() else _Lines(stream)
    if log is None:
        with shown:
            yield shown
        return
    try:
        file = log.open("a", encoding="utf-8")
    except OSError as error:
        raise ArgumentError("--log", f"{str(log)!r} ({os_reason(error)})", "a file") from None
    with file, shown:

        def both(progress: Progress) -> None:
            shown(progress)
            write_line(file, json.dumps(_logged(progress)))

        yield both


def _logged(progress: Progress) -> dict[str, Any]:
    values = {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in vars(progress).items()
    }
    return {"time": round(time.time(), 3), **values}


class _Lines:
    """A line at the start and one every minute: fit for logs."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._next = time.monotonic() + _LINE_S

    def __enter__(self) -> _Lines:
        return self

    def __exit__(self, *error: object) -> None:
        return

    def __call__(self, progress: Progress) -> None:
        if progress.event in ("retry", "failed"):
            self._note(f"{progress.name}: {progress.event}: {progress.error}")
        now = time.monotonic()
        if progress.event in ("start", "end") or now >= self._next:
            self._note(line_of(progress))
            self._next = now + _LINE_S

    def _note(self, text: str) -> None:
        write_line(self._stream, text)


class _Terminal(_Lines):
    """One line that is written anew every second."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__(stream)
        self._width = 0

    def __exit__(self, *error: object) -> None:
        if self._width:
            write_line(self._stream, "")

    def __call__(self, progress: Progress) -> None:
        if progress.event in ("retry", "failed"):
            self._note(f"{progress.name}: {progress.event}: {progress.error}")
        now = time.monotonic()
        if progress.event in ("start", "end") or now >= self._next:
            text = line_of(progress)
            try:
                self._stream.write("\r" + text.ljust(self._width))
                self._stream.flush()
            except (OSError, ValueError):
                return
            self._width = len(text)
            self._next = now + 1.0

    def _note(self, text: str) -> None:
        write_line(self._stream, "\r" + text.ljust(self._width))
        self._width = 0


def line_of(progress: Progress) -> str:
    """Return how far a run is, in one line."""
    there = progress.done + progress.skipped
    words = [
        f"{there}/{progress.partitions} partitions",
        f"{progress.rows_done:,} of {progress.rows:,} rows",
    ]
    if progress.failed:
        words.append(f"{progress.failed} failed")
    if math.isfinite(progress.rows_per_s):
        words.append(f"{progress.rows_per_s:,.0f} rows/s")
    if progress.rows_done:
        words.append(f"{progress.good / progress.rows_done:.2%} solved")
    if progress.event == "end":
        words.append(f"{_duration(progress.seconds)} in all")
    elif math.isfinite(progress.left_s):
        words.append(f"{_duration(progress.left_s)} left")
    return ", ".join(words)


def _duration(seconds: float) -> str:
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


# ---- what is printed at the end -----------------------------------------------------------------


def lines_of(summary: Summary) -> list[str]:
    """Return how a run ended, in words."""
    words = f"{summary.partitions} partitions: {summary.done} done, {summary.skipped} were there"
    if summary.failures:
        words += f", {len(summary.failures)} failed"
    lines = [words, f"{summary.rows} rows: {_counts(summary.counts)}"]
    if not summary.complete and not summary.failures:
        lines.append("other shards are not done yet: there is no manifest")
    return [*lines, f"results: {summary.place}"]


def _counts(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counts.items()) or "none"


def status_lines(found: FolderStatus) -> list[str]:
    """Return how far a folder is, in words."""
    lines = [
        f"{found.done} of {found.partitions} partitions, {found.rows_done} of {found.rows} rows: "
        f"{_counts(found.counts)}",
    ]
    lines += [f"failed: {each['name']}: {each['error']}" for each in found.failures]
    if found.leftovers:
        lines.append(f"{found.leftovers} temporary files left over; agrik-fast cluster clean")
    lines.append("complete" if found.complete else "not complete")
    return lines
