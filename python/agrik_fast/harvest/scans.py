"""The two scans of the method by themselves, for tables and pictures."""

from __future__ import annotations

from typing import Any

from .._checks import real_number, shown
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import Robot
from ._plan import checked_settings
from ._settings import Distance, Settings
from ._station import Crop

__all__ = ["approach_scan", "slide_table"]


def _one(
    robot: Robot | str, scene: Scene, target: object, distance: Distance
) -> tuple[Crop, tuple[float, float, float], list[int]]:
    crop = Crop(robot, scene, distance, 3, "equal")
    if not isinstance(target, str):
        raise ArgumentError("target", shown(target), "the name of a target")
    chosen = crop.chosen(target)
    x, y, z = chosen.points[0].tolist()
    return crop, (x, y, z), chosen.objects[0]


def approach_scan(
    robot: Robot | str,
    scene: Scene,
    target: str,
    *,
    settings: Settings | None = None,
    distance: Distance = "exact",
) -> dict[str, Any]:
    """Scan the approach angles of a target with the last links alone.

    Parameters
    ----------
    robot, scene, settings, distance
        As for `harvest.plan`.
    target : str
        Name of a target of the scene.

    Returns
    -------
    dict of ndarray, shape (angles,)
        "psi" (rad), "open" (the gripper is free), "rank" (order of trying, -1 for none),
        "hard" and "soft": distance of the last link's bodies from the crop, and of the wrist's
        other ones with the wrist straight, m.

    Raises
    ------
    ArgumentError, UnknownNameError
        As `harvest.plan`.

    Examples
    --------
    >>> from agrik_fast.harvest import scans
    >>> scan = scans.approach_scan("cucumber", ik.harvest.example_scene(), "C1")
    >>> len(scan["psi"])
    73
    """
    crop, point, objects = _one(robot, scene, target, distance)
    options = checked_settings(settings).as_options()
    return crop.station.approaches(point, objects, options)


def slide_table(
    robot: Robot | str,
    scene: Scene,
    target: str,
    psi: float,
    *,
    tilt: float = 0.0,
    shift: float = 0.0,
    settings: Settings | None = None,
    distance: Distance = "exact",
) -> dict[str, Any]:
    """Return all postures of one approach to a target, one row a place and branch.

    Parameters
    ----------
    robot, scene, settings, distance
        As for `harvest.plan`.
    target : str
        Name of a target of the scene.
    psi : float, rad
        Approach angle.
    tilt : float, default 0, rad
        Of the gripper, up.
    shift : float, default 0, m
        Of the grip point, up.

    Returns
    -------
    dict of ndarray, shape (n,)
        "q" (n, 7), "slide" (m), "branch", "distance" (m), "freedom", "score", "hits_itself",
        "admissible".

    Raises
    ------
    ArgumentError, UnknownNameError
        As `harvest.plan`.

    Examples
    --------
    >>> from agrik_fast.harvest import scans
    >>> table = scans.slide_table("cucumber", ik.harvest.example_scene(), "C1", psi=0.0)
    >>> "slide" in table
    True
    """
    crop, point, objects = _one(robot, scene, target, distance)
    options = checked_settings(settings).as_options()
    angles = (real_number("psi", psi), real_number("tilt", tilt), real_number("shift", shift))
    return crop.station.table(point, objects, *angles, options)
