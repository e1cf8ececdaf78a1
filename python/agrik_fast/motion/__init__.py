"""Motion: ways that are proven free, plans of them, and trajectories that others can play."""

from __future__ import annotations

from ._check import Checked, Contact, Outcome, check, check_segments
from ._goals import Prefer, goals_of
from ._plan import CutProof, PathStatus, Plan, plan
from ._rounded import rounded
from ._settings import Settings
from ._time_law import time_law
from ._trajectory import Trajectory

__all__ = [
    "Checked",
    "Contact",
    "CutProof",
    "Outcome",
    "PathStatus",
    "Plan",
    "Prefer",
    "Settings",
    "Trajectory",
    "check",
    "check_segments",
    "goals_of",
    "plan",
    "rounded",
    "time_law",
]
