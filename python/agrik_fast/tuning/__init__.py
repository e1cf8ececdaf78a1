"""Tuning: finds the gains of a feedback solver for a robot.

Particle swarms or CMA-ES, run in the compiled core, lower the mean cost over training
goals: a tenth of a point per hundred steps; for a goal that is missed ten points and
twenty per metre that is left. The best of them is refined by CMA-ES on four times as many
goals of another stream, too many to learn by heart. What is kept is chosen on goals of a
third stream, and tried on goals of a fourth.
"""

from ._plan import Tuning, template
from ._search import Report, trials, tune

__all__ = ["Report", "Tuning", "template", "trials", "tune"]
