"""Kviesis and Osadcuks, the tomato pointing arm: its table, figures and torques.

"Development of robot manipulator and motion control using inverse kinematics for robotized
vegetable harvesting". The paper prints neither link lengths nor start, targets, step or
tolerance; what is needed of these is a fit or a choice of ours and named as such.
"""

from ._links import Torque, level_torque, torques_by_links
from ._lost import ALPHAS, MAPS, Map, Sweep, lost_targets, sweep
from ._published import PUBLISHED, Published
from ._reproduce import reproduce
from ._tables import FITS, ErrorSizes, Row, monte_carlo, table1, targets
from ._torques import TorqueRow, printed_torques, torque_rows
from ._vision import Attempt, attempts, grid, latency

__all__ = [
    "ALPHAS",
    "FITS",
    "MAPS",
    "PUBLISHED",
    "Attempt",
    "ErrorSizes",
    "Map",
    "Published",
    "Row",
    "Sweep",
    "Torque",
    "TorqueRow",
    "attempts",
    "grid",
    "latency",
    "level_torque",
    "lost_targets",
    "monte_carlo",
    "printed_torques",
    "reproduce",
    "sweep",
    "table1",
    "targets",
    "torque_rows",
    "torques_by_links",
]
