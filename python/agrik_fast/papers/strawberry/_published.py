"""What the strawberry paper prints, and what of its set-up had to be fitted or assumed."""

from __future__ import annotations

import csv
from importlib import resources
from typing import Literal

import numpy as np

from ..._checks import FloatArray

Column = Literal["ncos", "ssas", "as", "exact"]
COLUMNS: tuple[Column, ...] = ("ncos", "ssas", "as", "exact")

SPHERE_CENTRE = np.array([0.5, 0.3675, -0.395])
"""Centre of the plant sphere, m; fitted to table 3."""

SPHERE_RADIUS = 0.1
"""Radius of the plant sphere, m; fitted to table 3."""

FIGURE_TARGET = np.array([0.426, 0.345, -0.33161])
"""Target of figures 4 to 6, m."""

TABLE4_TARGETS = np.array([[0.580, 0.310, -0.3779], [0.565, 0.420, -0.3401]])
"""Targets of table 4, m."""

MOTOR_SPEED = 0.374
"""Belt speed, m/s, at the motors' 200 rpm: 22 teeth of 5.1 mm pitch a turn."""

TABLE4_COLUMNS: tuple[Column, ...] = ("ncos", "as", "ssas", "exact")
"""Methods of table 4, and the exact minimum."""

PUBLISHED_TABLE4_S = ({"ncos": 6.0, "as": 4.0, "ssas": 4.0}, {"ncos": 4.0, "as": 6.0, "ssas": 6.0})
"""Execution times of the two targets of table 4, s."""

PUBLISHED_MEANS_S = {"ncos": 5.5, "ssas": 4.95, "as": 4.875}
"""Mean execution times of the 24 experiments, s."""


def published() -> list[dict[str, float]]:
    """Return table 3 as printed, one dict a row: mm, mJ, s and percent."""
    file = resources.files(__package__) / "table3.csv"
    rows = csv.DictReader(file.read_text(encoding="utf-8").splitlines())
    return [{name: float(value) for name, value in row.items()} for row in rows]


def targets(*, printed: bool = False) -> FloatArray:
    """Return the 20 targets of table 3, shape (20, 3), m.

    Parameters
    ----------
    printed : bool, default False
        The z that the table prints, rounded to 0.1 mm, instead of the sphere's, with which
        the published energies were computed.
    """
    rows = published()
    points = np.array([[row["x"], row["y"], row["z"]] for row in rows]) / 1000
    if not printed:
        off = points[:, :2] - SPHERE_CENTRE[:2]
        points[:, 2] = SPHERE_CENTRE[2] + np.sqrt(SPHERE_RADIUS**2 - (off**2).sum(axis=1))
    return points
