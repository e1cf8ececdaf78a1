"""A stream of target chunks, solved one ahead of the caller."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ._background import Started

if TYPE_CHECKING:
    from .result import IkResult

_INDICES = 2**64


def solve_ahead(
    chunks: Iterable[ArrayLike], solve: Callable[[ArrayLike, int], IkResult], first_index: int
) -> Generator[IkResult]:
    """Yield the result of every chunk in order.

    While the caller uses one result, the next chunk is being solved in another thread; while
    that goes on, the chunk after it is taken from `chunks`, in the caller's own thread. So
    reading, solving and writing overlap, and at most two chunks and two results exist.

    Parameters
    ----------
    chunks : iterable of array_like
    solve : callable
        Gets a chunk and the index of its first target.
    first_index : int
        Index of the first target of the first chunk.
    """
    index = first_index
    underway: Started[IkResult] | None = None
    for chunk in chunks:
        # The caller may fill the same buffer again as soon as the next chunk is asked for.
        own = np.array(chunk) if isinstance(chunk, np.ndarray) else chunk
        done = None
        if underway is not None:
            done = underway.result()
            index = (index + done.status.size) % _INDICES
        underway = Started(partial(solve, own, index), "agrik-fast-stream")
        if done is not None:
            yield done
    if underway is not None:
        yield underway.result()
