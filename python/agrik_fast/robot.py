"""The robot: geometry, limits and tool of a serial arm, and what can be asked of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ._checks import FloatArray, float_array, whole_number
from ._definition import Definition, bundled_names, from_robot_file, locate, read_urdf
from ._dh_rows import CONVENTIONS, DhRow, read_table
from ._stream import solve_ahead
from .errors import UnknownNameError

if TYPE_CHECKING:
    from ._native import TargetSolver
    from .path import Path
    from .result import Branches, IkResult
    from .solvers import DifferentialEvolution, GeneticAlgorithm, Solver
    from .tasks import Task

__all__ = ["DhRow", "Robot"]


class Robot:
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

    __slots__ = ("_chain", "_definition")

    def __init__(self, definition: Definition) -> None:
        self._definition = definition
        self._chain = definition.build()

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
        if convention not in CONVENTIONS:
            raise UnknownNameError("convention", str(convention), CONVENTIONS)
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
    ) -> Robot:
        """Build a robot from a URDF.

        Joints, origins, axes, limits and mimic rules count; meshes, inertias and
        transmissions are ignored.

        Parameters
        ----------
        path_or_text : str or path
            Path of the file, or the XML text itself (it holds a ``<``).
        base_link, tip_link : str, optional
            First and last link of the chain. Default: the only root and the only leaf
            link; needed where there are several.

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
        return cls(Definition("from_urdf", (read_urdf(path_or_text), base_link, tip_link)))

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

    def ik(
        self,
        targets: ArrayLike,
        task: Task | str | None = None,
        solver: Solver | str = "lm",
        q0: ArrayLike | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        *,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        first_index: int = 0,
    ) -> IkResult:
        """Inverse kinematics of a batch of targets.

        A target that cannot be solved is no error: its row of the result has
        ``success`` False, a status that says why, and the best joint values found.
        The same input, seed and version give bit-identical answers for any number of
        threads and for any split of a batch (see `first_index`).

        Parameters
        ----------
        targets : array_like, shape (..., 4, 4) or (..., 3)
            Poses of the tool, or positions of the tool point, in the base frame; m.
        task : task or {"position", "pose", "axis"}, optional
            What counts as reached, see `agrik_fast.tasks`. Default: "pose" for shape
            (..., 4, 4), "position" for (..., 3).
        solver : solver or a name, default "lm"
            How to get there, see `agrik_fast.solvers`; names are "lm", "dls", "pinv",
            "transpose", "de", "ga", "closed_form" (full poses of arms that have one, see
            `closed_form`) and "auto", the closed form where there is one, else "lm".
        q0 : array_like, shape broadcastable to (..., n), rad or m, optional
            Start values of the first attempt. Default: chosen from the seed.
        seed : int, default 0
            Seed of the random start values, 0 to 2**64 - 1.
        tool : array_like, shape (4, 4), optional
            An offset behind the robot's own tool for this call: the transform from the
            robot's tool frame to the frame that has to reach the target, m.
        threads : int, optional
            Number of threads; default as set by `agrik_fast.set_num_threads` or the
            environment variable ``AGRIK_NUM_THREADS``, else one per core.
        position_tolerance : float, default 1e-6
            Largest distance between tool point and target, m; above 0.
        orientation_tolerance : float, default 1e-6
            Largest angle between tool and target orientation, rad; above 0.
        first_index : int, default 0
            Index of the first target within a larger batch, so that the pieces of a
            batch get the answers of the whole.

        Returns
        -------
        IkResult
            Joint values, success, status, errors and effort, in the targets' leading
            shape.

        Raises
        ------
        ArgumentError
            A wrong shape, type or value of an argument; a transform that is not rigid.
            Non-finite rows of `targets` or `q0` do not raise: their status is
            ``Status.BAD_INPUT``.
        UnknownNameError
            Unknown task or solver; names the nearest.
        KeyboardInterrupt
            Ctrl-C; a long batch stops within a second.
        """
        return self._chain.ik(
            targets,
            task,
            solver,
            q0,
            seed,
            tool,
            threads,
            position_tolerance,
            orientation_tolerance,
            first_index,
        )

    def solver(
        self,
        task: Task | str | None = None,
        solver: Solver | str = "lm",
        seed: int = 0,
        tool: ArrayLike | None = None,
        *,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
    ) -> TargetSolver:
        """Make a solver for one target at a time, for control loops.

        Options are read once; its `solve` gives, bit for bit, what `ik` gives for the same
        target, and allocates nothing after the first call.

        Parameters
        ----------
        task : task or {"position", "pose", "axis"}, default "pose"
            What counts as reached, see `agrik_fast.tasks`.
        solver, seed, tool, position_tolerance, orientation_tolerance
            As for `ik`; step solvers only.

        Returns
        -------
        TargetSolver
            With `solve(target, q0)` and the last answer as attributes.

        Raises
        ------
        ArgumentError
            As for `ik`.
        """
        return self._chain.solver(
            task, solver, seed, tool, position_tolerance, orientation_tolerance
        )

    def follow(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        max_joint_step: ArrayLike = 0.1,
        task: Task | str | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
        *,
        pull: float = 0.5,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
    ) -> Path:
        """Follow a sequence of targets, every posture the continuation of the one before.

        Each target is solved by the default step solver from the posture before, inside
        limits that leave every joint no more than one step. The freedom that a redundant
        arm has is used to stay near the posture before. If that fails, other postures
        within the step are tried; if none leads to the target, the nearest posture that a
        search of the whole range finds is taken and reported as a discontinuity.

        Parameters
        ----------
        targets : array_like, shape (n, 4, 4) or (n, 3)
            Poses of the tool, or positions of the tool point, in order, base frame; m.
        q0 : array_like, shape (dof,), rad or m, optional
            Where the arm stands before the first target, within the limits. Without it the
            first posture is free.
        max_joint_step : float or array_like, shape (dof,), rad or m, default 0.1
            Largest change of each joint from one target to the next.
        task, tool, position_tolerance, orientation_tolerance : optional
            As in `ik`.
        seed : int, default 0
            Seed of the searches, 0 to 2**64 - 1.
        pull : float, default 0.5
            Share of the way back to the posture before that each solver step goes in the
            null space of the task; 0 to 1.

        Returns
        -------
        Path
            Joint values, success, errors and discontinuities, one row a target.

        Raises
        ------
        ArgumentError
            A wrong shape, type or value of an argument; start values out of the limits.
        KeyboardInterrupt
            Ctrl-C.
        """
        from .path import Path

        result, jumps = self._chain.follow(
            targets,
            max_joint_step,
            q0,
            pull,
            task,
            seed,
            tool,
            position_tolerance,
            orientation_tolerance,
        )
        steps = np.zeros_like(result.q)
        if len(steps):
            steps[1:] = np.diff(result.q, axis=0)
            if q0 is not None:
                steps[0] = result.q[0] - float_array("q0", q0)
        return Path(
            q=result.q,
            success=result.success,
            status=result.status,
            position_error=result.position_error,
            orientation_error=result.orientation_error,
            iterations=result.iterations,
            discontinuity=jumps,
            joint_step=steps,
        )

    def cost_history(
        self,
        target: ArrayLike,
        solver: DifferentialEvolution | GeneticAlgorithm | str = "de",
        task: Task | str | None = None,
        q0: ArrayLike | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
    ) -> FloatArray:
        """Best cost of a population solver, generation by generation.

        Parameters
        ----------
        target : array_like, shape (4, 4) or (3,)
            Pose of the tool, or position of the tool point, in the base frame; m.
        solver : DifferentialEvolution, GeneticAlgorithm, "de" or "ga"
            The search.
        task, q0, seed, tool : optional
            As in `ik`.

        Returns
        -------
        ndarray, shape (generations + 1,)
            Cost of the best individual of the first population and after each generation
            of the first run of `ik` with the same arguments; weights of the solver.

        Raises
        ------
        ArgumentError
            A step solver, several targets, or a wrong argument as in `ik`.
        """
        return self._chain.cost_history(target, solver, task, q0, seed, tool)

    @property
    def closed_form(self) -> str | None:
        """Family of the arm's closed form, "spherical wrist" or "S-R-S"; None without."""
        return self._chain.closed_form[0]

    def ik_all(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        arm_angle: ArrayLike | None = None,
        *,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
    ) -> Branches:
        """Every branch of the inverse kinematics of an arm with a closed form.

        Six revolute joints of which the last three axes meet have up to eight branches;
        seven revolute joints of which also the first three meet (S-R-S) have up to eight
        for each arm angle. Each branch is checked by forward kinematics.

        Parameters
        ----------
        targets : array_like, shape (..., 4, 4)
            Poses of the tool in the base frame; m.
        q0 : array_like, shape broadcastable to (..., n), rad, optional
            Of the values a whole turn apart that a joint's limits allow, the one nearest to
            this is returned, and angles that a singularity leaves open are taken from it.
            Default: the middle of the limits.
        tool : array_like, shape (4, 4), optional
            Tool in the last link's frame, in place of the robot's own for this call.
        threads : int, optional
            Number of threads, as for `ik`.
        arm_angle : array_like, shape broadcastable to (...), rad, optional
            Arm angle of an S-R-S arm, see `arm_angle`. Default: that of `q0`, or 0.
        position_tolerance : float, default 1e-6
            Largest distance between tool point and target, m; above 0. Branches of
            reachable targets come to rounding; this decides at the edge of the reach.
        orientation_tolerance : float, default 1e-6
            Largest angle between tool and target orientation, rad; above 0.

        Returns
        -------
        Branches
            Joint values (..., 8, n), which of them are valid, and a status per target:
            ``CONVERGED`` with at least one valid branch; ``OUT_OF_REACH`` if no solution
            exists within the limits; ``NOT_FOUND`` if an S-R-S arm has one only at other
            arm angles or not at all.

        Raises
        ------
        ArgumentError
            The arm has no closed form (the message says why), or an argument is wrong.
        KeyboardInterrupt
            Ctrl-C; a long batch stops within a second.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> arm = ik.Robot.load("puma560")
        >>> branches = arm.ik_all(arm.fk([0.1, 0.6, -0.4, 0.3, 0.5, 0.2]))
        >>> branches.q.shape, int(branches.valid.sum())
        ((8, 6), 4)
        """
        return self._chain.ik_all(
            targets,
            q0,
            tool,
            threads,
            arm_angle,
            position_tolerance,
            orientation_tolerance,
        )

    def arm_angle(self, q: ArrayLike) -> FloatArray:
        """Arm angle of an S-R-S arm.

        The elbow's turn about the line from shoulder to wrist, by the right hand about the
        direction to the wrist. It is zero where the elbow leans towards the direction of
        the first axis (where the wrist is right above or below the shoulder: towards x of
        the base frame, or y if the first axis is along x).

        Parameters
        ----------
        q : array_like, shape (..., 7), rad
            Joint values.

        Returns
        -------
        ndarray, shape (...), rad
            Angles in [-pi, pi].

        Raises
        ------
        ArgumentError
            The arm is no S-R-S arm, or `q` has another last dimension.
        """
        return self._chain.arm_angle(q)

    def arm_angle_intervals(
        self, target: ArrayLike, tool: ArrayLike | None = None
    ) -> tuple[FloatArray, ...]:
        """Arm angles at which the limits allow a pose of an S-R-S arm, for each branch.

        Parameters
        ----------
        target : array_like, shape (4, 4)
            Pose of the tool in the base frame; m.
        tool : array_like, shape (4, 4), optional
            Tool in the last link's frame, in place of the robot's own.

        Returns
        -------
        tuple of 8 ndarray, shape (k, 2), rad
            First and last arm angle of each interval, in the order of the branches of
            `ik_all`; the first in [-pi, pi), the last above pi where the interval goes
            through half a turn. No rows for a branch without any.

        Raises
        ------
        ArgumentError
            The arm is no S-R-S arm, or the target is no rigid transform.
        """
        found = self._chain.arm_angle_intervals(target, tool)
        return tuple(np.array(one, dtype=np.float64).reshape(-1, 2) for one in found)

    def ik_stream(
        self,
        chunks: Iterable[ArrayLike],
        task: Task | str | None = None,
        solver: Solver | str = "lm",
        q0: ArrayLike | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        *,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        first_index: int = 0,
    ) -> Iterator[IkResult]:
        """Inverse kinematics of a stream of chunks, for more targets than memory holds.

        One chunk is solved ahead: while the caller uses a result, the next chunk is being
        solved in another thread. The answers are those of one call of `ik` with all
        targets. Chunks are taken from the iterator in the caller's thread.

        Parameters
        ----------
        chunks : iterable of array_like, each of shape (..., 4, 4) or (..., 3)
            Targets as for `ik`; some tens of thousands in a chunk keep all cores busy.
        task, solver, seed, tool, threads, position_tolerance, orientation_tolerance
            As for `ik`, the same for all chunks.
        q0 : array_like, shape (n,), rad or m, optional
            Start values of every target's first attempt.
        first_index : int, default 0
            Index of the first target of the first chunk; those that follow are counted on.

        Returns
        -------
        iterator of IkResult
            One result a chunk, in order.

        Raises
        ------
        ArgumentError, UnknownNameError
            As `ik`, when the chunk's result is asked for; `first_index` at once.
        """
        first_index = whole_number("first_index", first_index, 0, 2**64 - 1)

        def solve(targets: ArrayLike, index: int) -> IkResult:
            return self.ik(
                targets,
                task,
                solver,
                q0,
                seed,
                tool,
                threads,
                position_tolerance=position_tolerance,
                orientation_tolerance=orientation_tolerance,
                first_index=index,
            )

        return solve_ahead(chunks, solve, first_index)

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
        if frame not in known:
            raise UnknownNameError("frame", frame, known)
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

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, dof={self.dof})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Robot, (self._definition,)
