"""The part of `Robot` that is looked at: its surfaces, and pictures of postures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from .. import _bodies
from .._checks import FloatArray, float_array, shown, word
from .._warnings import warn
from ..errors import ArgumentError, RobotWarning, UrdfError
from ..plots import (
    GREY,
    PALETTE,
    add_frame,
    add_triangles,
    bounds,
    checked_view,
    frame_space,
    is_blank,
    space_or,
    styled,
)
from ._surfaces import LOOKS, Look, Surface, frames_of, surfaces

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from . import Robot
    from ._definition import Definition

__all__ = ["COLOURS", "Drawing"]

COLOURS = {
    "base": "#555555",
    "link": PALETTE[4],
    "joint": "#444444",
    "rail": GREY,
    "carriage": "#444444",
    "finger": PALETTE[2],
    "body": PALETTE[4],
    "visual": "#b8bcc2",
}
"""Colours of the roles of surfaces."""
# Postures of a batch that a picture shows: those behind the last are pale.
_MOST = 60
_PALE = 0.12


class Drawing:
    """The part of `Robot` that is looked at."""

    __slots__ = ()

    _definition: Definition

    @property
    def has_visuals(self) -> bool:
        """Whether it came from a URDF that says what its links look like."""
        return self._definition.looks is not None and _bodies.has_visuals(self._definition.looks)

    def visuals(self) -> tuple[_bodies.Visual, ...]:
        """Return the triangles of a URDF's ``<visual>`` elements; none for other robots.

        Raises
        ------
        UrdfError
            A mesh is missing (says where it was looked for) or broken.

        Examples
        --------
        >>> ik.Robot.load("panda").visuals()
        ()
        """
        looks = self._definition.looks
        return () if looks is None else _bodies.visuals(looks, cast("Robot", self).link_names)

    def surfaces(self, show: Look = "auto") -> tuple[Surface, ...]:
        """Return what the arm looks like, as triangles that stand still in its frames.

        Parameters
        ----------
        show : {"auto", "chain", "bodies", "visuals"}, default "auto"
            The chain as solids: cylinders for links and for joints that turn, rails as long as
            their limits, with carriages, for those that slide; the bodies for collisions; the
            visual geometry of a URDF; or of these the last if there is one, else the first.

        Returns
        -------
        tuple of Surface

        Raises
        ------
        UnknownNameError
            Another word.
        ArgumentError
            The robot has no bodies, or no visual geometry.
        UrdfError
            With "visuals": a mesh is missing or broken.

        Warns
        -----
        RobotWarning
            With "auto": meshes that cannot be read, so that the chain is shown.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> sorted({each.role for each in Robot.load("cucumber").surfaces()})
        ['carriage', 'joint', 'link', 'rail']
        """
        word("show", show, LOOKS)
        robot = cast("Robot", self)
        if show == "auto" and self.has_visuals:
            try:
                return surfaces(robot, "visuals")
            except UrdfError as error:
                warn(f"{robot.name}: {error}; its chain is shown", RobotWarning)
                return surfaces(robot, "chain")
        return surfaces(robot, show)

    def frames_of(self, q: ArrayLike) -> FloatArray:
        """Return the frames that `surfaces` stand still in.

        Parameters
        ----------
        q : array_like, shape (..., n), rad or m
            Joint values.

        Returns
        -------
        ndarray, shape (..., links + 1, 4, 4), m
            The base, then the links in the order of `Robot.link_names`, in the base frame.

        Raises
        ------
        ArgumentError
            `q` has another last dimension or holds no numbers.

        Examples
        --------
        >>> arm = ik.Robot.load("panda")
        >>> len(arm.frames_of(arm.home)) == len(arm.link_names) + 1
        True
        """
        return frames_of(cast("Robot", self), float_array("q", q))

    @styled
    def plot(
        self,
        q: ArrayLike | None = None,
        *,
        show: Look = "auto",
        targets: ArrayLike | None = None,
        view: tuple[float, float] = (22.0, -60.0),
        axes: Any = None,
    ) -> Figure:
        """Draw the arm in space; needs the extra ``plots``.

        Parameters
        ----------
        q : array_like, shape (..., n), rad or m, optional
            Posture; of several the last is drawn in full, the others (no more than 60) pale,
            with the way of the tool point between them. Default: `home`.
        show : {"auto", "chain", "bodies", "visuals"}, default "auto"
            What it is shown as, see `surfaces`.
        targets : array_like, shape (..., 3) or (..., 4, 4), m, optional
            Positions or poses that are marked.
        view : (float, float), default (22, -60)
            Elevation and azimuth that it is seen from, deg.
        axes : Axes3D, optional
            Where to draw; default: a new figure as wide as a page. Axes that hold nothing get
            limits, names and the view; others keep theirs.

        Returns
        -------
        matplotlib.figure.Figure
            The figure, which belongs to no window.

        Raises
        ------
        ArgumentError
            A wrong shape, a joint value that is not finite, and as `surfaces`.
        MissingExtraError
            Matplotlib is not installed.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> arm = Robot.load("redundant7")
        >>> picture = arm.plot(arm.home, targets=[0.3, 0.2, 0.5])
        >>> [axes.get_xlabel() for axes in picture.axes]
        ['x [m]']
        """
        robot = cast("Robot", self)
        values = float_array("q", robot.home if q is None else q)
        if values.shape[-1:] != (robot.dof,) or not values.size or not np.isfinite(values).all():
            expected = f"finite numbers of shape (..., {robot.dof})"
            raise ArgumentError("q", shown(q), expected)
        rows = values.reshape(-1, robot.dof)
        parts = self.surfaces(show)
        angles = checked_view(view)
        drawing, drawn = space_or(axes, 6.5, 5.2)
        blank = is_blank(drawn)
        frames = self.frames_of(rows)
        tips = frames[:, -1, :3, 3]
        points = [tips, frames[-1][:, :3, 3]]
        chosen = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), _MOST)).astype(int))
        for row in chosen.tolist():
            alpha = 1.0 if row == chosen[-1] else _PALE
            for each in parts:
                corners = each.placed(frames[row])
                colour = each.colour or COLOURS[each.role]
                add_triangles(drawn, corners, each.faces, colour, alpha)
                points.append(corners)
        if len(rows) > 1:
            drawn.plot(*tips.T, color=PALETTE[0], linewidth=1.4, label="way of the tool point")
        add_frame(drawn, frames[-1][-1], 0.12 * robot.reach_radius)
        if targets is not None:
            places = _places(targets)
            drawn.plot(
                *places.T, "*", color=PALETTE[3], markersize=9, label="targets", linestyle="none"
            )
            points.append(places)
        if len(rows) > 1 or targets is not None:
            drawn.legend(loc="upper left")
        if blank:
            low, high = bounds(points)
            frame_space(drawn, low.tolist(), high.tolist(), angles)
        return drawing


def _places(targets: ArrayLike) -> FloatArray:
    given = float_array("targets", targets)
    if given.ndim >= 2 and given.shape[-2:] == (4, 4):
        given = given[..., :3, 3]
    if given.ndim < 1 or given.shape[-1] != 3 or not np.isfinite(given).all():
        raise ArgumentError("targets", shown(targets), "shape (..., 3) or (..., 4, 4), finite")
    return given.reshape(-1, 3)
