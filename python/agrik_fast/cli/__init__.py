"""The command ``agrik-fast``."""

from ._app import main

__all__ = ["main"]
