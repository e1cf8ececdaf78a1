"""What a job tells about its way."""

from __future__ import annotations

from types import TracebackType
from typing import Protocol, Self


class Progress(Protocol):
    """What `solve_file` tells about its way; used as a context manager.

    Examples
    --------
    >>> from agrik_fast.jobs import Silent
    >>> class Counter(Silent):
    ...     def advance(self, rows: int) -> None:
    ...         print(rows, "rows")
    >>> with Counter() as progress:
    ...     progress.advance(50)
    50 rows
    """

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...

    def start(self, label: str, total: int | None) -> None:
        """Begin; `total` is None while the number of rows is not known.

        Examples
        --------
        >>> from agrik_fast.jobs import Silent
        >>> with Silent() as progress:
        ...     progress.start("ur5", total=100)
        """

    def note(self, text: str) -> None:
        """Say something that does not change the count.

        Examples
        --------
        >>> from agrik_fast.jobs import Silent
        >>> with Silent() as progress:
        ...     progress.note("the tip is link 'tool0'")
        """

    def advance(self, rows: int) -> None:
        """Count rows as done.

        Examples
        --------
        >>> from agrik_fast.jobs import Silent
        >>> with Silent() as progress:
        ...     progress.start("ur5", total=100)
        ...     progress.advance(50)
        """


class Silent:
    """Shows nothing.

    Examples
    --------
    >>> from agrik_fast.jobs import Silent, SolveRequest, solve_file
    >>> from pathlib import Path
    >>> np.save("points.npy", [[0.4, 0.2, 0.3]])
    >>> paths = Path("points.npy"), Path("silent.csv")
    >>> solve_file(SolveRequest("ur5", *paths), progress=Silent()).solved
    1
    """

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        return

    def start(self, label: str, total: int | None) -> None:
        """Show nothing."""

    def note(self, text: str) -> None:
        """Show nothing."""

    def advance(self, rows: int) -> None:
        """Show nothing."""
