"""placeholder"""

from __future__ import annotations


class Queries:
    """Queries."""

    __slots__ = ()
