"""Motion: when an arm is where on its way, and trajectories that others can play."""

from __future__ import annotations

from ._time_law import time_law
from ._trajectory import Trajectory

__all__ = ["Trajectory", "time_law"]
