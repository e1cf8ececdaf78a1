"""Bodies of an arm from the ``<collision>`` elements of its URDF."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .. import _rotations
from .._checks import FloatArray
from ..errors import ArgumentError, UrdfError
from ._body import Body
from ._hulls import hull_of, overestimate
from ._meshes import MeshPlaces, triangles_of
from ._shapes import BodyShape, Box, Capsule, Convex, Cover, Sphere

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

CYLINDERS = ("capsule", "convex", "cover")
MESHES = ("convex", "cover")
_SIDES = 16
_PROVENANCE = "URDF"
_Part = tuple[str, BodyShape, float | None]


@dataclass(frozen=True)
class UrdfGeometry:
    """A URDF's solids, read when they are asked for: plain kinematics needs no meshes.

    Attributes
    ----------
    text : str
        The XML text.
    name : str
        What messages call it.
    base_link : str or None
        First link of the chain; None: the only root.
    places : MeshPlaces
        Where mesh files may be.
    cylinder : {"capsule", "convex", "cover"}
        What a cylinder becomes.
    mesh : {"convex", "cover"}
        What a mesh becomes.
    """

    text: str
    name: str = "URDF"
    base_link: str | None = None
    places: MeshPlaces = field(default_factory=MeshPlaces)
    cylinder: str = "capsule"
    mesh: str = "convex"

    def bodies(self, link_names: Sequence[str]) -> tuple[Body, ...]:
        """Return the bodies on a chain.

        Links that hang on the chain without being part of it are on the link that they hang
        on; where a joint moves them, at its zero, with a warning.

        Parameters
        ----------
        link_names : sequence of str
            Links of the chain, as `Robot.link_names` has them, the tool last.

        Raises
        ------
        UrdfError
            A solid that cannot be read, a mesh that is missing or broken.

        Warns
        -----
        UserWarning
            Links with visual geometry alone, which would be free for every query, and links
            that joints outside the chain move.
        """
        from xml.etree import ElementTree

        tree = Tree(ElementTree.fromstring(self.text), self.name)
        base = self.base_link or tree.root
        places = tree.places(base, link_names[:-1])
        bodies: list[Body] = []
        bare: list[str] = []
        for link, (frame, pose) in places.items():
            parts = list(self._parts(tree, link))
            if not parts and tree.links[link].find("visual") is not None:
                bare.append(link)
            for name, shape, over in parts:
                bodies.append(Body(name, frame, shape.moved(pose), _PROVENANCE, over))
        self._warn(tree, base, places, bare)
        return tuple(bodies)

    def _warn(
        self, tree: Tree, base: str, places: dict[str, tuple[int, FloatArray]], bare: list[str]
    ) -> None:
        def say(text: str) -> None:
            warnings.warn(f"{self.name}: {text}", UserWarning, stacklevel=2)

        if bare:
            say(
                f"links with <visual> geometry and no <collision>, which nothing will be found "
                f"to hit: {', '.join(bare)}; give them bodies with `Robot.with_bodies` or "
                f"`Robot.attach`"
            )
        moving = [link for link in tree.moved if link in places and tree.solid(link)]
        if moving:
            say(f"links that joints outside the chain move, taken at zero: {', '.join(moving)}")
        above = [link for link in tree.above(base) if tree.solid(link)]
        if above:
            say(f"links above the base link {base!r}, left out: {', '.join(above)}")

    # -- solids of one link --------------------------------------------------------------

    def _parts(self, tree: Tree, link: str) -> Iterator[_Part]:
        elements = tree.links[link].findall("collision")
        parts: list[tuple[BodyShape, float | None]] = []
        for element in elements:
            pose = origin_of(element, f"link {link!r}: <collision>", self.name)
            for shape, over in self._solids(link, element.find("geometry")):
                parts.append((shape.moved(pose), over))
        for count, (shape, over) in enumerate(parts):
            yield (link if len(parts) == 1 else f"{link}:{count}"), shape, over

    def _solids(
        self, link: str, geometry: Element | None
    ) -> Iterator[tuple[BodyShape, float | None]]:
        def refuse(reason: str) -> UrdfError:
            return UrdfError(f"{self.name}: link {link!r}: {reason}")

        kinds = [] if geometry is None else list(geometry)
        if len(kinds) != 1:
            raise refuse(f"<collision> with {len(kinds)} solids in its <geometry>, expected one")
        solid = kinds[0]
        try:
            if solid.tag == "box":
                yield Box((0, 0, 0), tuple(numbers_of(solid, "size", 3) / 2)), 0.0
            elif solid.tag == "sphere":
                yield Sphere((0, 0, 0), length_of(solid, "radius")), 0.0
            elif solid.tag == "cylinder":
                yield self._cylinder(length_of(solid, "radius"), length_of(solid, "length"))
            elif solid.tag == "capsule":
                half = length_of(solid, "length") / 2
                yield Capsule((0, 0, -half), (0, 0, half), length_of(solid, "radius")), 0.0
            elif solid.tag == "mesh":
                yield from self._meshes(link, solid)
            else:
                raise refuse(
                    f"<{solid.tag}> is no known solid; expected box, sphere, cylinder, capsule "
                    "or mesh"
                )
        except ArgumentError as error:
            words = f"<{solid.tag}> {error.argument}: expected {error.expected}, got"
            raise refuse(f"{words} {error.received}") from None
        except ValueError as error:
            if isinstance(error, UrdfError):
                raise
            raise refuse(f"<{solid.tag}> {error}") from None

    def _cylinder(self, radius: float, length: float) -> tuple[BodyShape, float | None]:
        half = length / 2
        if self.cylinder == "capsule":
            return Capsule((0, 0, -half), (0, 0, half), radius), radius
        if self.cylinder == "cover":
            cover = Cover((0, 0, 0), (radius, radius, half))
            over = math.sqrt(2.0) * radius - radius
            return cover, over + (cover.overestimate or 0.0)
        # The sides of the prism touch the cylinder, its corners stand out.
        out = radius / math.cos(math.pi / _SIDES)
        angles = 2 * math.pi * np.arange(_SIDES) / _SIDES
        ring = [(out * math.cos(a), out * math.sin(a)) for a in angles.tolist()]
        corners = tuple((x, y, z) for z in (-half, half) for x, y in ring)
        return Convex(corners), out - radius

    def _meshes(self, link: str, solid: Element) -> Iterator[tuple[BodyShape, float | None]]:
        name = solid.get("filename")
        if not name:
            raise ValueError("has no filename")
        scale = numbers_of(solid, "scale", 3) if solid.get("scale") else np.ones(3)
        for triangles in triangles_of(link, self.places.find(link, name)):
            scaled = triangles * scale
            points = scaled.reshape(-1, 3)
            if self.mesh == "cover":
                low, high = points.min(axis=0), points.max(axis=0)
                half = np.maximum((high - low) / 2, 1e-9)
                yield Cover(tuple((low + high) / 2), tuple(half)), None
                continue
            hull = hull_of(points)
            yield hull, overestimate(hull, scaled)


# ---- the tree of links ---------------------------------------------------------------------


class Tree:
    """Links and joints of a URDF, whose form the compiled core has checked."""

    def __init__(self, robot: Element, name: str) -> None:
        self._name = name
        self.links = {str(one.get("name")): one for one in robot.findall("link")}
        self.moved: list[str] = []
        self._children: dict[str, list[tuple[str, Element]]] = {}
        self._parent: dict[str, str] = {}
        for joint in robot.findall("joint"):
            parent, child = _link(joint, "parent"), _link(joint, "child")
            self._children.setdefault(parent, []).append((child, joint))
            self._parent[child] = parent
        self.root = next((link for link in self.links if link not in self._parent), "")

    def solid(self, link: str) -> bool:
        """Return whether a link has solids."""
        return self.links[link].find("collision") is not None

    def above(self, link: str) -> list[str]:
        """Return the links that lead to one."""
        found = []
        while link in self._parent:
            link = self._parent[link]
            found.append(link)
        return found

    def places(self, base: str, chain: Sequence[str]) -> dict[str, tuple[int, FloatArray]]:
        """Return for each link the frame of the arm that it stands still in, and where."""
        found = {base: (0, np.eye(4))} | {
            link: (number, np.eye(4)) for number, link in enumerate(chain, start=1)
        }
        waiting = list(found)
        while waiting:
            link = waiting.pop(0)
            frame, pose = found[link]
            for child, joint in self._children.get(link, ()):
                if child in found or child not in self.links:
                    continue
                found[child] = (frame, pose @ origin_of(joint, f"joint of {child!r}:", self._name))
                if joint.get("type") != "fixed" or link in self.moved:
                    self.moved.append(child)
                waiting.append(child)
        # In the order of the arm: the base, then link by link, each with what hangs on it.
        return dict(sorted(found.items(), key=lambda item: item[1][0]))


def _link(joint: Element, tag: str) -> str:
    element = joint.find(tag)
    return "" if element is None else str(element.get("link"))


def origin_of(element: Element, what: str, name: str) -> FloatArray:
    pose = np.eye(4)
    origin = element.find("origin")
    if origin is None:
        return pose
    try:
        if origin.get("xyz"):
            pose[:3, 3] = numbers_of(origin, "xyz", 3)
        if origin.get("rpy"):
            pose[:3, :3] = _rotations.from_rpy(numbers_of(origin, "rpy", 3))
    except ValueError as error:
        raise UrdfError(f"{name}: {what} <origin> {error}") from None
    return pose


def numbers_of(element: Element, key: str, count: int) -> FloatArray:
    words = (element.get(key) or "").split()
    try:
        values = np.array([float(word) for word in words])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count or not np.isfinite(values).all():
        got = repr(element.get(key))
        raise ValueError(f"{key}: expected {count} finite numbers, got {got}")
    return values


def length_of(element: Element, key: str) -> float:
    value = float(numbers_of(element, key, 1)[0])
    if value < 0.0:
        raise ValueError(f"{key}: expected a length >= 0, got {value:g}")
    return value


def mesh_places(folder: Path | None, given: Sequence[Path]) -> MeshPlaces:
    """Return the places of the meshes of a URDF in a folder."""
    return MeshPlaces(None if folder is None else folder.resolve(), tuple(given))
