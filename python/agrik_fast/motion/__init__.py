"""Ways of an arm among things that are proven free, and plans of them."""

from ._check import Checked, Contact, Outcome, check, check_segments
from ._goals import Prefer, goals_of
from ._plan import CutProof, PathStatus, Plan, plan
from ._settings import Settings

__all__ = [
    "Checked",
    "Contact",
    "CutProof",
    "Outcome",
    "PathStatus",
    "Plan",
    "Prefer",
    "Settings",
    "check",
    "check_segments",
    "goals_of",
    "plan",
]
