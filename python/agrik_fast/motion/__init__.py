"""Motion: ways that are proven free, plans of them, and trajectories that others can play."""

from __future__ import annotations

from ._blockers import Fewest, PathBlockers, blockers
from ._check import Checked, Contact, Outcome, check, check_segments
from ._errors import Errors
from ._goals import Prefer, goals_of
from ._path_errors import PathSensitivity, path_sensitivity
from ._plan import CutProof, PathStatus, Plan, plan
from ._risks import Risks
from ._rounded import rounded
from ._sensitivity import Sensitivity, sensitivity
from ._settings import Settings
from ._simulate import Simulated, simulate
from ._time_law import time_law
from ._trajectory import Trajectory

__all__ = [
    "Checked",
    "Contact",
    "CutProof",
    "Errors",
    "Fewest",
    "Outcome",
    "PathBlockers",
    "PathSensitivity",
    "PathStatus",
    "Plan",
    "Prefer",
    "Risks",
    "Sensitivity",
    "Settings",
    "Simulated",
    "Trajectory",
    "blockers",
    "check",
    "check_segments",
    "goals_of",
    "path_sensitivity",
    "plan",
    "rounded",
    "sensitivity",
    "simulate",
    "time_law",
]
