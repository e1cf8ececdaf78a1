"""Ways of the strawberry arm: out by remark 3, back by its step 7, clear of plant and bed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .._checks import FloatArray
from ..arms import Command, StrawberryArm
from ._clearance import Surroundings
from ._errors import ClearanceError

__all__ = ["H_EXTRA", "Ways"]

JOINTS = ("s10", "s21", "s32", "theta", "beta")
H_EXTRA = 0.03
"""How far above its end the arm waits, m, unless more is needed."""
_HEIGHT_STEP = 0.01


@dataclass(frozen=True, slots=True)
class Ways:
    """Command sequences of an arm among what stands round it; None for an empty bench."""

    arm: StrawberryArm
    surroundings: Surroundings | None

    def back(self, q: FloatArray, h_extra: float) -> list[Command]:
        """Return the way home: lift first, then back, last all the way up."""
        home = self.arm.reset_pose
        # Home is as high as it goes; within the play of the slide it may seem to be higher.
        lifted = max(float(q[2]) - h_extra, float(home[2]))
        return [
            Command("s32", lifted),
            Command("psi", 0.0),
            Command("beta", float(home[4])),
            Command("theta", float(home[3])),
            Command("s21", float(home[1])),
            Command("s10", float(home[0])),
            Command("s32", float(home[2])),
        ]

    def check(self, here: FloatArray, q: FloatArray, h_extra: float) -> None:
        """Refuse a way out, or its way back, that touches something."""
        commands = self.arm.commands(q[:5], h_extra=h_extra)
        # Down to the fruit, and the gripper closing on it.
        self._check(here, commands, "way out", gentle=(7, 8))
        self.check_back(q, h_extra)

    def check_back(self, here: FloatArray, h_extra: float) -> None:
        """Refuse a way back that touches something."""
        self._check(here, self.back(here, h_extra), "way back", gentle=(0,))

    def _check(
        self, start: FloatArray, steps: Sequence[Command], way: str, gentle: tuple[int, ...]
    ) -> None:
        if self.surroundings is None:
            return
        postures, names, soft = [start[:5].copy()], list[str](), list[bool]()
        for number, step in enumerate(steps):
            posture = postures[-1].copy()
            if step.axis in JOINTS:
                posture[JOINTS.index(step.axis)] = step.target
            postures.append(posture)
            names.append(f"{number + 1} of the {way} ({step.axis})")
            soft.append(number in gentle)
        self.surroundings.check_way(self.arm, postures, names, soft)

    def height(self, check: Callable[[float], None], given: float | None, s32: float) -> float:
        """Return the least height above `s32` that passes a check; a given one must."""
        if given is not None:
            check(given)
            return given
        if self.surroundings is None:
            return H_EXTRA
        highest = max(s32 - float(self.arm.reset_pose[2]), 0.0)
        heights = np.arange(H_EXTRA, highest, _HEIGHT_STEP).tolist()
        refusal: ClearanceError | None = None
        for height in [*heights, max(highest, H_EXTRA)]:
            try:
                check(height)
            except ClearanceError as error:
                refusal = error
            else:
                return float(height)
        assert refusal is not None
        raise refusal
