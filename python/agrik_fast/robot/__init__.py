"""The robot: geometry, limits and tool of a serial arm, and what can be asked of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, frame_of, real_number, shown, text, whole_number, word
from ..errors import ArgumentError
from . import _prepared, _sources
from ._collision import CollisionBodies
from ._definition import (
    Definition,
    EndEffector,
    UrdfSolids,
    from_robot_file,
    from_urdf,
    urdf_solids,
)
from ._degrees import warn_of_degrees
from ._dh_rows import CONVENTIONS, DhRow, read_table
from ._every_branch import EveryBranch
from ._inverse import PREFERENCES as PREFERENCES
from ._inverse import InverseKinematics
from ._inverse import Prefer as Prefer
from ._inverse import SceneOf as SceneOf
from ._joint_path import JointPath
from ._joint_table import JointTable
from ._limits import JointLimits
from ._lines import Lines
from ._many import ik_many
from ._motion_limits import MotionLimits
from ._path import Path
from ._plot import COLOURS as COLOURS
from ._plot import Drawing
from ._surfaces import LOOKS as LOOKS
from ._surfaces import Look as Look
from ._surfaces import Surface
from ._velocity import DifferentialKinematics

__all__ = ["DhRow", "JointPath", "Path", "Robot", "Surface", "file_schema"]


def file_schema() -> dict[str, Any]:
    """Return the JSON Schema of robot files, for editors.

    Returns
    -------
    dict
        The schema.

    Examples
    --------
    >>> from agrik_fast.robot import file_schema
    >>> file_schema()["required"]
    ['format', 'name']
    """
    from ._file import RobotFile

    return RobotFile.model_json_schema()


class Robot(
    InverseKinematics,
    EveryBranch,
    JointTable,
    CollisionBodies,
    MotionLimits,
    JointLimits,
    DifferentialKinematics,
    Lines,
    Drawing,
):
    """A serial arm: joints with limits, a base and a tool transform.

    Make one with `Robot.load`, `Robot.from_dh` or `Robot.from_urdf`. A robot never
    changes; `with_tool`, `with_base`, `with_limits`, `lock` and `in_frame` return new ones.
    Robots can be pickled and used from several threads at once.

    All lengths are in metres, all angles in radians, all poses 4x4 transforms of the
    tool in the frame that the base transform leads to (short: the base frame).

    Examples
    --------
    >>> import agrik_fast as ik
    >>> arm = ik.Robot.load("redundant7")
    >>> arm.dof
    7
    >>> T = arm.fk([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
    >>> result = arm.ik(T)
    >>> bool(result.success), bool(result.position_error < 1e-6)
    (True, True)
    """

    __slots__ = ("_chain",)

    def __init__(self, definition: Definition, chain: _native.Chain | None = None) -> None:
        if not isinstance(definition, Definition):
            raise ArgumentError(
                "Robot", shown(definition), "Robot.load, Robot.from_dh or Robot.from_urdf"
            )
        self._definition = definition
        self._chain = definition.build() if chain is None else chain
        self._compiled = None

    # -- where robots come from ------------------------------------------------------

    @classmethod
    def load(
        cls,
        name_or_path: str | bytes | PathLike[str],
        base_link: str | None = None,
        tip_link: str | None = None,
        *,
        tool: ArrayLike | None = None,
        frame: str | None = None,
    ) -> Robot:
        """Load a robot by its name, from a robot file, a URDF or a xacro file.

        Parameters
        ----------
        name_or_path : str, bytes or path
            A name out of `Robot.names`; a name of the package robot_descriptions, such as
            "ur5e_description" (needs the extra ``descriptions``, and downloads the robot when
            it is asked for first); or the path of a ``.toml``, ``.urdf``, ``.xml`` or
            ``.xacro`` file (the last needs the extra ``xacro``), the suffix in any case.
        base_link, tip_link : str, optional
            First and last link of a URDF's chain, as for `from_urdf`.
        tool : array_like, shape (4, 4) or (3,), optional
            Tool in the last link's frame, m, as for `with_tool`.
        frame : str, optional
            Named frame in which poses are given, as for `in_frame`.

        Returns
        -------
        Robot
            The robot.

        Raises
        ------
        UnknownNameError
            No robot or frame has that name; names the nearest.
        ArgumentError
            The path leads to no file of a known kind; links are named of a robot file; the
            tool is no rigid transform.
        RobotFileError
            The TOML file has faults; lists all of them with their places.
        UrdfError
            The URDF cannot be read, or does not describe one serial chain.
        MissingExtraError
            The robot needs a library that is not installed.

        Warns
        -----
        RobotWarning
            Limits of a URDF, both 0, lock joints; angles look like degrees.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> Robot.load("panda").dof
        7
        """
        source = _sources.find(name_or_path)
        if source.path is None:
            robot = cls._of_urdf(source, base_link, tip_link, UrdfSolids())
        else:
            for argument, link in (("base_link", base_link), ("tip_link", tip_link)):
                if link is not None:
                    expected = f"nothing: {source.name} is a robot file, which has one chain"
                    raise ArgumentError(argument, shown(link), expected)
            prepared = _prepared.read(source.path) if source.is_bundled else None
            robot = cls(prepared or from_robot_file(source.path))
        robot = robot if frame is None else robot.in_frame(frame)
        return robot if tool is None else robot.with_tool(tool)

    @classmethod
    def _of_urdf(
        cls, source: _sources.Source, base: str | None, tip: str | None, solids: UrdfSolids
    ) -> Robot:
        for argument, link in (("base_link", base), ("tip_link", tip)):
            if link is not None:
                text(argument, link)
        return cls(*from_urdf(source, base, tip, solids))

    @classmethod
    def from_dh(
        cls,
        rows: ArrayLike | Sequence[Mapping[str, float]],
        convention: Literal["standard", "modified"] = "standard",
        limits: ArrayLike | None = None,
        joint_types: Sequence[str] | None = None,
        joint_names: Sequence[str] | None = None,
        base: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        name: str = "robot",
    ) -> Robot:
        """Build a robot from Denavit-Hartenberg rows.

        Parameters
        ----------
        rows : array_like, shape (n, 4), or sequence of n dict
            One row per joint, from base to tool. Columns: a (m), alpha (rad), d (m),
            theta (rad). As dictionaries: keys ``a``, ``alpha`` or ``alpha_deg``, ``d``,
            and ``theta`` or ``theta_deg`` (0 if left out). A joint's value is added to
            theta (revolute, continuous) or to d (prismatic).
        convention : {"standard", "modified"}, default "standard"
            Standard (distal): ``Rz(theta) Tz(d) Tx(a) Rx(alpha)``. Modified (Craig):
            ``Rx(alpha) Tx(a) Rz(theta) Tz(d)``, so that row i holds Craig's
            alpha_(i-1) and a_(i-1).
        limits : array_like, shape (n, 2), rad or m, optional
            Smallest and largest value of each joint. Without it every joint turns
            freely. Rows of continuous and fixed joints are ignored.
        joint_types : sequence of n str, optional
            "revolute", "continuous", "prismatic" or "fixed". Default: revolute with
            `limits`, continuous without.
        joint_names : sequence of n str, optional
            Default q1, q2, ...
        base : array_like, shape (4, 4) or (3,), optional
            First row's frame, or its place, in the frame that poses are given in, m; default
            identity.
        tool : array_like, shape (4, 4) or (3,), optional
            Tool in the last row's frame, or its place there, m; default identity.
        name : str, default "robot"
            Name of the robot.

        Returns
        -------
        Robot
            The robot.

        Raises
        ------
        ArgumentError
            A wrong shape, key, value, limit or transform; names the row.
        UnknownNameError
            An unknown key, joint type or convention.

        Warns
        -----
        RobotWarning
            Angles look like degrees.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> arm = Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], name="planar")
        >>> arm.joint_types
        ('continuous', 'continuous')
        """
        word("convention", convention, CONVENTIONS)
        text("name", name)
        table = read_table(rows, limits, joint_types, joint_names)
        listing = table.listing()
        warn_of_degrees(
            name,
            [(row.name, row.type, row.lower, row.upper) for row in listing],
            [row.alpha for row in listing],
            [row.theta for row in listing],
        )
        definition = Definition(
            method="from_dh",
            arguments=(name, convention, *table),
            base=None if base is None else frame_of("base", base).copy(),
            tool=None if tool is None else frame_of("tool", tool).copy(),
            convention=convention,
            dh=listing,
        )
        return cls(definition)

    @classmethod
    def from_urdf(
        cls,
        path_or_text: str | bytes | PathLike[str],
        base_link: str | None = None,
        tip_link: str | None = None,
        *,
        cylinder: Literal["capsule", "convex", "cover"] = "capsule",
        mesh: Literal["convex", "cover"] = "convex",
        mesh_folders: Sequence[str | PathLike[str]] = (),
    ) -> Robot:
        """Build a robot from a URDF.

        Joints, origins, axes, limits and mimic rules count, and ``<collision>`` geometry,
        which is read when `bodies` are first needed; visuals, inertias and transmissions are
        ignored.

        Parameters
        ----------
        path_or_text : str, bytes or path
            Path of the file, or the XML text itself (it holds a ``<``). Bytes and files are
            read in the encoding that they declare, a ``.xacro`` file is expanded first.
        base_link, tip_link : str, optional
            First and last link of the chain, any two of the tree: joints on the way up to the
            link that both are below are gone through against their direction, their values
            stay what they are. Default: the only root, and the end of the only arm: a link
            named like tool0, tcp or flange, or what the last joint before a hand carries.
            `notes` says what was chosen where there was a choice.
        cylinder : {"capsule", "convex", "cover"}, default "capsule"
            What a cylinder becomes for collisions: a capsule, which reaches out of it by its
            radius at both ends; a prism of 16 sides, by 1.96 % of it; the cover of its box.
        mesh : {"convex", "cover"}, default "convex"
            What each mesh of a file becomes: its convex hull, or the cover of its box. Meshes
            need the extra ``meshes`` (trimesh, SciPy).
        mesh_folders : sequence of paths, optional
            Where mesh files are looked for besides the URDF's own folder: folders that hold
            ROS packages (``package://``), or what relative names begin from.

        Returns
        -------
        Robot
            The chain from `base_link` to `tip_link`; the tool frame is the tip link's.

        Raises
        ------
        ArgumentError
            The path leads to no file.
        UrdfError
            The text is no URDF, its links are cyclic or disconnected, a link is
            unknown, no joint moves, or several links could be the tip (it lists them).
        MissingExtraError
            A xacro file without the extra ``xacro``.

        Warns
        -----
        RobotWarning
            Limits that are both 0 lock joints; limits look like degrees.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> arm = Robot.from_urdf(
        ...     '<robot name="r"><link name="a"/><link name="b"/><joint name="j" '
        ...     'type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
        ... )
        >>> arm.joint_names
        ('j',)
        """
        solids = urdf_solids(cylinder, mesh, mesh_folders)
        return cls._of_urdf(_sources.find_urdf(path_or_text), base_link, tip_link, solids)

    ik_many = staticmethod(ik_many)

    @staticmethod
    def names() -> tuple[str, ...]:
        """Return the names of the robots that are installed, sorted.

        Those of the package, and those that other packages bring by the entry points
        ``agrik_fast.robots``.

        Examples
        --------
        >>> "ur5" in ik.Robot.names()
        True
        """
        return _sources.names()

    def save(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """Write the robot to a robot file, from which `load` makes an equal robot.

        Parameters
        ----------
        path : str or path
            A ``.toml`` file.
        force : bool, default False
            Replace an existing file.

        Raises
        ------
        ArgumentError
            Another suffix, or a robot that the form cannot hold: a joint that follows one
            outside of the chain.
        RobotFileError
            The file exists, or cannot be written.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> import tempfile, pathlib
        >>> path = pathlib.Path(tempfile.mkdtemp()) / "arm.toml"
        >>> Robot.load("ur5").save(path)
        >>> Robot.load(path) == Robot.load("ur5")
        True
        """
        from ._saving import write

        write(self._definition, self._chain, path, force=force)

    # -- what it is --------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self._chain.name

    @property
    def dof(self) -> int:
        """Number of joint variables n, the length of q."""
        return self._chain.dof

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joint variables, in the order of q."""
        return tuple(self._chain.joint_names)

    @property
    def joint_types(self) -> tuple[str, ...]:
        """Types of the joint variables: "revolute", "continuous" or "prismatic"."""
        return tuple(self._chain.joint_types)

    @property
    def lower(self) -> FloatArray:
        """Smallest joint values, shape (n,), rad or m; -inf for continuous joints."""
        return self._chain.lower

    @property
    def upper(self) -> FloatArray:
        """Largest joint values, shape (n,), rad or m; inf for continuous joints."""
        return self._chain.upper

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the frames that `fk_links` returns, from the first link to the tool."""
        return tuple(self._chain.link_names)

    @property
    def reach_radius(self) -> float:
        """Proven bound, m: the tool point is never further from `reach_center`."""
        return self._chain.reach_radius

    @property
    def reach_center(self) -> FloatArray:
        """Centre of the ball of `reach_radius`, base frame, shape (3,), m."""
        return self._chain.reach_center

    @property
    def reach_box(self) -> FloatArray:
        """Proven bounds of the tool point: lowest, highest x, y, z; shape (2, 3), m."""
        return self._chain.reach_box

    @property
    def fingerprint(self) -> str:
        """Hash of the definition (geometry, limits, base, tool, names), 64 hex digits.

        Equal for robots that are built from the same numbers; it says nothing of two
        descriptions of one arm.
        """
        return self._definition.fingerprint()

    @property
    def description(self) -> str:
        """One line on what the robot is; empty if nobody said."""
        return self._definition.description

    @property
    def notes(self) -> tuple[str, ...]:
        """What was decided while the robot was read and one might have decided otherwise."""
        return self._definition.notes

    @property
    def home(self) -> FloatArray:
        """Joint values of the home posture, shape (n,), rad or m.

        As the robot file says; of a joint of which it says nothing, the value inside the
        limits that is nearest to 0.
        """
        near = np.clip(0.0, self.lower, self.upper)
        said = [self._definition.home.get(name, np.nan) for name in self.joint_names]
        return np.where(np.isnan(said), near, said)

    @property
    def source(self) -> Mapping[str, Any]:
        """Title, authors, DOI, equation numbers, notes of the robot's description."""
        return MappingProxyType(self._definition.source)

    @property
    def provenance(self) -> Mapping[str, str]:
        """Where each number is from, as "mark" or "mark: text" by "joint.number"."""
        return MappingProxyType(self._definition.provenance)

    @property
    def provenance_marks(self) -> Mapping[str, str]:
        """Meaning of the marks that `provenance` uses."""
        return MappingProxyType(self._definition.marks)

    @property
    def convention(self) -> str | None:
        """Kind of the rows in `dh`, "standard" or "modified"; None without such rows."""
        return self._definition.convention

    @property
    def dh(self) -> tuple[DhRow, ...] | None:
        """Denavit-Hartenberg rows (m, rad), or None if the robot was given otherwise."""
        return self._definition.dh

    @property
    def frames(self) -> Mapping[str, FloatArray]:
        """The named frames, as the (4, 4) transforms (m) that lead a pose of `fk` to them.

        ``robot.frames["paper"] @ robot.fk(q)`` is the tool in the frame "paper".
        """
        return {name: pose.copy() for name, pose in self._definition.frames.items()}

    @property
    def end_effector(self) -> EndEffector | None:
        """The servo at the arm's end and the parts that it moves; None if nothing is known."""
        return self._definition.end_effector

    # -- what it does ------------------------------------------------------------------

    def fk(self, q: ArrayLike) -> FloatArray:
        """Forward kinematics: pose of the tool.

        Parameters
        ----------
        q : array_like, shape (..., n), rad or m
            Joint values, in or out of the limits.

        Returns
        -------
        ndarray, shape (..., 4, 4)
            Tool in the base frame; lengths in m.

        Raises
        ------
        ArgumentError
            `q` has another last dimension or holds no numbers.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> arm.fk(np.zeros(6))[:3, 3].round(4) + 0.0
        array([-0.8172, -0.1914, -0.0055])
        >>> arm.fk(np.zeros((5, 2, 6))).shape
        (5, 2, 4, 4)
        """
        return self._chain.fk(q)

    def fk_links(self, q: ArrayLike) -> FloatArray:
        """Forward kinematics of every link.

        Parameters
        ----------
        q : array_like, shape (..., n), rad or m
            Joint values.

        Returns
        -------
        ndarray, shape (..., links, 4, 4)
            Frames in the order of `link_names`, in the base frame; lengths in m.

        Raises
        ------
        ArgumentError
            `q` has another last dimension or holds no numbers.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> frames = arm.fk_links(np.zeros(6))
        >>> len(frames) == len(arm.link_names), np.allclose(frames[-1], arm.fk(np.zeros(6)))
        (True, True)
        """
        return self._chain.fk_links(q)

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Geometric Jacobian at the tool point.

        Parameters
        ----------
        q : array_like, shape (..., n), rad or m
            Joint values.

        Returns
        -------
        ndarray, shape (..., 6, n)
            Rows: linear velocity x, y, z (m), then angular velocity x, y, z (rad), in
            the base frame, per rad or per m of each joint.

        Raises
        ------
        ArgumentError
            `q` has another last dimension or holds no numbers.

        Examples
        --------
        >>> ik.Robot.load("redundant7").jacobian(np.zeros(7)).shape
        (6, 7)
        """
        return self._chain.jacobian(q)

    def with_tool(self, tool: ArrayLike) -> Robot:
        """Return the same robot with another tool in place of its own.

        Parameters
        ----------
        tool : array_like, shape (4, 4) or (3,)
            Tool in the last link's frame, m, or its place alone, which does not turn it; replaces
            the present one. (The argument `tool` of `ik` is an offset behind the robot's tool
            instead.)

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        ArgumentError
            Not a rigid transform.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5").with_tool([0, 0, 0.12])
        >>> arm.reach_radius > ik.Robot.load("ur5").reach_radius
        True
        """
        return Robot(self._definition.replaced(tool=frame_of("tool", tool).copy()))

    @property
    def base(self) -> FloatArray:
        """First link's frame in the frame that poses are given in, shape (4, 4), m."""
        given = self._definition.base
        return np.eye(4) if given is None else given.copy()

    def with_base(self, base: ArrayLike) -> Robot:
        """Return the same robot with another base.

        Parameters
        ----------
        base : array_like, shape (4, 4) or (3,)
            First link's frame, or its place alone, in the frame that poses are given in, m;
            replaces the present one. The named frames are dropped: they are tied to the old base.

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        ArgumentError
            Not a rigid transform.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> float((arm.with_base([0, 0, 0.5]).fk(arm.home) - arm.fk(arm.home))[2, 3].round(6))
        0.5
        """
        return Robot(self._definition.replaced(base=frame_of("base", base).copy(), frames={}))

    def in_frame(self, frame: str) -> Robot:
        """Return the same robot with its poses given in one of its named frames.

        Parameters
        ----------
        frame : str
            A name out of `frames`.

        Returns
        -------
        Robot
            The new robot: ``in_frame(f).fk(q)`` is ``frames[f] @ fk(q)``, and `ik` takes
            its targets in that frame.

        Raises
        ------
        UnknownNameError
            No frame has that name.

        Examples
        --------
        >>> arm = ik.Robot.load("strawberry")
        >>> moved = [arm.in_frame(name).fk(arm.home) for name in arm.frames]
        >>> all(np.allclose(T, F @ arm.fk(arm.home)) for T, F in zip(moved, arm.frames.values()))
        True
        """
        known = self._definition.frames
        word("frame", frame, known)
        back = np.eye(4)
        back[:3, :3] = known[frame][:3, :3].T
        back[:3, 3] = -back[:3, :3] @ known[frame][:3, 3]
        base = np.eye(4) if self._definition.base is None else self._definition.base
        frames = {name: pose @ back for name, pose in known.items()}
        return Robot(self._definition.replaced(base=known[frame] @ base, frames=frames))

    def random_q(self, n: int | tuple[int, ...] | None = None, seed: int = 0) -> FloatArray:
        """Draw joint values uniformly within the limits.

        Parameters
        ----------
        n : int or tuple of int, optional
            Leading shape; None draws one vector.
        seed : int, default 0
            Seed of the generator (NumPy's PCG64), >= 0.

        Returns
        -------
        ndarray, shape (*n, dof), rad or m
            Joint values; continuous joints in [-pi, pi].

        Raises
        ------
        ArgumentError
            A negative number.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> q = arm.random_q(100, seed=1)
        >>> q.shape, bool(((arm.lower <= q) & (q <= arm.upper)).all())
        ((100, 6), True)
        """
        sizes = () if n is None else n if isinstance(n, tuple) else (n,)
        shape = tuple(whole_number("n", size, 0) for size in sizes)
        generator = np.random.Generator(np.random.PCG64(whole_number("seed", seed, 0)))
        lower = np.where(np.isfinite(self.lower), self.lower, -np.pi)
        upper = np.where(np.isfinite(self.upper), self.upper, np.pi)
        return generator.uniform(lower, upper, (*shape, self.dof))

    def _with(self, definition: Definition) -> Self:
        return type(self)(definition)

    def joint_values(self, values: Mapping[str, float]) -> FloatArray:
        """Return the vector q in which some joints, named, have the given values.

        Parameters
        ----------
        values : mapping of str to float
            Values, rad or m, by joint name; the other joints are at `home`.

        Returns
        -------
        ndarray, shape (n,), rad or m
            Joint values. Vectors by name can be had back by
            ``dict(zip(robot.joint_names, q))``.

        Raises
        ------
        UnknownNameError
            No joint has that name.
        ArgumentError
            A value is no finite number.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> Robot.load("ur5").joint_values({"elbow": 0.5}).tolist()
        [0.0, 0.0, 0.5, 0.0, 0.0, 0.0]
        """
        if not isinstance(values, Mapping):
            raise ArgumentError("values", shown(values), "values by joint name")
        q = self.home
        for name, value in values.items():
            word("joint", name, self.joint_names)
            q[self.joint_names.index(name)] = real_number(f"values[{name!r}]", value)
        return q

    def __eq__(self, other: object) -> bool:
        """Return True for a robot of the same name, joints, limits, base, tool and home."""
        if not isinstance(other, Robot):
            return NotImplemented
        return self._chain.same(other._chain) and bool((self.home == other.home).all())

    def __hash__(self) -> int:
        return hash((self.name, self.joint_names, self.lower.tobytes(), self.upper.tobytes()))

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, dof={self.dof})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Robot, (self._definition,)
