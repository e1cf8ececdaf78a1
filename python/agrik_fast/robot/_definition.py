"""What a robot is made of before it is compiled, and where that comes from."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _native
from .._bodies import CYLINDERS, MESHES, Body, CollisionRules, UrdfGeometry, mesh_places
from .._checks import FloatArray, items, shown, word
from .._files import decode, read_bytes
from ..errors import ArgumentError, UnknownNameError, UrdfError
from ._dh_rows import DhRow, DhTable

if TYPE_CHECKING:
    from .._native import JointSpec
    from ._file import RobotFile

ROBOTS = Path(__file__).resolve().parent / "bundled"
# The core has the same limit for texts.
_URDF_BYTES = 16 << 20
_SUFFIXES = (".toml", ".urdf", ".xml")


@dataclass(frozen=True)
class Definition:
    """Everything that makes a `Robot`.

    The compiled chain cannot be pickled; this can, and a pickled robot is rebuilt
    from it.
    """

    method: str
    """Name of the constructor of `_native.Chain`."""
    arguments: tuple[Any, ...]
    """Its positional arguments, without base and tool."""
    base: FloatArray | None = None
    tool: FloatArray | None = None
    variable_order: list[str] | None = None
    description: str = ""
    source: dict[str, Any] = field(default_factory=dict)
    marks: dict[str, str] = field(default_factory=dict)
    provenance: dict[str, str] = field(default_factory=dict)
    convention: str | None = None
    dh: tuple[DhRow, ...] | None = None
    frames: dict[str, FloatArray] = field(default_factory=dict)
    bodies: tuple[Body, ...] = ()
    """Bodies that are known; those of a URDF are read when they are asked for."""
    rules: CollisionRules = field(default_factory=CollisionRules)
    attached: tuple[Body, ...] = ()
    """Bodies put on at run time."""
    urdf: UrdfGeometry | None = None
    """Where the bodies of a URDF are to be read."""

    def build(self) -> _native.Chain:
        """Compile the chain."""
        if self.method == "from_urdf":
            chain = _native.Chain.from_urdf(*self.arguments)
            chain = chain if self.base is None else chain.with_base(self.base)
            return chain if self.tool is None else chain.with_tool(self.tool)
        make: Callable[..., _native.Chain] = getattr(_native.Chain, self.method)
        return make(*self.arguments, self.base, self.tool, self.variable_order)

    def replaced(self, **changes: Any) -> Definition:
        """Return the definition with other fields."""
        return replace(self, **changes)


def bundled_names() -> tuple[str, ...]:
    """Return the names of the robots in the package, sorted."""
    return tuple(sorted(path.stem for path in ROBOTS.glob("*.toml")))


def locate(name_or_path: str | PathLike[str]) -> Path:
    """Return the file meant by a bundled robot's name or a path."""
    text = fspath(name_or_path)
    path = Path(text)
    looks_like_path = isinstance(name_or_path, PathLike) or path.suffix or path.name != text
    if not looks_like_path:
        if text not in bundled_names():
            raise UnknownNameError("robot", text, bundled_names())
        return ROBOTS / f"{text}.toml"
    if path.suffix not in _SUFFIXES:
        raise ArgumentError(
            "name_or_path", repr(text), f"a bundled robot's name or a {', '.join(_SUFFIXES)} file"
        )
    if not path.is_file():
        raise ArgumentError("name_or_path", f"{text!r}, which is no file", "an existing file")
    return path


def read_urdf(path_or_text: str | PathLike[str]) -> str:
    """Return a URDF's text, reading the file if a path is given."""
    text = fspath(path_or_text)
    if "<" in text:
        return text
    path = Path(text)
    if not path.is_file():
        expected = "the path of an existing URDF, or its text"
        raise ArgumentError("path_or_text", f"{text!r}, which is no file", expected)

    def refuse(reason: str) -> UrdfError:
        return UrdfError(f"{path.name}: {reason}")

    return decode(read_bytes(path, refuse, _URDF_BYTES), refuse)


def urdf_geometry(
    path_or_text: str | PathLike[str],
    base_link: str | None,
    *,
    cylinder: str,
    mesh: str,
    mesh_folders: Sequence[str | PathLike[str]],
) -> UrdfGeometry:
    """Return a URDF's text, and how its solids are to be read."""
    word("cylinder", cylinder, CYLINDERS)
    word("mesh", mesh, MESHES)
    try:
        folders = [Path(fspath(one)) for one in items("mesh_folders", mesh_folders, "paths")]
    except TypeError:
        raise ArgumentError("mesh_folders", shown(mesh_folders), "paths") from None
    content = read_urdf(path_or_text)
    text = fspath(path_or_text)
    file = None if "<" in text else Path(text)
    return UrdfGeometry(
        content,
        "URDF" if file is None else file.name,
        base_link,
        mesh_places(None if file is None else file.parent, folders),
        cylinder,
        mesh,
    )


@contextlib.contextmanager
def naming_file(path_or_text: str | PathLike[str]) -> Iterator[None]:
    """Put the name of the file, if there is one, before what is wrong with its URDF."""
    try:
        yield
    except UrdfError as error:
        text = fspath(path_or_text)
        if "<" in text:
            raise
        raise UrdfError(f"{Path(text).name}: {error}") from None


def from_robot_file(path: Path) -> Definition:
    """Read a robot file."""
    # pydantic takes longer to import than everything else together, and robots made
    # from rows or URDF do not need it.
    from ._collision_tables import bodies_of
    from ._file import read, source_fields

    content = read(path)
    method, arguments, dh = _dh(content) if content.dh else _joints(content)
    return Definition(
        method=method,
        arguments=arguments,
        base=content.base.matrix(),
        tool=content.tool.matrix(),
        variable_order=content.q_order,
        description=content.description,
        source=dict(source_fields(content.source)),
        marks=dict(content.provenance),
        provenance=_provenance(content),
        convention=content.convention,
        dh=dh,
        frames={name: table.matrix() for name, table in content.frames.items()},
        bodies=bodies_of(content.collision, content.provenance),
        rules=content.collision_rules.rules(),
    )


def _dh(content: RobotFile) -> tuple[str, tuple[Any, ...], tuple[DhRow, ...]]:
    limits = np.array([row.limits for row in content.dh])
    table = DhTable(
        rows=np.array([row.values() for row in content.dh]),
        types=[row.type for row in content.dh],
        names=[row.name for row in content.dh],
        lower=limits[:, 0].copy(),
        upper=limits[:, 1].copy(),
    )
    return "from_dh", (content.name, content.convention, *table), table.listing()


def _joints(content: RobotFile) -> tuple[str, tuple[Any, ...], None]:
    joints: list[JointSpec] = []
    for row in content.joint:
        lower, upper = row.limits
        rule = row.mimic
        joints.append(
            {
                "name": row.name,
                "type": row.type,
                "origin": row.matrix(),
                "axis": np.array(row.axis or (0.0, 0.0, 1.0)),
                "lower": lower,
                "upper": upper,
                "mimic": None if rule is None else (rule.joint, rule.multiplier, rule.offset),
            }
        )
    return "from_joints", (content.name, joints), None


def _provenance(content: RobotFile) -> dict[str, str]:
    tables: list[tuple[str, Mapping[str, str]]] = [("base", content.base.provenance)]
    tables += [(row.name, row.provenance) for row in (*content.dh, *content.joint)]
    tables += [("tool", content.tool.provenance)]
    tables += [(f"frames.{name}", table.provenance) for name, table in content.frames.items()]
    return {f"{place}.{key}": note for place, notes in tables for key, note in notes.items()}
