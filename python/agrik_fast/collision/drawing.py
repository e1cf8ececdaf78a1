"""Scenes, drawn into axes in space; they need Matplotlib."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .. import _bodies
from .._bodies import HalfSpace
from .._checks import FloatArray, items, shown, text
from ..errors import ArgumentError
from ..plots import (
    FIELD,
    PALETTE,
    add_triangles,
    bounds,
    checked_view,
    frame_space,
    is_blank,
    space_or,
    styled,
)
from ..robot import Robot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ._objects import SceneObject

__all__ = ["draw_scene"]

OTHER = PALETTE[5]
MOST_POINTS = 4000
"""Spheres of a crop that a picture in space shows, as points."""
# Solids, all together, that are drawn as triangles; of more spheres the middles are shown.
_MOST_SOLIDS = 150
_SIDES = 12


def draw_scene(axes: Any, scene: Iterable[SceneObject], skip: Iterable[str] = ()) -> None:
    """Add objects to axes in space.

    Parameters
    ----------
    axes : Axes3D
    scene : iterable of SceneObject
        Such as ``Scene.objects``.
    skip : iterable of str, optional
        Kinds of objects that are left out.

    Examples
    --------
    >>> import matplotlib.figure
    >>> from agrik_fast.collision import drawing
    >>> axes = matplotlib.figure.Figure().add_subplot(projection="3d")
    >>> drawing.draw_scene(axes, ik.harvest.example_scene().objects, skip=["machine"])
    >>> len(axes.collections) > 0
    True
    """
    left_out = set(skip)
    shown_ones = [one for one in scene if one.kind not in left_out]
    many = sum(map(len, shown_ones)) > _MOST_SOLIDS
    points: dict[str, list[FloatArray]] = {}
    for one in shown_ones:
        colour = FIELD.get(one.kind, OTHER)
        if many and len(one.spheres):
            points.setdefault(colour, []).append(one.spheres[:, :3])
        rest = replace(one, spheres=np.zeros((0, 4))) if many else one
        for shape in rest.shapes():
            if isinstance(shape, HalfSpace):
                continue  # it has no end, and would hide what stands on it
            add_triangles(axes, *_bodies.surface(shape, _SIDES), colour, 0.6)
    total = sum(len(rows) for each in points.values() for rows in each)
    step = max(1, total // MOST_POINTS)
    for colour, each in points.items():
        rows = np.concatenate(each)[::step]
        axes.scatter(*rows.T, color=colour, s=14, alpha=0.75, linewidths=0, depthshade=True)


@styled
def plot(
    scene: Any, arm: Any, q: ArrayLike | None, skip: Any, view: tuple[float, float], axes: Any
) -> Figure:
    """Draw a scene, and an arm in it; `Scene.plot` documents it."""
    kinds = tuple(text("skip", kind) for kind in items("skip", skip, "kinds of objects"))
    if arm is not None and not isinstance(arm, Robot):
        raise ArgumentError("arm", shown(arm), "a Robot")
    if arm is None and q is not None:
        raise ArgumentError("q", shown(q), "an arm with it")
    angles = checked_view(view)
    drawing, drawn = space_or(axes, 6.5, 5.4)
    blank = is_blank(drawn)
    draw_scene(drawn, scene.objects, kinds)
    points = [np.array(target.point)[None] for target in scene.targets.values()]
    if points:
        places = np.concatenate(points)
        drawn.plot(
            *places.T, "*", color=PALETTE[3], markersize=9, linestyle="none", label="targets"
        )
        drawn.legend(loc="upper left")
    points += [_corners(one) for one in scene.objects if one.kind not in kinds]
    if arm is not None:
        arm.plot(q, axes=drawn)
        points.append(arm.frames_of(arm.home if q is None else q)[..., :3, 3])
    if blank:
        full = [each for each in points if each.size] or [np.zeros((1, 3))]
        low, high = bounds(full)
        frame_space(drawn, low.tolist(), high.tolist(), angles)
    return drawing


def _corners(one: SceneObject) -> FloatArray:
    """Return points that lie round all solids of an object that have an end, shape (k, 3), m."""
    parts = [one.spheres[:, :3] - one.spheres[:, 3:], one.spheres[:, :3] + one.spheres[:, 3:]]
    for end in (0, 3):
        middle = one.capsules[:, end : end + 3]
        parts += [middle - one.capsules[:, 6:], middle + one.capsules[:, 6:]]
    turned = np.abs(one.boxes[:, 6:15].reshape(-1, 3, 3))
    reach = np.einsum("kij,kj->ki", turned, one.boxes[:, 3:6])
    parts += [one.boxes[:, :3] - reach, one.boxes[:, :3] + reach]
    parts += [points for points, _ in one.hulls]
    return np.concatenate(parts)
