"""Robots written as robot files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _atomic, _checks
from .._bodies import Body, CollisionRules, Cover
from .._checks import truth_value
from .._native import Chain
from ..errors import AgrikError, ArgumentError, RobotFileError
from ._definition import Definition
from ._file_checks import MOTION, key_of

# What the keys of a file without units in mm and degrees are called.
_IN_SI = {
    f"_{old}{behind}": f"_{new}{behind}"
    for old, new in (("mm", "m"), ("deg", "rad"))
    for behind in ("", *MOTION.values())
}


def write(definition: Definition, chain: Chain, path: str | PathLike[str], *, force: bool) -> None:
    """Write a robot; see `agrik_fast.Robot.save`."""
    import tomli_w

    file = _checks.path("path", path)
    truth_value("force", force)
    if file.suffix.lower() != ".toml":
        raise ArgumentError("path", repr(str(file)), "the name of a .toml file")
    data = tomli_w.dumps(tables(definition, chain)).encode()

    def refuse(reason: str) -> AgrikError:
        return RobotFileError(file.name, [("", reason)])

    _atomic.write_bytes(file, data, refuse, force=force)


def tables(definition: Definition, chain: Chain) -> dict[str, Any]:
    """Return a robot's file as tables; all numbers in m and rad."""
    content: dict[str, Any] = {"format": 1, "name": chain.name}
    if definition.description:
        content["description"] = definition.description
    if definition.dh is not None:
        content["convention"] = definition.convention
    if definition.variable_order is not None:
        content["q_order"] = list(definition.variable_order)
    if definition.source:
        content["source"] = dict(definition.source)
    if definition.marks:
        content["provenance"] = dict(definition.marks)
    content["base"] = _transform(chain.base)
    content["tool"] = _transform(chain.tool)
    content["frames"] = {name: _transform(pose) for name, pose in definition.frames.items()}
    if definition.dh is not None:
        content["dh"] = [_dh(row) for row in definition.dh]
    else:
        specs = chain.joints()
        names = [spec["name"] for spec in specs]
        content["joint"] = [_joint(spec, names) for spec in specs]
    motion = dict(chain.joint_motion_limits())
    for row in content.get("dh", content.get("joint", [])):
        unit = "m" if row["type"] == "prismatic" else "rad"
        if row["name"] in definition.home:
            row[f"home_{unit}"] = definition.home[row["name"]]
        if row["type"] != "fixed":
            for stem, limit in zip(MOTION, motion.get(row["name"], ()), strict=False):
                if math.isfinite(limit):
                    row[key_of(stem, unit)] = limit
    if definition.end_effector is not None:
        servo, moves = definition.end_effector
        content["end_effector"] = {"servo": servo, "moves": list(moves)}
    _explain(content, definition.provenance)
    if definition.urdf is None:
        content["collision"] = [_body(body) for body in definition.bodies]
        content["collision_rules"] = _rules(definition.rules)
    return {key: value for key, value in content.items() if value not in ({}, [])}


def _body(body: Body) -> dict[str, Any]:
    shape = {
        f"{name}_m" if name not in ("rotation", "level", "split") else name: _listed(value)
        for name, value in vars(body.shape).items()
    }
    table: dict[str, Any] = {
        "name": body.name,
        "frame": body.frame,
        "shape": type(body.shape).__name__.lower(),
    }
    if body.overestimate is not None and not isinstance(body.shape, Cover):
        table["overestimate_m"] = body.overestimate
    return table | shape


def _rules(rules: CollisionRules) -> dict[str, Any]:
    return {name: _listed(value) for name, value in vars(rules).items() if value}


def _listed(value: Any) -> Any:
    return [_listed(x) for x in value] if isinstance(value, tuple) else value


def _transform(pose: NDArray[np.float64]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    if pose[:3, 3].any():
        table["xyz_m"] = pose[:3, 3].tolist()
    if not np.array_equal(pose[:3, :3], np.eye(3)):
        table["rotation"] = pose[:3, :3].tolist()
    return table


def _limits(kind: str, lower: float, upper: float) -> dict[str, float]:
    if kind not in ("revolute", "prismatic"):
        return {}
    unit = "m" if kind == "prismatic" else "rad"
    return {f"lower_{unit}": lower, f"upper_{unit}": upper}


def _dh(row: Any) -> dict[str, Any]:
    return {
        "name": row.name,
        "type": row.type,
        "a_m": row.a,
        "alpha_rad": row.alpha,
        "d_m": row.d,
        "theta_rad": row.theta,
        **_limits(row.type, row.lower, row.upper),
    }


def _joint(spec: Mapping[str, Any], names: list[str]) -> dict[str, Any]:
    name, kind = spec["name"], spec["type"]
    row = {"name": name, "type": kind, "link": spec["link"], **_transform(spec["origin"])}
    if kind != "fixed":
        row["axis"] = spec["axis"].tolist()
        row |= _limits(kind, spec["lower"], spec["upper"])
    if spec["mimic"] is not None:
        leader, multiplier, offset = spec["mimic"]
        if leader not in names:
            expected = "joints that follow joints of the chain only"
            raise ArgumentError("robot", f"joint {name!r}, which follows {leader!r}", expected)
        unit = "m" if kind == "prismatic" else "rad"
        row["mimic"] = {"joint": leader, "multiplier": multiplier, f"offset_{unit}": offset}
    if any(isinstance(value, float) and not math.isfinite(value) for value in row.values()):
        raise ArgumentError("robot", f"joint {name!r} with an infinite limit", "finite limits")
    return row


def _explain(content: dict[str, Any], notes: Mapping[str, str]) -> None:
    """Put each note to the table of its number, under the key that the number has now."""
    places = {name: content.get(name, {}) for name in ("base", "tool", "end_effector")}
    places |= {f"frames.{name}": table for name, table in content["frames"].items()}
    places |= {row["name"]: row for row in content.get("dh", content.get("joint", []))}
    for number, note in notes.items():
        place, _, key = number.rpartition(".")
        for old, new in _IN_SI.items():
            key = key.removesuffix(old) + new if key.endswith(old) else key
        table = places.get(place, {})
        if key.startswith("rpy") and "rotation" in table:
            key = "rotation"
        if key in table or any(key_of(key, unit) in table for unit in ("m", "rad")):
            table.setdefault("provenance", {})[key] = note
