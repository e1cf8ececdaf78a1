"""A scene: named objects round an arm, and what can be asked of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from .._bodies import pose_of
from .._checks import shown, word
from ..errors import ArgumentError
from ._content import TOUCH_RADIUS, Content, Pair, Target, checked_content
from ._files import content_of, load, save, table_of
from ._objects import SceneObject
from ._queries import Queries

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..robot import Robot

__all__ = ["Scene", "document_of", "from_document"]


class Scene(Queries):
    """Named objects in one frame, that of an arm's targets; it does not change.

    All lengths are in metres. The frame is the one in which the arm gives its poses.

    Parameters
    ----------
    objects : iterable of SceneObject
        Objects, no two of one name. None: an empty scene, from which everything is
        infinitely far away.
    targets : mapping of str to Target, optional
        Named places that a tool is to reach, with what may be touched there.
    exemptions : iterable of (body, object), optional
        Names of a body of the arm and of an object that do not mind each other, at any
        posture. Those that belong to an arm, wherever it stands, are better kept with the arm
        (``static_skip`` of a robot file).
    touch_radius : float, default 0.15, m
        How near to a target the tool point has to be for the target to be touched.

    Raises
    ------
    ArgumentError
        Two objects of one name, an exemption or a target of an unknown object, a number that
        is not finite.

    Examples
    --------
    >>> from agrik_fast.collision import Capsule, Scene, SceneObject
    >>> stem = SceneObject.of("stem", Capsule([0.5, 0, 0], [0.5, 0, 2], 0.01), kind="stem")
    >>> scene = Scene([stem])
    >>> scene.names
    ('stem',)
    """

    __slots__ = ("_content",)

    _content: Content

    def __init__(
        self,
        objects: Iterable[SceneObject] = (),
        *,
        targets: Mapping[str, Target] | None = None,
        exemptions: Iterable[Pair] = (),
        touch_radius: float = TOUCH_RADIUS,
    ) -> None:
        self._content = checked_content(objects, targets, exemptions, touch_radius)
        self._made = None
        self._colliders = {}

    # -- what it holds -----------------------------------------------------------------

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """The objects, in order."""
        return self._content.objects

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the objects, in order."""
        return tuple(self._content.by_name)

    @property
    def targets(self) -> Mapping[str, Target]:
        """The targets by name."""
        return MappingProxyType(self._content.targets)

    @property
    def exemptions(self) -> tuple[Pair, ...]:
        """Names of a body and of an object that do not mind each other."""
        return self._content.exemptions

    @property
    def touch_radius(self) -> float:
        """How near to its target the tool point has to be for it to be touched, m."""
        return self._content.touch_radius

    @property
    def target(self) -> str | None:
        """Name of the target that is aimed at; None for none."""
        return self._content.target

    def __len__(self) -> int:
        return len(self.objects)

    def __getitem__(self, name: str) -> SceneObject:
        return self._content.by_name[word("object", name, self._content.by_name)]

    def __repr__(self) -> str:
        solids = sum(map(len, self.objects))
        return f"Scene({len(self)} objects, {solids} solids)"

    # -- others made of it -------------------------------------------------------------

    def aiming_at(self, target: str | None) -> Scene:
        """Return the scene with one target that may be touched.

        While the tool point is no farther from the target than `touch_radius`, the bodies of
        ``may_touch_target`` (those of a gripper) do not mind the target's objects. Farther
        away, and without a target, they are obstacles like others.

        Parameters
        ----------
        target : str or None
            A name out of `targets`; None aims at nothing.

        Returns
        -------
        Scene

        Raises
        ------
        UnknownNameError
            No target has that name.

        Examples
        --------
        >>> scene = ik.harvest.example_scene()
        >>> aim = scene.aiming_at("C1")
        >>> q = ik.harvest.plan("cucumber", scene, ["C1"]).q[0]
        >>> arm = ik.Robot.load("cucumber")
        >>> bool(aim.clearance(arm, q) > scene.clearance(arm, q))
        True
        """
        if target is not None:
            word("target", target, self.targets)
        aimed = _rebuilt(replace(self._content, target=target))
        aimed._made = self._made
        return aimed

    def without(self, *names: str) -> Scene:
        """Return the scene without some objects, and without what refers to them.

        Parameters
        ----------
        *names : str
            Names of objects.

        Returns
        -------
        Scene

        Raises
        ------
        UnknownNameError
            No object has that name.

        Examples
        --------
        >>> scene = ik.collision.greenhouse(seed=1, plants=1)
        >>> name = scene.objects[0].name
        >>> len(scene.objects) - len(scene.without(name).objects)
        1
        """
        for name in names:
            word("object", name, self.names)
        gone = set(names)
        targets = {
            where: Target(target.point, tuple(n for n in target.objects if n not in gone))
            for where, target in self.targets.items()
        }
        return self._changed(
            objects=tuple(one for one in self.objects if one.name not in gone),
            targets=targets,
            exemptions=tuple(pair for pair in self.exemptions if pair[1] not in gone),
        )

    def with_objects(self, *objects: SceneObject) -> Scene:
        """Return the scene with more objects.

        Parameters
        ----------
        *objects : SceneObject
            Objects whose names are not in the scene.

        Returns
        -------
        Scene

        Raises
        ------
        ArgumentError
            A name is there already.

        Examples
        --------
        >>> ball = ik.collision.SceneObject.of("ball", ik.collision.Sphere((1, 0, 0), 0.1))
        >>> len(ik.Scene([]).with_objects(ball).objects)
        1
        """
        content = self._content
        together = checked_content(
            (*self.objects, *objects), content.targets, content.exemptions, content.touch_radius
        )
        return _rebuilt(replace(together, target=content.target))

    def moved(self, pose: ArrayLike) -> Scene:
        """Return the scene of a frame that lies at `pose` in another, given in that other.

        Parameters
        ----------
        pose : array_like, shape (4, 4), m
            A rigid transform.

        Returns
        -------
        Scene

        Raises
        ------
        ArgumentError
            Not a rigid transform.

        Examples
        --------
        >>> pose = ik.rotations.pose([0, 0, 1.0])
        >>> scene = ik.collision.greenhouse(seed=1, plants=1)
        >>> raised = scene.moved(pose)
        >>> round(raised.targets["F0_0"].point[2] - scene.targets["F0_0"].point[2], 6)
        1.0
        """
        turn, shift = pose_of("pose", pose)
        return self._changed(
            objects=tuple(one.moved(pose) for one in self.objects),
            targets={
                where: Target(tuple((turn @ target.point + shift).tolist()), target.objects)
                for where, target in self.targets.items()
            },
        )

    def _changed(self, **changes: Any) -> Scene:
        return _rebuilt(replace(self._content, **changes))

    def plot(
        self,
        arm: Robot | None = None,
        q: ArrayLike | None = None,
        *,
        skip: Iterable[str] = (),
        view: tuple[float, float] = (22.0, -60.0),
        axes: Any = None,
    ) -> Figure:
        """Draw the scene in space; needs the extra ``plots``.

        Parameters
        ----------
        arm : Robot, optional
            An arm that is drawn in it.
        q : array_like, shape (..., n), rad or m, optional
            Its posture, or postures as for `Robot.plot`; default its home.
        skip : iterable of str, optional
            Kinds of objects that are left out. Half-spaces have no end, and are never drawn.
        view : (float, float), default (22, -60)
            Elevation and azimuth that it is seen from, deg.
        axes : Axes3D, optional
            Where to draw; default: a new figure as wide as a page. Axes that hold nothing get
            limits, names and the view; others keep theirs.

        Returns
        -------
        matplotlib.figure.Figure
            The figure, which belongs to no window; targets are stars.

        Raises
        ------
        ArgumentError
            A posture without an arm, or of a wrong shape.
        MissingExtraError
            Matplotlib is not installed.

        Examples
        --------
        >>> from agrik_fast.collision import Scene
        >>> from agrik_fast.collision import Sphere, SceneObject
        >>> scene = Scene([SceneObject.of("berry", Sphere([0.3, 0, 0.5], 0.02), kind="fruit")])
        >>> scene.plot().axes[0].get_zlabel()
        'z [m]'
        """
        from .drawing import plot

        return plot(self, arm, q, skip, view, axes)

    # -- files -------------------------------------------------------------------------

    @staticmethod
    def load(path: str | PathLike[str]) -> Scene:
        """Read a scene file.

        Parameters
        ----------
        path : str or path
            A ``.json`` or ``.toml`` file; the page on collision describes it.

        Returns
        -------
        Scene
            In metres, whatever the file's unit.

        Raises
        ------
        SceneFileError
            The file has faults; lists all of them with their places.
        ArgumentError
            The path leads to no file of a known kind.

        Examples
        --------
        >>> ik.collision.greenhouse(seed=1, plants=1).save("plant.json")
        >>> "F0_0" in ik.Scene.load("plant.json").targets
        True
        """
        return _rebuilt(load(path))

    def save(
        self, path: str | PathLike[str], *, unit: str = "m", about: str = "", force: bool = False
    ) -> None:
        """Write a scene file, which appears when it is complete.

        Parameters
        ----------
        path : str or path
            A ``.json`` or ``.toml`` file.
        unit : {"m", "mm"}, default "m"
            Unit of the lengths in it. With "m", reading it gives the same bits again.
        about : str, optional
            One line on what it is.
        force : bool, default False
            Replace an existing file.

        Raises
        ------
        SceneFileError
            The file cannot be written, or exists already.
        ArgumentError
            Another suffix or unit.

        Examples
        --------
        >>> scene = ik.collision.greenhouse(seed=1, plants=1)
        >>> scene.save("crop.toml", unit="mm", about="one plant")
        >>> len(ik.Scene.load("crop.toml").objects) == len(scene.objects)
        True
        """
        save(self._content, path, unit=unit, about=about, force=force)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self._content,)


def _rebuilt(content: Content) -> Scene:
    """Return the scene of a content that has been checked."""
    scene = Scene.__new__(Scene)
    scene._content = content
    scene._made = None
    scene._colliders = {}
    return scene


def from_document(
    document: Any, *, name: str = "document", folder: str | PathLike[str] = "."
) -> Scene:
    """Make a scene of what a scene file says.

    Parameters
    ----------
    document : dict
        The content of a scene file, as the JSON or TOML parser returns it.
    name : str, default "document"
        What messages call it.
    folder : path, default "."
        Where its ``clouds`` are.

    Returns
    -------
    Scene
        In metres.

    Raises
    ------
    SceneFileError
        With every fault and its place.

    Examples
    --------
    >>> from agrik_fast.collision import from_document
    >>> ball = {"name": "ball", "spheres": [[0, 0, 500, 40]]}
    >>> scene = from_document({"unit": "mm", "objects": [ball]})
    >>> scene["ball"].spheres
    array([[0.  , 0.  , 0.5 , 0.04]])
    """
    return _rebuilt(content_of(document, name, folder))


def document_of(scene: Scene, *, unit: str = "m", about: str = "") -> dict[str, Any]:
    """Return a scene as the content of a scene file.

    Parameters
    ----------
    scene : Scene
    unit : {"m", "mm"}, default "m"
        Unit of its lengths.
    about : str, optional
        One line on what it is.

    Returns
    -------
    dict
        As the JSON and TOML parsers would return it.

    Raises
    ------
    ArgumentError
        Another unit; no scene.

    Examples
    --------
    >>> scene = ik.collision.greenhouse(seed=1, plants=1)
    >>> ik.collision.document_of(scene, unit="mm")["unit"]
    'mm'
    """
    if not isinstance(scene, Scene):
        raise ArgumentError("scene", shown(scene), "a Scene")
    return table_of(scene._content, unit=unit, about=about)
