"""Targets to results: a thread that reads, one that solves, and the caller who writes.

The stages overlap, and bounded queues between them keep the memory the same however long the
file is. The caller's thread never enters the solver, so Ctrl-C is answered at once however
long that stays in compiled code.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._background import ahead
from ..io import Extras, ResultChunk, TargetChunk, part_of

# A piece is what one call of the solver gets: long enough to keep every core busy, short
# enough that the bar moves.
PIECE_S = 0.2
FIRST_PIECE = 64
LARGEST_PIECE = 65_536
CHUNKS_AHEAD = 2
PIECES_AHEAD = 4


Solve = Callable[[NDArray[np.float64], int, NDArray[Any], Extras], ResultChunk]
"""Solves targets, the first of which has an index within the file, and which have ids and columns
that are passed on."""


class Pipeline:
    """Solves chunks of targets piece by piece.

    Parameters
    ----------
    chunks : iterable of TargetChunk
        Read in a thread.
    solve : callable
        Called in another thread.

    Attributes
    ----------
    solve_s : float
        Seconds spent in `solve` so far.
    """

    def __init__(self, chunks: Iterable[TargetChunk], solve: Solve) -> None:
        self._chunks = chunks
        self._solve = solve
        self._size = FIRST_PIECE
        self.solve_s = 0.0

    def pieces(self) -> Generator[tuple[int, ResultChunk]]:
        """Return numbers of targets and their results, in order; closing ends the threads."""
        read = ahead(self._chunks, CHUNKS_AHEAD, "agrik-fast-read")
        return ahead(self._solved(read), PIECES_AHEAD, "agrik-fast-solve")

    def _solved(self, chunks: Generator[TargetChunk]) -> Generator[tuple[int, ResultChunk]]:
        try:
            for chunk in chunks:
                yield from self._solved_chunk(chunk)
        finally:
            chunks.close()

    def _solved_chunk(self, chunk: TargetChunk) -> Generator[tuple[int, ResultChunk]]:
        at = 0
        while at < len(chunk):
            part = slice(at, at + self._size)
            started = time.perf_counter()
            targets = chunk.targets[part]
            extras = part_of(chunk.extras, part)
            piece = self._solve(targets, chunk.first + at, chunk.ids[part], extras)
            took = time.perf_counter() - started
            self.solve_s += took
            at += len(targets)
            fit = int(len(targets) * PIECE_S / max(took, 1e-6))
            self._size = max(1, min(fit, 8 * self._size, LARGEST_PIECE))
            yield len(targets), piece
