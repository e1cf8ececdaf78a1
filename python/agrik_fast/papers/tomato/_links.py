"""The claim that more degrees of freedom need more torque, over the number of links."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arms import Load, PointMass, gravity_torques
from ...plots import PAGE_WIDTH, figure, styled
from ...robot import Robot
from .._output import save, write_csv

LINK = 0.16
"""Length of a link, m, as the tomato arm's."""

MOST_LINKS = 8


class Torque(NamedTuple):
    """What the first joint of a level arm holds.

    Attributes
    ----------
    links : int
        Links of one arm.
    longer : float, N m
        Every link 0.16 m long and 32 g heavy: the arm grows.
    divided : float, N m
        The two links' 0.32 m and 64 g are shared out among the links.
    divided_without_motors : float, N m
        The same, with motors that weigh nothing.
    """

    links: int
    longer: float
    divided: float
    divided_without_motors: float


def level_torque(links: int, link: float, mass: float, motor: float, payload: float) -> float:
    """Return the torque (N m) of the first joint of a planar arm, stretched out level.

    Parameters
    ----------
    links : int
        Links of the arm, each with a joint at its beginning.
    link : float, m
        Length of a link.
    mass : float, kg
        Mass of a link, in its middle.
    motor : float, kg
        Mass of the motor of every joint but the first.
    payload : float, kg
        Mass at the tool point.
    """
    arm = Robot.from_dh([(link, 0.0, 0.0, 0.0)] * links, name="planar")
    masses = [PointMass(link="tool", mass=payload)]
    # A standard DH link's frame is at its end.
    middle = (-link / 2, 0.0, 0.0)
    masses += [PointMass(link=name, mass=mass, position=middle) for name in arm.link_names[:links]]
    masses += [PointMass(link=name, mass=motor) for name in arm.link_names[: links - 1]]
    held = gravity_torques(arm, np.zeros(links), masses, up=(0.0, 1.0, 0.0))
    return float(held[0])


def torques_by_links() -> list[Torque]:
    """Return what one to eight links need, with the masses of `Load`."""
    load = Load()
    rows = []
    for links in range(1, MOST_LINKS + 1):
        part, mass = 2 * LINK / links, 2 * load.link1 / links
        rows.append(
            Torque(
                links,
                level_torque(links, LINK, load.link1, load.motor, load.payload),
                level_torque(links, part, mass, load.motor, load.payload),
                level_torque(links, part, mass, 0.0, load.payload),
            )
        )
    return rows


@styled
def write_links(directory: Path) -> list[Path]:
    """Write and draw the torques by the number of links; return the files."""
    rows = torques_by_links()
    drawing = figure(PAGE_WIDTH, 3.0)
    axes = drawing.subplots()
    number = [row.links for row in rows]
    curves = {
        "every link 0.16 m, a motor at each joint": "longer",
        "0.32 m shared out, a motor at each joint": "divided",
        "0.32 m shared out, motors without mass": "divided_without_motors",
    }
    for (label, field), mark in zip(curves.items(), "os^", strict=True):
        axes.semilogy(number, [getattr(row, field) for row in rows], f"{mark}-", ms=4, label=label)
    axes.set_xlabel("links (degrees of freedom)")
    axes.set_ylabel("torque of the first joint [N m]")
    axes.legend()
    header = [
        "links",
        "torque_longer_nm",
        "torque_divided_nm",
        "torque_divided_without_motors_nm",
    ]
    lines = [(row.links, *(f"{x:.4f}" for x in row[1:])) for row in rows]
    return [
        write_csv(directory / "links.csv", header, lines),
        *save(drawing, directory, "links"),
    ]
