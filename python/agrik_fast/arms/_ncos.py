"""NCOS, the paper's problem P2: nonlinear optimisation from the home pose, by SciPy."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray
from ..errors import AgrikError
from ..result import Status

SCALE = np.array([0.1, 0.1, 0.1, 1.0, 1.0])
"""Joint values are divided by this, so that SLSQP sees numbers of one size."""

RESIDUAL_M = 1e-8
"""A solution whose tool point is farther than this from the target is none."""


class Mechanism(Protocol):
    """What the optimisation asks of an arm."""

    @property
    def lower(self) -> FloatArray:
        """Smallest joint values, shape (5,), m and rad."""

    @property
    def upper(self) -> FloatArray:
        """Largest joint values, shape (5,), m and rad."""

    @property
    def reset_pose(self) -> FloatArray:
        """What rows that are not solved hold, shape (5,), m and rad."""

    def fk(self, q: ArrayLike) -> FloatArray:
        """Return tool points, shape (..., 3), m, of joint values, shape (..., 5)."""

    def energy(self, q: ArrayLike) -> FloatArray:
        """Return energy indices, shape (...), J, of joint values, shape (..., 5)."""


def solve_one(
    arm: Mechanism, target: FloatArray, start: FloatArray
) -> tuple[FloatArray | None, int]:
    """Return joint values, shape (5,), or None where SLSQP finds none; and its iterations."""
    try:
        from scipy.optimize import minimize
    except ImportError:
        raise AgrikError(
            'method "ncos" needs SciPy; install the extra: agrik_fast[papers]'
        ) from None
    found = minimize(
        lambda s: 1000 * float(arm.energy(s * SCALE)),
        start / SCALE,
        method="SLSQP",
        bounds=list(zip(arm.lower / SCALE, arm.upper / SCALE, strict=True)),
        constraints={"type": "eq", "fun": lambda s: 10 * (arm.fk(s * SCALE) - target)},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    q = np.clip(found.x * SCALE, arm.lower, arm.upper)
    near = np.linalg.norm(arm.fk(q) - target) <= RESIDUAL_M
    return (q if near else None), int(found.nit)


class Answers(NamedTuple):
    """What NCOS found; arrays have the targets' leading shape.

    Attributes
    ----------
    q : ndarray, shape (..., 5), m and rad
        Joint values; the reset pose where SLSQP finds none.
    status : ndarray, shape (...)
        Codes of `agrik_fast.Status`.
    error : ndarray, shape (...), m
        Distance of the tool point from the target; infinite for bad input.
    iterations : ndarray, shape (...)
        Iterations of SLSQP.
    """

    q: FloatArray
    status: NDArray[np.uint8]
    error: FloatArray
    iterations: NDArray[np.uint32]


def solve_all(arm: Mechanism, points: FloatArray, starts: FloatArray) -> Answers:
    """Solve targets, shape (..., 3), m, from starts, shape (..., 5), one after the other."""
    leading = points.shape[:-1]
    flat = points.reshape(-1, 3)
    q = np.tile(arm.reset_pose, (len(flat), 1))
    status = np.full(len(flat), Status.NOT_FOUND, dtype=np.uint8)
    error = np.full(len(flat), np.inf)
    iterations = np.zeros(len(flat), dtype=np.uint32)
    begin = starts.reshape(-1, 5)
    for i, target in enumerate(flat):
        if not np.isfinite(target).all():
            status[i] = Status.BAD_INPUT
            continue
        found, iterations[i] = solve_one(arm, target, begin[i])
        if found is not None:
            q[i], status[i] = found, Status.CONVERGED
        error[i] = float(np.linalg.norm(arm.fk(q[i]) - target))
    return Answers(
        q.reshape(*leading, 5),
        status.reshape(leading),
        error.reshape(leading),
        iterations.reshape(leading),
    )
