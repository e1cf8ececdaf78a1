"""Single arms with classes of their own: what a chain of joints does not tell of them.

`StrawberryArm` chooses, by masses and friction, among the infinitely many postures of the
strawberry handling arm that reach a target; `TomatoArm` lists the four of the tomato pointing
arm within its servos' limits, and `holding_torques` says what its servos have to hold;
`gravity_torques` says it of any chain.
"""

from ._commands import Command, Commands
from ._gravity import PointMass, gravity_torques
from ._strawberry import Place, StrawberryArm, StrawberryResult
from ._tomato import (
    BRANCHES,
    HOME,
    Outcome,
    PacedResult,
    TomatoArm,
    TomatoBranches,
    TomatoResult,
    TransposeStepWarning,
)
from ._torques import HD_6001HB, HS_311, Load, Servo, Torques, holding_torques

__all__ = [
    "BRANCHES",
    "HD_6001HB",
    "HOME",
    "HS_311",
    "Command",
    "Commands",
    "Load",
    "Outcome",
    "PacedResult",
    "Place",
    "PointMass",
    "Servo",
    "StrawberryArm",
    "StrawberryResult",
    "TomatoArm",
    "TomatoBranches",
    "TomatoResult",
    "Torques",
    "TransposeStepWarning",
    "gravity_torques",
    "holding_torques",
]
