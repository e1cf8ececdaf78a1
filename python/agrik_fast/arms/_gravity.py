"""What the joints of any arm have to hold against gravity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, direction, finite_array, float_array, real_number, shown, word
from ..errors import ArgumentError
from ..robot import Robot

__all__ = ["PointMass", "gravity_torques"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PointMass:
    """A mass that a link carries: its own, a motor, a load.

    Parameters
    ----------
    link : str
        One of ``Robot.link_names``.
    mass : float, kg
        Mass.
    position : tuple of 3 float, default (0, 0, 0), m
        Its centre in the link's frame.

    Raises
    ------
    ArgumentError
        A name that is none, a mass below 0, or a position that is not three finite numbers.

    Examples
    --------
    >>> from agrik_fast.arms import PointMass, gravity_torques
    >>> arm = ik.Robot.load("ur5")
    >>> gravity_torques(arm, arm.home, [PointMass(link="tool", mass=2.0)]).shape
    (6,)
    """

    link: str
    mass: float
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        link: object = self.link
        if not isinstance(link, str):
            raise ArgumentError("PointMass.link", shown(link), "the name of a link")
        real_number("PointMass.mass", self.mass, 0, unit="kg")
        place = finite_array("PointMass.position", self.position, (3,))
        object.__setattr__(self, "position", tuple(place.tolist()))


def gravity_torques(
    robot: Robot,
    q: ArrayLike,
    masses: Sequence[PointMass],
    *,
    gravity: float = 9.80665,
    up: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> FloatArray:
    """Return what each joint has to hold, for a chain of any length.

    The derivative of the masses' potential energy by each joint value: a torque for a
    revolute joint, a force for a prismatic one. For the tomato arm these are (1) to (4) of
    Kviesis and Osadcuks.

    Parameters
    ----------
    robot : Robot
        The arm.
    q : array_like, shape (..., n), rad or m
        Joint values.
    masses : sequence of PointMass
        What its links carry.
    gravity : float, default 9.80665, m/s^2
        Gravity.
    up : tuple of 3 float, default (0, 0, 1)
        Direction against gravity in the base frame, of any length but zero.

    Returns
    -------
    ndarray, shape (..., n), N m or N
        Positive where the joint has to push towards greater values.

    Raises
    ------
    ArgumentError
        A wrong shape or number.
    UnknownNameError
        A mass hangs on a link that the robot does not have.

    Examples
    --------
    >>> from agrik_fast import Robot
    >>> from agrik_fast.arms import PointMass, gravity_torques
    >>> arm = Robot.load("tomato")
    >>> load = PointMass(link="tool", mass=0.05)
    >>> gravity_torques(arm, [0.0, 0.0, 0.0], [load]).round(4).tolist()
    [0.1569, 0.0785, 0.0]
    """
    gravity = real_number("gravity", gravity, 0, unit="m/s^2")
    upward = np.array(direction("up", up))
    values = float_array("q", q)
    if values.ndim == 0 or values.shape[-1] != robot.dof:
        raise ArgumentError("q", f"shape {values.shape}", f"shape (..., {robot.dof})")
    links = list(robot.link_names)
    listed: object = masses
    if not isinstance(listed, list | tuple):
        raise ArgumentError("masses", shown(listed), "a list or tuple of PointMass objects")
    for each in masses:
        given: object = each
        if not isinstance(given, PointMass):
            raise ArgumentError("masses", shown(given), "PointMass objects")
        word("link", each.link, links)
    moved = _moved_links(robot)
    frames = robot.fk_links(values)
    jacobian = robot.jacobian(values)
    tool = frames[..., -1, :3, 3]
    held = np.zeros(values.shape)
    for each in masses:
        link = links.index(each.link)
        frame = frames[..., link, :, :]
        point = frame[..., :3, :3] @ np.array(each.position) + frame[..., :3, 3]
        # As fast as the tool, but for the turn about it.
        turn = np.cross(jacobian[..., 3:, :], (point - tool)[..., :, None], axis=-2)
        speed = np.einsum("k,...kn->...n", upward, jacobian[..., :3, :] + turn)
        held += each.mass * gravity * np.where(moved[link], speed, 0.0)
    return held


def _moved_links(robot: Robot) -> NDArray[np.bool_]:
    """Return which joint moves which link, shape (links, n)."""

    def steps(q: FloatArray) -> FloatArray:
        """Return each link's frame in that of the link before it."""
        frames = np.concatenate([np.eye(4)[None], robot.fk_links(q)])
        return np.linalg.solve(frames[:-1], frames[1:])

    q = np.zeros(robot.dof)
    still = steps(q)
    changed = [np.abs(steps(q + unit) - still).max((1, 2)) > 1e-9 for unit in np.eye(robot.dof)]
    if np.sum(changed, axis=1).max() > 1:
        raise ArgumentError("robot", repr(robot), "a chain without joints that follow others")
    return np.logical_or.accumulate(np.transpose(changed), axis=0)
