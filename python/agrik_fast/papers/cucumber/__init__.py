"""Van Henten and others, the cucumber-picking robot: its formulas, searches and scans.

"Collision-free inverse kinematics of the redundant seven-link manipulator used in a cucumber
picking robot", Biosystems Engineering (2010). Table 1 is missing in the scan: lengths and
limits are those of a sister arm, and named as such.
"""

from ._formulas import LENGTHS, MISPRINTS, Misprint, forward, random_poses
from ._published import FIELD, GENETIC
from ._reproduce import reproduce
from ._tables import ABLATION, ablation, crop_shares, field_cycle

__all__ = [
    "ABLATION",
    "FIELD",
    "GENETIC",
    "LENGTHS",
    "MISPRINTS",
    "Misprint",
    "ablation",
    "crop_shares",
    "field_cycle",
    "forward",
    "random_poses",
    "reproduce",
]
