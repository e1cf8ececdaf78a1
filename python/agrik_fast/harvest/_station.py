"""An arm, a scene and targets, as the compiled core takes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, float_array, shown, text, whole_number, word
from ..collision import Scene, Target
from ..errors import ArgumentError
from ..robot import Robot
from ._settings import checked_distance

__all__ = ["STATIC_KIND", "Chosen", "Crop", "Targets"]

STATIC_KIND = "machine"
"""Objects of this kind are never touched, but may be near: a rail, a vehicle."""

Targets: TypeAlias = "str | Sequence[str | tuple[str, Target]] | Mapping[str, Target] | ArrayLike"


@dataclass(frozen=True, eq=False)
class Chosen:
    """Targets with their names, points (n, 3) and objects."""

    names: tuple[str, ...]
    points: FloatArray
    objects: list[list[int]]

    def __len__(self) -> int:
        return len(self.names)


def loaded(robot: Robot | str) -> Robot:
    """Return a robot, or that of a name."""
    arm = Robot.load(robot) if isinstance(robot, str) else robot
    if not isinstance(arm, Robot):
        raise ArgumentError("robot", shown(robot), "a Robot or the name of one")
    return arm


def moved_along(robot: Robot, along: float) -> Robot:
    """Return a robot that stands `along` (m) farther along y."""
    base = robot.base.copy()
    base[1, 3] += along
    return robot.with_base(base)


class Crop:
    """An arm with bodies in a scene, and how distances are measured."""

    def __init__(
        self,
        robot: Robot | str,
        scene: Scene,
        distance: str,
        level: int,
        split: str,
        along: float = 0.0,
    ) -> None:
        self.robot = loaded(robot)
        self.along = along
        if not isinstance(scene, Scene):
            raise ArgumentError("scene", shown(scene), "a Scene")
        self.scene = scene
        self.distance = checked_distance(distance)
        self.level = whole_number("level", level, 0, 3)
        self.split = word("split", split, ("equal", "near-cubic"))
        collider = scene.collider(self.robot)
        self.bodies, self.things = collider.bodies, collider.scene
        body = {name: k for k, name in enumerate(self.bodies.names)}
        self._thing = {name: k for k, name in enumerate(scene.names)}
        rules = self.robot.collision_rules
        named = {name for _, name in rules.static_skip}
        self.statics = [
            k for k, one in enumerate(scene.objects) if one.kind == STATIC_KIND or one.name in named
        ]
        pairs = (*rules.static_skip, *scene.exemptions)
        self.skip = [(body[a], self._thing[b]) for a, b in pairs if b in self._thing]
        self.touching = [body[name] for name in rules.may_touch_target if name in body]

    @property
    def _level(self) -> int | None:
        return self.level if self.distance == "tree" else None

    @cached_property
    def station(self) -> _native.HarvestStation:
        """The arm in the crop, for the two-step method."""
        return _native.HarvestStation(
            self.bodies,
            self.things,
            self.statics,
            self.skip,
            self.touching,
            self._level,
            self.split,
            (0.0, self.along, 0.0),
        )

    def programme(
        self, point: tuple[float, float, float], objects: list[int], weights: list[float]
    ) -> _native.HarvestProgramme:
        """Return the non-linear programme of a target."""
        return _native.HarvestProgramme(
            self.bodies,
            self.things,
            self.statics,
            self.skip,
            self.touching,
            point,
            objects,
            weights,
            self._level,
            self.split,
        )

    def chosen(self, targets: Targets | None) -> Chosen:
        """Return the targets that were asked for; all of the scene's for None."""
        found = self._named(targets)
        if found is None:
            points = float_array("targets", cast(ArrayLike, targets))
            if points.ndim != 2 or points.shape[1] != 3:
                expected = "names, a mapping of names to Target, or an array of shape (n, 3), m"
                raise ArgumentError("targets", f"shape {points.shape}", expected)
            names = tuple(str(k) for k in range(len(points)))
            return Chosen(names, points, [[] for _ in names])
        seen: set[str] = set()
        for name, target in found:
            text("targets", name)
            if not isinstance(target, Target):
                raise ArgumentError(f"targets of {name!r}", shown(target), "a Target")
            if name in seen:
                raise ArgumentError("targets", f"{name!r} twice", "names that differ")
            seen.add(name)
            for one in target.objects:
                word(f"object of target {name!r}", one, self._thing)
        return Chosen(
            tuple(name for name, _ in found),
            np.array([target.point for _, target in found], dtype=float).reshape(-1, 3),
            [[self._thing[one] for one in target.objects] for _, target in found],
        )

    def _named(self, targets: Targets | None) -> list[tuple[str, Target]] | None:
        known = self.scene.targets
        if targets is None:
            return list(known.items())
        if isinstance(targets, str):
            targets = [targets]
        if isinstance(targets, Mapping):
            return list(targets.items())
        if isinstance(targets, np.ndarray) or not isinstance(targets, Sequence | set | frozenset):
            return None
        found = []
        for one in targets:
            if isinstance(one, str):
                word("target", one, known)
                found.append((one, known[one]))
            elif isinstance(one, tuple) and len(one) == 2 and isinstance(one[1], Target):
                found.append((text("targets", one[0]), one[1]))
            else:
                return None
        return found

    def refuse_targets_inside(self, chosen: Chosen) -> None:
        """Refuse targets that lie in an object which is not theirs."""
        for k, inside in enumerate(self.station.inside(chosen.points, chosen.objects)):
            if inside >= 0:
                received = f"a point inside the obstacle {self.scene.names[inside]!r}"
                expected = "a point in none, or in one of the target's own objects"
                raise ArgumentError(f"targets: {chosen.names[k]}", received, expected)
