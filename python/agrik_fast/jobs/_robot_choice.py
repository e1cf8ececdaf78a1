"""The robot of a job, as a file of jobs or a command line names it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._checks import FloatArray
from .._rotations import from_rpy
from ..robot import Robot


@dataclass(frozen=True)
class RobotChoice:
    """Which robot, between which links, with which tool.

    Attributes
    ----------
    robot : str
        A robot's name or a path, as for `Robot.load`.
    base_link, tip_link : str, optional
        First and last link, for URDFs.
    tool : tuple of 3 or 6 float, optional
        Tool in the last link's frame instead of the robot's own: x, y, z (m), and roll, pitch
        and yaw about the fixed x, y and z axes in turn (rad).
    frame : str, optional
        Named frame of the robot in which poses are given.
    """

    robot: str
    base_link: str | None = None
    tip_link: str | None = None
    tool: tuple[float, ...] | None = None
    frame: str | None = None

    def load(self) -> Robot:
        """Return the robot.

        Raises
        ------
        AgrikError
            As `Robot.load`.
        """
        tool = None if self.tool is None else _transform(self.tool)
        return Robot.load(self.robot, self.base_link, self.tip_link, tool=tool, frame=self.frame)

    def words(self) -> dict[str, str]:
        """Return what was chosen beside the robot, for a result's metadata."""
        tool = None if self.tool is None else ",".join(map(repr, self.tool))
        chosen = {
            "base_link": self.base_link,
            "tip_link": self.tip_link,
            "tool": tool,
            "frame": self.frame,
        }
        return {name: value for name, value in chosen.items() if value is not None}


def _transform(numbers: tuple[float, ...]) -> FloatArray:
    pose = np.eye(4)
    pose[:3, 3] = numbers[:3]
    if len(numbers) == 6:
        pose[:3, :3] = from_rpy(np.array(numbers[3:]))
    return pose
