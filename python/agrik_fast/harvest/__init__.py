"""Harvest postures: whether an arm can pick a fruit among leaves, and how."""

from ._crops import CropsJob
from ._cutter import Cut, Cutter, cuts, with_cutter
from ._cycle import Cycle, Leg, cycle
from ._decisions import Attempt, Decision, Decisions, Stage, Status
from ._evaluate import Evaluation, evaluate
from ._plan import Blockers, blockers, plan
from ._programme import Programme, Runs, Terms, Weights
from ._report import summary, write_report
from ._scenes import SCENES, example_scene
from ._sensitivity import Errors, Sensitivity, Simulated, sensitivity, simulate
from ._settings import Distance, Settings

__all__ = [
    "SCENES",
    "Attempt",
    "Blockers",
    "CropsJob",
    "Cut",
    "Cutter",
    "Cycle",
    "Decision",
    "Decisions",
    "Distance",
    "Errors",
    "Evaluation",
    "Leg",
    "Programme",
    "Runs",
    "Sensitivity",
    "Settings",
    "Simulated",
    "Stage",
    "Status",
    "Terms",
    "Weights",
    "blockers",
    "cuts",
    "cycle",
    "evaluate",
    "example_scene",
    "plan",
    "sensitivity",
    "simulate",
    "summary",
    "with_cutter",
    "write_report",
]
