"""Robot files: the TOML form of a robot, read strictly.

A file describes a chain in one of two forms, ``[[dh]]`` rows or ``[[joint]]``
rows, with optional ``[base]``, ``[tool]``, ``[frames.<name>]``, ``[source]`` and
``[provenance]`` tables, and bodies for collisions (``[[collision]]``,
``[collision_rules]``). Every number's key ends in its unit: ``_m`` or ``_mm``,
``_rad`` or ``_deg``, with ``_s``, ``_s2``, ``_s3`` behind it for limits of
motion. Unknown keys are faults, and all faults of a file are reported at once.

pydantic checks types and keys. What needs more than one key (one unit only,
limits that suit the joint's type, names that exist) is checked on the raw
tables, so that a wrong type in one row does not hide a fault in another.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from .. import _rotations
from .._files import decode, listing, parse_toml, read_bytes, shown
from ..errors import Fault, RobotFileError, nearest_names
from ._collision_tables import CollisionRulesTable, CollisionTable, collision_faults
from ._file_checks import MOTION, NAMED_FAULTS, combined_faults, quantity

__all__ = ["DhTable", "JointTable", "MimicTable", "RobotFile", "TransformTable", "read"]

_Triple = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
_JointType = Literal["revolute", "continuous", "prismatic", "fixed"]
_Name = Annotated[str, Field(min_length=1, max_length=1000)]
# Rows of a robot: some checks take the square of them.
_ROWS = 1000
_T = TypeVar("_T")


class _Table(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class TransformTable(_Table):
    """A rigid transform: a translation and a rotation, both optional."""

    xyz_m: _Triple | None = None
    """Translation x, y, z, m."""
    xyz_mm: _Triple | None = None
    """Translation x, y, z, mm."""
    rpy_rad: _Triple | None = None
    """Roll, pitch, yaw about the fixed x, y, z axes in turn (as in URDF), rad."""
    rpy_deg: _Triple | None = None
    """The same, degrees."""
    rotation: Annotated[list[_Triple], Field(min_length=3, max_length=3)] | None = None
    """Rotation matrix, row by row; instead of roll, pitch, yaw."""
    description: str | None = None
    """What the frame is."""
    provenance: dict[str, str] = {}
    """Where the numbers are from: mark, or mark and text."""

    def matrix(self) -> NDArray[np.float64]:
        """Return the transform as an array, shape (4, 4), m."""
        result = np.eye(4)
        tables = self.model_dump()
        result[:3, 3] = _or(quantity(tables, "xyz"), (0.0, 0.0, 0.0))
        if self.rotation is not None:
            result[:3, :3] = self.rotation
        else:
            rpy = _or(quantity(tables, "rpy"), (0.0, 0.0, 0.0))
            result[:3, :3] = _rotations.from_rpy(np.array(rpy))
        return result


class MimicTable(_Table):
    """The rule of a joint that follows another: multiplier * value + offset."""

    joint: _Name
    """Name of the joint it follows."""
    multiplier: FiniteFloat = 1.0
    """Factor, no unit (rad/rad, m/m) or rad/m, m/rad."""
    offset_m: FiniteFloat | None = None
    """Added, m."""
    offset_mm: FiniteFloat | None = None
    """Added, mm."""
    offset_rad: FiniteFloat | None = None
    """Added, rad."""
    offset_deg: FiniteFloat | None = None
    """Added, degrees."""

    @property
    def offset(self) -> float:
        """Added after the factor, m or rad."""
        return float(_or(quantity(self.model_dump(), "offset"), 0.0))


class _Row(_Table):
    name: _Name
    """Name of the joint."""
    type: _JointType
    """revolute, continuous, prismatic or fixed."""
    lower_m: FiniteFloat | None = None
    """Smallest value of a prismatic joint, m."""
    lower_mm: FiniteFloat | None = None
    """The same, mm."""
    lower_rad: FiniteFloat | None = None
    """Smallest value of a revolute joint, rad."""
    lower_deg: FiniteFloat | None = None
    """The same, degrees."""
    upper_m: FiniteFloat | None = None
    """Largest value of a prismatic joint, m."""
    upper_mm: FiniteFloat | None = None
    """The same, mm."""
    upper_rad: FiniteFloat | None = None
    """Largest value of a revolute joint, rad."""
    upper_deg: FiniteFloat | None = None
    """The same, degrees."""
    velocity_m_s: FiniteFloat | None = None
    """Largest speed of a prismatic joint, m/s."""
    velocity_mm_s: FiniteFloat | None = None
    """The same, mm/s."""
    velocity_rad_s: FiniteFloat | None = None
    """Largest speed of a turning joint, rad/s."""
    velocity_deg_s: FiniteFloat | None = None
    """The same, degrees/s."""
    acceleration_m_s2: FiniteFloat | None = None
    """Largest acceleration and deceleration of a prismatic joint, m/s^2."""
    acceleration_mm_s2: FiniteFloat | None = None
    """The same, mm/s^2."""
    acceleration_rad_s2: FiniteFloat | None = None
    """Largest acceleration and deceleration of a turning joint, rad/s^2."""
    acceleration_deg_s2: FiniteFloat | None = None
    """The same, degrees/s^2."""
    jerk_m_s3: FiniteFloat | None = None
    """Largest change of the acceleration of a prismatic joint, m/s^3."""
    jerk_mm_s3: FiniteFloat | None = None
    """The same, mm/s^3."""
    jerk_rad_s3: FiniteFloat | None = None
    """Largest change of the acceleration of a turning joint, rad/s^3."""
    jerk_deg_s3: FiniteFloat | None = None
    """The same, degrees/s^3."""
    home_m: FiniteFloat | None = None
    """Value of a prismatic joint in the home posture, m."""
    home_mm: FiniteFloat | None = None
    """The same, mm."""
    home_rad: FiniteFloat | None = None
    """Value of a turning joint in the home posture, rad."""
    home_deg: FiniteFloat | None = None
    """The same, degrees."""
    provenance: dict[str, str] = {}
    """Where the numbers are from: mark, or mark and text."""

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest value, rad or m; infinite where there is none."""
        table = self.model_dump()
        return (
            float(_or(quantity(table, "lower"), -np.inf)),
            float(_or(quantity(table, "upper"), np.inf)),
        )

    @property
    def motion(self) -> tuple[float, float, float]:
        """Velocity, acceleration and jerk limit, rad or m and s; infinite where unknown."""
        table = self.model_dump()
        velocity, acceleration, jerk = (float(_or(quantity(table, x), np.inf)) for x in MOTION)
        return velocity, acceleration, jerk


class DhTable(_Row):
    """One row of a Denavit-Hartenberg table.

    The joint's value is added to theta (revolute, continuous) or to d (prismatic).
    """

    a_m: FiniteFloat | None = None
    """Link length, m."""
    a_mm: FiniteFloat | None = None
    """Link length, mm."""
    alpha_rad: FiniteFloat | None = None
    """Link twist, rad."""
    alpha_deg: FiniteFloat | None = None
    """Link twist, degrees."""
    d_m: FiniteFloat | None = None
    """Link offset, m."""
    d_mm: FiniteFloat | None = None
    """Link offset, mm."""
    theta_rad: FiniteFloat | None = None
    """Joint angle offset, rad."""
    theta_deg: FiniteFloat | None = None
    """Joint angle offset, degrees."""

    def values(self) -> tuple[float, float, float, float]:
        """Return a (m), alpha (rad), d (m), theta (rad)."""
        table = self.model_dump()
        a, alpha, d, theta = (float(quantity(table, k)) for k in ("a", "alpha", "d", "theta"))
        return a, alpha, d, theta


class JointTable(_Row, TransformTable):
    """One joint by its origin in the previous link and its axis in that origin."""

    axis: _Triple | None = None
    """Direction of the axis; any length but zero."""
    link: _Name | None = None
    """Name of the link it carries; without it the joint's name and `_link`."""
    mimic: MimicTable | None = None
    """Rule, if the joint follows another."""


class EndEffectorTable(_Table):
    """What the arm carries at its end and what drives it."""

    servo: _Name
    """Name of the one servo, as in command sequences."""
    moves: Annotated[list[_Name], Field(min_length=1)]
    """Names of the parts that it opens and closes together."""
    provenance: dict[str, str] = {}
    """Where the names are from: mark, or mark and text."""


class SourceTable(_Table):
    """Where the robot's description is from."""

    title: _Name
    """Title of the paper or the model."""
    authors: str | None = None
    """Authors' surnames."""
    journal: str | None = None
    """Journal, volume, pages."""
    year: int | None = None
    """Year of publication."""
    doi: str | None = None
    """DOI, without the address of a resolver."""
    url: str | None = None
    """Address."""
    equation: str | None = None
    """Numbers of the equations used."""
    table: str | None = None
    """Numbers of the tables used."""
    note: str | None = None
    """Readings, corrections, doubts."""


class RobotFile(_Table):
    """A robot file's content."""

    format: Literal[1]
    """Version of this form: 1."""
    name: _Name
    """Short name of the robot."""
    description: str = ""
    """One line: what it is, its joints, its tool frame."""
    convention: Literal["standard", "modified"] | None = None
    """Kind of the ``[[dh]]`` rows: standard (distal) or modified (Craig)."""
    q_order: list[str] | None = None
    """Names of the joint variables in the order of q; physical order without it."""
    source: SourceTable | None = None
    """Where the description is from."""
    provenance: dict[str, str] = {}
    """Meaning of each mark used in the rows' ``provenance``."""
    base: TransformTable = TransformTable()
    """First link's frame in the frame that poses are given in."""
    tool: TransformTable = TransformTable()
    """Tool in the last link's frame."""
    end_effector: EndEffectorTable | None = None
    """What is at the arm's end, if it is more than a point."""
    frames: dict[str, TransformTable] = {}
    """Further frames: each transform leads from poses of this file to that frame."""
    dh: Annotated[list[DhTable], Field(max_length=_ROWS)] = []
    """Denavit-Hartenberg rows, from base to tool."""
    joint: Annotated[list[JointTable], Field(max_length=_ROWS)] = []
    """Joint rows, from base to tool."""
    collision: Annotated[list[CollisionTable], Field(max_length=_ROWS)] = []
    """Bodies on the frames."""
    collision_rules: CollisionRulesTable = CollisionRulesTable()
    """Which collisions of them count."""

    def home(self) -> dict[str, float]:
        """Return the values of the home posture, rad or m, by the joints that have one."""
        rows = [*self.dh, *self.joint]
        said = {row.name: quantity(row.model_dump(), "home") for row in rows}
        return {name: float(value) for name, value in said.items() if value is not None}

    def motion(self) -> dict[str, tuple[float, float, float]]:
        """Return velocity, acceleration and jerk limits, rad or m and s, by joint.

        Of the joints that have one of them; infinite where the file says nothing.
        """
        unknown = (np.inf, np.inf, np.inf)
        said = {row.name: row.motion for row in (*self.dh, *self.joint)}
        return {name: limits for name, limits in said.items() if limits != unknown}


def read(path: Path) -> RobotFile:
    """Read and check a robot file.

    Parameters
    ----------
    path : path
        TOML file.

    Returns
    -------
    RobotFile
        The content; all checks passed.

    Raises
    ------
    RobotFileError
        With every fault of the file and its place; also if it cannot be read.
    """

    def refuse(reason: str) -> RobotFileError:
        return RobotFileError(path.name, [("", reason)])

    return parse(read_bytes(path, refuse), path.name)


def parse(data: bytes, name: str) -> RobotFile:
    """Check the content of a robot file; `name` is used in messages only."""

    def refuse(reason: str) -> RobotFileError:
        return RobotFileError(name, [("", reason)])

    raw = parse_toml(decode(data, refuse), refuse)
    faults: list[Fault] = []
    result = None
    try:
        result = RobotFile.model_validate(raw)
    except ValidationError as error:
        for item in error.errors(include_url=False, include_context=False):
            # The nearest of many names takes a while to find.
            hint = len(faults) < NAMED_FAULTS
            message = _message(item["type"], item["loc"], item["msg"], item["input"], hint=hint)
            faults.append(Fault(_place(item["loc"]), message))
    if not any(isinstance(raw.get(rows), list) and len(raw[rows]) > _ROWS for rows in _ROW_TABLES):
        faults += combined_faults(raw)
        faults += collision_faults(raw)
    if faults or result is None:
        raise RobotFileError(name, faults)
    return result


def _place(loc: tuple[int | str, ...]) -> str:
    if len(loc) > 1 and isinstance(loc[1], int):
        place, keys = f"[[{loc[0]}]] row {loc[1] + 1}", loc[2:]
    elif loc[0] == "frames" and len(loc) > 1:
        place, keys = f"[frames.{loc[1]}]", loc[2:]
    elif len(loc) > 1:
        place, keys = f"[{loc[0]}]", loc[1:]
    else:
        place, keys = "", loc
    key = listing([".".join(str(k) for k in keys if isinstance(k, str))])
    return ", ".join(part for part in (place, key) if part)


_ROW_TABLES = ("dh", "joint", "collision")
_UNIT = re.compile(r"(?:m|mm|rad|deg)(?:_s[23]?)?$")
# Letters of a key that others are compared with.
_COMPARED = 60
_TABLES: dict[str, type[BaseModel]] = {
    "base": TransformTable,
    "tool": TransformTable,
    "frames": TransformTable,
    "source": SourceTable,
    "end_effector": EndEffectorTable,
    "dh": DhTable,
    "joint": JointTable,
    "collision": CollisionTable,
    "collision_rules": CollisionRulesTable,
}


def _message(
    kind: str, loc: tuple[int | str, ...], message: str, value: object, *, hint: bool
) -> str:
    if kind == "missing":
        return "missing"
    if kind == "extra_forbidden":
        table: type[BaseModel] = RobotFile if len(loc) == 1 else _TABLES[str(loc[0])]
        if "mimic" in loc[:-1]:
            table = MimicTable
        known = list(table.model_fields)
        stem = f"{loc[-1]}_"
        in_units = [repr(n) for n in known if n.startswith(stem) and _UNIT.match(n[len(stem) :])]
        if in_units and hint:
            *first, last = in_units
            words = f"{', '.join(first)} or {last}" if first else last
            return f"unknown key, its name ends in a unit; did you mean {words}?"
        near = nearest_names(str(loc[-1])[:_COMPARED], known) if hint else ()
        if near:
            return f"unknown key; did you mean {near[0]!r}?"
        return f"unknown key; known: {', '.join(known)}" if hint else "unknown key"
    if kind == "too_long" and loc[-1] in _ROW_TABLES:
        return f"expected at most {_ROWS} rows, got {len(value) if isinstance(value, list) else 0}"
    return f"{message[0].lower()}{message[1:]}, got {shown(value)}"


def _or(value: _T | None, default: _T) -> _T:
    return default if value is None else value


def source_fields(source: SourceTable | None) -> Mapping[str, Any]:
    """Return the given fields of a source table, in the file's order of keys."""
    return {} if source is None else source.model_dump(exclude_none=True)
