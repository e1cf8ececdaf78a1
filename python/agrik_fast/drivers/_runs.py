"""What motions of the strawberry rig leave behind."""

from __future__ import annotations

from dataclasses import dataclass

from .._checks import FloatArray

__all__ = ["Arrival", "Run"]


@dataclass(frozen=True, slots=True)
class Arrival:
    """One motion that ended.

    Attributes
    ----------
    axis : str
        What moved.
    target : float, m or rad
        Where to; for the gripper 1 is open and 0 closed.
    begin, end : float, s
        By the clock of the line.
    encoder_error : float, m
        Encoder less command when the slide stood; 0 for servos, which have none.

    Examples
    --------
    >>> from agrik_fast.drivers import Arrival
    >>> arrival = Arrival("s10", target=0.2, begin=1.0, end=2.5)
    >>> arrival.end - arrival.begin
    1.5
    """

    axis: str
    target: float
    begin: float
    end: float
    encoder_error: float = 0.0


@dataclass(frozen=True, slots=True)
class Run:
    """A command sequence that was carried out.

    Attributes
    ----------
    q : ndarray, shape (6,), m and rad
        Joint values at its end, as commanded.
    seconds : float
        From the first command to the last end.
    h_extra : float, m
        How far above its end the arm waited.
    steps : tuple of Arrival
        The steps.

    Examples
    --------
    >>> from agrik_fast.drivers import Arrival, Run
    >>> Run(np.zeros(6), 4.4, 0.03, (Arrival("gripper", 1.0, 0.0, 0.3),)).steps[0].axis
    'gripper'
    """

    q: FloatArray
    seconds: float
    h_extra: float
    steps: tuple[Arrival, ...]
