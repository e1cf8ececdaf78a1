"""What a runner offers: partitions in, how they ended out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from ..jobs import Finished, Partition


class Ended(NamedTuple):
    """How an attempt at a partition ended."""

    partition: Partition
    outcome: Finished | str
    """The outcome, or what went wrong."""


class Runner(Protocol):
    """Does the work on partitions in other processes.

    Attributes
    ----------
    group : int
        Partitions that are handed over together.
    workers : int
        Processes or threads that work at a time, as far as is known.
    """

    group: int
    workers: int

    def room(self) -> bool:
        """Return whether more partitions are wanted now."""

    def busy(self) -> bool:
        """Return whether any partition is underway."""

    def submit(self, partitions: Sequence[Partition]) -> None:
        """Take over partitions, at most `group`."""

    def wait(self, timeout_s: float) -> list[Ended]:
        """Return what ended since the last call, waiting for it if there is nothing yet."""

    def share_out(self) -> None:
        """Let those at work use what the others leave idle: there are no more partitions.

        The last partitions end one after the other, and whoever ends first has nothing to do.
        Results are the same for any number of threads.
        """

    def close(self, *, cancel: bool) -> None:
        """End everything that was started; with `cancel`, work that is underway too."""
