"""What the paper on redundant7 prints, and the lengths that fit its answer."""

from __future__ import annotations

import math

POSITION = (0.334, 0.471, 0.539)
"""The paper's target, m."""
ANGLES = (math.pi / 2, math.pi / 4, math.pi / 6)
"""Its ZYZ angles, rad."""
PUBLISHED_Q = (-0.1463, 2.0494, 1.9414, 1.9062, 0.4786, 0.4610, -1.6490)
"""The paper's answer, rad."""
PUBLISHED_COST = 6.65e-6
"""Cost of the paper's single run after 200 generations."""
PUBLISHED_MEAN = 1.27e-6
"""Mean cost of the paper's 30 runs."""
FITTED_LENGTHS = (0.400, 0.450, 0.450, 0.200)
"""d1, d3, d5, d7 in m, with which that answer meets the paper's position."""
