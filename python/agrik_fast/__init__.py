"""Fast, verified inverse kinematics for serial robot arms.

The names below are loaded when first used, so that ``import agrik_fast`` (and
with it the command line's help) costs next to nothing.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import arms as arms
    from . import cluster as cluster
    from . import (
        collision,
        errors,
        euler,
        harvest,
        motion,
        plots,
        rotations,
        solvers,
        tasks,
        viewer,
    )
    from . import drivers as drivers
    from . import io as io
    from . import jobs as jobs
    from . import papers as papers
    from . import tune as tune
    from . import tuning as tuning
    from ._native import __version__, get_num_threads, set_num_threads, simd_level
    from .collision import Scene
    from .errors import (
        AgrikError,
        ArgumentError,
        RobotFileError,
        SceneFileError,
        UnknownNameError,
        UrdfError,
    )
    from .result import Branches, Family, IkResult, Singularity, Status, Warnings
    from .robot import JointPath, Path, Robot
else:
    from ._lazy import __dir__ as __dir__
    from ._lazy import __getattr__ as __getattr__

__all__ = [
    "AgrikError",
    "ArgumentError",
    "Branches",
    "Family",
    "IkResult",
    "JointPath",
    "Path",
    "Robot",
    "RobotFileError",
    "Scene",
    "SceneFileError",
    "Singularity",
    "Status",
    "UnknownNameError",
    "UrdfError",
    "Warnings",
    "__version__",
    "collision",
    "errors",
    "euler",
    "get_num_threads",
    "harvest",
    "motion",
    "plots",
    "rotations",
    "set_num_threads",
    "simd_level",
    "solvers",
    "tasks",
    "viewer",
]
