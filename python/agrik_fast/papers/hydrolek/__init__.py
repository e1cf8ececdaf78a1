"""The HydroLek paper: Table II, figures 2 to 7, success counts, units, singular starts.

Burrell, Montazeri, Monk and Taylor, "Feedback Control-Based Inverse Kinematics Solvers for
a Nuclear Decommissioning Robot". Every number is computed when `reproduce` is called;
what the paper prints stands beside it.
"""

from ._edge import Lost, edge_solvers, lost_goals
from ._pose import LENGTHS_M, POSE_TOLERANCE, PoseRow, pose_solvers, success_by_weight
from ._printed import Reading, Run, algorithm1, printed_fk
from ._published import PLANAR_DEG, SUCCESS, TABLE_2_MS
from ._reproduce import reproduce
from ._robots import OTHERS, RobotRow, gains_of, tuned_robots
from ._singular import (
    DISTANCES,
    least_singular_value,
    least_within_limits,
    singular_postures,
    singularity_study,
    unlimited,
)
from ._stability import Stability, spectral_radius, stability
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
from ._workspace import Edge

__all__ = [
    "DISTANCES",
    "LENGTHS_M",
    "OTHERS",
    "PLANAR_DEG",
    "POSE_TOLERANCE",
    "SUCCESS",
    "TABLE_2_COLUMNS",
    "TABLE_2_MS",
    "Edge",
    "Lost",
    "PoseRow",
    "Reading",
    "RobotRow",
    "Run",
    "Stability",
    "algorithm1",
    "comparison",
    "displaced_goal",
    "edge_solvers",
    "error_trace",
    "gains_of",
    "least_singular_value",
    "least_within_limits",
    "lost_goals",
    "methods",
    "planar_arm",
    "planar_claim",
    "pose_solvers",
    "printed_fk",
    "reproduce",
    "singular_postures",
    "singular_start",
    "singularity_study",
    "spectral_radius",
    "stability",
    "success_by_weight",
    "success_counts",
    "tuned_robots",
    "units",
    "unlimited",
]
