"""Counts, without the library's kinematics, the rows of a result file that hold their promise."""

import numpy as np

from agrik_fast.io import read_results, read_targets
from agrik_fast.jobs import SolveRequest
from numpy_fk import fk, limits, pose_error

# The last digits of two forward kinematics differ; tolerances are five orders above.
ROUNDING = 1e-11


def count_within_tolerance(request: SolveRequest) -> int:
    """Number of rows that say success and are within tolerance and limits by `numpy_fk`.

    Parameters
    ----------
    request : SolveRequest
        A finished job; its targets and results are read back from the files.
    """
    targets = read_targets(request.targets).read_all()
    _, results = read_results(request.output)
    assert len(targets) == len(results)
    assert targets.ids.astype(str).tolist() == results.ids.astype(str).tolist()
    pose = fk(request.robot, results.q)
    goal = targets.targets
    point = goal[:, :3, 3] if goal.ndim == 3 else goal
    good = results.success.copy()
    good &= np.linalg.norm(pose[:, :3, 3] - point, axis=1) <= (
        request.position_tolerance + ROUNDING
    )
    if request.task == "axis":
        assert request.direction is not None
        tool_axis = np.array(request.tool_axis)
        wanted = np.array(request.direction)
        axis = pose[:, :3, :3] @ (tool_axis / np.linalg.norm(tool_axis))
        unit = wanted / np.linalg.norm(wanted)
        angle = np.arctan2(np.linalg.norm(np.cross(axis, unit), axis=1), axis @ unit)
        good &= angle <= request.orientation_tolerance + ROUNDING
    elif goal.ndim == 3:
        good &= pose_error(pose, goal)[1] <= request.orientation_tolerance + ROUNDING
    low, high = limits(request.robot).T
    good &= ((results.q >= low - ROUNDING) & (results.q <= high + ROUNDING)).all(axis=1)
    return int(np.count_nonzero(good))
