"""The package's own robot files, read already: JSON beside each TOML, the same numbers.

To check a TOML file takes pydantic, whose import takes longer than everything else that a
first answer needs. ``tools/prepare_robots.py`` writes the JSON, a test compares the two.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .._bodies import Body, BodyShape, Box, Capsule, CollisionRules, Convex, Cover, Sphere
from ._definition import Definition, EndEffector
from ._dh_rows import DhRow

__all__ = ["read", "text"]

_SUFFIX = ".json"
_SHAPES: dict[str, Callable[..., BodyShape]] = {
    shape.__name__: shape for shape in (Sphere, Capsule, Box, Convex, Cover)
}


def read(path: Path) -> Definition | None:
    """Return the definition that stands beside a bundled robot file; None if none does."""
    try:
        data = path.with_suffix(_SUFFIX).read_text(encoding="utf-8")
    except OSError:
        return None
    fields = json.loads(data)
    base, tool = np.array(fields["base"]), np.array(fields["tool"])
    method, arguments = _arguments(fields)
    rows = fields["dh"]
    return Definition(
        **fields
        | {
            "method": method,
            "arguments": arguments,
            "base": base,
            "tool": tool,
            "dh": None if rows is None else tuple(DhRow(*row) for row in rows),
            "frames": {name: np.array(pose) for name, pose in fields["frames"].items()},
            "notes": tuple(fields["notes"]),
            "motion": {name: tuple(limits) for name, limits in fields["motion"].items()},
            "end_effector": _hand(fields["end_effector"]),
            "bodies": tuple(_body(body) for body in fields["bodies"]),
            "rules": CollisionRules(**fields["rules"]),
            "attached": (),
        }
    )


def _hand(fields: list[Any] | None) -> EndEffector | None:
    return None if fields is None else EndEffector(fields[0], tuple(fields[1]))


def _body(fields: dict[str, Any]) -> Body:
    shape = _SHAPES[fields.pop("kind")](**fields.pop("shape"))
    return Body(**fields, shape=shape)


def _arguments(fields: dict[str, Any]) -> tuple[str, tuple[Any, ...]]:
    name, *rest = fields["arguments"]
    if fields["method"] == "from_dh":
        convention, rows, types, names, lower, upper = rest
        arrays = (np.array(rows), types, names, np.array(lower), np.array(upper))
        return "from_dh", (name, convention, *arrays)
    (joints,) = rest
    for joint in joints:
        joint["origin"], joint["axis"] = np.array(joint["origin"]), np.array(joint["axis"])
        joint["mimic"] = None if joint["mimic"] is None else tuple(joint["mimic"])
    return "from_joints", (name, joints)


def text(definition: Definition) -> str:
    """Return a definition as the JSON that `read` takes."""
    return json.dumps(vars(definition), default=_plain, ensure_ascii=False, indent=1) + "\n"


def _plain(value: object) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Body):
        kind = type(value.shape).__name__
        return vars(value) | {"kind": kind, "shape": vars(value.shape)}
    if isinstance(value, CollisionRules):
        return vars(value)
    raise TypeError(f"{type(value).__name__} has no place in a bundled robot")
