"""Li et al., "Inverse Kinematics Study for Intelligent Agriculture Robot Development via
Differential Evolution Algorithm": the single-point test (figure 3), the repetitive test
(figure 4) with the runs that fail, and what of the recipe matters.
"""  # noqa: D205 - the title does not fit one line

from ._published import (
    ANGLES,
    FITTED_LENGTHS,
    POSITION,
    PUBLISHED_COST,
    PUBLISHED_MEAN,
    PUBLISHED_Q,
)
from ._reproduce import reproduce
from ._tables import (
    TOLERANCE,
    ablation,
    arm,
    comparison,
    cost,
    fitted_arm,
    lengths,
    repeated,
    single_point,
    target,
)

__all__ = [
    "ANGLES",
    "FITTED_LENGTHS",
    "POSITION",
    "PUBLISHED_COST",
    "PUBLISHED_MEAN",
    "PUBLISHED_Q",
    "TOLERANCE",
    "ablation",
    "arm",
    "comparison",
    "cost",
    "fitted_arm",
    "lengths",
    "repeated",
    "reproduce",
    "single_point",
    "target",
]
