"""All branches of targets as rows of a result file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..io import Extras, ResultChunk, part_of
from ..result import Branches, Status
from ..robot import Robot
from ..tasks import Axis
from ._task import JobTask

# Statuses of targets whose valid branches are answers.
_SOLVED = (Status.CONVERGED, Status.SINGULAR_FAMILY)


def as_rows(
    robot: Robot,
    task: JobTask,
    targets: NDArray[np.float64],
    found: Branches,
    ids: NDArray[Any],
    extras: Extras,
) -> ResultChunk:
    """Return a row for each valid branch of each target, in order.

    A target without any keeps one row, of its first branch held within the limits. Errors are
    those of the forward kinematics of each row.
    """
    valid = np.array(found.valid)
    solved = np.isin(found.status, _SOLVED)
    valid &= solved[:, None]
    shown = valid.copy()
    shown[~valid.any(axis=1), 0] = True
    row, branch = np.nonzero(shown)
    q = found.q[row, branch]
    success = valid[row, branch]
    q = np.where(success[:, None], q, np.clip(q, robot.lower, robot.upper))
    status = np.where(success, Status.CONVERGED, found.status[row]).astype(np.uint8)
    position, angle = _errors(robot.fk(q), targets[row], task)
    bad = status == Status.BAD_INPUT
    effort = np.zeros(len(row), dtype=np.uint32)
    return ResultChunk(
        ids=ids[row],
        q=q,
        status=status,
        success=success,
        position_error=np.where(bad, np.inf, position),
        orientation_error=np.where(bad, np.inf, angle),
        iterations=effort,
        restarts=effort,
        extras=part_of(extras, row),
    )


def _errors(
    poses: NDArray[np.float64], targets: NDArray[np.float64], task: JobTask
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return distances, m, and angles, rad, that a task leaves between poses and targets."""
    points = targets if targets.shape[-1] == 3 else targets[:, :3, 3]
    off = np.linalg.norm(poses[:, :3, 3] - points, axis=1)
    if task == "position":
        return off, np.zeros(len(off))
    if isinstance(task, Axis):
        axis = np.asarray(task.tool_axis) / np.linalg.norm(task.tool_axis)
        if task.direction is None:
            wanted = targets[:, :3, :3] @ axis
        else:
            wanted = np.asarray(task.direction) / np.linalg.norm(task.direction)
        apart = np.linalg.norm(poses[:, :3, :3] @ axis - wanted, axis=1)
        return off, 2.0 * np.arcsin(np.clip(0.5 * apart, 0.0, 1.0))
    chord = np.linalg.norm(poses[:, :3, :3] - targets[:, :3, :3], axis=(1, 2))
    # A turn by x moves the three axes by 2 sqrt(2) sin(x / 2) in all.
    return off, 2.0 * np.arcsin(np.clip(chord / np.sqrt(8.0), 0.0, 1.0))
