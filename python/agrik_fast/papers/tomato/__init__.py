"""Kviesis and Osadcuks, the tomato pointing arm: its table, figures and torques.

"Development of robot manipulator and motion control using inverse kinematics for robotized
vegetable harvesting". The paper prints neither link lengths nor start, targets, step or
tolerance; what is needed of these is a fit or a choice of ours and named as such.
"""

from ._published import PUBLISHED, Published
from ._reproduce import reproduce
from ._tables import FITS, ErrorSizes, Row, monte_carlo, table1, targets

__all__ = [
    "FITS",
    "PUBLISHED",
    "ErrorSizes",
    "Published",
    "Row",
    "monte_carlo",
    "reproduce",
    "table1",
    "targets",
]
