"""The former name of `agrik_fast.arms`, with the same classes and functions."""

from .arms import (
    Command,
    Load,
    Outcome,
    PacedResult,
    Place,
    Servo,
    StrawberryArm,
    StrawberryResult,
    TomatoArm,
    TomatoBranches,
    TomatoResult,
    Torques,
    TransposeStepWarning,
    holding_torques,
)

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
