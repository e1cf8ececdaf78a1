"""Tables and figures of the papers that the bundled robots come from, one module a paper.

Each has a function ``reproduce(directory, report=...)`` that writes its files and returns
their paths; ``agrik-fast paper NAME -o DIR`` calls it. Figures need the extra ``papers``.
"""

PAPERS = ("strawberry", "tomato", "hydrolek", "redundant7")
"""Names of the papers, each a module here."""

__all__ = ["PAPERS"]
