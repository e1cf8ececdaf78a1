"""The command ``agrik-fast``."""

from .app import main

__all__ = ["main"]
