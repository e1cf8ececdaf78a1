"""What the cucumber paper prints: costs, times and field results."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["FIELD", "GENETIC", "Field", "Genetic"]


class Genetic(NamedTuple):
    """One run of the paper's genetic algorithm.

    Attributes
    ----------
    figure : str
        Where its posture is shown.
    cost : float
        J of equation (3).
    generations : int
    seconds : float
        Matlab, a PC of 2000.
    """

    figure: str
    cost: float
    generations: int
    seconds: float


GENETIC = (Genetic("5a", 0.0001467, 170, 750.0), Genetic("5b", 0.0099359, 1500, 6500.0))
"""The two runs that the text names."""


class Field(NamedTuple):
    """Results of the field test.

    Attributes
    ----------
    success : float
        Share of cucumbers harvested.
    cycle : float
        A successful cycle, s.
    per_cucumber : float
        Time per harvested cucumber, up to three attempts, s.
    motion : float
        Inverse kinematics, motion planning and execution, s.
    two_step : float
        The two-step method took less, s.
    """

    success: float
    cycle: float
    per_cucumber: float
    motion: float
    two_step: float


FIELD = Field(0.744, 65.2, 124.0, 12.5, 1.0)
"""Section 6 and the introduction."""
