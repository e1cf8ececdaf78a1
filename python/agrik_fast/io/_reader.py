"""What every reader of targets offers."""

from __future__ import annotations

import abc
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ._extras import Extra, joined
from ._records import TargetChunk

DEFAULT_CHUNK = 65_536
"""Rows of a chunk."""
CHUNK_BYTES = 32 << 20
"""About how many bytes a chunk takes at most: of wide rows there are fewer."""


def rows_within(size: int, row_bytes: int) -> int:
    """Return how many rows a chunk of at most `size` has."""
    return max(1, min(size, CHUNK_BYTES // max(row_bytes, 1)))


class TargetReader(abc.ABC):
    """An open target file.

    Attributes
    ----------
    path : pathlib.Path
    is_pose : bool
        True if every target has an orientation.
    count : int or None
        Number of targets, None where only reading on would tell (CSV).
    has_text_ids : bool
        True if the row ids are text.
    ignored : tuple of str
        Columns or keys that were found and not used.
    extras : tuple of Extra
        Those of them that can be passed on to the results.

    Examples
    --------
    >>> from agrik_fast.io import read_targets
    >>> np.save("points.npy", [[0.4, 0.2, 0.3], [0.3, 0.1, 0.4]])
    >>> read_targets("points.npy").count
    2
    """

    path: Path
    is_pose: bool
    count: int | None
    has_text_ids: bool = False
    ignored: tuple[str, ...] = ()
    extras: tuple[Extra, ...] = ()

    @abc.abstractmethod
    def chunks(self, size: int = DEFAULT_CHUNK) -> Iterator[TargetChunk]:
        """Yield the targets in order, at most `size` rows at a time.

        Raises
        ------
        TargetFileError
            At the chunk that holds the fault, naming its row and column.

        Examples
        --------
        >>> from agrik_fast.io import read_targets
        >>> np.save("points.npy", np.zeros((5, 3)))
        >>> [len(chunk.targets) for chunk in read_targets("points.npy").chunks(2)]
        [2, 2, 1]
        """

    def read_all(self) -> TargetChunk:
        """All targets as one chunk.

        Examples
        --------
        >>> from agrik_fast.io import read_targets
        >>> np.save("points.npy", np.zeros((5, 3)))
        >>> read_targets("points.npy").read_all().targets.shape
        (5, 3)
        """
        parts = list(self.chunks())
        return TargetChunk(
            0,
            np.concatenate([part.targets for part in parts]),
            np.concatenate([part.ids for part in parts]),
            joined([part.extras for part in parts]),
        )
