"""A picture of what became of targets: outcomes in words, errors, steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from ..result import Status
from ._style import GREY, PAGE_WIDTH, PALETTE, STATUS_COLOURS, figure, label, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BINS = 40
# Errors of zero have no logarithm: they are drawn at this, m.
_FLOOR = 1e-18


@styled
def outcomes(
    status: NDArray[np.uint8], position_error: FloatArray, iterations: NDArray[np.uint32]
) -> Figure:
    """Draw what became of targets.

    Parameters
    ----------
    status : ndarray of uint8, shape (...)
        Codes of `agrik_fast.Status`.
    position_error : ndarray, shape (...), m
    iterations : ndarray of uint32, shape (...)

    Returns
    -------
    matplotlib.figure.Figure
        Three panels: targets by status; position errors, of those that were reached and the
        others; steps taken.

    Raises
    ------
    MissingExtraError
        Matplotlib is not installed.

    Examples
    --------
    >>> from agrik_fast.plots import outcomes
    >>> import numpy as np
    >>> picture = outcomes(np.array([0, 0, 1]), np.array([1e-9, 1e-8, 0.1]), np.array([5, 6, 0]))
    >>> [axes.get_xlabel() for axes in picture.axes]
    ['targets', 'position error [m]', 'iterations']
    """
    status, error, steps = status.reshape(-1), position_error.reshape(-1), iterations.reshape(-1)
    drawing = figure(PAGE_WIDTH, 2.6)
    bars, errors, work = drawing.subplots(1, 3)
    _bars(bars, status)
    reached = status == Status.CONVERGED
    finite = np.maximum(error[np.isfinite(error)], _FLOOR)
    if len(finite):
        low, high = np.floor(np.log10(finite.min())), np.ceil(np.log10(finite.max()))
        edges = np.logspace(low, max(high, low + 1), _BINS)
        for rows, colour, name in (
            (reached, PALETTE[0], "reached"),
            (~reached, PALETTE[1], "not reached"),
        ):
            values = error[rows & np.isfinite(error)]
            if len(values):
                errors.hist(np.maximum(values, _FLOOR), edges, color=colour, label=name)
        errors.set_xscale("log")
        errors.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0))
    errors.set_xlabel(label("position error", "m"))
    errors.set_ylabel("targets")
    if len(steps):
        most = int(steps.max())
        edges = np.arange(most + 2) - 0.5 if most < _BINS else np.linspace(0, most, _BINS)
        work.hist(steps, edges, color=GREY)
    work.set_xlabel("iterations")
    work.set_ylabel("targets")
    return drawing


def _bars(axes: Any, status: NDArray[np.uint8]) -> None:
    codes, counts = np.unique(status, return_counts=True)
    names = [Status(int(code)) for code in codes]
    words = [name.name.replace("_", " ").lower() for name in names]
    colours = [STATUS_COLOURS.get(name, GREY) for name in names]
    axes.barh(words, counts, color=colours)
    for row, count in enumerate(counts):
        axes.text(count, row, f" {count}", va="center")
    axes.set_xlim(0, 1.25 * max(counts, default=1))
    axes.invert_yaxis()
    axes.set_xlabel("targets")
