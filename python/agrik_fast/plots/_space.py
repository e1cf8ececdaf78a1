"""Things in space: shaded triangles, frames, axes of equal scales."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, finite_array, shown
from ..errors import ArgumentError
from ._style import PALETTE, figure, label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Where the light comes from, and how dark the shadow side is.
_LIGHT = np.array([0.35, -0.55, 0.76])
_DARKEST = 0.55
# Names of axes clear of the numbers at them, and neither beyond the picture's edge: points from
# an axis beyond the usual, and how large the box is.
_LABEL_PAD, _NUMBER_PAD, _ZOOM = 9, -5, 0.8


def space(width: float, height: float) -> tuple[Figure, Any]:
    """Return a figure with axes in space.

    Parameters
    ----------
    width, height : float, in

    Returns
    -------
    figure : matplotlib.figure.Figure
    axes : Axes3D

    Raises
    ------
    MissingExtraError
        Matplotlib is not installed.

    Examples
    --------
    >>> from agrik_fast.plots import space
    >>> figure, axes = space(4, 4)
    >>> axes.name
    '3d'
    """
    drawing = figure(width, height)
    return drawing, drawing.add_subplot(projection="3d")


def checked_view(view: object) -> tuple[float, float]:
    """Return elevation and azimuth, deg.

    Raises
    ------
    ArgumentError
        Not two finite numbers.
    """
    elevation, azimuth = finite_array("view", view, (2,)).tolist()  # type: ignore[arg-type]
    return elevation, azimuth


def space_or(axes: Any, width: float, height: float) -> tuple[Figure, Any]:
    """Return axes in space that were given, with their figure, or new ones for None.

    Raises
    ------
    ArgumentError
        Something else than axes in space.
    """
    if axes is None:
        return space(width, height)
    from mpl_toolkits.mplot3d import Axes3D

    if not isinstance(axes, Axes3D):
        raise ArgumentError("axes", shown(axes), "axes in space (projection='3d')")
    return axes.figure, axes


def is_blank(axes: Any) -> bool:
    """Return whether axes in space are new, or hold nothing: then what is drawn sets their limits.

    Examples
    --------
    >>> from agrik_fast.plots import is_blank, space
    >>> is_blank(space(4, 4)[1])
    True
    """
    return axes is None or not axes.has_data()


def add_triangles(
    axes: Any,
    vertices: FloatArray,
    faces: NDArray[np.int32],
    colour: str | Sequence[float],
    alpha: float = 1.0,
) -> None:
    """Add shaded triangles to axes in space.

    Parameters
    ----------
    axes : Axes3D
    vertices : ndarray, shape (k, 3), m
    faces : ndarray of int, shape (m, 3)
        The corners of each triangle.
    colour : str or (red, green, blue)
    alpha : float, default 1
        0 for glass, 1 for what hides all behind it.

    Examples
    --------
    >>> from agrik_fast.plots import add_triangles, space
    >>> figure, axes = space(4, 4)
    >>> add_triangles(axes, np.eye(3), np.array([[0, 1, 2]]), "#009e73")
    >>> len(axes.collections)
    1
    """
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    kept = length[:, 0] > 0.0
    lit = np.abs(normal[kept] / length[kept] @ _LIGHT)
    base: Any = to_rgb(colour)  # type: ignore[arg-type]
    shades = np.outer(_DARKEST + (1 - _DARKEST) * lit, base)
    colours = np.column_stack([np.clip(shades, 0, 1), np.full(len(shades), alpha)])
    axes.add_collection3d(
        Poly3DCollection(corners[kept], facecolors=colours, edgecolors="none", linewidths=0)
    )


def add_frame(axes: Any, pose: FloatArray, size: float, name: str = "") -> None:
    """Add the three axes of a frame: x, y, z in orange, green, blue, each named.

    Parameters
    ----------
    axes : Axes3D
    pose : ndarray, shape (4, 4), m
    size : float, m
        Length of an axis.
    name : str, optional
        Text at its origin.

    Examples
    --------
    >>> from agrik_fast.plots import add_frame, space
    >>> figure, axes = space(4, 4)
    >>> add_frame(axes, np.eye(4), 0.1, "base")
    >>> len(axes.lines)
    3
    """
    at = pose[:3, 3]
    for column, (axis, colour) in enumerate(zip("xyz", PALETTE[1:3] + PALETTE[:1], strict=True)):
        end = at + size * pose[:3, column]
        axes.plot(*np.array([at, end]).T, color=colour, linewidth=1.6)
        axes.text(*(at + 1.15 * size * pose[:3, column]), axis, color=colour, ha="center")
    if name:
        axes.text(*at, f"  {name}")


def bounds(clouds: Iterable[FloatArray], margin: float = 0.05) -> tuple[FloatArray, FloatArray]:
    """Return lowest and highest corner of points, with room round them.

    Parameters
    ----------
    clouds : iterable of ndarray, shape (k, 3), m
        At least one point.
    margin : float, default 0.05
        Share of the longest side.

    Returns
    -------
    low, high : ndarray, shape (3,), m

    Examples
    --------
    >>> from agrik_fast.plots import bounds
    >>> low, high = bounds([np.zeros((1, 3)), np.ones((1, 3))], margin=0.0)
    >>> low.tolist(), high.tolist()
    ([-0.001, -0.001, -0.001], [1.001, 1.001, 1.001])
    """
    points = np.concatenate([np.asarray(cloud).reshape(-1, 3) for cloud in clouds])
    low, high = points.min(axis=0), points.max(axis=0)
    room = max(margin * float((high - low).max()), 1e-3)
    return low - room, high + room


def frame_space(axes: Any, low: Sequence[float], high: Sequence[float], view: Any) -> None:
    """Set limits, equal scales, labels and the view of axes in space.

    Parameters
    ----------
    axes : Axes3D
    low, high : sequence of 3 float, m
        Corners of what is shown.
    view : (float, float)
        Elevation and azimuth, deg.

    Examples
    --------
    >>> from agrik_fast.plots import frame_space, space
    >>> figure, axes = space(4, 4)
    >>> frame_space(axes, (0, -1, 0), (1, 1, 2), (20, -60))
    >>> axes.get_xlabel()
    'x [m]'
    """
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_zlim(low[2], high[2])
    sides = [b - a for a, b in zip(low, high, strict=True)]
    axes.set_box_aspect(sides, zoom=_ZOOM)
    # Ticks of one distance on all three, or short sides would be full of them.
    from matplotlib.ticker import MultipleLocator

    step = _step(max(sides))
    for axis, name in zip((axes.xaxis, axes.yaxis, axes.zaxis), "xyz", strict=True):
        axis.set_major_locator(MultipleLocator(step))
        axis.set_label_text(label(name, "m"))
        # Matplotlib turns it along its axis, where it runs into the numbers.
        axis.set_rotate_label(False)
        axis.labelpad = _LABEL_PAD
        # Those of z stand beside their axis, and would come onto it.
        axis.set_tick_params(pad=0 if name == "z" else _NUMBER_PAD)
    axes.view_init(*view)


def _step(longest: float) -> float:
    """Return 1, 2 or 5 times a power of ten, about a fifth of a length."""
    power = 10.0 ** np.floor(np.log10(longest / 5))
    return float(next(k * power for k in (1, 2, 5, 10) if k * power >= longest / 5))
