"""What can be asked of a scene: whether an arm hits it, and how near it comes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _native
from .._checks import FloatArray, real_number, shown, truth_value, word
from ..errors import ArgumentError
from ..robot import Robot

if TYPE_CHECKING:
    from ._content import Target
    from ._objects import SceneObject

__all__ = ["Distances", "Queries"]

# Arms that a scene remembers what it made for.
_REMEMBERED = 8


@dataclass(frozen=True, eq=False)
class Distances:
    """How far the bodies of an arm are from a scene and from each other.

    Arrays have the leading shape (...) of the joint values.

    Attributes
    ----------
    bodies : tuple of n str
        Names of the bodies.
    objects : tuple of str
        Names of the objects of the scene.
    distance : ndarray, shape (..., n), m
        Of each body from the nearest object; 0 or less in contact, infinite where there is
        no object that the body minds within the cap. The size of a depth has a meaning only
        for half-spaces and for spheres and capsules.
    nearest : ndarray of int, shape (..., n)
        Which of `objects` that is; -1 for none.
    on_body, on_object : ndarray, shape (..., n, 3), m
        Where they come nearest, in the frame of the scene; 0 for none.
    own_distance : ndarray, shape (...), m
        Of the two bodies that are nearest to each other; infinite for none.
    own_pair : ndarray of int, shape (..., 2)
        Which of `bodies` they are; -1 for none.
    own_points : ndarray, shape (..., 2, 3), m
        Where they come nearest; 0 for none.

    Examples
    --------
    >>> scene = ik.collision.greenhouse(seed=1)
    >>> arm = ik.Robot.load("cucumber")
    >>> found = scene.distances(arm, arm.home)
    >>> found.distance.shape == (len(found.bodies),)
    True
    """

    bodies: tuple[str, ...]
    objects: tuple[str, ...]
    distance: FloatArray
    nearest: NDArray[np.int64]
    on_body: FloatArray
    on_object: FloatArray
    own_distance: FloatArray
    own_pair: NDArray[np.int64]
    own_points: FloatArray

    @property
    def object_names(self) -> NDArray[np.object_]:
        """Name of the nearest object of each body, shape (..., n); empty for none."""
        return _named(self.nearest, self.objects)

    @property
    def own_names(self) -> NDArray[np.object_]:
        """Names of the two bodies that are nearest to each other, shape (..., 2)."""
        return _named(self.own_pair, self.bodies)


def _named(index: NDArray[np.int64], names: Sequence[str]) -> NDArray[np.object_]:
    # The last one is what -1 stands for.
    return np.array([*names, ""], dtype=object)[index]


class Queries:
    """The part of `Scene` that is asked about arms."""

    __slots__ = ("_colliders", "_made")

    _colliders: dict[int, tuple[_native.Bodies, _native.Collider]]
    _made: _native.Scene | None

    if TYPE_CHECKING:

        @property
        def objects(self) -> tuple[SceneObject, ...]:
            """The objects."""

        @property
        def names(self) -> tuple[str, ...]:
            """Their names."""

        @property
        def exemptions(self) -> tuple[tuple[str, str], ...]:
            """Pairs that do not mind each other."""

        @property
        def targets(self) -> Mapping[str, Target]:
            """The targets."""

        @property
        def target(self) -> str | None:
            """The target that is aimed at."""

        @property
        def touch_radius(self) -> float:
            """How near to the target it may be touched."""

    def collides(
        self, arm: Robot, q: ArrayLike, *, clear: float = 0.0, threads: int | None = None
    ) -> NDArray[np.bool_]:
        """Whether postures of an arm hit the scene, or the arm itself.

        Parameters
        ----------
        arm : Robot
            An arm with bodies.
        q : array_like, shape (..., n), rad or m
            Joint values, finite; limits are of no account.
        clear : float, default 0, m
            Distance to be kept from the scene: as near or nearer is a hit. Pairs of the arm's
            own bodies hit where they touch.
        threads : int, optional
            Number of threads, as for `Robot.ik`. Answers do not depend on it.

        Returns
        -------
        ndarray of bool, shape (...)

        Raises
        ------
        ArgumentError
            A wrong shape, a joint value that is not finite, a negative `clear`, an arm without
            bodies; an exemption of a body that the arm does not have.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> from agrik_fast.collision import HalfSpace, Scene, SceneObject
        >>> scene = Scene([SceneObject.of("floor", HalfSpace([0, 0, 1], 0.0))])
        >>> arm = Robot.load("panda")
        >>> scene.collides(arm, [[0, 0, 0, -1.5, 0, 1.5, 0], [0, 1.7, 0, -0.2, 0, 1.5, 0]])
        array([False,  True])
        """
        return self.collider(arm).collides(q, real_number("clear", clear, 0.0, unit="m"), threads)

    def clearance(
        self,
        arm: Robot,
        q: ArrayLike,
        *,
        cap: float | None = None,
        own: bool = False,
        threads: int | None = None,
    ) -> FloatArray:
        """Distance of postures of an arm from the scene, m.

        Parameters
        ----------
        arm : Robot
            An arm with bodies.
        q : array_like, shape (..., n), rad or m
            Joint values, finite.
        cap : float, optional, m
            Distances above it are it: the less it is, the quicker the answer. Default: none.
        own : bool, default False
            The distances of the arm's own bodies from each other count as well; then the
            clearance is 0 or less exactly where `collides` is True.
        threads : int, optional
            Number of threads.

        Returns
        -------
        ndarray, shape (...), m
            Distance of the nearest body from the nearest object; 0 or less in contact, and
            infinite in an empty scene. The size of a depth has a meaning only for half-spaces
            and for spheres and capsules.

        Raises
        ------
        ArgumentError
            As `collides`.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> from agrik_fast.collision import HalfSpace, Scene, SceneObject
        >>> scene = Scene([SceneObject.of("floor", HalfSpace([0, 0, 1], 0.0))])
        >>> arm = Robot.load("panda")
        >>> round(float(scene.clearance(arm, [0, 0, 0, -1.5, 0, 1.5, 0])), 3)
        0.068
        >>> float(scene.clearance(arm, [0, 0, 0, -1.5, 0, 1.5, 0], cap=0.05))
        0.05
        """
        return self.collider(arm).clearance(q, _cap(cap), threads, truth_value("own", own))

    def distances(
        self, arm: Robot, q: ArrayLike, *, cap: float | None = None, threads: int | None = None
    ) -> Distances:
        """Distance of each body of an arm, with the nearest object and the points.

        Parameters
        ----------
        arm : Robot
            An arm with bodies.
        q : array_like, shape (..., n), rad or m
            Joint values, finite.
        cap : float, optional, m
            What is farther away counts as not there. Default: none.
        threads : int, optional
            Number of threads.

        Returns
        -------
        Distances

        Raises
        ------
        ArgumentError
            As `collides`.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> from agrik_fast.collision import HalfSpace, Scene, SceneObject
        >>> scene = Scene([SceneObject.of("floor", HalfSpace([0, 0, 1], 0.0))])
        >>> found = scene.distances(Robot.load("panda"), [0, 0, 0, -1.5, 0, 1.5, 0])
        >>> found.bodies[1], round(float(found.distance[1]), 3), found.object_names[1]
        ('link1', 0.068, 'floor')
        """
        collider = self.collider(arm)
        found = collider.distances(q, _cap(cap), threads)
        return Distances(
            bodies=tuple(collider.bodies.names),
            objects=self.names,
            distance=found.distance,
            nearest=found.object,
            on_body=found.on_body,
            on_object=found.on_object,
            own_distance=found.own_distance,
            own_pair=found.own_pair,
            own_points=found.own_points,
        )

    def gradient(
        self,
        arm: Robot,
        q: ArrayLike,
        *,
        cap: float | None = None,
        own: bool = False,
        threads: int | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Clearance of postures, and how it changes with the joint values.

        The derivative is that of the nearest pair, along the line between its points: where
        two pairs are equally near it is that of one of them; it is 0 where cores meet and
        where nothing is within `cap`.

        Parameters
        ----------
        arm : Robot
            An arm with bodies.
        q : array_like, shape (..., n), rad or m
            Joint values, finite.
        cap, own, threads : optional
            As for `clearance`.

        Returns
        -------
        clearance : ndarray, shape (...), m
            As `clearance` gives it.
        gradient : ndarray, shape (..., n), m/rad or no unit
            Change of the clearance with each joint value.

        Raises
        ------
        ArgumentError
            As `collides`.

        Examples
        --------
        >>> scene = ik.collision.greenhouse(seed=1)
        >>> arm = ik.Robot.load("cucumber")
        >>> clearance, gradient = scene.gradient(arm, arm.random_q(5, seed=1))
        >>> clearance.shape, gradient.shape
        ((5,), (5, 7))
        """
        return self.collider(arm).gradient(q, _cap(cap), threads, truth_value("own", own))

    # -- what the compiled core is given -------------------------------------------------

    def collider(self, arm: Robot) -> _native.Collider:
        """Return the arm in this scene, ready for the compiled core; remembered.

        `Robot.ik` asks for it.

        Parameters
        ----------
        arm : Robot
            An arm with bodies.

        Returns
        -------
        Collider

        Raises
        ------
        ArgumentError
            The arm has no bodies, or an exemption names a body that it does not have.

        Examples
        --------
        >>> scene = ik.collision.greenhouse(seed=1)
        >>> arm = ik.Robot.load("cucumber")
        >>> scene.collider(arm) is scene.collider(arm)
        True
        """
        if not isinstance(arm, Robot):
            raise ArgumentError("arm", shown(arm), "a Robot")
        bodies = arm.compiled_bodies()
        known = self._colliders.get(id(bodies))
        if known is not None:
            return known[1]
        made = self._collider(arm, bodies)
        # The bodies are kept, so that no others get their number. A new table in place of the
        # old one: another thread may be looking something up.
        last = list(self._colliders.items())[1 - _REMEMBERED :]
        self._colliders = {**dict(last), id(bodies): (bodies, made)}
        return made

    def _collider(self, arm: Robot, bodies: _native.Bodies) -> _native.Collider:
        body = {name: k for k, name in enumerate(bodies.names)}
        thing = {name: k for k, name in enumerate(self.names)}
        for name, _ in self.exemptions:
            word("body of an exemption", name, body)
        rules = arm.collision_rules
        pairs = [(body[a], thing[b]) for a, b in self.exemptions]
        pairs += [(body[a], thing[b]) for a, b in rules.static_skip if b in thing]
        touch = None
        if self.target is not None:
            aim = self.targets[self.target]
            meeting = [(body[a], thing[b]) for a in rules.may_touch_target for b in aim.objects]
            touch = (meeting, np.array(aim.point), self.touch_radius)
        return _native.Collider(bodies, self._compiled(), pairs, touch)

    def _compiled(self) -> _native.Scene:
        if self._made is None:
            self._made = _native.Scene(
                self.names, [one.removable for one in self.objects], **_rows(self.objects)
            )
        return self._made


def _cap(cap: float | None) -> float | None:
    if cap is None or (type(cap) is float and math.isinf(cap) and cap > 0.0):
        return None
    return real_number("cap", cap, 0.0, unit="m")


def _rows(objects: Sequence[SceneObject]) -> dict[str, Any]:
    """Return the solids of all objects as the compiled core takes them."""
    found: dict[str, Any] = {}
    for key, label in (
        ("spheres", "sphere_labels"),
        ("capsules", "capsule_labels"),
        ("boxes", "box_labels"),
        ("halfspaces", "halfspace_labels"),
    ):
        rows = [(k, own) for k, one in enumerate(objects) if len(own := getattr(one, key))]
        if rows:
            found[key] = rows[0][1] if len(rows) == 1 else np.concatenate([own for _, own in rows])
            found[label] = np.repeat([k for k, _ in rows], [len(own) for _, own in rows])
    hulls = [(k, hull) for k, one in enumerate(objects) for hull in one.hulls]
    if hulls:
        found["hulls"] = [points for _, (points, _) in hulls]
        found["hull_radii"] = np.array([radius for _, (_, radius) in hulls])
        found["hull_labels"] = np.array([k for k, _ in hulls])
    return found
