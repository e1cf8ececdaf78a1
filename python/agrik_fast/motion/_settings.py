"""How a path is looked for."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from .._checks import real_number, shown, truth_value, whole_number
from ..errors import ArgumentError

__all__ = ["Settings", "checked_settings"]


@dataclass(frozen=True)
class Settings:
    """Settings of a plan.

    Parameters
    ----------
    clear : float, default 0.002, m
        Distance that the path keeps from the scene.
    own_clear : float, optional, m
        Distance that bodies of the arm keep from each other. Default: `clear`, 2 mm at most.
    cap : float, default 0.05, m
        Up to where the distance that the path keeps is told.
    n_goals : int, default 12
        Goals that are tried: the best, then those that are farthest from all before.
    step : float, default 0.3, m
        Longest step of a tree, in the metric of the joints: a slide counts as it is, a turn as
        far as it moves what is farthest from its axis.
    rounds : int, default 400
        Rounds of the trees, eight extensions each.
    max_checks : int, default 300000
        Questions for the whole plan: one a body or a pair of bodies at one posture.
    shortcuts : int, default 60
        Tries to make a path of the trees shorter.
    retreats : bool, default True
        Look for straight lines of the tool backwards out of the goals.
    prove : bool, default True
        Where no path is found, look for a proof that there is none.
    seed : int, default 0
        Which random numbers are drawn.
    time_limit : float, optional, s
        A plan that takes longer ends with ``TIME_LIMIT``. Answers then depend on the machine.

    Raises
    ------
    ArgumentError
        A number out of its range.

    Examples
    --------
    >>> from agrik_fast.motion import Settings
    >>> Settings(clear=0.005, seed=3).n_goals
    12
    """

    clear: float = 0.002
    own_clear: float | None = None
    cap: float = 0.05
    n_goals: int = 12
    step: float = 0.3
    rounds: int = 400
    max_checks: int = 300_000
    shortcuts: int = 60
    retreats: bool = True
    prove: bool = True
    seed: int = 0
    time_limit: float | None = None

    def __post_init__(self) -> None:
        real_number("clear", self.clear, 0.0, unit="m")
        if self.own_clear is not None:
            real_number("own_clear", self.own_clear, 0.0, unit="m")
        real_number("cap", self.cap, 0.0, unit="m")
        whole_number("n_goals", self.n_goals, 1)
        if real_number("step", self.step, 0.0, unit="m") == 0:
            raise ArgumentError("step", "0", "a length above 0, m")
        whole_number("rounds", self.rounds, 0, 2**32 - 1)
        whole_number("max_checks", self.max_checks, 1)
        whole_number("shortcuts", self.shortcuts, 0, 2**32 - 1)
        truth_value("retreats", self.retreats)
        truth_value("prove", self.prove)
        whole_number("seed", self.seed, 0, 2**64 - 1)
        if self.time_limit is not None and real_number("time_limit", self.time_limit, 0.0) == 0:
            raise ArgumentError("time_limit", "0", "a time above 0, s")

    def as_options(self) -> dict[str, Any]:
        """Return the settings as the compiled core takes them."""
        return {**asdict(self), "cap": max(self.cap, self.clear)}


def checked_settings(settings: Settings | None) -> Settings:
    """Return the settings, or the usual ones."""
    if settings is None:
        return Settings()
    if not isinstance(settings, Settings):
        raise ArgumentError("settings", shown(settings), "motion.Settings")
    return settings
