"""What a URDF's links look like: the triangles of its ``<visual>`` elements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray
from ..errors import UrdfError
from ._meshes import triangles_of
from ._shapes import Box, Capsule, Sphere
from ._surfaces import Triangles, cylinder, surface
from ._urdf import Tree, UrdfGeometry, length_of, numbers_of, origin_of

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Visual:
    """What one link of a URDF looks like, in the frame of the arm that it stands still in."""

    link: str
    frame: int
    vertices: FloatArray
    faces: NDArray[np.int32]
    colour: Colour | None


def has_visuals(geometry: UrdfGeometry) -> bool:
    """Return whether a URDF says what its links look like."""
    from xml.etree import ElementTree

    return any(ElementTree.fromstring(geometry.text).iterfind("link/visual/geometry"))


def visuals(geometry: UrdfGeometry, link_names: Sequence[str]) -> tuple[Visual, ...]:
    """Return what the links on a chain look like.

    Parameters
    ----------
    geometry : UrdfGeometry
    link_names : sequence of str
        Links of the chain, as `Robot.link_names` has them, the tool last.

    Raises
    ------
    UrdfError
        A mesh is missing or broken, a number is none.
    """
    from xml.etree import ElementTree

    root = ElementTree.fromstring(geometry.text)
    tree = Tree(root, geometry.name)
    named = {str(one.get("name")): colour for one in root.findall("material")
             if (colour := _colour(one)) is not None}  # fmt: skip
    found = []
    for link, (frame, pose) in tree.places(
        geometry.base_link or tree.root, link_names[:-1]
    ).items():
        for element in tree.links[link].findall("visual"):
            place = pose @ origin_of(element, f"link {link!r}: <visual>", geometry.name)
            material = element.find("material")
            colour = None
            if material is not None:
                colour = _colour(material) or named.get(str(material.get("name")))
            try:
                for vertices, faces in _solids(geometry, link, element.find("geometry")):
                    moved = vertices @ place[:3, :3].T + place[:3, 3]
                    found.append(Visual(link, frame, moved, faces, colour))
            except ValueError as error:
                if isinstance(error, UrdfError):
                    raise
                raise UrdfError(f"{geometry.name}: link {link!r}: <visual> {error}") from None
    return tuple(found)


def _solids(geometry: UrdfGeometry, link: str, element: Element | None) -> Iterator[Triangles]:
    for solid in () if element is None else element:
        if solid.tag == "box":
            yield surface(Box((0, 0, 0), tuple(numbers_of(solid, "size", 3) / 2)))
        elif solid.tag == "sphere":
            yield surface(Sphere((0, 0, 0), length_of(solid, "radius")))
        elif solid.tag in ("cylinder", "capsule"):
            half, radius = length_of(solid, "length") / 2, length_of(solid, "radius")
            ends = (0.0, 0.0, -half), (0.0, 0.0, half)
            if solid.tag == "capsule":
                yield surface(Capsule(*ends, radius))
            else:
                yield cylinder(np.array(ends[0]), np.array(ends[1]), radius)
        elif solid.tag == "mesh":
            name = solid.get("filename")
            if not name:
                raise ValueError("<mesh> has no filename")
            scale = numbers_of(solid, "scale", 3) if solid.get("scale") else np.ones(3)
            for triangles in triangles_of(link, geometry.places.find(link, name)):
                corners, faces = np.unique(
                    (triangles * scale).reshape(-1, 3), axis=0, return_inverse=True
                )
                order = faces.reshape(-1, 3).astype(np.int32)
                # A mirrored mesh is inside out.
                yield corners, order[:, ::-1] if np.prod(scale) < 0 else order
        else:
            raise ValueError(f"<{solid.tag}> is no known solid")


def _colour(material: Element) -> Colour | None:
    element = material.find("color")
    if element is None:
        return None
    values = numbers_of(element, "rgba", 4)
    red, green, blue = (float(min(1.0, max(0.0, value))) for value in values[:3])
    return red, green, blue
