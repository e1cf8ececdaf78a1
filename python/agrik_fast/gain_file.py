"""The former name of `agrik_fast.solvers.gain_file`, with the same class and functions."""

from .solvers.gain_file import GainFile, bundled, load, read, write

__all__ = ["GainFile", "bundled", "load", "read", "write"]
