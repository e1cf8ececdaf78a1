"""Colours, sizes and labels that all figures share."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from ..errors import MissingExtraError
from ..result import Status

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PNG_DPI = 130
"""Points per inch of a PNG."""

PAGE_WIDTH = 6.5
"""Width of a page's text, in; figures as wide are shown at their own size."""

PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Colours that the colour-blind tell apart too (Okabe and Ito)."""

GOOD = PALETTE[0]
BAD = PALETTE[1]
"""Blue for what was reached, orange for what was not; words say the same."""

GREY = "#888888"
PALE = "#cccccc"
"""For what is there for comparison, and for what is behind."""

FIELD = {
    "fruit": "#d55e00",
    "leaf": "#009e73",
    "stem": "#8c6d31",
    "stalk": "#8c6d31",
    "pipe": "#888888",
    "wire": "#888888",
    "machine": "#bababa",
    "ground": "#d9d4c7",
}
"""Colours of the kinds of objects in scenes."""

STATUS_COLOURS = {
    Status.CONVERGED: PALETTE[0],
    Status.OUT_OF_REACH: GREY,
    Status.NOT_FOUND: PALETTE[1],
    Status.BAD_INPUT: PALETTE[6],
    Status.STALLED: PALETTE[4],
    Status.NON_FINITE: PALETTE[3],
    Status.IN_COLLISION: PALETTE[5],
}
"""Colours of the statuses of `Robot.ik`."""

_STYLE = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "figure.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}
_P = ParamSpec("_P")
_T = TypeVar("_T")


def style() -> dict[str, Any]:
    """Return the settings of this package's figures: sizes for a page's width, colours, frames.

    Returns
    -------
    dict
        For ``matplotlib.rcParams.update`` or ``matplotlib.rc_context``.

    Raises
    ------
    MissingExtraError
        Matplotlib is not installed.

    Examples
    --------
    >>> from agrik_fast.plots import style
    >>> style()["font.size"]
    9
    """
    try:
        from cycler import cycler
    except ImportError:
        raise MissingExtraError("figures (Matplotlib)", "plots") from None
    return {**_STYLE, "axes.prop_cycle": cycler(color=PALETTE)}


def styled(draw: Callable[_P, _T]) -> Callable[_P, _T]:
    """Return a function that draws in the style of this package's figures.

    Parameters
    ----------
    draw : callable
        It makes its figures while it runs.

    Returns
    -------
    callable

    Raises
    ------
    MissingExtraError
        When it is called: Matplotlib is not installed.

    Examples
    --------
    >>> from agrik_fast.plots import figure, styled
    >>> draw = styled(lambda: figure(3.0, 2.0))
    >>> callable(draw)
    True
    """

    @functools.wraps(draw)
    def drawn(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        settings: Any = style()  # says what is missing
        import matplotlib as mpl

        with mpl.rc_context(settings):
            return draw(*args, **kwargs)

    return drawn


def figure(width: float, height: float) -> Figure:
    """Return an empty figure that belongs to no window.

    Parameters
    ----------
    width, height : float, in

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    MissingExtraError
        Matplotlib is not installed.

    Examples
    --------
    >>> from agrik_fast.plots import PAGE_WIDTH, figure
    >>> figure(PAGE_WIDTH, 3.0).get_size_inches().tolist()
    [6.5, 3.0]
    """
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("figures (Matplotlib)", "plots") from None
    # The same drawing has the same bytes, whoever makes it.
    mpl.rcParams["svg.hashsalt"] = "agrik_fast"
    return Figure(figsize=(width, height), layout="constrained")


def label(what: str, unit: str = "") -> str:
    """Return the label of an axis: what is drawn, and its unit in brackets, once.

    Examples
    --------
    >>> from agrik_fast.plots import label
    >>> label("position error", "m"), label("iterations")
    ('position error [m]', 'iterations')
    """
    return f"{what} [{unit}]" if unit else what
