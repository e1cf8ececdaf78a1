"""Give the tutorials' pictures the style of all others."""

from typing import Any

import matplotlib as mpl

from agrik_fast.plots import style


def use(_settings: dict[str, Any], _file: str) -> None:
    """Set the style, as sphinx-gallery asks before every script."""
    mpl.rcParams.update(style())
