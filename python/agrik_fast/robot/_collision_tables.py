"""The tables of a robot file on collisions: ``[[collision]]`` and ``[collision_rules]``.

Single keys are checked by pydantic in `_file`, what needs more than one key here on the raw
tables, as in `_file_checks`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from .. import _rotations
from .._bodies import Body, BodyShape, Box, Capsule, CollisionRules, Convex, Cover, Sphere
from .._files import listing, shown
from ..errors import Fault, nearest_names
from ._file_checks import mark_faults, one_unit, quantity, transform_faults

_Triple = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
_Length = Annotated[FiniteFloat, Field(ge=0)]
_Name = Annotated[str, Field(min_length=1, max_length=1000)]
_Pairs = list[Annotated[list[_Name], Field(min_length=2, max_length=2)]]
_Vertices = Annotated[list[_Triple], Field(min_length=1, max_length=10_000)]
LENGTH = ("m", "mm")

# Lengths that a body of each shape has to have, and those that it may have.
SHAPES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "sphere": (("centre", "radius"), ()),
    "capsule": (("a", "b", "radius"), ()),
    "box": (("centre", "half"), ("radius",)),
    "convex": (("vertices",), ("radius",)),
    "cover": (("centre", "half"), ()),
}
_TURNED = ("box", "cover")


class CollisionTable(BaseModel):
    """One body of a robot: a solid that stands still in one of its frames."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    name: _Name
    """Name of the body, which no other has."""
    frame: Annotated[int, Field(ge=0)] | _Name
    """0 or "base", or the number (from 1) or the name of the link; "tool" is the tool frame."""
    shape: Literal["sphere", "capsule", "box", "convex", "cover"]
    """What it is."""
    centre_m: _Triple | None = None
    """Centre of a sphere, a box or a cover, m."""
    centre_mm: _Triple | None = None
    """The same, mm."""
    a_m: _Triple | None = None
    """One end of a capsule's core, m."""
    a_mm: _Triple | None = None
    """The same, mm."""
    b_m: _Triple | None = None
    """The other end, m."""
    b_mm: _Triple | None = None
    """The same, mm."""
    half_m: _Triple | None = None
    """Half lengths of a box or a cover along its own axes, m."""
    half_mm: _Triple | None = None
    """The same, mm."""
    rotation: Annotated[list[_Triple], Field(min_length=3, max_length=3)] | None = None
    """Rotation matrix of a box or a cover, row by row: its axes as columns."""
    rpy_rad: _Triple | None = None
    """Instead: roll, pitch, yaw about the fixed x, y, z axes in turn, rad."""
    rpy_deg: _Triple | None = None
    """The same, degrees."""
    vertices_m: _Vertices | None = None
    """Points of a convex body, which is their hull, m."""
    vertices_mm: _Vertices | None = None
    """The same, mm."""
    radius_m: _Length | None = None
    """Radius round the core; of boxes and convex bodies 0 without it, m."""
    radius_mm: _Length | None = None
    """The same, mm."""
    level: Annotated[int, Field(ge=0, le=3)] | None = None
    """Level of a cover, which has 8^level spheres; 3 without it."""
    split: Literal["equal", "near-cubic"] | None = None
    """How a cover's box is split; equal without it."""
    overestimate_m: _Length | None = None
    """How far the body reaches out of what it stands for, m."""
    overestimate_mm: _Length | None = None
    """The same, mm."""
    provenance: dict[str, str] = {}
    """Where the numbers are from: mark, or mark and text; the key "shape" is for all of them."""

    def body(self) -> Body:
        """Return the body, in metres."""
        over = quantity(self.model_dump(), "overestimate")
        if over is None and self.shape == "cover":
            over = self._cover().overestimate
        return Body(self.name, self.frame, self._shape(), self.provenance.get("shape", ""), over)

    def _shape(self) -> BodyShape:
        table = self.model_dump()
        radius = quantity(table, "radius") or 0.0
        if self.shape == "sphere":
            return Sphere(quantity(table, "centre"), radius)
        if self.shape == "capsule":
            return Capsule(quantity(table, "a"), quantity(table, "b"), radius)
        if self.shape == "convex":
            return Convex(quantity(table, "vertices"), radius)
        if self.shape == "cover":
            return self._cover()
        return Box(quantity(table, "centre"), quantity(table, "half"), self._turn(), radius)

    def _cover(self) -> Cover:
        table = self.model_dump()
        level = 3 if self.level is None else self.level
        centre, half = quantity(table, "centre"), quantity(table, "half")
        return Cover(centre, half, self._turn(), level, self.split or "equal")

    def _turn(self) -> Any:
        rpy = quantity(self.model_dump(), "rpy")
        if self.rotation is not None:
            return self.rotation
        return np.eye(3) if rpy is None else _rotations.from_rpy(np.array(rpy))


class CollisionRulesTable(BaseModel):
    """Which collisions of the bodies count."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    may_touch_target: list[_Name] = []
    """Bodies that may touch a target while the tool point is near it."""
    static_skip: _Pairs = []
    """Pairs of a body and an object of a scene that it does not mind."""
    pairs: _Pairs | None = None
    """Pairs of bodies that are asked whether they hit each other; worked out without it."""
    exclude: _Pairs = []
    """Pairs that are not asked, where they are worked out."""

    def rules(self) -> CollisionRules:
        """Return the rules."""
        return CollisionRules(
            tuple(self.may_touch_target),
            tuple((a, b) for a, b in self.static_skip),
            None if self.pairs is None else tuple((a, b) for a, b in self.pairs),
            tuple((a, b) for a, b in self.exclude),
        )


def collision_faults(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Faults of the raw tables that a check of single keys cannot see."""
    rows = raw.get("collision")
    tables = [
        (number, row)
        for number, row in enumerate(rows if isinstance(rows, list) else (), start=1)
        if isinstance(row, dict)
    ]
    frames = _frames(raw)
    first: dict[str, int] = {}
    for number, row in tables:
        place = f"[[collision]] row {number}"
        yield from _shape_faults(place, row)
        yield from mark_faults(place, row, raw.get("provenance"))
        frame, name = row.get("frame"), row.get("name")
        if isinstance(frame, str) and frame not in frames:
            near = nearest_names(frame[:60], frames)
            hint = f"; did you mean {shown(near[0])}?" if near else f"; frames: {listing(frames)}"
            yield Fault(f"{place}, frame", f"no frame is named {shown(frame)}{hint}")
        elif isinstance(frame, int) and not isinstance(frame, bool) and frame >= len(frames):
            yield Fault(f"{place}, frame", f"expected at most {len(frames) - 1}, got {frame}")
        if isinstance(name, str) and first.setdefault(name, number) != number:
            yield Fault(f"{place}, name", f"{shown(name)} is the name of row {first[name]} too")
    if isinstance(raw.get("collision_rules"), dict):
        yield from _rule_faults(raw["collision_rules"], list(first))


def _frames(raw: Mapping[str, Any]) -> list[str]:
    """Return the names of the frames, those of the links as `Robot.link_names` has them."""
    rows = raw.get("dh") or raw.get("joint")
    links = [
        str(row.get("link") or f"{row.get('name')}_link")
        for row in (rows if isinstance(rows, list) else ())
        if isinstance(row, dict)
    ]
    return ["base", *links, "tool"]


def _shape_faults(place: str, row: Mapping[str, Any]) -> Iterator[Fault]:
    shape = row.get("shape")
    if shape not in SHAPES:
        return
    needed, allowed = SHAPES[shape]
    for stem in needed:
        yield from one_unit(place, row, stem, LENGTH, required=True)
    for stem in (*allowed, "overestimate"):
        yield from one_unit(place, row, stem, LENGTH, required=False)
    of_others = {stem for parts in SHAPES.values() for part in parts for stem in part}
    for stem in sorted(of_others - {*needed, *allowed}):
        for key in (f"{stem}_{unit}" for unit in LENGTH):
            if key in row:
                yield Fault(f"{place}, {key}", f"a {shape} has none")
    for key in ("rotation", "rpy_rad", "rpy_deg"):
        if key in row and shape not in _TURNED:
            yield Fault(f"{place}, {key}", f"a {shape} is not turned")
    for key in ("level", "split"):
        if key in row and shape != "cover":
            yield Fault(f"{place}, {key}", f"a {shape} has none")
    if shape in _TURNED:
        yield from transform_faults(place, row)
        half = quantity(row, "half") if _numbers(row, "half") else None
        least = 0.0 if shape == "box" else np.nextafter(0.0, 1.0)
        if half is not None and min(half) < least:
            word = ">= 0" if shape == "box" else "> 0"
            yield Fault(f"{place}, half", f"expected half lengths {word}, got {half} m")


def _numbers(row: Mapping[str, Any], stem: str) -> bool:
    values = [row[f"{stem}_{unit}"] for unit in LENGTH if f"{stem}_{unit}" in row]
    return bool(values) and all(
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in value)
        for value in values
    )


def _rule_faults(rules: Mapping[str, Any], bodies: Sequence[str]) -> Iterator[Fault]:
    def unknown(key: str, name: Any) -> Iterator[Fault]:
        if isinstance(name, str) and name not in bodies:
            near = nearest_names(name[:60], bodies)
            hint = f"; did you mean {shown(near[0])}?" if near else f"; bodies: {listing(bodies)}"
            yield Fault(f"[collision_rules], {key}", f"no body is named {shown(name)}{hint}")

    touching = rules.get("may_touch_target")
    for name in touching if isinstance(touching, list) else ():
        yield from unknown("may_touch_target", name)
    for key, how_many in (("static_skip", 1), ("pairs", 2), ("exclude", 2)):
        pairs = rules.get(key)
        for number, pair in enumerate(pairs if isinstance(pairs, list) else (), start=1):
            if isinstance(pair, list) and len(pair) == 2:
                for name in pair[:how_many]:
                    yield from unknown(f"{key} row {number}", name)
                if how_many == 2 and isinstance(pair[0], str) and pair[0] == pair[1]:
                    place = f"[collision_rules], {key} row {number}"
                    yield Fault(place, f"{shown(pair[0])} twice, expected two bodies")
    if "pairs" in rules and rules.get("exclude"):
        yield Fault("[collision_rules], exclude", "given with pairs, which leave out all others")


def bodies_of(tables: Sequence[CollisionTable], marks: Mapping[str, str]) -> tuple[Body, ...]:
    """Return the bodies of checked tables; a mark is told with its meaning."""
    found = []
    for table in tables:
        body = table.body()
        mark, _, more = body.provenance.partition(":")
        meaning = marks.get(mark, mark)
        said = f"{meaning}:{more}" if more else meaning
        found.append(Body(body.name, body.frame, body.shape, said, body.overestimate))
    return tuple(found)
