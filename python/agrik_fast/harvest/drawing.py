"""Crops and arms, drawn into axes in space; they need Matplotlib."""

from __future__ import annotations

from typing import Any

from .._checks import FloatArray
from ..plots import PALETTE, add_triangles
from ..robot import Robot

__all__ = ["ARM", "draw_arm"]

ARM = PALETTE[4]
"""Colour of an arm's bodies."""


def draw_arm(axes: Any, robot: Robot, q: FloatArray, colour: str = ARM, alpha: float = 0.6) -> None:
    """Add the bodies of an arm that move to axes in space, at a posture.

    Parameters
    ----------
    axes : Axes3D
    robot : Robot
    q : ndarray, shape (n,), rad and m
    colour : str, optional
    alpha : float, default 0.6

    Examples
    --------
    >>> import matplotlib.figure
    >>> from agrik_fast.harvest import drawing
    >>> axes = matplotlib.figure.Figure().add_subplot(projection="3d")
    >>> arm = ik.Robot.load("cucumber")
    >>> drawing.draw_arm(axes, arm, arm.home)
    >>> len(axes.collections) > 0
    True
    """
    frames = robot.frames_of(q)
    for each in robot.surfaces("bodies"):
        if each.frame > 0:
            add_triangles(axes, each.placed(frames), each.faces, colour, alpha)
