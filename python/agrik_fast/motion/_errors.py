"""Sizes of errors, and which lengths of an arm can have one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, real_number
from ..robot import Robot

__all__ = ["Errors", "Lengths"]

# Descriptions have rounding where they mean 0, m.
_NOTHING = 1e-9


@dataclass(frozen=True)
class Errors:
    """Sizes of errors, as standard deviations; all assumed unless measured.

    Parameters
    ----------
    joint : float, default 0.1 degrees, rad
        Of turning joints: encoder offsets.
    slide : float, default 0.5e-3, m
        Of sliding joints.
    length : float, default 0.5e-3, m
        Of each length of the arm that is not zero: those of its Denavit-Hartenberg rows or
        of its joints' origins, and the tool's along its own z axis.
    backlash : float, default 0, rad
        Play of turning joints, all of it. It counts as even unless the direction of the last
        move is given (``moving``): a joint then stands half of it behind.
    vision : float, default 5e-3, m
        Of where the scene is seen, in each direction; it is off as a whole.
    camera : float, default 0, rad
        Of the camera's orientation about each axis, about the base.

    Raises
    ------
    ArgumentError
        A number that is negative or not finite.

    Examples
    --------
    >>> from agrik_fast.motion import Errors
    >>> Errors(vision=2e-3).length
    0.0005
    """

    joint: float = math.radians(0.1)
    slide: float = 0.5e-3
    length: float = 0.5e-3
    backlash: float = 0.0
    vision: float = 5e-3
    camera: float = 0.0

    def __post_init__(self) -> None:
        for name in ("joint", "slide", "length", "backlash", "vision", "camera"):
            real_number(name, getattr(self, name), 0.0)

    def joints(self, robot: Robot) -> FloatArray:
        """Return the standard deviation of each joint value, rad or m; play counts as even.

        Examples
        --------
        >>> from agrik_fast import Robot, motion
        >>> motion.Errors(slide=0.001).joints(Robot.load("cucumber")).shape
        (7,)
        """
        turning = math.hypot(self.joint, self.backlash / math.sqrt(12))
        slides = np.array([kind == "prismatic" for kind in robot.joint_types])
        return np.where(slides, self.slide, turning)


class Lengths:
    """The lengths of an arm that are not zero, and their directions.

    Attributes
    ----------
    frames : ndarray of int, shape (n,)
        The first frame, counted as those of bodies are, that each length moves.
    """

    __slots__ = ("_axes", "_base", "_robot", "frames")

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._base = robot.base
        # Frame in which the direction stands, its axis, first frame that moves.
        rows: list[tuple[int, int, int]] = []
        origins = self._origins()
        if robot.dh is not None:
            # d along z before the joint turns, a along x before (modified) or behind it.
            modified = robot.convention == "modified"
            for k, row in enumerate(robot.dh):
                if row.a:
                    rows.append((k if modified else k + 1, 0, k + 1))
                if row.d:
                    rows.append((k + 1 if modified else k, 2, k + 1))
        else:
            for k, axis in np.argwhere(np.abs(origins[:-1]) > _NOTHING).tolist():
                rows.append((k, axis, k + 1))
        last = len(robot.link_names)
        if abs(origins[-1, 2]) > _NOTHING:
            rows.append((last - 1, 2, last))
        self._axes = [(frame, axis) for frame, axis, _ in rows]
        self.frames: NDArray[np.int64] = np.array([first for *_, first in rows], dtype=np.int64)

    def _origins(self) -> FloatArray:
        """Return where each frame of the robot at zero is in the one before, shape (n, 3), m."""
        poses = self._robot.fk_links(np.zeros(self._robot.dof))
        before = np.concatenate([self._base[None], poses[:-1]])
        ways = poses[:, :3, 3] - before[:, :3, 3]
        return np.asarray(np.einsum("kxy,kx->ky", before[:, :3, :3], ways))

    def directions(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the direction of each length, shape (n, lengths, 3), and the tool points."""
        poses = self._robot.fk_links(q)
        base = np.broadcast_to(self._base, (len(q), 1, 4, 4))
        before = np.concatenate([base, poses], axis=1)
        if not self._axes:
            return np.zeros((len(q), 0, 3)), poses[:, -1, :3, 3]
        each = [before[:, frame, :3, axis] for frame, axis in self._axes]
        return np.stack(each, axis=1), poses[:, -1, :3, 3]
