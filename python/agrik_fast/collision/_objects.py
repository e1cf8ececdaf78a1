"""One thing of a scene, as rows of numbers: a fruit, a stem, a pipe."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from .._bodies import Box, Capsule, Convex, HalfSpace, Rows, Shape, Sphere, pose_of
from .._checks import FloatArray, float_array, items, shown, text, truth_value
from ..errors import ArgumentError
from ._rows import CAPSULE, HALFSPACE, SPHERE, RowKind, first_fault

BOX_COLUMNS = 16
"""Centre, half lengths, rotation row by row, radius."""

Hull = tuple[FloatArray, float]
"""Points, of which it is the convex hull, shape (k, 3), m, and the radius round it, m."""


def _none(columns: int) -> FloatArray:
    return np.zeros((0, columns))


def _checked(kind: RowKind, name: str, value: ArrayLike) -> FloatArray:
    array = float_array(f"{kind.name} of {name!r}", value)
    if array.size == 0:
        return _none(kind.columns)
    if array.ndim != 2 or array.shape[1] != kind.columns:
        expected = f"shape (n, {kind.columns}): {kind.meaning}"
        raise ArgumentError(f"{kind.name} of {name!r}", f"shape {array.shape}", expected)
    fault = first_fault(kind, array)
    if fault is not None:
        row, received, expected = fault
        raise ArgumentError(f"{kind.name} of {name!r}", f"{received} in row {row + 1}", expected)
    # A copy that nobody else writes to.
    array = array.copy()
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class SceneObject:
    """A named thing of a scene, made of any number of solids; it does not change.

    Parameters
    ----------
    name : str
        Its name, which no other object of a scene has.
    kind : str
        What it is, in a word: fruit, stem, leaf, wire, pipe, ground, machine.
    removable : bool
        True for what may be taken out of the way.
    spheres : array_like, shape (n, 4), m
        Rows x, y, z, radius. Clouds of points come in here, of a million rows as well.
    capsules : array_like, shape (n, 7), m
        Rows of the two ends of the core and the radius round it.
    boxes : array_like, shape (n, 16), m
        Rows of centre, half lengths, rotation row by row and the radius round the box.
    halfspaces : array_like, shape (n, 4)
        Rows of an outward normal and d, m: solid is where ``normal . x <= d``.
    hulls : sequence of (vertices, radius)
        Points (k, 3) of each convex hull and the radius round it, m.

    Raises
    ------
    ArgumentError
        A wrong shape, NaN or infinity, a negative radius; names the object and the row.

    See Also
    --------
    SceneObject.of : an object of shapes.
    SceneObject.cloud : an object of points.

    Examples
    --------
    >>> one = ik.collision.SceneObject("post", capsules=[[0, 0, 0, 0, 0, 1, 0.05]])
    >>> one.name, len(one.shapes())
    ('post', 1)
    """

    name: str
    kind: str = ""
    removable: bool = False
    spheres: FloatArray = field(default_factory=lambda: _none(SPHERE.columns))
    capsules: FloatArray = field(default_factory=lambda: _none(CAPSULE.columns))
    boxes: FloatArray = field(default_factory=lambda: _none(BOX_COLUMNS))
    halfspaces: FloatArray = field(default_factory=lambda: _none(HALFSPACE.columns))
    hulls: tuple[Hull, ...] = ()

    def __post_init__(self) -> None:
        name = text("name", self.name)
        if not name:
            raise ArgumentError("name", "an empty text", "a name of one letter or more")
        text(f"kind of {name!r}", self.kind)
        truth_value(f"removable of {name!r}", self.removable)
        put = object.__setattr__
        put(self, "spheres", _checked(SPHERE, name, self.spheres))
        put(self, "capsules", _checked(CAPSULE, name, self.capsules))
        put(self, "halfspaces", _checked(HALFSPACE, name, self.halfspaces))
        put(self, "boxes", _checked_boxes(name, self.boxes))
        put(self, "hulls", _checked_hulls(name, self.hulls))

    @classmethod
    def of(cls, name: str, *shapes: Shape, kind: str = "", removable: bool = False) -> SceneObject:
        """Make an object of shapes.

        Parameters
        ----------
        name : str
            Its name.
        *shapes : Sphere, Capsule, Box, Convex or HalfSpace
            What it is made of, in the frame of the scene.
        kind : str, default ""
            What it is.
        removable : bool, default False
            True for what may be taken out of the way.

        Returns
        -------
        SceneObject

        Raises
        ------
        ArgumentError
            Something else than a shape.

        Examples
        --------
        >>> from agrik_fast.collision import Capsule, SceneObject
        >>> post = SceneObject.of("post", Capsule([0.4, 0, 0], [0.4, 0, 2], 0.02), kind="wire")
        >>> post.capsules.shape
        (1, 7)
        """
        rows: dict[type, list[list[float]]] = {Sphere: [], Capsule: [], Box: [], HalfSpace: []}
        hulls: list[Hull] = []
        for shape in shapes:
            if isinstance(shape, Convex):
                hulls.append((np.array(shape.vertices), shape.radius))
            elif isinstance(shape, Sphere):
                rows[Sphere].append([*shape.centre, shape.radius])
            elif isinstance(shape, Capsule):
                rows[Capsule].append([*shape.a, *shape.b, shape.radius])
            elif isinstance(shape, Box):
                turn = [x for row in shape.rotation for x in row]
                rows[Box].append([*shape.centre, *shape.half, *turn, shape.radius])
            elif isinstance(shape, HalfSpace):
                rows[HalfSpace].append([*shape.normal, shape.offset])
            else:
                raise ArgumentError("shapes", shown(shape), "shapes of agrik_fast.collision")
        return cls(
            name,
            kind,
            removable,
            spheres=np.array(rows[Sphere]),
            capsules=np.array(rows[Capsule]),
            boxes=np.array(rows[Box]),
            halfspaces=np.array(rows[HalfSpace]),
            hulls=tuple(hulls),
        )

    @classmethod
    def cloud(
        cls,
        name: str,
        points: ArrayLike,
        radius: ArrayLike,
        *,
        kind: str = "",
        removable: bool = False,
    ) -> SceneObject:
        """Make an object of points with a radius.

        Parameters
        ----------
        name : str
            Its name.
        points : array_like, shape (n, 3), m
            Points. What lies between two that are farther apart than two radii is free.
        radius : float or array_like, shape (n,), m
            One radius for all, or one each; 0 or more.
        kind, removable : optional
            As for `of`.

        Returns
        -------
        SceneObject

        Raises
        ------
        ArgumentError
            A wrong shape, NaN or infinity, a negative radius.

        Examples
        --------
        >>> points = [[0.6, 0.0, 0.9], [0.6, 0.02, 0.9]]
        >>> leaf = ik.collision.SceneObject.cloud("leaf", points, 0.025, kind="leaf")
        >>> leaf.spheres.shape
        (2, 4)
        """
        array = float_array("points", points)
        if array.ndim != 2 or array.shape[1] != 3:
            raise ArgumentError("points", f"shape {array.shape}", "shape (n, 3)")
        radii = float_array("radius", radius)
        if radii.shape not in ((), (len(array),)):
            expected = f"one number, or one for each of {len(array)} points"
            raise ArgumentError("radius", f"shape {radii.shape}", expected)
        rows = np.column_stack([array, np.broadcast_to(radii, len(array))])
        return cls(name, kind, removable, spheres=rows)

    def shapes(self) -> tuple[Shape, ...]:
        """Return what it is made of, one shape a solid.

        Examples
        --------
        >>> ball = ik.collision.SceneObject.of("ball", ik.collision.Sphere((1, 0, 0), 0.1))
        >>> ball.shapes()[0].radius
        0.1
        """
        found: list[Shape] = [Sphere(tuple(row[:3]), row[3]) for row in self.spheres.tolist()]
        found += [
            Capsule(tuple(row[:3]), tuple(row[3:6]), row[6]) for row in self.capsules.tolist()
        ]
        found += [
            Box(tuple(row[:3]), tuple(row[3:6]), _three_by_three(row[6:15]), row[15])
            for row in self.boxes.tolist()
        ]
        found += [HalfSpace(tuple(row[:3]), row[3]) for row in self.halfspaces.tolist()]
        found += [Convex(points, radius) for points, radius in self.hulls]  # type: ignore[arg-type]
        return tuple(found)

    def moved(self, pose: ArrayLike) -> SceneObject:
        """Return the same object of a frame that lies at `pose`, shape (4, 4), m.

        Examples
        --------
        >>> ball = ik.collision.SceneObject.of("ball", ik.collision.Sphere((1, 0, 0), 0.1))
        >>> ball.moved(ik.rotations.pose([0, 0, 1])).spheres
        array([[1. , 0. , 1. , 0.1]])
        """
        turn, shift = pose_of("pose", pose)

        def place(points: FloatArray) -> FloatArray:
            return points @ turn.T + shift

        spheres, capsules = self.spheres.copy(), self.capsules.copy()
        spheres[:, :3] = place(spheres[:, :3])
        for end in (0, 3):
            capsules[:, end : end + 3] = place(capsules[:, end : end + 3])
        boxes, halfspaces = self.boxes.copy(), self.halfspaces.copy()
        boxes[:, :3] = place(boxes[:, :3])
        boxes[:, 6:15] = (turn @ boxes[:, 6:15].reshape(-1, 3, 3)).reshape(-1, 9)
        halfspaces[:, :3] = halfspaces[:, :3] @ turn.T
        halfspaces[:, 3] += halfspaces[:, :3] @ shift
        return replace(
            self,
            spheres=spheres,
            capsules=capsules,
            boxes=boxes,
            halfspaces=halfspaces,
            hulls=tuple((place(points), radius) for points, radius in self.hulls),
        )

    def __len__(self) -> int:
        rows = (self.spheres, self.capsules, self.boxes, self.halfspaces)
        return sum(len(one) for one in rows) + len(self.hulls)

    def __repr__(self) -> str:
        what = f", kind={self.kind!r}" if self.kind else ""
        return f"SceneObject({self.name!r}{what}, {len(self)} solids)"


def _three_by_three(values: Sequence[float]) -> Rows:
    a, b, c, d, e, f, g, h, i = values
    return (a, b, c), (d, e, f), (g, h, i)


def _checked_boxes(name: str, value: ArrayLike) -> FloatArray:
    array = float_array(f"boxes of {name!r}", value)
    if array.size == 0:
        return _none(BOX_COLUMNS)
    if array.ndim != 2 or array.shape[1] != BOX_COLUMNS:
        raise ArgumentError(f"boxes of {name!r}", f"shape {array.shape}", "shape (n, 16)")
    for number, row in enumerate(array, start=1):
        try:
            Box(row[:3], row[3:6], row[6:15].reshape(3, 3), float(row[15]))
        except ArgumentError as error:
            place = f"boxes of {name!r}, row {number}, {error.argument}"
            raise ArgumentError(place, error.received, error.expected) from None
    array = array.copy()
    array.flags.writeable = False
    return array


def _checked_hulls(name: str, value: Iterable[tuple[ArrayLike, float]]) -> tuple[Hull, ...]:
    hulls: list[Hull] = []
    for number, hull in enumerate(items(f"hulls of {name!r}", value, "hulls"), start=1):
        place = f"hulls of {name!r}, row {number}"
        try:
            points, radius = hull
            shape = Convex(points, radius)
        except ArgumentError as error:
            received, expected = error.received, error.expected
            raise ArgumentError(f"{place}, {error.argument}", received, expected) from None
        except (TypeError, ValueError):
            raise ArgumentError(place, shown(hull), "vertices and a radius") from None
        vertices = np.array(shape.vertices)
        vertices.flags.writeable = False
        hulls.append((vertices, shape.radius))
    return tuple(hulls)
