"""Defterli and Xu (2017), the strawberry handling arm: its tables and figures.

"Analytical solution of a five-degree-of-freedom inverse kinematics problem for the handling
mechanism of an agricultural robot", Int. J. Mechanisms and Robotic Systems 4(1), 43-60.
"""

from ._experiments import Experiment, execution_time, experiments
from ._mechanism import Terms, energy_terms
from ._problem1 import CORRECTED, Derivatives, Formulas, conditions_hold, derivatives, problem1
from ._published import SPHERE_CENTRE, SPHERE_RADIUS, published, targets
from ._quadrants import Quadrant, quadrant_times
from ._reproduce import reproduce
from ._starts import Guess, guesses, random_targets
from ._tables import Cell, table3
from ._times import Times, time_columns, times_ns

__all__ = [
    "CORRECTED",
    "SPHERE_CENTRE",
    "SPHERE_RADIUS",
    "Cell",
    "Derivatives",
    "Experiment",
    "Formulas",
    "Guess",
    "Quadrant",
    "Terms",
    "Times",
    "conditions_hold",
    "derivatives",
    "energy_terms",
    "execution_time",
    "experiments",
    "guesses",
    "problem1",
    "published",
    "quadrant_times",
    "random_targets",
    "reproduce",
    "table3",
    "targets",
    "time_columns",
    "times_ns",
]
