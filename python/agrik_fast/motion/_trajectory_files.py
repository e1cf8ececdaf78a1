"""Trajectories in files: tables, and the shape of ROS's JointTrajectory."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from io import BytesIO
from os import PathLike
from typing import Any

import numpy as np

from .. import _atomic, _checks
from .._checks import FloatArray, truth_value
from ..errors import AgrikError, ArgumentError
from ..io import ResultFileError, import_pyarrow
from ._points import Points

__all__ = ["columns", "message", "save"]

_NANOSECONDS = 10**9


def save(points: Points, path: str | PathLike[str], *, force: bool) -> None:
    """Write a trajectory; see `Trajectory.save`."""
    file = _checks.path("path", path)
    truth_value("force", force)

    def refuse(reason: str) -> AgrikError:
        return ResultFileError(file, reason)

    make = _MAKERS.get(file.suffix.lower())
    if make is None:
        raise ArgumentError("path", repr(str(file)), f"a name that ends in {', '.join(_MAKERS)}")
    _atomic.write_bytes(file, make(points, refuse), refuse, force=force)


def message(points: Points, frame_id: str = "") -> dict[str, Any]:
    """Return a trajectory as ROS has it; see `Trajectory.to_ros`."""
    _checks.text("frame_id", frame_id)
    stamps = np.rint(points.times * _NANOSECONDS).astype(np.int64)
    # Of points that the message cannot tell apart the last one counts.
    kept = np.append(np.diff(stamps) > 0, True)
    rows = [
        {
            "positions": q,
            "velocities": v,
            "accelerations": a,
            "effort": [],
            "time_from_start": {"sec": stamp // _NANOSECONDS, "nanosec": stamp % _NANOSECONDS},
        }
        for q, v, a, stamp in zip(
            points.positions[kept].tolist(),
            points.velocities[kept].tolist(),
            points.accelerations[kept].tolist(),
            stamps[kept].tolist(),
            strict=True,
        )
    ]
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": frame_id}
    return {"header": header, "joint_names": list(points.joint_names), "points": rows}


def columns(points: Points) -> dict[str, FloatArray]:
    """Return the columns of a table: time, joint values, velocities, accelerations."""
    units = ["m" if kind == "prismatic" else "rad" for kind in points.joint_types]
    table = {"time_s": points.times}
    blocks = (
        ("", points.positions),
        ("_s", points.velocities),
        ("_s2", points.accelerations),
    )
    for behind, block in blocks:
        for name, unit, column in zip(points.joint_names, units, block.T, strict=True):
            table[f"{name}_{unit}{behind}"] = column
    return table


def _csv(points: Points, _: Callable[[str], AgrikError]) -> bytes:
    table = columns(points)
    rows = np.column_stack(list(table.values())).tolist()
    lines = [",".join(_quoted(name) for name in table)]
    lines += [",".join(map(repr, row)) for row in rows]
    return ("\n".join(lines) + "\n").encode()


def _quoted(name: str) -> str:
    if any(letter in name for letter in ',"\r\n'):
        return '"' + name.replace('"', '""') + '"'
    return name


def _parquet(points: Points, refuse: Callable[[str], AgrikError]) -> bytes:
    pyarrow = import_pyarrow(refuse)
    from pyarrow import parquet

    stream = BytesIO()
    table = {name: np.ascontiguousarray(column) for name, column in columns(points).items()}
    parquet.write_table(pyarrow.table(table), stream, use_dictionary=False)
    return stream.getvalue()


def _npz(points: Points, _: Callable[[str], AgrikError]) -> bytes:
    stream = BytesIO()
    np.savez(
        stream,
        joint_names=np.array(points.joint_names),
        joint_types=np.array(points.joint_types),
        times=points.times,
        positions=points.positions,
        velocities=points.velocities,
        accelerations=points.accelerations,
    )
    return stream.getvalue()


def _json(points: Points, _: Callable[[str], AgrikError]) -> bytes:
    return (json.dumps(message(points), ensure_ascii=False, indent=1) + "\n").encode()


def _yaml(points: Points, _: Callable[[str], AgrikError]) -> bytes:
    return ("\n".join(_yaml_lines(message(points))) + "\n").encode()


def _yaml_lines(content: dict[str, Any]) -> Iterator[str]:
    """Write the message as YAML: flow style from the second level on.

    All that is in it is written so that readers of YAML 1.1 and 1.2 agree on it.
    """
    for key in ("header", "joint_names"):
        yield f"{key}: {_flow(content[key])}"
    yield "points:"
    for point in content["points"]:
        for lead, (key, value) in zip(("- ", *("  ",) * 4), point.items(), strict=True):
            yield f"{lead}{key}: {_flow(value)}"


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, float):
        # YAML 1.1 takes 1e-05 for a text.
        text = repr(value)
        return text if "." in text else text.replace("e", ".0e")
    return json.dumps(value)


_MAKERS: dict[str, Callable[[Points, Callable[[str], AgrikError]], bytes]] = {
    ".csv": _csv,
    ".parquet": _parquet,
    ".npz": _npz,
    ".json": _json,
    ".yaml": _yaml,
    ".yml": _yaml,
}
