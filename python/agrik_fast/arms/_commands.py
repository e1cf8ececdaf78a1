"""Command sequences of the strawberry arm: out to a pose (remark 3) and home again (step 7)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple


class Command(NamedTuple):
    """One step of the command sequence (remark 3).

    Attributes
    ----------
    axis : str
        s10, s21, s32, theta, beta, psi or gripper: the joints of ``Robot.load("strawberry6")``
        and the servo of its end effector.
    target : float
        Where to, m or rad; for the gripper 1 is open and 0 closed.

    Examples
    --------
    >>> from agrik_fast.arms import Command
    >>> Command("gripper", 1.0).axis
    'gripper'
    """

    axis: str
    target: float


class Commands(list[Command]):
    """The steps of a command sequence, with the clearance that they really keep.

    Parameters
    ----------
    steps : iterable of Command
        The steps.
    clearance : float, m
        How far above its end the arm is while anything but slide s32 moves.
    wanted : float, m
        The clearance asked for, `h_extra`.

    Attributes
    ----------
    clearance : float, m
        How far above its end the arm is while anything but slide s32 moves. Less than
        `h_extra` where that would take the slide past its home.
    wanted : float, m
        The clearance asked for.

    Examples
    --------
    >>> from agrik_fast.arms import StrawberryArm
    >>> arm = StrawberryArm()
    >>> steps = arm.commands(arm.solve([0.426, 0.345, -0.3316]).q, h_extra=0.04)
    >>> steps.wanted, steps.clearance >= 0.0
    (0.04, True)
    """

    def __init__(self, steps: Iterable[Command], clearance: float, wanted: float) -> None:
        super().__init__(steps)
        self.clearance = clearance
        self.wanted = wanted

    @property
    def note(self) -> str:
        """What there is to say of the clearance; empty where it is the one asked for."""
        # Two numbers of the slide's length: what they differ by is rounded.
        if self.clearance >= self.wanted - 1e-12:
            return ""
        return (
            f"the clearance is {1000 * self.clearance:.1f} mm, not {1000 * self.wanted:.1f} mm: "
            "more would take slide s32 past its home"
        )


def there(steps: Sequence[tuple[str, float]], h_extra: float) -> Commands:
    """Return the way out as the core gives it."""
    waiting, end = steps[1][1], steps[7][1]
    return Commands((Command(*step) for step in steps), end - waiting, h_extra)


def back(out: Commands, home: Sequence[float]) -> Commands:
    """Return the way home from the end of the way out: lifted first, then in its reverse.

    Parameters
    ----------
    out : Commands
        The way out.
    home : sequence of 5 float, m and rad
        Where to.
    """
    s10, s21, s32, theta, beta = home
    steps = [
        ("s32", out[1].target),
        ("psi", 0.0),
        ("beta", beta),
        ("theta", theta),
        ("s21", s21),
        ("s10", s10),
        ("s32", s32),
    ]
    return Commands((Command(*step) for step in steps), out.clearance, out.wanted)
