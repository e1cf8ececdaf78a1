"""The points of a trajectory, as files and messages hold them."""

from __future__ import annotations

from typing import NamedTuple

from .._checks import FloatArray

__all__ = ["Points"]


class Points(NamedTuple):
    """Joint values, velocities and accelerations by time; one row a point, SI units."""

    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    times: FloatArray
    positions: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
