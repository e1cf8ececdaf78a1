"""Numbers printed in the HydroLek paper (Burrell, Montazeri, Monk, Taylor)."""

from __future__ import annotations

TOLERANCES_M = (5e-3, 2e-3, 1e-3, 1e-4)

TABLE_2_MS: dict[str, tuple[float | None, ...]] = {
    "pseudo-inverse": (0.823, 1.115, 1.368, 1.727),
    "transpose": (0.951, 1.327, 1.602, 2.391),
    "damped": (1.091, 1.524, 1.780, 2.538),
    "IK-PID": (16.258, 16.231, 16.147, None),
    "state space": (0.604, 0.763, 0.875, 1.310),
}
"""Table II: mean time of a solve, ms, at each tolerance."""

SUCCESS: dict[str, int | str] = {
    "IK-PID, Kp 0.02": 960,
    "IK-PID, tuned": 994,
    "state space, trial": 665,
    "state space, optimised": 993,
    "pseudo-inverse": "992 to 999",
    "transpose": "992 to 999",
    "damped, 200 mm": "992 to 999",
}
"""Goals reached of 1,000 (sections 6.1 and 6.2); three Jacobian methods together lose 1 to 8."""

PLANAR_DEG = (47.6, -60.0, -18.8)
"""Joint angles of the planar arm at (5, 0), degrees (section 6.4)."""

DISPLACEMENT_M = (-0.1, 0.5, -0.2)
"""The goal (-10, 50, -20) read as a displacement in cm, paper frame, m."""
