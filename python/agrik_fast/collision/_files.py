"""Scene files: reading and writing."""

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .._atomic import write_bytes
from .._checks import FloatArray, text, truth_value, word
from .._checks import path as checked_path
from .._files import decode, parse_json, parse_toml, read_bytes
from ..errors import ArgumentError, Fault, SceneFileError
from ._clouds import objects_of, read_cloud
from ._content import TOUCH_RADIUS, Content, Target, checked_content
from ._objects import SceneObject
from ._solids_in_tables import numbers_in
from ._tables import UNITS, SceneFile, parse

SUFFIXES = (".json", ".toml")
# A million points are some 60 MB of JSON. TOML is read by a parser in Python.
JSON_BYTES = 256 << 20
TOML_BYTES = 16 << 20


def file_schema() -> dict[str, Any]:
    """Return the JSON Schema of scene files, for editors.

    Returns
    -------
    dict
        The schema.

    Examples
    --------
    >>> from agrik_fast.collision import file_schema
    >>> file_schema()["required"]
    ['unit']
    """
    return SceneFile.model_json_schema()


def load(path: str | PathLike[str]) -> Content:
    """Read a scene file; see `Scene.load`."""
    file = checked_path("path", path)
    if file.suffix not in SUFFIXES:
        raise ArgumentError("path", repr(str(file)), f"a {' or '.join(SUFFIXES)} file")
    if not file.is_file():
        raise ArgumentError("path", f"{str(file)!r}, which is no file", "an existing file")

    def refuse(reason: str) -> SceneFileError:
        return SceneFileError(file.name, [("", reason)])

    limit = JSON_BYTES if file.suffix == ".json" else TOML_BYTES
    content = decode(read_bytes(file, refuse, limit), refuse)
    raw: Any = (parse_json if file.suffix == ".json" else parse_toml)(content, refuse)
    return content_of(raw, file.name, file.parent)


def content_of(document: Any, name: str, folder: str | PathLike[str]) -> Content:
    """Return what a scene file says; see `from_document`."""
    content, objects = parse(document, text("name", name))
    objects += _clouds(content, checked_path("folder", folder), name)
    scale = UNITS[content.unit]
    names = {one.name for one in objects}
    targets = {}
    for where, table in content.targets.items():
        usual = [where] if where in names else []
        touched = usual if table.objects is None else table.objects
        targets[where] = Target(_point(table.point, scale), tuple(touched))
    touch = content.touch_radius
    try:
        return checked_content(
            objects,
            targets,
            [(body, one) for body, one in content.exemptions],
            TOUCH_RADIUS if touch is None else float(numbers_in(touch, scale)),
        )
    except ArgumentError as error:
        # What clouds bring is known only now.
        raise SceneFileError(name, [("", str(error))]) from None


def _point(values: list[float], scale: float) -> tuple[float, float, float]:
    x, y, z = numbers_in(values, scale).tolist()
    return x, y, z


def _clouds(content: SceneFile, folder: Path, name: str) -> list[SceneObject]:
    objects: list[SceneObject] = []
    faults: list[Fault] = []
    scale = UNITS[content.unit]
    for number, table in enumerate(content.clouds, start=1):
        place = f"clouds row {number} ({table.file!r})"
        radius = None if table.radius is None else float(numbers_in(table.radius, scale))
        try:
            cloud = read_cloud(folder / table.file, unit=table.unit or content.unit, radius=radius)
            objects += objects_of(
                cloud, names=table.names, kind=table.kind, removable=table.removable
            )
        except SceneFileError as error:
            faults += [
                Fault(", ".join(part for part in (place, fault.place) if part), fault.message)
                for fault in error.faults
            ]
        except ArgumentError as error:
            faults.append(Fault(place, str(error)))
    if faults:
        raise SceneFileError(name, faults)
    return objects


# ---- writing -------------------------------------------------------------------------------


def save(
    content: Content, path: str | PathLike[str], *, unit: str, about: str, force: bool
) -> None:
    """Write a scene file; see `Scene.save`."""
    file = checked_path("path", path)
    if file.suffix not in SUFFIXES:
        raise ArgumentError("path", repr(str(file)), f"a {' or '.join(SUFFIXES)} file")
    truth_value("force", force)
    document = table_of(content, unit=unit, about=about)
    written = _json(document) if file.suffix == ".json" else _toml(document)

    def refuse(reason: str) -> SceneFileError:
        return SceneFileError(file.name, [("", reason.replace("--force", "force=True"))])

    write_bytes(file, written.encode(), refuse, force=force)


def table_of(content: Content, *, unit: str, about: str) -> dict[str, Any]:
    """Return a scene as the content of a scene file; see `document_of`."""
    scale = UNITS[word("unit", unit, UNITS)]
    document: dict[str, Any] = {"format": 1, "unit": unit}
    if text("about", about):
        document["about"] = about
    document["touch_radius"] = content.touch_radius * scale
    if content.exemptions:
        document["exemptions"] = [list(pair) for pair in content.exemptions]
    if content.targets:
        document["targets"] = {
            where: {
                "point": (np.array(target.point) * scale).tolist(),
                "objects": list(target.objects),
            }
            for where, target in content.targets.items()
        }
    document["objects"] = [_object_table(one, scale) for one in content.objects]
    return document


def _object_table(one: SceneObject, scale: float) -> dict[str, Any]:
    table: dict[str, Any] = {"name": one.name}
    if one.kind:
        table["kind"] = one.kind
    if one.removable:
        table["removable"] = True
    if len(one.spheres):
        table["spheres"] = (one.spheres * scale).tolist()
    if len(one.capsules):
        table["capsules"] = (one.capsules * scale).tolist()
    if len(one.boxes):
        table["boxes"] = [_box_table(row, scale) for row in one.boxes]
    if len(one.halfspaces):
        table["halfspaces"] = (one.halfspaces * [1.0, 1.0, 1.0, scale]).tolist()
    if one.hulls:
        table["hulls"] = [
            {"vertices": (points * scale).tolist(), "radius": radius * scale}
            for points, radius in one.hulls
        ]
    return table


def _box_table(row: FloatArray, scale: float) -> dict[str, Any]:
    table: dict[str, Any] = {
        "centre": (row[:3] * scale).tolist(),
        "half": (row[3:6] * scale).tolist(),
    }
    if row[6:15].tolist() != np.eye(3).ravel().tolist():
        table["R"] = row[6:15].reshape(3, 3).tolist()
    if row[15]:
        table["radius"] = float(row[15] * scale)
    return table


def _json(document: dict[str, Any]) -> str:
    """Return a document with one object a line."""
    objects = [json.dumps(one, ensure_ascii=False) for one in document.pop("objects")]
    head = json.dumps(document, ensure_ascii=False)[:-1]
    return f'{head}, "objects": [\n' + ",\n".join(objects) + "\n]}\n"


def _toml(document: dict[str, Any]) -> str:
    """Return a document as TOML, one table an object."""
    objects, targets = document.pop("objects"), document.pop("targets", {})
    lines = [f"{key} = {_value(value)}" for key, value in document.items()]
    for where, table in targets.items():
        lines += ["", f"[targets.{_value(where)}]"]
        lines += [f"{key} = {_value(value)}" for key, value in table.items()]
    for one in objects:
        lines += ["", "[[objects]]", *(f"{key} = {_value(value)}" for key, value in one.items())]
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_value(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    # JSON's texts, numbers and truth values are TOML's as well, but for the letter DEL.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
