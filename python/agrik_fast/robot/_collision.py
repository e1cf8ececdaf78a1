"""The part of `Robot` that knows its solids: bodies on links, tools, held objects."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from .. import _native
from .._bodies import (
    Body,
    BodyShape,
    Box,
    Capsule,
    CollisionRules,
    Convex,
    Cover,
    ExcludedPair,
    SelfPairs,
    Sphere,
)
from .._checks import items, shown, text, truth_value, whole_number, word
from ..errors import ArgumentError

if TYPE_CHECKING:
    from ._definition import Definition

__all__ = ["CollisionBodies"]

# What the compiled core calls the shapes.
_KINDS = {Sphere: "sphere", Capsule: "capsule", Box: "box", Convex: "convex", Cover: "cover"}


class CollisionBodies:
    """The part of `Robot` that knows its solids."""

    __slots__ = ("_compiled", "_definition")

    _chain: _native.Chain
    _definition: Definition
    _compiled: _native.Bodies | None

    def _with(self, definition: Definition) -> Self:
        raise NotImplementedError

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The solids on its frames, those that were attached last.

        Those of a URDF, with its meshes, are read when this is first asked for.

        Raises
        ------
        UrdfError
            A solid of the URDF cannot be read: a mesh is missing (says where it was looked
            for) or broken, or `agrik_fast[meshes]` is not installed.

        Warns
        -----
        UserWarning
            Links of a URDF that have visual geometry alone.
        """
        definition = self._definition
        if definition.urdf is not None:
            own = definition.urdf.bodies(self._chain.link_names)
            # Robots made of this one, and copies in other processes, need not read them again.
            self._definition = definition = definition.replaced(bodies=own, urdf=None)
        return definition.bodies + definition.attached

    @property
    def collision_rules(self) -> CollisionRules:
        """Which collisions of the bodies count."""
        return self._definition.rules

    @property
    def self_pairs(self) -> SelfPairs:
        """Which bodies are asked whether they hit each other, and why others are not.

        Raises
        ------
        ArgumentError
            The robot has no bodies.
        """
        names = [body.name for body in self.bodies]
        compiled = self.compiled_bodies()
        rules = self.collision_rules
        by_rule = "not listed" if rules.pairs is not None else "excluded"
        asked = tuple((names[i], names[j]) for i, j in compiled.self_pairs)
        excluded = []
        usual = {(i, j): (why, share) for i, j, why, share in self._usual().excluded_pairs}
        for i, j, _, _ in compiled.excluded_pairs:
            why, share = usual.get((i, j), (by_rule, None))
            excluded.append(ExcludedPair((names[i], names[j]), why, share))
        return SelfPairs(asked, tuple(excluded))

    def with_bodies(self, bodies: Iterable[Body], rules: CollisionRules | None = None) -> Self:
        """Return the same robot with other solids on its links.

        Parameters
        ----------
        bodies : iterable of Body
            Instead of all that it has, attached ones too.
        rules : CollisionRules, optional
            Which collisions of them count; default: none that may touch a target, no object
            skipped, self pairs worked out.

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        ArgumentError
            Two bodies of one name, a rule of an unknown body.
        UnknownNameError
            An unknown frame.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> from agrik_fast.collision import Body, Capsule
        >>> arm = Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], name="planar")
        >>> links = [Body(f"link{k}", k, Capsule([-1, 0, 0], [0, 0, 0], 0.05)) for k in (1, 2)]
        >>> [body.name for body in arm.with_bodies(links).bodies]
        ['link1', 'link2']
        """
        found = self._checked("bodies", bodies)
        kept = CollisionRules() if rules is None else rules
        if not isinstance(kept, CollisionRules):
            raise ArgumentError("rules", shown(rules), "CollisionRules")
        _check_names(found)
        _check_rules(kept, [body.name for body in found])
        definition = self._definition.replaced(bodies=found, rules=kept, attached=(), urdf=None)
        return self._with(definition)

    def attach(
        self,
        bodies: Body | BodyShape | Iterable[Body | BodyShape],
        frame: int | str | None = None,
        *,
        name: str = "attached",
        may_touch_target: bool = True,
    ) -> Self:
        """Return the same robot with a tool or a held object on it.

        An object that is held is no obstacle any more: take it out of the scene with
        `Scene.without`.

        Parameters
        ----------
        bodies : Body, shape, or iterable of them
            What is put on. A body's own frame counts where `frame` is not given.
        frame : int or str, optional
            The frame that it stands still in, as for `Body`; default the last link's, "tool"
            is the tool frame.
        name : str, default "attached"
            Name of a shape; several get a number behind it.
        may_touch_target : bool, default True
            Whether it may touch the objects of a target near it.

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        ArgumentError
            No shape or body, a name that another body has.
        UnknownNameError
            An unknown frame.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> from agrik_fast.collision import Sphere
        >>> arm = Robot.load("panda").attach(Sphere([0, 0, 0.1], 0.03), "tool", name="fruit")
        >>> arm.bodies[-1].name
        'fruit'
        """
        if isinstance(bodies, Body | Sphere | Capsule | Box | Convex | Cover):
            given: tuple[Body | BodyShape, ...] = (bodies,)
        else:
            given = items("bodies", bodies, "bodies or shapes")
        text("name", name)
        last = len(self._chain.link_names) - 1
        found: list[Body] = []
        for number, one in enumerate(given):
            if isinstance(one, Body):
                found.append(one if frame is None else replace(one, frame=frame))
            elif isinstance(one, Sphere | Capsule | Box | Convex | Cover):
                own = name if len(given) == 1 else f"{name}{number}"
                found.append(Body(own, last if frame is None else frame, one))
            else:
                raise ArgumentError("bodies", shown(one), "bodies or shapes")
        checked = self._checked("bodies", found)
        _check_names((*self.bodies, *checked))
        touches = truth_value("may_touch_target", may_touch_target)
        touching = [body.name for body in checked if touches]
        rules = replace(
            self.collision_rules,
            may_touch_target=(*self.collision_rules.may_touch_target, *touching),
        )
        attached = (*self._definition.attached, *checked)
        return self._with(self._definition.replaced(attached=attached, rules=rules))

    def detach(self, *names: str) -> Self:
        """Return the same robot without bodies that were attached.

        Parameters
        ----------
        *names : str
            Names of attached bodies; none: all of them.

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        UnknownNameError
            No attached body has that name.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> held = arm.attach(ik.collision.Sphere((0, 0, 0.1), 0.03), "tool", name="fruit")
        >>> len(held.bodies) - len(held.detach("fruit").bodies)
        1
        """
        known = [body.name for body in self._definition.attached]
        for name in names:
            word("attached body", name, known)
        gone = names or known
        kept = tuple(body for body in self._definition.attached if body.name not in gone)
        touching = self.collision_rules.may_touch_target
        rules = replace(
            self.collision_rules,
            may_touch_target=tuple(name for name in touching if name not in gone),
        )
        return self._with(self._definition.replaced(attached=kept, rules=rules))

    def compiled_bodies(self) -> _native.Bodies:
        """Return the bodies as the compiled core has them; made once.

        Raises
        ------
        ArgumentError
            The robot has no bodies; says how it gets some.

        Examples
        --------
        >>> len(ik.Robot.load("panda").compiled_bodies().frames)
        12
        """
        if self._compiled is None:
            self._compiled = self._compile()
        return self._compiled

    # -- how they are made ---------------------------------------------------------------

    def _compile(self) -> _native.Bodies:
        bodies, rules = self.bodies, self.collision_rules
        if not bodies:
            raise ArgumentError(
                "arm",
                f"{self._chain.name!r}, which has no bodies",
                "an arm with bodies: [[collision]] tables in its robot file, <collision> "
                "elements in its URDF, or `Robot.with_bodies` and `Robot.attach`",
            )
        usual = self._usual()
        if rules.pairs is None and not rules.exclude:
            return usual
        index = {body.name: k for k, body in enumerate(bodies)}

        def numbers(pairs: Iterable[tuple[str, str]]) -> list[tuple[int, int]]:
            both = ((index[a], index[b]) for a, b in pairs)
            return [(min(pair), max(pair)) for pair in both]

        first = len(bodies) - len(self._definition.attached)
        if rules.pairs is None:
            gone = set(numbers(rules.exclude))
            wanted = [pair for pair in usual.self_pairs if pair not in gone]
        else:
            # The list knows nothing of what was put on later. Of equal distances the first pair
            # is told, so its order counts.
            later = [pair for pair in usual.self_pairs if max(pair) >= first]
            wanted = list(dict.fromkeys([*numbers(rules.pairs), *later]))
        return self._native(wanted)

    def _usual(self) -> _native.Bodies:
        """Return the bodies with the self pairs that are worked out; made once a chain."""
        return self._native(None)

    def _native(self, pairs: list[tuple[int, int]] | None) -> _native.Bodies:
        bodies = self.bodies
        return _native.Bodies(
            self._chain,
            [body.name for body in bodies],
            [self.frame_number(body.frame) for body in bodies],
            [_KINDS[type(body.shape)] for body in bodies],
            [_core(body.shape) for body in bodies],
            np.array([getattr(body.shape, "radius", 0.0) for body in bodies]),
            pairs,
            [k >= len(bodies) - len(self._definition.attached) for k in range(len(bodies))],
        )

    def frame_number(self, frame: int | str) -> int:
        """Return the number of a frame that bodies stand still in.

        Parameters
        ----------
        frame : int or str
            As for `Body`.

        Returns
        -------
        int
            0 for the base frame, k for ``link_names[k - 1]``.

        Raises
        ------
        ArgumentError, UnknownNameError
            There is no such frame.

        Examples
        --------
        >>> ik.Robot.load("ur5").frame_number("base"), ik.Robot.load("ur5").frame_number("tool")
        (0, 7)
        """
        links = self._chain.link_names
        if isinstance(frame, str):
            if frame == "base" and "base" not in links:
                return 0
            if frame not in links:
                word("frame", frame, ["base", *links])
            return links.index(frame) + 1
        return whole_number("frame", frame, 0, len(links))

    def _checked(self, argument: str, bodies: Any) -> tuple[Body, ...]:
        found = items(argument, bodies, "an iterable of Body")
        for body in found:
            if not isinstance(body, Body):
                raise ArgumentError(argument, shown(body), "an iterable of Body")
            self.frame_number(body.frame)
        return found


def _core(shape: BodyShape) -> object:
    match shape:
        case Sphere():
            return np.array([shape.centre])
        case Capsule():
            return np.array([shape.a, shape.b])
        case Box():
            return shape.centre, shape.half, np.array(shape.rotation)
        case Cover():
            return shape.centre, shape.half, np.array(shape.rotation), shape.level, shape.split
        case Convex():
            return np.array(shape.vertices)


def _check_names(bodies: Iterable[Body]) -> None:
    seen: set[str] = set()
    for body in bodies:
        if body.name in seen:
            raise ArgumentError("bodies", f"the name {body.name!r} twice", "names of their own")
        seen.add(body.name)


def _check_rules(rules: CollisionRules, names: list[str]) -> None:
    for name in rules.may_touch_target:
        word("body of may_touch_target", name, names)
    for name, _ in rules.static_skip:
        word("body of static_skip", name, names)
    for pair in (*(rules.pairs or ()), *rules.exclude):
        for name in pair:
            word("body of a self pair", name, names)
