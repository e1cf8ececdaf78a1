"""Where the tool point can be, as points with a colour: the whole, or a slice of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from ..collision import Scene
from ..robot import Robot

QUANTITIES = ("reachable", "manipulability", "clearance")
PLANES = ("x", "y", "z")
HALF = 0.02
"""How far from the plane of a slice points are still shown, m."""
# Dark blue, grey, yellow: told apart without red and green, and in print.
_COLOURS = np.array([[0, 34, 78], [124, 123, 120], [254, 232, 56]], dtype=float)
_PLAIN = np.array([86, 180, 233], dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Reach:
    """Points that the tool reaches.

    Attributes
    ----------
    places : ndarray, shape (n, 3), m
    colours : ndarray of uint8, shape (n, 3)
    words : str
        What the colours mean.
    """

    places: FloatArray
    colours: NDArray[np.uint8]
    words: str

    def slice(self, plane: str, at: float) -> Reach:
        """Return the points within 2 cm of a plane across x, y or z, m."""
        near = np.abs(self.places[:, PLANES.index(plane)] - at) <= HALF
        return Reach(self.places[near], self.colours[near], self.words)


def reach(robot: Robot, count: int, quantity: str, scene: Scene | None) -> Reach:
    """Return where the tool is at random postures within the limits.

    Parameters
    ----------
    robot : Robot
    count : int
    quantity : {"reachable", "manipulability", "clearance"}
        What colours say: nothing; how far the arm is from being stuck in a direction; how far it
        is from the scene and from itself.
    scene : Scene or None
        None: clearance is not known.
    """
    q = robot.random_q(count, seed=0)
    places = robot.fk(q)[:, :3, 3]
    if quantity == "manipulability":
        # Of the tool point: the volume of what it can do at unit speed of the joints.
        motion = robot.jacobian(q)[:, :3]
        value = np.sqrt(np.maximum(np.linalg.det(motion @ motion.transpose(0, 2, 1)), 0.0))
        unit = "no unit"
    elif quantity == "clearance" and scene is not None:
        value = np.clip(scene.clearance(robot, q, own=True, cap=0.3), 0.0, None)
        unit = "m"
    else:
        words = f"{count:,} postures within the limits"
        if quantity == "clearance":
            words += "; no clearance: the arm has no bodies"
        return Reach(places, np.tile(_PLAIN, (count, 1)), words)
    high = float(np.quantile(value, 0.98)) or 1.0
    share = np.clip(value / high, 0.0, 1.0) * (len(_COLOURS) - 1)
    low = np.minimum(share.astype(int), len(_COLOURS) - 2)
    mixed = _COLOURS[low] + (share - low)[:, None] * (_COLOURS[low + 1] - _COLOURS[low])
    words = f"{quantity}: dark blue 0, yellow {high:.2g} or more [{unit}]"
    return Reach(places, mixed.astype(np.uint8), words)
