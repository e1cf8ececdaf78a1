"""How a command ends: exit statuses, one line for every fault, streams that fail.

What a command was asked for comes first: a result that is on the disk stays, whatever
becomes of the words about it.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from typing import IO, Any, TextIO

import typer

BAD_ARGUMENTS = 2
NOT_ALL_SOLVED = 3
NO_MEMORY = 4
PARTITIONS_FAILED = 4
"""Of a cluster job, some are not there; the others are."""
NOT_TOLD = 5
"""The work is done, but standard output is full."""
FAULT = 70  # EX_SOFTWARE of sysexits.h
INTERRUPTED = 130  # the shell's 128 + SIGINT
HUNG_UP = 129
TERMINATED = 143

# Faults of a file that are told, a line each, below one on their number.
_FAULTS = 20
_ENDINGS = {"SIGTERM": ("terminated", TERMINATED), "SIGHUP": ("hung up", HUNG_UP)}


class _Ended(BaseException):
    """The process was asked to end."""

    def __init__(self, word: str, status: int) -> None:
        self.word = word
        self.status = status


class Kept:
    """What is left when a command is cut off."""

    def __init__(self) -> None:
        self.what: Callable[[], str] = lambda: "nothing was written"


@contextlib.contextmanager
def exit_codes() -> Iterator[Kept]:
    """Turn errors and signals into lines on stderr and an exit status, warnings into lines."""
    kept = Kept()
    try:
        with _signals_as_exceptions(), _warnings_as_lines():
            yield kept
    except _Ended as ended:
        say(f"agrik-fast: {ended.word}, {kept.what()}")
        raise typer.Exit(ended.status) from None
    except KeyboardInterrupt:
        say(f"agrik-fast: interrupted, {kept.what()}")
        raise typer.Exit(INTERRUPTED) from None
    except MemoryError:
        say(f"agrik-fast: out of memory, {kept.what()}")
        raise typer.Exit(NO_MEMORY) from None
    except typer.Exit:
        raise
    except Exception as error:
        try:
            line, status = _told(error)
        except MemoryError:
            line, status = f"out of memory, {kept.what()}", NO_MEMORY
        say(f"agrik-fast: {line}")
        raise typer.Exit(status) from None


def _told(error: Exception) -> tuple[str, int]:
    from .._files import brief
    from ..errors import AgrikError

    if isinstance(error, AgrikError | OSError):
        parts = [part.strip() for part in str(error).splitlines() if part.strip()]
        told, left = parts[: 1 + _FAULTS], parts[1 + _FAULTS :]
        # A single line that is left may be such a line on the rest.
        more = [f"and {len(left)} more"] if len(left) > 1 else left
        # A single fault stands behind its file's name.
        between = "; " if len(parts) <= 2 else "\n  "
        return between.join(told + more), BAD_ARGUMENTS
    if isinstance(error, ImportError):
        return f"cannot be loaded: {brief(error)}", NO_MEMORY
    if isinstance(error, RuntimeError) and "new thread" in str(error):
        return f"out of threads or memory: {brief(error)}", NO_MEMORY
    place = error.__traceback__
    while place is not None and place.tb_next is not None:
        place = place.tb_next
    where = "" if place is None else f" ({place.tb_frame.f_code.co_name}, line {place.tb_lineno})"
    return (
        f"a fault of the program, please report it: {type(error).__name__}{where}: {brief(error)}",
        FAULT,
    )


@contextlib.contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Tell what the package warns of in a line, without the place in its sources."""
    with warnings.catch_warnings():
        before = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if category.__module__.partition(".")[0] == __package__.partition(".")[0]:
                say(f"agrik-fast: {message}")
            else:
                before(message, category, *place, **more)

        warnings.showwarning = show
        yield


@contextlib.contextmanager
def _signals_as_exceptions() -> Iterator[None]:
    """Let SIGTERM and SIGHUP unwind the program as Ctrl-C does, so that half a result goes."""

    def end(number: int, frame: object) -> None:
        # A second signal must not interrupt the cleaning up.
        for each in before:
            signal.signal(each, signal.SIG_IGN)
        raise _Ended(*_ENDINGS[signal.Signals(number).name])

    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may set handlers, and only it is interrupted
        return
    numbers = [getattr(signal, name) for name in _ENDINGS if hasattr(signal, name)]
    # One that is ignored, as under nohup, stays so.
    before = {
        number: signal.getsignal(number)
        for number in numbers
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    for number in before:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


# ---- streams ------------------------------------------------------------------------------


def open_streams() -> None:
    """Let closed standard streams lead nowhere, and no letter be one that they cannot bear.

    Otherwise the next file that is opened would take a closed stream's number, and messages
    of other libraries would end up in it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def write_line(stream: TextIO, text: str) -> None:
    """Write a line about the work, which a full or closed stream does not end."""
    with contextlib.suppress(OSError, ValueError):
        print(text, file=stream, flush=True)


def say(text: str) -> None:
    """Write a line to stderr."""
    write_line(sys.stderr, text)


@contextlib.contextmanager
def telling(result: str = "") -> Iterator[None]:
    """Write to standard output once the work is done.

    A reader that left (``| head``) has what it wanted. A full disk is said, with the result.

    Parameters
    ----------
    result : str
        Where the result is, if it is a file.

    Raises
    ------
    typer.Exit
        With `NOT_TOLD` where the words could not be written.
    """
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        _mute(sys.stdout)
    except OSError as error:
        from .._files import os_reason

        _mute(sys.stdout)
        where = f"; {result}" if result else ""
        say(f"agrik-fast: standard output cannot be written: {os_reason(error)}{where}")
        raise typer.Exit(NOT_TOLD) from None


def _mute(stream: IO[str]) -> None:
    """Let what is still in the buffer go nowhere, not to an error while Python ends."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, stream.fileno())
        finally:
            os.close(nowhere)


def run(command: Callable[[], None]) -> None:
    """Run the program and exit with its status, also where nobody reads what it says."""
    open_streams()
    status: str | int | None = None
    try:
        with telling():
            command()
    except SystemExit as leaving:
        status = leaving.code
    except typer.Exit as leaving:
        status = leaving.exit_code
    except MemoryError:
        say("agrik-fast: out of memory, nothing was written")
        status = NO_MEMORY
    try:
        with telling():
            pass
    except typer.Exit as leaving:
        status = status or leaving.exit_code
    sys.exit(status)
