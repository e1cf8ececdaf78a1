"""The papers' tables and figures as functions, one module a paper.

Each module has ``reproduce(directory)``, which writes everything it can reproduce and
returns the files; ``agrik-fast paper NAME`` calls it. Figures need the extra ``papers``.
"""

PAPERS = ("strawberry", "tomato")
"""Names of the papers, each a module here."""

__all__ = ["PAPERS"]
