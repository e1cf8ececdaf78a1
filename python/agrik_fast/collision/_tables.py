"""The content of a scene file: its keys and their types, and the rows of numbers in it.

pydantic checks keys and types. Rows of numbers, of which there may be a million, are checked
as arrays, after it and whatever it found, so that all faults of a file are told at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat, ValidationError

from .._files import listing, shown
from ..errors import Fault, SceneFileError, nearest_names
from ._objects import SceneObject
from ._solids_in_tables import object_of, tables

__all__ = ["CloudTable", "SceneFile", "TargetTable", "parse"]

_Triple = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
_Length = Annotated[FiniteFloat, Field(ge=0)]
_Name = Annotated[str, Field(min_length=1, max_length=1000)]
_Rows = list[Any]
# Letters of a key that others are compared with.
_COMPARED = 60
UNITS = {"m": 1.0, "mm": 1000.0}
"""Units of a file by their number in a metre."""


class _Table(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class BoxTable(_Table):
    """A box of an object."""

    centre: _Triple
    """Centre."""
    half: _Triple
    """Half lengths along its own axes."""
    R: Annotated[list[_Triple], Field(min_length=3, max_length=3)] | None = None
    """Rotation matrix, row by row: its axes as columns; along the scene's axes without it."""
    radius: _Length = 0.0
    """What its edges are rounded by, outwards."""


class HullTable(_Table):
    """A convex hull of an object."""

    vertices: _Rows
    """Points."""
    radius: _Length = 0.0
    """Radius round the hull."""


class ObjectTable(_Table):
    """One object; any number of solids of any kinds."""

    name: _Name
    """Its name, which no other object has."""
    kind: str = ""
    """What it is, in a word."""
    removable: bool = False
    """True for what may be taken out of the way."""
    note: str = ""
    """For the reader."""
    points: _Rows = []
    """Rows x, y, z of points that share `radius`, or have one each."""
    radius: _Length | list[Any] | None = None
    """Radius of `points`: one number, or a list of one each."""
    spheres: _Rows = []
    """Rows x, y, z, radius."""
    capsules: _Rows = []
    """Rows of two ends and a radius: seven numbers, or [a, b, radius]."""
    boxes: list[BoxTable] = []
    """Boxes."""
    halfspaces: _Rows = []
    """Rows of an outward normal n and d: n . x <= d is solid; four numbers, or [n, d]."""
    hulls: list[HullTable] = []
    """Convex hulls."""


class TargetTable(_Table):
    """A target, and what may be touched there."""

    point: _Triple
    """Where the tool point goes."""
    objects: list[str] | None = None
    """Names of the objects that may be touched near it; that of the target's name without."""


def _as_table(target: Any) -> Any:
    return {"point": target} if isinstance(target, list) else target


_PointOrTarget = Annotated[
    TargetTable, BeforeValidator(_as_table, json_schema_input_type=TargetTable | _Triple)
]


class CloudTable(_Table):
    """A file of labelled points beside the scene file: one object a label."""

    file: _Name
    """Name of the file, beside the scene file: .ply, .pcd, .npz or .csv."""
    unit: Literal["m", "mm"] | None = None
    """Unit of the points; that of the scene file without it."""
    radius: _Length | None = None
    """Radius of points that have none in the file; in the scene file's unit."""
    names: dict[str, str] = {}
    """Names of objects by label; the label itself without one."""
    kind: str = ""
    """What the objects are."""
    removable: bool = False
    """True for what may be taken out of the way."""


class SceneFile(_Table):
    """A scene file's content."""

    format: Literal[1] = 1
    """Version of this form: 1."""
    unit: Literal["m", "mm"]
    """Unit of every length in the file."""
    about: str = ""
    """One line on what it is."""
    touch_radius: _Length | None = None
    """How near to its target the tool point has to be for it to be touched; 150 mm without."""
    exemptions: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = []
    """Pairs of a body and an object that do not mind each other."""
    targets: dict[str, _PointOrTarget] = {}
    """Targets by name: a table, or a point alone."""
    clouds: list[CloudTable] = []
    """Files of labelled points."""
    objects: list[ObjectTable] = []
    """The objects."""


def parse(raw: Any, name: str) -> tuple[SceneFile, list[SceneObject]]:
    """Check the content of a scene file.

    Parameters
    ----------
    raw : object
        What the JSON or TOML text says.
    name : str
        Name of the file, for messages.

    Returns
    -------
    SceneFile, list of SceneObject
        The content, and its objects in metres, clouds not among them.

    Raises
    ------
    SceneFileError
        With every fault and its place.
    """
    if not isinstance(raw, dict):
        raise SceneFileError(name, [("", f"expected a table of keys, got {shown(raw)}")])
    faults: list[Fault] = []
    content = None
    try:
        content = SceneFile.model_validate(raw)
    except ValidationError as error:
        faults += [
            Fault(_place(raw, item["loc"]), _message(item["type"], item["loc"], item))
            for item in error.errors(include_url=False, include_context=False)
        ]
    scale = UNITS.get(str(raw.get("unit")), 1.0)
    objects: list[SceneObject] = []
    for index, table in tables(raw.get("objects")):
        made = object_of(_row(raw, "objects", index), table, scale, faults)
        if made is not None:
            objects.append(made)
    faults += _names_twice(raw)
    faults += _unknown_objects(raw)
    if faults or content is None:
        raise SceneFileError(name, faults)
    return content, objects


# ---- names ---------------------------------------------------------------------------------


def _names_twice(raw: Mapping[str, Any]) -> Iterator[Fault]:
    first: dict[str, int] = {}
    for index, table in tables(raw.get("objects")):
        name = table.get("name")
        if isinstance(name, str) and first.setdefault(name, index) != index:
            place = f"{_row(raw, 'objects', index)}, name"
            yield Fault(place, f"{shown(name)} is the name of row {first[name] + 1} too")


def _unknown_objects(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Faults of exemptions and targets that name no object; clouds may bring any."""
    if raw.get("clouds"):
        return
    names = [
        table["name"]
        for _, table in tables(raw.get("objects"))
        if isinstance(table.get("name"), str)
    ]
    pairs = raw.get("exemptions")
    for number, pair in enumerate(pairs if isinstance(pairs, list) else (), start=1):
        if isinstance(pair, list) and len(pair) == 2 and isinstance(pair[1], str):
            yield from _unknown(f"exemptions row {number}", pair[1], names)
    targets = raw.get("targets")
    for where, target in targets.items() if isinstance(targets, dict) else ():
        objects = target.get("objects") if isinstance(target, dict) else None
        for name in objects if isinstance(objects, list) else ():
            if isinstance(name, str):
                yield from _unknown(f"targets.{where}, objects", name, names)


def _unknown(place: str, name: str, names: Sequence[str]) -> Iterator[Fault]:
    if name not in names:
        near = nearest_names(name[:_COMPARED], names)
        hint = f"; did you mean {shown(near[0])}?" if near else f"; objects: {listing(names)}"
        yield Fault(place, f"no object is named {shown(name)}{hint}")


# ---- words ---------------------------------------------------------------------------------


def _row(raw: Mapping[str, Any], key: str, index: int) -> str:
    """Return the place of a row of tables, counted from 1, with the name that it has."""
    rows = raw.get(key)
    table = rows[index] if isinstance(rows, list) and index < len(rows) else None
    name = table.get("name") if isinstance(table, dict) else None
    return f"{key} row {index + 1}" + (f" ({shown(name)})" if isinstance(name, str) else "")


def _place(raw: Mapping[str, Any], loc: tuple[int | str, ...]) -> str:
    parts: list[str] = []
    for k, part in enumerate(loc):
        if isinstance(part, int):
            parts[-1] = _row(raw, str(loc[0]), part) if k == 1 else f"{parts[-1]} row {part + 1}"
        elif not _is_kind(part):  # which of two allowed kinds was tried
            parts.append(listing([part]))
    return ", ".join(parts)


def _is_kind(part: str) -> bool:
    return "[" in part or part == "float"


_TABLES: dict[str, type[_Table]] = {
    "objects": ObjectTable,
    "boxes": BoxTable,
    "hulls": HullTable,
    "targets": TargetTable,
    "clouds": CloudTable,
}


def _message(kind: str, loc: tuple[int | str, ...], item: Mapping[str, Any]) -> str:
    if kind == "missing":
        if loc == ("unit",):
            return "missing: 'm' or 'mm', the unit of every length in the file"
        return "missing"
    if kind == "extra_forbidden":
        above = [str(part) for part in loc[:-1] if str(part) in _TABLES]
        known = list((_TABLES[above[-1]] if above else SceneFile).model_fields)
        near = nearest_names(str(loc[-1])[:_COMPARED], known)
        return f"unknown key; did you mean {near[0]!r}?" if near else (
            f"unknown key; known: {', '.join(known)}"
        )  # fmt: skip
    message = str(item["msg"])
    return f"{message[0].lower()}{message[1:]}, got {shown(item['input'])}"
