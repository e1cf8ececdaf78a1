"""A ball on two slides among rooms: paths whose blockers can be told without any planner."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np

import agrik_fast as ik
from agrik_fast.collision import Body, Box, Scene, SceneObject, Sphere
from urdf_text import joint, urdf

ROOM = 0.3
"""Length of a room, m."""
BALL = 0.08
WALL = 0.01
"""Half the thickness of walls and doors, m."""

Room = tuple[int, int]
Passage = tuple[Room, Room]


def gantry(size: int) -> ik.Robot:
    """Return a ball that slides over rooms, `size` in a row each way."""
    limit = (0.0, ROOM * size)
    text = urdf(
        ["base", "bridge", "carriage"],
        [
            joint("x", "base", "bridge", kind="prismatic", axis="1 0 0", limit=limit),
            joint("y", "bridge", "carriage", kind="prismatic", axis="0 1 0", limit=limit),
        ],
    )
    return ik.Robot.from_urdf(text).with_bodies([Body("ball", "carriage", Sphere([0, 0, 0], BALL))])


def centre(room: Room) -> np.ndarray:
    """Return the joint values in the middle of a room."""
    return ROOM * (np.array(room) + 0.5)


def passages(size: int) -> list[Passage]:
    """Return all pairs of rooms that are neighbours."""
    rooms = list(itertools.product(range(size), repeat=2))
    steps = ((1, 0), (0, 1))
    pairs = [((i, j), (i + di, j + dj)) for (i, j) in rooms for di, dj in steps]
    return [pair for pair in pairs if max(pair[1]) < size]


def between(passage: Passage) -> Box:
    """Return the box that shuts a passage."""
    a, b = (np.array(room) for room in passage)
    x, y = ROOM * (a + b + 1) / 2
    along = (WALL, ROOM / 2, BALL + 0.01)
    half = along if a[0] != b[0] else (along[1], along[0], along[2])
    return Box([x, y, 0.0], list(half))


def rooms(size: int, walls: Iterable[Passage], doors: dict[str, list[Passage]]) -> Scene:
    """Return rooms with walls that stay, and doors that may be taken out."""
    length = ROOM * size / 2
    high = BALL + 0.01
    shell = [
        Box([length, length, side * (high + WALL)], [length, length, WALL]) for side in (-1, 1)
    ]
    for side in (-WALL, 2 * length + WALL):
        shell.append(Box([side, length, 0], [WALL, length, high]))
        shell.append(Box([length, side, 0], [length, WALL, high]))
    fixed = SceneObject.of("walls", *shell, *(between(one) for one in walls))
    leaves = [
        SceneObject.of(name, *(between(one) for one in shut), removable=True)
        for name, shut in doors.items()
    ]
    return Scene([fixed, *leaves])


def opens(
    size: int, walls: Iterable[Passage], doors: dict[str, list[Passage]], gone: Iterable[str],
    start: Room, goal: Room,
) -> bool:  # fmt: skip
    """Return whether rooms hang together once some doors are gone."""
    shut = set(walls)
    for name, of in doors.items():
        if name not in set(gone):
            shut |= set(of)
    todo, seen = [start], {start}
    while todo:
        room = todo.pop()
        for a, b in passages(size):
            if (a, b) in shut or room not in (a, b):
                continue
            other = b if room == a else a
            if other not in seen:
                seen.add(other)
                todo.append(other)
    return goal in seen


def least_doors(
    size: int, walls: Iterable[Passage], doors: dict[str, list[Passage]], start: Room, goal: Room
) -> int | None:
    """Return how many doors have to go, by trying all sets; None where that does not help."""
    for count in range(len(doors) + 1):
        for gone in itertools.combinations(doors, count):
            if opens(size, walls, doors, gone, start, goal):
                return count
    return None
