"""What a process is set to before it works on partitions, and what it tells of itself."""

from __future__ import annotations

import importlib.metadata
import platform
import sys

import numpy as np

from .._native import __version__, set_num_threads, simd_level


def set_threads(threads: int) -> None:
    """Let batch calls of this process use so many threads."""
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
