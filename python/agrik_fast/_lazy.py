"""Loads the package's public names when they are first used (PEP 562)."""

from __future__ import annotations

import importlib
import sys

MODULE_OF = {
    "AgrikError": "errors",
    "ArgumentError": "errors",
    "Branches": "result",
    "Family": "result",
    "IkResult": "result",
    "JointPath": "robot",
    "Path": "robot",
    "Robot": "robot",
    "RobotFileError": "errors",
    "Scene": "collision",
    "SceneFileError": "errors",
    "Singularity": "result",
    "Status": "result",
    "UnknownNameError": "errors",
    "UrdfError": "errors",
    "Warnings": "result",
    "__version__": "_native",
    "get_num_threads": "_native",
    "set_num_threads": "_native",
    "simd_level": "_native",
}
"""Module that defines each public name."""

MODULES = (
    "arms",
    "cluster",
    "collision",
    "drivers",
    "errors",
    "euler",
    "harvest",
    "io",
    "jax",
    "jobs",
    "motion",
    "papers",
    "plots",
    "rotations",
    "solvers",
    "tasks",
    "torch",
    "tune",
    "tuning",
    "viewer",
)
"""Modules that are names of the package without being imported first."""

_PACKAGE = "agrik_fast"


def __getattr__(name: str) -> object:
    """Return a public name, importing the module that defines it."""
    if name in MODULES:
        return importlib.import_module(f"{_PACKAGE}.{name}")
    if name not in MODULE_OF:
        raise AttributeError(f"module {_PACKAGE!r} has no attribute {name!r}", name=name)
    value: object = getattr(importlib.import_module(f"{_PACKAGE}.{MODULE_OF[name]}"), name)
    setattr(sys.modules[_PACKAGE], name, value)  # the next use does not come here
    return value


def __dir__() -> list[str]:
    """Return the package's names, loaded or not."""
    return sorted({*vars(sys.modules[_PACKAGE]), *MODULE_OF, *MODULES})
