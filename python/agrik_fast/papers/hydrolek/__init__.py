"""The HydroLek paper: Table II, figures 4 to 7, success counts, units, singular start.

Burrell, Montazeri, Monk and Taylor, "Feedback Control-Based Inverse Kinematics Solvers for
a Nuclear Decommissioning Robot". Every number is computed when `reproduce` is called;
what the paper prints stands beside it.
"""

from ._reproduce import reproduce
from ._tables import (
    TABLE_2_COLUMNS,
    comparison,
    displaced_goal,
    error_trace,
    methods,
    planar_arm,
    planar_claim,
    singular_start,
    success_counts,
    units,
)

__all__ = [
    "TABLE_2_COLUMNS",
    "comparison",
    "displaced_goal",
    "error_trace",
    "methods",
    "planar_arm",
    "planar_claim",
    "reproduce",
    "singular_start",
    "success_counts",
    "units",
]
