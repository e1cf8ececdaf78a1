"""The closed forms of arms as a solver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from .._checks import real_number, truth_value
from ..errors import ArgumentError


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedForm:
    """Every branch of the exact solution, and the best of them; named "closed_form".

    For full poses of arms with a closed form (see `Robot.closed_form`): six revolute
    joints whose last three axes meet, or seven of which also the first three do (S-R-S).
    No iteration, no random start: `seed` does not matter, and a target without a solution
    within the limits is proven to have none.

    Parameters
    ----------
    choose : {"nearest", "margin", "middle"}, default "nearest"
        Which of the valid branches is the answer. "nearest": the least sum of squared
        distances from `q0`, or from the middle of the limits where no `q0` is given.
        "margin": the one whose worst joint is furthest from its limits, as a share of
        half the joint's range. "middle": the least sum of squared distances from the
        middle of the limits, as shares of half the range. Joints without limits do not
        count in the last two.
    arm_angle : float, optional
        Arm angle of an S-R-S arm, rad (see `Robot.arm_angle`). Default: the best one by
        `choose`, out of all that the limits allow.
    certify : bool, default False
        Prove that no other arm angle of an S-R-S arm is better by more than 1e-9 in the
        cost (rad^2, or shares), see the page on closed forms. Takes many times as long as
        the default, the best of a quick look round. Nothing to prove with `arm_angle`, for
        other arms, or where axes of shoulder or wrist meet at another than a right angle.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    Examples
    --------
    >>> arm = ik.Robot.load("puma560")
    >>> pose = arm.fk(np.full(6, 0.5))
    >>> result = arm.ik(pose, solver=ik.solvers.ClosedForm(choose="margin"))
    >>> bool(result.success), int(result.iterations)
    (True, 0)
    """

    name: ClassVar[str] = "closed_form"
    choose: Literal["nearest", "margin", "middle"] = "nearest"
    arm_angle: float | None = None
    certify: bool = False

    def __post_init__(self) -> None:
        choose: object = self.choose
        if not isinstance(choose, str) or choose not in ("nearest", "margin", "middle"):
            raise ArgumentError(
                "ClosedForm.choose", repr(self.choose), "'nearest', 'margin' or 'middle'"
            )
        if self.arm_angle is not None:
            angle = real_number("ClosedForm.arm_angle", self.arm_angle, unit="rad")
            object.__setattr__(self, "arm_angle", angle)
        object.__setattr__(self, "certify", truth_value("ClosedForm.certify", self.certify))
