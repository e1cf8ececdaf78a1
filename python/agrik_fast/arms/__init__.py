"""Closed forms: arms whose geometry gives the joint values without iteration.

`StrawberryArm` chooses among the infinitely many postures of the strawberry handling arm
that reach a target; `TomatoArm` lists the four of the tomato pointing arm.
"""

from .strawberry import Command, Place, StrawberryArm, StrawberryResult
from .tomato import (
    Outcome,
    PacedResult,
    TomatoArm,
    TomatoBranches,
    TomatoResult,
    TransposeStepWarning,
)
from .torques import Load, Servo, Torques, holding_torques

__all__ = [
    "Command",
    "Load",
    "Outcome",
    "PacedResult",
    "Place",
    "Servo",
    "StrawberryArm",
    "StrawberryResult",
    "TomatoArm",
    "TomatoBranches",
    "TomatoResult",
    "Torques",
    "TransposeStepWarning",
    "holding_torques",
]
