"""What the tomato paper prints: table 1 and the errors that its text names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Published(NamedTuple):
    """A row of the paper's table 1 and its position error.

    Attributes
    ----------
    milliseconds : float
        Execution time on an Athlon 64 X2 at 2.6 GHz, C#.
    iterations : int
        Iterations.
    error_percent : float
        Mean position error; NaN where the text gives none (figure 8 is missing).
    """

    milliseconds: float
    iterations: int
    error_percent: float


PUBLISHED: Mapping[str, Published] = MappingProxyType(
    {
        "inverse": Published(0.59, 316, 1.95),
        "transpose": Published(0.07, 35, 2.6),
        "pinv": Published(7.1, 507, math.nan),
        "analytic": Published(0.0007, 1, 1.95),
    }
)
"""Table 1 and the errors named in the text; 2.6 is given as the maximum."""
