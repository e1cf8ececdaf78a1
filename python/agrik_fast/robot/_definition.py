"""What a robot is made of before it is compiled, and where that comes from."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import _bodies, _native
from .._bodies import Body, CollisionRules
from .._checks import FloatArray, items, shown, word
from .._files import listing
from .._warnings import warn
from ..errors import ArgumentError, RobotWarning, UrdfError
from ._degrees import warn_of_degrees
from ._dh_rows import DhRow, DhTable
from ._sources import Source

if TYPE_CHECKING:
    from .._native import JointSpec
    from ._file import RobotFile


class EndEffector(NamedTuple):
    """What an arm carries at its end.

    Attributes
    ----------
    servo : str
        Name of the one servo, as in command sequences.
    moves : tuple of str
        Parts that it opens and closes together.
    """

    servo: str
    moves: tuple[str, ...]


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
    notes: tuple[str, ...] = ()
    home: dict[str, float] = field(default_factory=dict)
    """Values of the home posture by joint, as far as they are said."""
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Joint limits in place of those that the arguments have, by joint."""
    locks: dict[str, float] = field(default_factory=dict)
    """Values of joints that stand still."""
    motion: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    """Velocity, acceleration and jerk limits by joint, as far as they are said."""
    bodies: tuple[Body, ...] = ()
    """Bodies that are known; those of a URDF are read when they are asked for."""
    rules: CollisionRules = field(default_factory=CollisionRules)
    attached: tuple[Body, ...] = ()
    """Bodies put on at run time."""
    urdf: _bodies.UrdfGeometry | None = None
    """Where the bodies of a URDF are to be read; None once they are."""
    looks: _bodies.UrdfGeometry | None = None
    """Where the visual geometry of a URDF is to be read."""
    end_effector: EndEffector | None = None

    def build(self) -> _native.Chain:
        """Compile the chain."""
        chain = self._geometry()
        chain = chain.with_motion_limits(self.motion) if self.motion else chain
        chain = chain.with_limits(self.limits) if self.limits else chain
        return chain.locked(self.locks) if self.locks else chain

    def _geometry(self) -> _native.Chain:
        if self.method == "from_urdf":
            chain, _ = _native.Chain.from_urdf(*self.arguments)
            chain = chain if self.base is None else chain.with_base(self.base)
            return chain if self.tool is None else chain.with_tool(self.tool)
        make: Callable[..., _native.Chain] = getattr(_native.Chain, self.method)
        return make(*self.arguments, self.base, self.tool, self.variable_order)

    def fingerprint(self) -> str:
        """Return a hash of all that the chain is built from."""
        # The hashes' library alone takes a quarter of the memory of a first answer.
        import hashlib
        import json

        parts: list[object] = [
            self.method,
            self.arguments,
            self.base,
            self.tool,
            self.variable_order,
        ]
        parts += [changed for changed in (self.limits, self.locks) if changed]
        return hashlib.sha256(json.dumps(parts, default=_plain).encode()).hexdigest()

    def replaced(self, **changes: Any) -> Definition:
        """Return the definition with other fields."""
        return replace(self, **changes)


def _plain(value: Any) -> Any:
    """Return what JSON has no word for as lists; floats keep all of their digits."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else repr(value)


@dataclass(frozen=True)
class UrdfSolids:
    """How the solids of a URDF are to be read; see `Robot.from_urdf`."""

    cylinder: str = "capsule"
    mesh: str = "convex"
    mesh_folders: tuple[Path, ...] = ()


def urdf_solids(
    cylinder: str, mesh: str, mesh_folders: Sequence[str | PathLike[str]]
) -> UrdfSolids:
    """Return how a URDF's solids are to be read.

    Raises
    ------
    UnknownNameError
        An unknown word.
    ArgumentError
        Folders that are no paths.
    """
    word("cylinder", cylinder, _bodies.CYLINDERS)
    word("mesh", mesh, _bodies.MESHES)
    try:
        folders = [Path(fspath(one)) for one in items("mesh_folders", mesh_folders, "paths")]
    except TypeError:
        raise ArgumentError("mesh_folders", shown(mesh_folders), "paths") from None
    return UrdfSolids(cylinder, mesh, tuple(folders))


def from_urdf(
    source: Source, base_link: str | None, tip_link: str | None, solids: UrdfSolids
) -> tuple[Definition, _native.Chain]:
    """Read a URDF."""
    text, name = source.urdf or "", source.name
    try:
        chain, (base, tip, others, locked) = _native.Chain.from_urdf(text, base_link, tip_link)
    except UrdfError as error:
        raise UrdfError(f"{name}: {error}" if name else str(error)) from None
    notes = []
    if others:
        notes.append(
            f"the tip is link {tip!r}; it could also be {listing(others)} (choose with tip_link)"
        )
    if locked:
        words = "joint" if len(locked) == 1 else "joints"
        said = f"{words} {listing(locked)} cannot move: both limits are 0"
        warn(f"{name or chain.name}: {said}", RobotWarning)
    limits = zip(chain.joint_names, chain.joint_types, chain.lower, chain.upper, strict=True)
    warn_of_degrees(name or chain.name, limits)
    places = _bodies.mesh_places(source.folder, solids.mesh_folders)
    urdf = _bodies.UrdfGeometry(text, name or "URDF", base, places, solids.cylinder, solids.mesh)
    arguments = (text, base, tip)
    made = Definition("from_urdf", arguments, notes=tuple(notes), urdf=urdf, looks=urdf)
    return made, chain


def from_robot_file(path: Path) -> Definition:
    """Read a robot file."""
    # pydantic takes longer to import than everything else together, and robots made
    # from rows or URDF do not need it.
    from ._collision_tables import bodies_of
    from ._file import read, source_fields

    content = read(path)
    method, arguments, dh = _dh(content) if content.dh else _joints(content)
    rows = content.dh or content.joint
    warn_of_degrees(
        path.name,
        [(row.name, row.type, *row.limits) for row in rows],
        [row.alpha for row in dh or ()],
        [row.theta for row in dh or ()],
    )
    hand = content.end_effector
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
        home=content.home(),
        motion=content.motion(),
        bodies=bodies_of(content.collision, content.provenance),
        rules=content.collision_rules.rules(),
        end_effector=None if hand is None else EndEffector(hand.servo, tuple(hand.moves)),
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
                "link": row.link,
            }
        )
    return "from_joints", (content.name, joints), None


def _provenance(content: RobotFile) -> dict[str, str]:
    tables: list[tuple[str, Mapping[str, str]]] = [("base", content.base.provenance)]
    tables += [(row.name, row.provenance) for row in (*content.dh, *content.joint)]
    tables += [("tool", content.tool.provenance)]
    if content.end_effector is not None:
        tables += [("end_effector", content.end_effector.provenance)]
    tables += [(f"frames.{name}", table.provenance) for name, table in content.frames.items()]
    return {f"{place}.{key}": note for place, notes in tables for key, note in notes.items()}
