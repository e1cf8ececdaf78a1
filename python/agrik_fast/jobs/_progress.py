"""What a job tells about its way."""

from __future__ import annotations

from types import TracebackType
from typing import Protocol, Self


class Progress(Protocol):
    """What `solve_file` tells about its way; used as a context manager."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...

    def start(self, label: str, total: int | None) -> None:
        """Begin; `total` is None while the number of rows is not known."""

    def note(self, text: str) -> None:
        """Say something that does not change the count."""

    def advance(self, rows: int) -> None:
        """Count rows as done."""


class Silent:
    """Shows nothing."""

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
