"""Arms and scenes that are given as they are, by name or as files."""

from __future__ import annotations

from os import PathLike

from ..collision import Scene
from ..robot import Robot


def load(robot: Robot | str | PathLike[str]) -> tuple[Robot, str]:
    """Return an arm, and what it is loaded by."""
    if isinstance(robot, Robot):
        return robot, robot.name
    return Robot.load(robot), str(robot)


def load_scene(scene: Scene | str | PathLike[str] | None) -> Scene | None:
    """Return a scene of a file, or as it is."""
    if scene is None or isinstance(scene, Scene):
        return scene
    return Scene.load(scene)
