"""NCOS, the paper's problem P2: nonlinear optimisation from the home pose, by SciPy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array
from .._native import ik_record
from ..errors import AgrikError, ArgumentError
from ..result import Status

if TYPE_CHECKING:
    from .strawberry import StrawberryArm, StrawberryResult

SCALE = np.array([0.1, 0.1, 0.1, 1.0, 1.0])
"""Joint values are divided by this, so that SLSQP sees numbers of one size."""

RESIDUAL_M = 1e-8
"""A solution whose tool point is farther than this from the target is none."""


def solve_one(arm: StrawberryArm, target: FloatArray) -> FloatArray | None:
    """Return joint values, shape (5,), or None where SLSQP finds none."""
    try:
        from scipy.optimize import minimize
    except ImportError:
        raise AgrikError(
            'method "ncos" needs SciPy; install the extra: agrik_fast[papers]'
        ) from None
    found = minimize(
        lambda s: 1000 * float(arm.energy(s * SCALE)),
        arm.reset_pose / SCALE,
        method="SLSQP",
        bounds=list(zip(arm.lower / SCALE, arm.upper / SCALE, strict=True)),
        constraints={"type": "eq", "fun": lambda s: 10 * (arm.fk(s * SCALE) - target)},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    q = np.clip(found.x * SCALE, arm.lower, arm.upper)
    return q if np.linalg.norm(arm.fk(q) - target) <= RESIDUAL_M else None


def solve_all(arm: StrawberryArm, targets: ArrayLike) -> StrawberryResult:
    """Solve targets, shape (..., 3), m, one after the other."""
    from .strawberry import StrawberryResult

    points = float_array("targets", targets)
    if points.ndim == 0 or points.shape[-1] != 3:
        raise ArgumentError("targets", f"shape {points.shape}", "shape (..., 3)")
    leading = points.shape[:-1]
    flat = points.reshape(-1, 3)
    q = np.tile(arm.reset_pose, (len(flat), 1))
    status = np.full(len(flat), Status.NOT_FOUND, dtype=np.uint8)
    error = np.full(len(flat), np.inf)
    for i, target in enumerate(flat):
        if not np.isfinite(target).all():
            status[i] = Status.BAD_INPUT
            continue
        found = solve_one(arm, target)
        if found is not None:
            q[i], status[i] = found, Status.CONVERGED
        error[i] = float(np.linalg.norm(arm.fk(q[i]) - target))
    record = ik_record(q.reshape(*leading, 5), status.reshape(leading), error.reshape(leading))
    solved = status == Status.CONVERGED
    energy = np.where(solved, arm.energy(q), np.nan)
    # Why SLSQP fails it does not say; the exact method does, or for constants for which it
    # has no proof the analytical one.
    try:
        why = arm.solve(points, "exact")
    except ArgumentError:
        why = arm.solve(points, "as")
    place = np.where(solved.reshape(leading), 0, why.place).astype(np.uint8)
    gap = np.where(solved.reshape(leading), 0.0, why.gap)
    return StrawberryResult(record, energy.reshape(leading), place, gap)
