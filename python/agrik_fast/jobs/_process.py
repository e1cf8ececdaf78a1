"""What a process is set to before it works on partitions, and what it tells of itself."""

from __future__ import annotations

import contextlib
import importlib.metadata
import platform
import sys
import threading
from collections.abc import Iterator

import numpy as np

from .._native import __version__, get_num_threads, set_num_threads, simd_level

_at_work = 0
"""How many pieces of work use threads of this process."""
_before = 0
"""What the process used before the first of them."""
_lock = threading.Lock()


@contextlib.contextmanager
def using_threads(threads: int) -> Iterator[None]:
    """Let batch calls of this process use so many threads, until all work like this has ended.

    A worker may live in the process of the one who asks, whose own number is put back then.
    """
    global _at_work, _before
    with _lock:
        if _at_work == 0:
            _before = get_num_threads()
        _at_work += 1
        set_num_threads(threads)
    try:
        yield
    finally:
        with _lock:
            _at_work -= 1
            if _at_work == 0:
                set_num_threads(None)
                if get_num_threads() != _before:
                    set_num_threads(_before)


def change_threads(threads: int) -> None:
    """Let the work that is going on use so many threads from now on."""
    with _lock:
        if _at_work:
            set_num_threads(threads)


def about_process() -> dict[str, str]:
    """Return the versions and the instruction set of this process."""
    return {**versions(), "simd": simd_level(), "host": platform.node()}


def versions() -> dict[str, str]:
    """Return the versions of what results depend on."""
    return {
        "agrik_fast": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "pyarrow": importlib.metadata.version("pyarrow"),
    }


def peak_mb() -> float:
    """Return the largest resident memory of this process so far; 0 where that is not known."""
    try:
        import resource
    except ImportError:
        return 0.0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6, 1)
