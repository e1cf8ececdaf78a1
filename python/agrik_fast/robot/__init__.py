"""The robot: geometry, limits and tool of a serial arm, and what can be asked of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array, text, whole_number, word
from ._collision import CollisionBodies
from ._definition import (
    Definition,
    bundled_names,
    from_robot_file,
    locate,
    naming_file,
    urdf_geometry,
)
from ._dh_rows import CONVENTIONS, DhRow, read_table
from ._inverse import PREFERENCES as PREFERENCES
from ._inverse import InverseKinematics
from ._inverse import Prefer as Prefer
from ._inverse import SceneOf as SceneOf
from ._path import Path

__all__ = ["DhRow", "Path", "Robot"]


class Robot(InverseKinematics, CollisionBodies):
    """A serial arm: joints with limits, a base and a tool transform.

    Make one with `Robot.load`, `Robot.from_dh` or `Robot.from_urdf`. A robot never
    changes; `with_tool`, `with_base` and `in_frame` return new ones. Robots can be
    pickled and used from several threads at once.

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

    def __init__(self, definition: Definition) -> None:
        self._definition = definition
        self._chain = definition.build()
        self._compiled = None

    # -- where robots come from ------------------------------------------------------

    @classmethod
    def load(cls, name_or_path: str | PathLike[str]) -> Robot:
        """Load a bundled robot, a robot file or a URDF.

        Parameters
        ----------
        name_or_path : str or path
            A name out of `Robot.names`, or the path of a ``.toml``, ``.urdf`` or
            ``.xml`` file. A URDF must have one root and one leaf link; choose links
            with `Robot.from_urdf` where it has more.

        Returns
        -------
        Robot
            The robot.

        Raises
        ------
        UnknownNameError
            No bundled robot has that name; names the nearest.
        ArgumentError
            The path leads to no file of a known kind.
        RobotFileError
            The TOML file has faults; lists all of them with their places.
        UrdfError
            The URDF does not describe one serial chain.
        """
        path = locate(name_or_path)
        if path.suffix == ".toml":
            return cls(from_robot_file(path))
        return cls.from_urdf(path)

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
        base : array_like, shape (4, 4), optional
            First row's frame in the frame that poses are given in; default identity.
        tool : array_like, shape (4, 4), optional
            Tool in the last row's frame; default identity.
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

        Examples
        --------
        >>> arm = Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], name="planar")
        >>> arm.joint_types
        ('continuous', 'continuous')
        """
        word("convention", convention, CONVENTIONS)
        text("name", name)
        table = read_table(rows, limits, joint_types, joint_names)
        definition = Definition(
            method="from_dh",
            arguments=(name, convention, *table),
            base=None if base is None else float_array("base", base).copy(),
            tool=None if tool is None else float_array("tool", tool).copy(),
            convention=convention,
            dh=table.listing(),
        )
        return cls(definition)

    @classmethod
    def from_urdf(
        cls,
        path_or_text: str | PathLike[str],
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
        path_or_text : str or path
            Path of the file, or the XML text itself (it holds a ``<``).
        base_link, tip_link : str, optional
            First and last link of the chain. Default: the only root and the only leaf
            link; needed where there are several.
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
            unknown or ambiguous, or no joint moves.
        """
        for argument, link in (("base_link", base_link), ("tip_link", tip_link)):
            if link is not None:
                text(argument, link)
        geometry = urdf_geometry(
            path_or_text, base_link, cylinder=cylinder, mesh=mesh, mesh_folders=mesh_folders
        )
        definition = Definition("from_urdf", (geometry.text, base_link, tip_link), urdf=geometry)
        with naming_file(path_or_text):
            return cls(definition)

    @staticmethod
    def names() -> tuple[str, ...]:
        """Return the names of the bundled robots, sorted."""
        return bundled_names()

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
    def description(self) -> str:
        """One line on what the robot is; empty if nobody said."""
        return self._definition.description

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
        """
        return self._chain.jacobian(q)

    def with_tool(self, tool: ArrayLike) -> Robot:
        """Return the same robot with another tool.

        Parameters
        ----------
        tool : array_like, shape (4, 4)
            Tool in the last link's frame, m; replaces the present one.

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        ArgumentError
            Not a rigid transform.
        """
        return Robot(self._definition.replaced(tool=float_array("tool", tool).copy()))

    @property
    def base(self) -> FloatArray:
        """First link's frame in the frame that poses are given in, shape (4, 4), m."""
        given = self._definition.base
        return np.eye(4) if given is None else given.copy()

    def with_base(self, base: ArrayLike) -> Robot:
        """Return the same robot with another base.

        Parameters
        ----------
        base : array_like, shape (4, 4)
            First link's frame in the frame that poses are given in, m; replaces the
            present one. The named frames are dropped: they are tied to the old base.

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        ArgumentError
            Not a rigid transform.
        """
        return Robot(self._definition.replaced(base=float_array("base", base).copy(), frames={}))

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
        """
        sizes = () if n is None else n if isinstance(n, tuple) else (n,)
        shape = tuple(whole_number("n", size, 0) for size in sizes)
        generator = np.random.Generator(np.random.PCG64(whole_number("seed", seed, 0)))
        lower = np.where(np.isfinite(self.lower), self.lower, -np.pi)
        upper = np.where(np.isfinite(self.upper), self.upper, np.pi)
        return generator.uniform(lower, upper, (*shape, self.dof))

    def _with(self, definition: Definition) -> Self:
        return type(self)(definition)

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, dof={self.dof})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Robot, (self._definition,)
