"""Li et al., "Inverse Kinematics Study for Intelligent Agriculture Robot Development via
Differential Evolution Algorithm": the single-point test (figure 3), the repetitive test
(figure 4) with the runs that fail, and what of the recipe matters.
"""  # noqa: D205 - the title does not fit one line

from ._field_jobs import CUTTER, NOZZLE, FieldJob, cotton_topping, spray_pass, topping_points
from ._published import (
    ANGLES,
    FITTED_LENGTHS,
    POSITION,
    PUBLISHED_COST,
    PUBLISHED_MEAN,
    PUBLISHED_Q,
)
from ._reproduce import reproduce
from ._scalability import DEGREES_OF_FREEDOM, GENERATIONS, Scaled, alternating_arm, scalability
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
    "CUTTER",
    "DEGREES_OF_FREEDOM",
    "FITTED_LENGTHS",
    "GENERATIONS",
    "NOZZLE",
    "POSITION",
    "PUBLISHED_COST",
    "PUBLISHED_MEAN",
    "PUBLISHED_Q",
    "TOLERANCE",
    "FieldJob",
    "Scaled",
    "ablation",
    "alternating_arm",
    "arm",
    "comparison",
    "cost",
    "cotton_topping",
    "fitted_arm",
    "lengths",
    "repeated",
    "reproduce",
    "scalability",
    "single_point",
    "spray_pass",
    "target",
    "topping_points",
]
