"""Motion: when an arm is where on its way, and trajectories that others can play."""

from __future__ import annotations

from ._errors import Errors
from ._path_errors import PathSensitivity, path_sensitivity
from ._sensitivity import Sensitivity, Simulated, sensitivity, simulate
from ._time_law import time_law
from ._trajectory import Trajectory

__all__ = [
    "Errors",
    "PathSensitivity",
    "Sensitivity",
    "Simulated",
    "Trajectory",
    "path_sensitivity",
    "sensitivity",
    "simulate",
    "time_law",
]
