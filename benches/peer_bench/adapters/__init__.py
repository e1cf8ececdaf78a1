"""One module per library. Each runs in a worker process of that library's own environment.

A module may define these functions; a missing one means 'the library has no such call':

* ``pose(robot, urdf_path)`` and ``position(robot, urdf_path, tolerance_m)`` -> `Solver`
* ``closed_form(robot, urdf_path)`` -> `Solver` with `every_solution`, or None
* ``fk``, ``jacobian``, ``fk_batch``, ``jacobian_batch`` ``(robot, urdf_path)`` -> `Evaluation`
* ``DISTRIBUTION``: the name on the package index, for the version in the report

Settings are chosen so that no library is at a disadvantage: the cheapest call of its API that
still meets the success criterion, targets converted to its own types before the clock starts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def unchanged(value: Array) -> Any:
    return value


@dataclass(frozen=True)
class Solver:
    """One way to solve targets.

    `solve(native_target, start)` returns joint values, or None when the library reports failure;
    with `every_solution` it returns an array of solutions, of which one inside the limits counts.
    `batch(poses, threads)` returns joint values (n, dof) and the library's own success (n,), by
    way of `unpack`.
    """

    solve: Callable[[Any, Array], Any]
    settings: str
    prepare: Callable[[Array], Any] = unchanged
    every_solution: bool = False
    # What `batch` returns is made of the call's result by `unpack`, off the clock.
    batch: Callable[[Array, int], Any] | None = None
    unpack: Callable[[Any], tuple[Array, Any]] = unchanged
    # How many solutions a pose has, limits aside.
    count: Callable[[Any], int] | None = None
    # A call that starts at a solution, so that only the cost of calling remains.
    overhead: Callable[[Array, Array], Any] | None = None


@dataclass(frozen=True)
class Evaluation:
    """FK or Jacobian: `call(q)`, and `as_pose(result)` -> (4, 4) to check FK against NumPy."""

    call: Callable[[Any], Any]
    note: str
    as_pose: Callable[[Any], Array] | None = None


def quaternion_xyzw(r: Array) -> tuple[float, float, float, float]:
    """Return a rotation matrix as a unit quaternion (eigenvector of the largest eigenvalue)."""
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0.0, 0.0, 0.0],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], 0.0, 0.0],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], 0.0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
        ]
    )
    vector = np.linalg.eigh(k, UPLO="L")[1][:, -1]
    x, y, z, w = (float(value) for value in vector)
    return x, y, z, w
