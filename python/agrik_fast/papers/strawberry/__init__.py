"""Defterli and Xu (2017), the strawberry handling arm: its tables and figures.

"Analytical solution of a five-degree-of-freedom inverse kinematics problem for the handling
mechanism of an agricultural robot", Int. J. Mechanisms and Robotic Systems 4(1), 43-60.
"""

from ._experiments import Experiment, execution_time, experiments
from ._published import SPHERE_CENTRE, SPHERE_RADIUS, published, targets
from ._reproduce import reproduce
from ._tables import Cell, table3

__all__ = [
    "SPHERE_CENTRE",
    "SPHERE_RADIUS",
    "Cell",
    "Experiment",
    "execution_time",
    "experiments",
    "published",
    "reproduce",
    "table3",
    "targets",
]
