"""Triangles as a browser is given them: few meshes, each with one colour."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .. import _bodies
from .._bodies import HalfSpace
from .._checks import FloatArray
from ..collision import Scene
from ..plots import FIELD, PALETTE
from ..robot import COLOURS, Surface

Rgb = tuple[int, int, int]
# Spheres of an object above this number are points of a cloud, not meshes.
_MOST_BALLS = 200
# Round things of a scene of many solids have this many sides: a browser without a graphics card
# draws them too.
_MANY, _FEW_SIDES, _SIDES = 100, 8, 20


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one colour that stand still in one frame, or move as the hand opens."""

    frame: int
    vertices: FloatArray
    faces: NDArray[np.int32]
    colour: Rgb
    opens: tuple[float, float, float] = (0.0, 0.0, 0.0)
    name: str = ""


@dataclass(frozen=True, eq=False)
class Points:
    """Balls that are shown as points."""

    places: FloatArray
    size: float
    colour: Rgb


def rgb(colour: str | Sequence[float]) -> Rgb:
    """Return red, green, blue, 0 to 255, of "#rrggbb" or of three numbers, 0 to 1."""
    if isinstance(colour, str):
        red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    else:
        red, green, blue = (round(255 * value) for value in colour[:3])
    return red, green, blue


def arm_meshes(parts: Iterable[Surface]) -> list[Mesh]:
    """Return the meshes of an arm: one for each frame and colour; fingers have their own."""
    groups: dict[tuple[int, Rgb, str], list[Surface]] = {}
    for each in parts:
        colour = rgb(each.colour or COLOURS[each.role])
        moving = each.name if any(each.opens) else ""
        groups.setdefault((each.frame, colour, moving), []).append(each)
    return [
        Mesh(frame, *_joined([(p.vertices, p.faces) for p in group]), colour, group[0].opens, name)
        for (frame, colour, name), group in groups.items()
    ]


def whole(parts: Iterable[Surface], frames: FloatArray) -> tuple[FloatArray, NDArray[np.int32]]:
    """Return an arm at a posture as one mesh, for pale copies of it."""
    return _joined([(each.placed(frames), each.faces) for each in parts])


def scene_solids(scene: Scene) -> tuple[list[Mesh], list[Points]]:
    """Return the objects of a scene: meshes by colour, and clouds of many spheres as points."""
    groups: dict[Rgb, list[tuple[FloatArray, NDArray[np.int32]]]] = {}
    points = []
    sides = _FEW_SIDES if sum(map(len, scene.objects)) > _MANY else _SIDES
    for one in scene.objects:
        colour = rgb(FIELD.get(one.kind, PALETTE[5]))
        many = len(one.spheres) > _MOST_BALLS
        if many:
            size = 2 * float(np.median(one.spheres[:, 3]))
            points.append(Points(one.spheres[:, :3], max(size, 0.002), colour))
        rest = replace(one, spheres=np.zeros((0, 4))) if many else one
        for shape in rest.shapes():
            place = rgb(FIELD["ground"]) if isinstance(shape, HalfSpace) else colour
            groups.setdefault(place, []).append(_bodies.surface(shape, sides))
    return [Mesh(0, *_joined(group), colour) for colour, group in groups.items()], points


def _joined(
    parts: Sequence[tuple[FloatArray, NDArray[np.int32]]],
) -> tuple[FloatArray, NDArray[np.int32]]:
    shifts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = np.concatenate([vertices for vertices, _ in parts])
    faces = np.concatenate(
        [faces + shift for (_, faces), shift in zip(parts, shifts, strict=False)]
    )
    return vertices, faces.astype(np.int32)


def wxyz(rotations: FloatArray) -> FloatArray:
    """Return the unit quaternions of rotations, scalar first, as browsers want them."""
    from ..rotations import quat_of

    return np.roll(quat_of(rotations), 1, axis=-1)
