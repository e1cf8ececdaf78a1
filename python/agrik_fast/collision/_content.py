"""What a scene is made of, checked: objects, targets, what may be touched."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from .._bodies import point
from .._checks import items, real_number, shown, text, word
from ..errors import ArgumentError
from ._objects import SceneObject

Pair = tuple[str, str]

TOUCH_RADIUS = 0.15
"""Distance of the tool point from its target within which the target may be touched, m."""


@dataclass(frozen=True)
class Target:
    """What the tool is to reach, and the objects that may be touched there.

    Parameters
    ----------
    point : array_like, shape (3,), m
        Where the tool point goes, in the frame of the scene.
    objects : sequence of str
        Names of the objects that the bodies which may touch a target do not mind near it: a
        fruit and its stalk.

    Raises
    ------
    ArgumentError
        Not three finite numbers; not names.

    Examples
    --------
    >>> target = ik.collision.Target((0.6, 0.0, 1.1), ("fruit", "stalk"))
    >>> target.objects
    ('fruit', 'stalk')
    """

    point: tuple[float, float, float]
    objects: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", point("point", self.point))
        names = items("objects", self.objects, "a sequence of names")
        object.__setattr__(self, "objects", tuple(text("objects", name) for name in names))


@dataclass(frozen=True)
class Content:
    """Everything that a scene holds; see `Scene`."""

    objects: tuple[SceneObject, ...]
    targets: dict[str, Target] = field(default_factory=dict)
    exemptions: tuple[Pair, ...] = ()
    touch_radius: float = TOUCH_RADIUS
    target: str | None = None
    """Name of the target that is aimed at."""

    @cached_property
    def by_name(self) -> dict[str, SceneObject]:
        """The objects by name, in order."""
        return {one.name: one for one in self.objects}


def checked_content(
    objects: Iterable[SceneObject],
    targets: Mapping[str, Target] | None,
    exemptions: Iterable[Pair],
    touch_radius: float,
) -> Content:
    """Return the content of a scene.

    Raises
    ------
    ArgumentError
        As `Scene`.
    """
    content = Content(
        _checked_objects(objects),
        _checked_targets(targets),
        tuple(
            _checked_pair(pair)
            for pair in items("exemptions", exemptions, "pairs of a body and an object")
        ),
        real_number("touch_radius", touch_radius, 0.0, unit="m"),
    )
    names = [one.name for one in content.objects]
    for where, target in content.targets.items():
        for name in target.objects:
            word(f"object of target {where!r}", name, names)
    for _, name in content.exemptions:
        word("object of an exemption", name, names)
    return content


def _checked_objects(objects: Iterable[SceneObject]) -> tuple[SceneObject, ...]:
    found = items("objects", objects, "an iterable of SceneObject")
    seen: dict[str, int] = {}
    twice: list[str] = []
    for one in found:
        if not isinstance(one, SceneObject):
            raise ArgumentError("objects", shown(one), "an iterable of SceneObject")
        seen[one.name] = seen.get(one.name, 0) + 1
        if seen[one.name] == 2:
            twice.append(repr(one.name))
    if twice:
        raise ArgumentError("objects", f"the name {', '.join(twice)} twice", "names of their own")
    return found


def _checked_targets(targets: Mapping[str, Target] | None) -> dict[str, Target]:
    if targets is None:
        return {}
    given: object = targets
    if not isinstance(given, Mapping):
        raise ArgumentError("targets", shown(given), "a mapping of names to Target")
    for where, target in given.items():
        text("name of a target", where)
        if not isinstance(target, Target):
            raise ArgumentError(f"targets of {where!r}", shown(target), "a Target")
    return dict(given)


def _checked_pair(pair: object) -> Pair:
    both = items("exemptions", pair, "pairs of a body and an object")
    if len(both) != 2:
        raise ArgumentError("exemptions", shown(pair), "pairs of a body and an object")
    return text("body of an exemption", both[0]), text("object of an exemption", both[1])
