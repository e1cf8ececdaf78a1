"""The compiled core: chains, kinematics and solvers.

Users go through `agrik_fast.Robot`, which hands its arguments on; this module checks them
and raises the classes of `agrik_fast.errors`. Tasks and solvers are read by their names and
fields, so that it knows none of their classes.
"""

from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, NotRequired, TypedDict, final, type_check_only

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Bodies",
    "Branches",
    "Chain",
    "Collider",
    "CsvRows",
    "Distances",
    "HarvestProgramme",
    "HarvestStation",
    "IkResult",
    "Motion",
    "Scene",
    "StrawberryArm",
    "TargetSolver",
    "TomatoArm",
    "Tuner",
    "__version__",
    "_panic",
    "branches",
    "check_solver",
    "collision_near",
    "collision_shifted_own",
    "csv_lines",
    "default_settings",
    "get_num_threads",
    "harvest_words",
    "ik_paced",
    "ik_record",
    "ik_result",
    "limited_solver_names",
    "motion_blockers",
    "motion_check",
    "motion_corners",
    "motion_plan",
    "motion_words",
    "set_num_threads",
    "simd_level",
    "solver_names",
    "statuses",
]

__version__: str

@type_check_only
class JointSpec(TypedDict):
    """One joint of `Chain.from_joints`."""

    name: str
    type: str
    origin: ArrayLike
    axis: ArrayLike
    lower: float
    upper: float
    mimic: tuple[str, float, float] | None
    link: NotRequired[str | None]

@final
class Motion:
    """A motion along a way, from rest to rest within the limits of the joints.

    Through waypoints, shape (n, dof), whose segments have `lengths`, shape (n - 1,): with
    corners rounded by `blends`, shape (n,), or as one smooth curve where it is None; `limits`,
    shape (3, dof), are those of velocity, acceleration and jerk, `speed` one along the way.
    """

    def __new__(
        cls,
        waypoints: ArrayLike,
        lengths: ArrayLike,
        blends: ArrayLike | None,
        limits: ArrayLike,
        speed: float,
    ) -> Motion: ...
    @property
    def duration(self) -> float:
        """Duration, s."""

    @property
    def length(self) -> float:
        """Length of the way, in the measure of the segments' lengths."""

    @property
    def deviation(self) -> float:
        """How far a rounded corner leaves its waypoint at most, in any joint value, rad or m."""

    @property
    def times(self) -> NDArray[np.float64]:
        """When the phases begin, and when the last one ends, shape (n + 1,), s."""

    @property
    def phases(self) -> NDArray[np.float64]:
        """Place on the way and its derivatives by time at the begin of each phase, (n, 4)."""

    def place(self, times: ArrayLike) -> NDArray[np.float64]:
        """Return the place on the way and its first three derivatives by time, shape (n, 4)."""

    def at(self, times: ArrayLike) -> NDArray[np.float64]:
        """Return joint values, velocities, accelerations and jerks, shape (4, n, dof)."""

@final
class Chain:
    """A serial chain: geometry, limits, base and tool, compiled for the solvers."""

    @staticmethod
    def from_dh(
        name: str,
        convention: str,
        rows: ArrayLike,
        joint_types: list[str],
        joint_names: list[str],
        lower: ArrayLike,
        upper: ArrayLike,
        base: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        variable_order: list[str] | None = None,
    ) -> Chain:
        """Build a chain from Denavit-Hartenberg rows.

        Parameters
        ----------
        name : str
            Name of the robot.
        convention : {"standard", "modified"}
            Distal, or Craig's.
        rows : ndarray, shape (n, 4)
            Columns a (m), alpha (rad), d (m), theta (rad).
        joint_types : list of n str
            "revolute", "continuous", "prismatic" or "fixed".
        joint_names : list of n str
            Unique names.
        lower, upper : ndarray, shape (n,), rad or m
            Limits; ignored for continuous and fixed joints.
        base, tool : ndarray, shape (4, 4), optional
            Base and tool transforms, m; default identity.
        variable_order : list of str, optional
            Names of the joint variables in the order of q; default: physical order.

        Returns
        -------
        Chain
            The chain.

        Raises
        ------
        ArgumentError
            A wrong shape or value, limits in the wrong order, a transform that is not
            rigid, no joint that moves.
        """

    @staticmethod
    def from_joints(
        name: str,
        joints: list[JointSpec],
        base: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        variable_order: list[str] | None = None,
    ) -> Chain:
        """Build a chain from joints with origins and axes.

        Parameters
        ----------
        name : str
            Name of the robot.
        joints : list of dict
            ``name``; ``type``; ``origin``, shape (4, 4), in the previous link, m;
            ``axis``, shape (3,), in the origin's frame; ``lower`` and ``upper``, rad or
            m; ``mimic``, None or (joint, multiplier, offset).
        base, tool : ndarray, shape (4, 4), optional
            Base and tool transforms, m; default identity.
        variable_order : list of str, optional
            Names of the joint variables in the order of q; default: physical order.

        Returns
        -------
        Chain
            The chain.

        Raises
        ------
        ArgumentError
            A wrong shape or value, a zero axis, limits in the wrong order, a mimic rule
            without its joint, no joint that moves.
        """

    @staticmethod
    def from_urdf(
        text: str, base_link: str | None = None, tip_link: str | None = None
    ) -> tuple[Chain, tuple[str, str, list[str], list[str]]]:
        """Build a chain from the text of a URDF.

        Parameters
        ----------
        text : str
            XML text.
        base_link, tip_link : str, optional
            First and last link; default: the only root and the end of the only arm.

        Returns
        -------
        chain : Chain
            The chain.
        ends : (str, str, list of str, list of str)
            Its first and last link, other links that the last could be, and the joints that
            their limits, both 0, lock.

        Raises
        ------
        UrdfError
            The text does not describe one serial chain.
        """

    @property
    def name(self) -> str:
        """Name of the robot."""

    @property
    def dof(self) -> int:
        """Number of joint variables, the length of q."""

    @property
    def joint_names(self) -> list[str]:
        """Names of the joint variables, in the order of q."""

    @property
    def joint_types(self) -> list[str]:
        """Types of the joint variables, in the order of q."""

    def joints(self) -> list[dict[str, Any]]:
        """Return the joints, fixed ones and followers too, as `from_joints` takes them."""

    @property
    def base(self) -> NDArray[np.float64]:
        """Base transform, shape (4, 4), m."""

    @property
    def tool(self) -> NDArray[np.float64]:
        """Tool transform, shape (4, 4), m."""

    def same(self, other: Chain) -> bool:
        """Return True for a chain of the same name, joints, links, limits, base and tool."""

    @property
    def lower(self) -> NDArray[np.float64]:
        """Smallest values, shape (dof,), rad or m; -inf for continuous joints."""

    @property
    def upper(self) -> NDArray[np.float64]:
        """Largest values, shape (dof,), rad or m; inf for continuous joints."""

    @property
    def motion_limits(self) -> NDArray[np.float64]:
        """Largest speed, acceleration and jerk, shape (3, dof), rad or m and s; inf where unknown.

        No faster than any joint that follows another allows.
        """

    def joint_motion_limits(self) -> list[tuple[str, tuple[float, float, float]]]:
        """Return the same by the names of the joints, as `with_motion_limits` takes it.

        Of the joints of which anything is known.
        """

    def with_limits(self, limits: dict[str, tuple[float, float]]) -> Chain:
        """Return the chain with other limits of the joint variables that are named."""

    def locked(self, locks: dict[str, float]) -> Chain:
        """Return the chain with the joint variables that are named at rest, at their values."""

    def velocity(
        self,
        q: ArrayLike,
        twists: ArrayLike,
        least: ArrayLike,
        most: ArrayLike,
        turns: bool,
        second_aim: object = None,
        gain: float = 1.0,
        threads: int | None = None,
    ) -> NDArray[np.float64]:
        """Return joint rates, shape (n, dof), for twists, shape (n, 6).

        They lie between bounds, shape (n, dof); the turns count where `turns`.
        """

    def with_motion_limits(self, limits: Mapping[str, tuple[float, float, float]]) -> Chain:
        """Return the chain with other limits of motion of the joints that are named."""

    @property
    def link_names(self) -> list[str]:
        """Names of the frames of `fk_links`, the tool last."""

    @property
    def reach_radius(self) -> float:
        """Proven bound, m, on the tool point's distance from `reach_center`."""

    @property
    def reach_center(self) -> NDArray[np.float64]:
        """Centre of the reach ball, base frame, shape (3,), m."""

    @property
    def reach_box(self) -> NDArray[np.float64]:
        """Proven bounds of the tool point, base frame, shape (2, 3), m."""

    def with_tool(self, tool: ArrayLike) -> Chain:
        """Return the chain with another tool, shape (4, 4), m."""

    def with_base(self, base: ArrayLike) -> Chain:
        """Return the chain with another base, shape (4, 4), m."""

    def fk(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return tool poses, shape (..., 4, 4), of joint values, shape (..., dof)."""

    def fk_links(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return link poses, shape (..., links, 4, 4), of joint values, shape (..., dof)."""

    def jacobian(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return geometric Jacobians, shape (..., 6, dof), linear rows first."""

    def frozen_gain(self, per_radian: float | None = None) -> NDArray[np.float64]:
        """Return the gain that feedback solvers without matrices start from.

        Half a pseudo-inverse, in the middle of the limits or where the arm is not singular;
        rad or m by m, along the axes of the first link, shape (dof, 3) for positions. With
        the length (m) that a radian counts as: shape (dof, 6), for poses.
        """

    def ik(
        self,
        targets: ArrayLike,
        task: object = None,
        solver: object = None,
        q0: ArrayLike | None = None,
        seed: int | None = None,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        position_tolerance: ArrayLike | None = None,
        orientation_tolerance: ArrayLike | None = None,
        first_index: int | None = None,
        tolerance_frame: str | None = None,
        collider: Collider | None = None,
        clear: float | None = None,
        prefer: str | None = None,
        invalid: str | None = None,
        second_aim: object = None,
        nearest: int | bool | None = None,
        joint_weights: ArrayLike | None = None,
        limits: ArrayLike | None = None,
    ) -> IkResult:
        """Solve a batch of targets; see `agrik_fast.Robot.ik`.

        `collider` is that of the scene, of the same arm; `clear` (m, default 0) is what
        answers keep from the scene; `prefer` is "first" (default), "near" or "clearance".
        """

    def solver(
        self,
        task: object = None,
        solver: object = None,
        seed: int | None = None,
        tool: ArrayLike | None = None,
        position_tolerance: ArrayLike | None = None,
        orientation_tolerance: ArrayLike | None = None,
        tolerance_frame: str | None = None,
        second_aim: object = None,
        max_change: ArrayLike | None = None,
        recipe: tuple[Any, ...] | None = None,
    ) -> TargetSolver:
        """Make a solver for one target at a time; see `agrik_fast.Robot.solver`."""

    def follow(
        self,
        targets: ArrayLike,
        max_joint_step: ArrayLike,
        q0: ArrayLike | None = None,
        pull: float | None = None,
        task: object = None,
        seed: int | None = None,
        tool: ArrayLike | None = None,
        position_tolerance: ArrayLike | None = None,
        orientation_tolerance: ArrayLike | None = None,
        tolerance_frame: str | None = None,
    ) -> tuple[IkResult, NDArray[np.bool_], NDArray[np.float64]]:
        """Follow a sequence of targets; see `agrik_fast.Robot.follow`."""

    def cost_history(
        self,
        target: ArrayLike,
        solver: object,
        task: object = None,
        q0: ArrayLike | None = None,
        seed: int | None = None,
        tool: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """Return the best cost of a population solver's first run, generation by generation."""

    def ik_all(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        arm_angle: ArrayLike | None = None,
        position_tolerance: ArrayLike | None = None,
        orientation_tolerance: ArrayLike | None = None,
        tolerance_frame: str | None = None,
        locked: Mapping[str, ArrayLike] | None = None,
        sweep: int | None = None,
        wrap: bool | None = None,
        task: object = None,
        invalid: str | None = None,
    ) -> Branches:
        """All branches of a batch of poses; see `agrik_fast.Robot.ik_all`."""

    def arm_angle(self, q: ArrayLike) -> NDArray[np.float64]:
        """Arm angles, shape (...), rad, of joint values, shape (..., dof), of an S-R-S arm."""

    def arm_angle_intervals(
        self, target: ArrayLike, tool: ArrayLike | None = None
    ) -> list[list[tuple[float, float]]]:
        """Arm angles that the limits allow for one pose: for each branch (lower, upper), rad."""

    @property
    def family(self) -> tuple[str, str, str, int, str | None]:
        """Name, method, reason, most branches and locked joint, see `agrik_fast.Robot.family`."""

    @property
    def closed_form(self) -> tuple[str | None, str | None]:
        """Family of the chain's closed form, or why it has none: (name, reason)."""

@final
class Branches:
    """Every branch of the targets of one `Robot.ik_all` call.

    Examples
    --------
    >>> arm = ik.Robot.load("puma560")
    >>> found = arm.ik_all(arm.fk([0.4, 0.9, -0.6, 0.5, 0.7, 0.2]))
    >>> found.q.shape, int(found.valid.sum())
    ((8, 6), 4)
    """

    @property
    def q(self) -> NDArray[np.float64]:
        """Joint values, shape (..., branches, dof), rad; the nearest where not reached."""

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Reached by forward kinematics, inside the limits, no branch twice."""

    @property
    def reached(self) -> NDArray[np.bool_]:
        """`valid` without regard to the limits."""

    @property
    def singular(self) -> NDArray[np.uint8]:
        """Singularities of each branch, a sum of codes of `agrik_fast.Singularity`."""

    @property
    def status(self) -> NDArray[np.uint8]:
        """Codes of `agrik_fast.Status`."""

    @property
    def warnings(self) -> NDArray[np.uint8]:
        """Sums of codes of `agrik_fast.Warnings`, one a target."""

    @property
    def free_joint(self) -> NDArray[np.int8]:
        """Entry of `q` that a singularity leaves free, -1 for none; one a target."""

    @property
    def value(self) -> NDArray[np.float64]:
        """Value of the swept joint or arm angle of each branch, rad or m; NaN without a sweep."""

    @property
    def branch(self) -> NDArray[np.uint32]:
        """Number of each branch among those of its value."""

    @property
    def orientation_error(self) -> NDArray[np.float64]:
        """Least angle left, rad, of targets that ask for more than the arm has joints for.

        Of ``OVERDETERMINED`` targets for arms of five joints it is the least among the branches
        within the limits, or of all where none is; infinite where none reaches the point.
        """

    @property
    def position_error(self) -> NDArray[np.float64]:
        """Distance that goes with it, m; 0 where the record says nothing of it.

        Of ``OVERDETERMINED`` targets for arms of up to four joints that turn, angle and distance
        are those of the posture of least error within the limits, orientations counted as
        `Robot.ik` does; it is ``q[..., 0, :]``. For arms of five the distance is that of rounding,
        or infinite as the angle is.
        """

    def __len__(self) -> int:
        """Return the number of rows along the first dimension of the targets."""

    def __getitem__(self, key: object, /) -> Branches:
        """Return the record of some of the targets, chosen as in a NumPy array of them."""

    def __iter__(self) -> Iterator[Branches]:
        """Go through the rows along the first dimension of the targets."""

    def to_dict(self) -> dict[str, Any]:
        """Return the arrays by their names.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> arm.ik_all(arm.fk(np.full(6, 0.5))).to_dict()["q"].shape
        (8, 6)
        """

    def to_arrow(self) -> Any:
        """Return a `pyarrow.Table`: one row a target (of branches: a branch).

        Raises
        ------
        MissingExtraError
            pyarrow is not installed.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> found = arm.ik_all(arm.fk(np.full((1, 6), 0.5)))
        >>> found.to_arrow().num_rows
        8
        """

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame` of the same columns.

        Raises
        ------
        MissingExtraError
            pandas is not installed.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> found = arm.ik_all(arm.fk(np.full((1, 6), 0.5)))
        >>> len(found.to_pandas())
        8
        """

@final
class TargetSolver:
    """A solver for one target at a time, from `Robot.solver`.

    Each call overwrites the values of the one before and, but for the feedback laws with
    matrices, allocates no memory after the first.

    Examples
    --------
    >>> arm = ik.Robot.load("panda")
    >>> solver = arm.solver(seed=1)
    >>> q = np.array([0.0, -0.4, 0.0, -2.0, 0.0, 1.8, 0.8])
    >>> solver.solve(arm.fk(q), q), ik.Status(solver.status).name
    (True, 'CONVERGED')
    """

    def solve(self, target: ArrayLike, q0: ArrayLike | None = None) -> bool:
        """Solve one target.

        Parameters
        ----------
        target : array_like, shape (4, 4) or (3,)
            Pose of the tool, or position of the tool point, in the base frame; m. An
            array of doubles is read without conversion.
        q0 : array_like, shape (n,), rad or m, optional
            Start values of the first attempt, for example the last `q`. Default: chosen
            from the seed. With `max_change` where the arm stands; default: the last answer.

        Returns
        -------
        bool
            Whether the target was reached: by a final FK check, within the limits.

        Raises
        ------
        ArgumentError
            A wrong shape or type; a transform that is not rigid.

        Examples
        --------
        >>> solver = ik.Robot.load("tomato").solver("position")
        >>> solver.solve([0.2, 0.1, 0.1]), solver.solve([9.0, 0.0, 0.0])
        (True, False)
        """

    @property
    def q(self) -> NDArray[np.float64]:
        """Joint values of the last answer, shape (n,), rad or m; a copy."""

    @property
    def success(self) -> bool:
        """Whether the last target was reached."""

    @property
    def status(self) -> int:
        """Code of `agrik_fast.Status` of the last target."""

    @property
    def position_error(self) -> float:
        """Distance of the tool point from the last target, m; infinite for bad input."""

    @property
    def orientation_error(self) -> float:
        """Angle left to the last target's orientation, rad; 0 for position tasks."""

    @property
    def iterations(self) -> int:
        """Steps taken for the last target, over all attempts."""

    @property
    def restarts(self) -> int:
        """Attempts after the first for the last target."""

    @property
    def result(self) -> IkResult:
        """The last answer as a record of its own.

        Examples
        --------
        >>> solver = ik.Robot.load("tomato").solver("position")
        >>> solver.solve([0.2, 0.1, 0.1]), solver.result.success
        (True, array(True))
        """

    def to_dict(self) -> dict[str, Any]:
        """Return the last answer's arrays by their names, as `IkResult.to_dict`.

        Examples
        --------
        >>> list(ik.Robot.load("tomato").solver("position").to_dict())[:2]
        ['q', 'status']
        """

    def to_arrow(self) -> Any:
        """Return the last answer as a `pyarrow.Table` of one row.

        Raises
        ------
        MissingExtraError
            pyarrow is not installed (extra ``parquet``).

        Examples
        --------
        >>> ik.Robot.load("tomato").solver("position").to_arrow().num_rows
        1
        """

    def to_pandas(self) -> Any:
        """Return the last answer as a `pandas.DataFrame` of one row.

        Raises
        ------
        MissingExtraError
            pandas is not installed (extra ``pandas``).

        Examples
        --------
        >>> len(ik.Robot.load("tomato").solver("position").to_pandas())
        1
        """

@final
class IkResult:
    """Answers of one `Robot.ik` call; arrays have the targets' leading shape.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> result = arm.ik(arm.fk(arm.random_q(4, seed=1)))
    >>> result.q.shape, bool(result.success.all()), bool((result.position_error < 1e-6).all())
    ((4, 6), True, True)
    """

    @property
    def q(self) -> NDArray[np.float64]:
        """Joint values, shape (..., dof), rad or m; the best found where unsolved."""

    @property
    def success(self) -> NDArray[np.bool_]:
        """True only where a final FK check met the tolerances and the limits."""

    @property
    def status(self) -> NDArray[np.uint8]:
        """Codes of `agrik_fast.Status`."""

    @property
    def position_error(self) -> NDArray[np.float64]:
        """Distance of the tool point from the target, m; infinite for bad input."""

    @property
    def orientation_error(self) -> NDArray[np.float64]:
        """Angle left to the target orientation, rad; 0 for position tasks."""

    @property
    def iterations(self) -> NDArray[np.uint32]:
        """Steps taken, over all attempts."""

    @property
    def restarts(self) -> NDArray[np.uint32]:
        """Attempts after the first."""

    @property
    def clearance(self) -> NDArray[np.float64] | None:
        """Distance of each answer from the nearest collision, m; None without a scene.

        Worked out when it is asked for.
        """

    @property
    def nearest_pair(self) -> NDArray[np.object_] | None:
        """Names of a body and of the object or other body nearest to it, shape (..., 2).

        Empty names where there is nothing. Worked out when it is asked for; None without a
        scene.
        """

    @property
    def warnings(self) -> NDArray[np.uint8]:
        """Codes of `agrik_fast.Warnings`, shape (...); 0 for none."""

    def jacobian_of_q(self, wrt: Literal["target", "dh"] = "target") -> NDArray[np.float64]:
        """How the joint values follow their targets, or the numbers of the arm.

        By the implicit function theorem at the answer: the joint values change so that the
        error of the task stays zero. Of a redundant arm, and of tasks that leave something
        free, it is the smallest change that does so (least squares over rad and m); near a
        singularity directions that the arm cannot go are left out. Limits are not looked at.

        Parameters
        ----------
        wrt : {"target", "dh"}, default "target"
            By the target, or by the rows of an arm that was made from such.

        Returns
        -------
        ndarray, shape (..., n, 6), (..., n, 3) or (..., n, rows, 4)
            By a displacement of the target: of each joint value (rad, m) the derivatives by a
            way along x, y, z (m), then by a turn about x, y, z (rad), in the base frame; for
            targets that are points by the way alone. By rows: the derivatives by a, alpha, d
            and theta (m, rad), in the order of `Robot.dh`. 0 for targets that were not
            reached.

        Raises
        ------
        ArgumentError
            The result does not know its question, as one that was pickled; the task is
            "position-first"; the arm has no DH rows.
        UnknownNameError
            Another word.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> arm = ik.Robot.load("ur5")
        >>> result = arm.ik(arm.fk([[0.1, -1.2, 1.3, 0.2, 0.9, 0.3]]))
        >>> follows = result.jacobian_of_q()
        >>> follows.shape
        (1, 6, 6)
        >>> bool(abs(arm.jacobian(result.q) @ follows - np.eye(6)).max() < 1e-9)
        True
        """

    def __len__(self) -> int:
        """Return the number of rows along the first dimension of the targets."""

    def __getitem__(self, key: object, /) -> IkResult:
        """Return the record of some of the targets, chosen as in a NumPy array of them."""

    def __iter__(self) -> Iterator[IkResult]:
        """Go through the rows along the first dimension of the targets."""

    def to_dict(self) -> dict[str, Any]:
        """Return the arrays by their names.

        Examples
        --------
        >>> arrays = ik.Robot.load("ur5").ik([0.4, 0.2, 0.3]).to_dict()
        >>> arrays["q"].shape, bool(arrays["success"])
        ((6,), True)
        """

    def to_arrow(self) -> Any:
        """Return a `pyarrow.Table`: one row a target (of branches: a branch).

        Raises
        ------
        MissingExtraError
            pyarrow is not installed.

        Examples
        --------
        >>> ik.Robot.load("tomato").ik([[0.2, 0.1, 0.1]]).to_arrow().num_rows
        1
        """

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame` of the same columns.

        Raises
        ------
        MissingExtraError
            pandas is not installed.

        Examples
        --------
        >>> len(ik.Robot.load("tomato").ik([[0.2, 0.1, 0.1]] * 3).to_pandas())
        3
        """

    def plot(self, arm: Any = None) -> Any:
        """Draw what became of the targets; needs the extra ``plots``.

        Parameters
        ----------
        arm : Robot, optional
            With the arm that was asked, its postures in space are drawn instead.

        Returns
        -------
        matplotlib.figure.Figure
            Targets by status, in words; position errors of those that were reached and of the
            others; steps taken. Or the arm: the last posture in full, the others pale.

        Raises
        ------
        ArgumentError
            `arm` is no Robot, or has another number of joints.
        MissingExtraError
            Matplotlib is not installed.

        Examples
        --------
        >>> picture = ik.Robot.load("tomato").ik([[0.2, 0.1, 0.1]]).plot()
        >>> len(picture.axes) > 0
        True
        """

    def __bool__(self) -> bool:
        """Return whether a single target was reached.

        Raises
        ------
        ValueError
            Of several targets, as for NumPy's arrays.
        """

def ik_result(
    q: NDArray[np.float64],
    status: NDArray[np.uint8],
    position_error: NDArray[np.float64],
    orientation_error: NDArray[np.float64],
    iterations: NDArray[np.uint32],
    restarts: NDArray[np.uint32],
    warnings: NDArray[np.uint8],
    clearance: NDArray[np.float64] | None = None,
    nearest_pair: NDArray[np.object_] | None = None,
    like: IkResult | None = None,
) -> IkResult:
    """Return the record of arrays that belong together, such as those of another record.

    With `like` it belongs to the same question, as some of its rows do.
    """

def branches(
    q: NDArray[np.float64],
    valid: NDArray[np.bool_],
    reached: NDArray[np.bool_],
    singular: NDArray[np.uint8],
    status: NDArray[np.uint8],
    warnings: NDArray[np.uint8],
    free_joint: NDArray[np.int8],
    value: NDArray[np.float64],
    branch: NDArray[np.uint32],
    orientation_error: NDArray[np.float64],
    position_error: NDArray[np.float64] | None = None,
) -> Branches:
    """Return the record of arrays that belong together, such as those of another record."""

@final
class Scene:
    """Objects in the base frame of an arm, ready for questions; holds no arm."""

    def __new__(
        cls,
        names: Sequence[str],
        removable: Sequence[bool] | None = None,
        *,
        spheres: ArrayLike | None = None,
        sphere_labels: ArrayLike | None = None,
        capsules: ArrayLike | None = None,
        capsule_labels: ArrayLike | None = None,
        boxes: ArrayLike | None = None,
        box_labels: ArrayLike | None = None,
        halfspaces: ArrayLike | None = None,
        halfspace_labels: ArrayLike | None = None,
        hulls: Sequence[ArrayLike] | None = None,
        hull_radii: ArrayLike | None = None,
        hull_labels: ArrayLike | None = None,
    ) -> Scene:
        """Make a scene of objects, each of any number of solids.

        All lengths in m, in the frame in which the arm's own base stands (that of targets).
        Labels say, solid by solid, which of `names` a solid belongs to.

        Parameters
        ----------
        names : sequence of str
            Names of the objects, no two alike, none empty. No names: an empty scene.
        removable : sequence of bool, optional
            Which objects may be taken out of the way. Default: none.
        spheres : ndarray, shape (n, 4), optional
            Rows x, y, z, radius. Clouds of points come in here, of a million rows as well.
        capsules : ndarray, shape (n, 7), optional
            Rows of the two ends of the core and the radius round it.
        boxes : ndarray, shape (n, 16), optional
            Rows of centre (3), half lengths (3), rotation row by row (9; its columns are the
            axes of the box) and the radius round the box.
        halfspaces : ndarray, shape (n, 4), optional
            Rows of an outward normal (3) and d: solid is where ``normal . x <= d``.
        hulls : sequence of ndarray, shape (k, 3), optional
            Points, of each the convex hull; points inside cost time alone.
        hull_radii : ndarray, shape (n,), optional
            Radius round each hull. Default: 0.
        sphere_labels, capsule_labels, box_labels, halfspace_labels, hull_labels : ndarray
            shape (n,), whole numbers from 0: as many as there are solids of that kind.

        Raises
        ------
        ArgumentError
            A wrong shape, a number that is not finite, a negative radius or half length, a
            rotation that is none, a normal of no length, a label without a name, a name
            twice. The message names the argument and the row.
        """

    @property
    def names(self) -> list[str]:
        """Names of the objects."""

    @property
    def removable(self) -> list[bool]:
        """Which objects may be taken out of the way."""

    def __len__(self) -> int:
        """Return the number of objects."""

@final
class Bodies:
    """Solids on the frames of an arm, and which pairs of them may hit each other."""

    def __new__(
        cls,
        chain: Chain,
        names: Sequence[str],
        frames: Sequence[int],
        kinds: Sequence[str],
        cores: Sequence[object],
        radii: ArrayLike,
        self_pairs: Sequence[tuple[int, int]] | None = None,
        attached: Sequence[bool] | None = None,
    ) -> Bodies:
        """Make the bodies of an arm.

        Parameters
        ----------
        chain : Chain
            The arm.
        names : sequence of n str
            Names of the bodies, no two alike, none empty.
        frames : sequence of n int
            The frame that each body stands still in: 0 is the base frame, k that of
            ``chain.link_names[k - 1]`` as `Chain.fk_links` gives it, so that the last one,
            ``len(chain.link_names)``, is the tool frame.
        kinds : sequence of n {"sphere", "capsule", "box", "convex", "cover"}
            What core each body has.
        cores : sequence of n
            In the body's frame, m: of a sphere its centre, shape (1, 3) or (3,); of a capsule
            its two ends, shape (2, 3); of a box the tuple (centre, half, rotation), shapes
            (3,), (3,), (3, 3) with the axes of the box as columns; of a convex body the
            points whose hull it is, shape (k, 3). A "cover" is a box that meets the scene (not
            other bodies) as spheres that cover it, 8**level of them: the tuple (centre, half,
            rotation, level, split), level 0 to 3, split "equal" or "near-cubic".
        radii : ndarray, shape (n,), m
            Radius round each core.
        self_pairs : sequence of (int, int), optional
            The pairs of bodies that may hit each other. Default: all but those that stand on
            one link, those on links that one joint joins, and those that structure makes hit:
            at most two joints apart and hitting in more than 25 % of 4,000 sampled postures,
            or in more than 95 % at any distance. Pairs that were never seen hitting stay.
        attached : sequence of n bool, optional
            Which bodies are tools or held objects, put on at run time. Default: none.

        Raises
        ------
        ArgumentError
            A wrong shape or number of entries, an unknown kind or frame, a number that is not
            finite, a negative radius or half length, a name twice, a pair that is none.
        """

    @property
    def names(self) -> list[str]:
        """Names of the bodies."""

    @property
    def frames(self) -> list[int]:
        """Frame of each body."""

    @property
    def attached(self) -> list[bool]:
        """Which bodies are tools or held objects."""

    @property
    def self_pairs(self) -> list[tuple[int, int]]:
        """Pairs of bodies that are asked whether they hit each other."""

    @property
    def excluded_pairs(self) -> list[tuple[int, int, str, float | None]]:
        """Pairs that are not asked: two bodies, why, and the share of postures that hit.

        Why is "same link", "adjacent", "structural" or, of given pairs, "not listed"; the
        share is None but for "structural".
        """

    def levers(self, q: ArrayLike, margin: ArrayLike) -> NDArray[np.float64]:
        """Return levers, shape (..., dof, bodies), m/rad or no unit.

        A joint that changes by no more than `margin`, shape (dof,), from the joint values,
        shape (..., dof), moves a core point of a body by no more than its lever times its change.
        """

    def __len__(self) -> int:
        """Return the number of bodies."""

@final
class Collider:
    """An arm with bodies in a scene: what hits what at given joint values."""

    def __new__(
        cls,
        bodies: Bodies,
        scene: Scene,
        exemptions: Sequence[tuple[int, int]] | None = None,
        touch: tuple[Sequence[tuple[int, int]], ArrayLike, float] | None = None,
    ) -> Collider:
        """Put bodies into a scene.

        What is given to `agrik_fast.Robot.ik` as its scene is an object that makes one of
        these for the arm, with a method ``collider(robot)``, or one of these itself.

        Bodies on the base frame are never asked about the scene, as they do not move in it.

        Parameters
        ----------
        bodies : Bodies
            The arm with its bodies.
        scene : Scene
            The objects.
        exemptions : sequence of (int, int), optional
            Pairs of a body and an object of the scene that do not mind each other, at any
            posture.
        touch : tuple (pairs, target, radius), optional
            More such pairs, which hold only while the tool point of the chain is no farther
            than `radius` (m) from `target`, shape (3,), m: the fruit that a gripper may touch
            is an obstacle like others on the way there.

        Raises
        ------
        ArgumentError
            A pair that names no body or no object; a target or radius that is not finite.
        """

    @property
    def bodies(self) -> Bodies:
        """The arm with its bodies."""

    @property
    def scene(self) -> Scene:
        """The objects."""

    def collides(
        self, q: ArrayLike, clear: float | None = None, threads: int | None = None
    ) -> NDArray[np.bool_]:
        """Whether postures hit the scene or themselves.

        Parameters
        ----------
        q : ndarray, shape (..., dof), rad or m
            Joint values, finite; limits are of no account.
        clear : float, default 0, m
            Distance to be kept from the scene: as near or nearer is a hit. Pairs of bodies
            hit at distance 0 whatever it is.
        threads : int, optional
            Number of threads, as for `Chain.ik`. Answers do not depend on it.

        Returns
        -------
        ndarray of bool, shape (...)
            True where a body is `clear` or less away from an object that it minds, or two
            bodies of a self pair touch.

        Raises
        ------
        ArgumentError
            A wrong shape, a joint value that is not finite, a negative `clear`.
        """

    def clearance(
        self,
        q: ArrayLike,
        cap: float | None = None,
        threads: int | None = None,
        own: bool = True,
    ) -> NDArray[np.float64]:
        """Distance of postures from the nearest collision, m.

        Parameters
        ----------
        q : ndarray, shape (..., dof), rad or m
            Joint values, finite.
        cap : float, optional, m
            Distances above it are it: the less it is, the quicker the answer. Default:
            none, and infinity where there is nothing to hit.
        threads : int, optional
            Number of threads.
        own : bool, default True
            The distances of self pairs count as well.

        Returns
        -------
        ndarray, shape (...), m
            Least distance; 0 or less exactly where `collides` (with `own`). The size of a
            depth has a meaning only for half-spaces and for cores that are points or
            segments.

        Raises
        ------
        ArgumentError
            As `collides`.
        """

    def shifted_clearance(
        self, q: ArrayLike, shifts: ArrayLike, threads: int | None = None
    ) -> NDArray[np.float64]:
        """Distance from the scene at joint values (n, dof), m.

        The bodies of each posture are shifted by vectors, shape (n, bodies, 3), m.
        """

    def distances(
        self, q: ArrayLike, cap: float | None = None, threads: int | None = None
    ) -> Distances:
        """Distance of each body, with the nearest object and the points; m.

        Parameters
        ----------
        q : ndarray, shape (..., dof), rad or m
            Joint values, finite.
        cap : float, optional, m
            What is farther away counts as not there. Default: none.
        threads : int, optional
            Number of threads.

        Returns
        -------
        Distances
            Body by body, and for the nearest self pair.

        Raises
        ------
        ArgumentError
            As `collides`.
        """

    def gradient(
        self,
        q: ArrayLike,
        cap: float | None = None,
        threads: int | None = None,
        own: bool = True,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Clearance and how it changes with the joint values.

        The derivative is that of the nearest pair, along the line between its points: where
        two pairs are equally near it is that of one of them, where cores meet it is 0, as it
        is where nothing is within `cap`.

        Parameters
        ----------
        q : ndarray, shape (..., dof), rad or m
            Joint values, finite.
        cap, threads, own : optional
            As for `clearance`.

        Returns
        -------
        clearance : ndarray, shape (...), m
            As `clearance` gives it.
        gradient : ndarray, shape (..., dof), m/rad or no unit
            Change of the clearance with each joint value.

        Raises
        ------
        ArgumentError
            As `collides`.
        """

@final
class Distances:
    """What `Collider.distances` returns; arrays have the leading shape of the joint values."""

    @property
    def distance(self) -> NDArray[np.float64]:
        """Distance of each body from its nearest object, shape (..., bodies), m.

        Infinite where there is none: within the cap, or that the body minds.
        """

    @property
    def object(self) -> NDArray[np.int64]:
        """Index of the nearest object of each body, shape (..., bodies); -1 for none."""

    @property
    def on_body(self) -> NDArray[np.float64]:
        """The body's point nearest to the object, shape (..., bodies, 3), m; 0 for none."""

    @property
    def on_object(self) -> NDArray[np.float64]:
        """The object's point nearest to the body, shape (..., bodies, 3), m; 0 for none."""

    @property
    def own_distance(self) -> NDArray[np.float64]:
        """Distance of the nearest self pair, shape (...), m; infinite for none."""

    @property
    def own_pair(self) -> NDArray[np.int64]:
        """The two bodies of the nearest self pair, shape (..., 2); -1 for none."""

    @property
    def own_points(self) -> NDArray[np.float64]:
        """Where they come nearest, shape (..., 2, 3), m; 0 for none."""

@final
class CsvRows:
    """Rows of a CSV file that are neither blank nor comments."""

    def __new__(cls, path: str | PathLike[str], limit: int) -> CsvRows:
        """Open a file and read its header; rows of more than `limit` bytes are refused."""

    @property
    def header(self) -> list[str]:
        """Names of the columns; none where the file holds no row."""

    def block(
        self, size: int, bytes: int, numeric: list[int], texts: list[int]
    ) -> tuple[NDArray[np.float64], list[list[str]], list[int]]:
        """Read up to `size` rows, fewer where they take more than `bytes` together.

        Parameters
        ----------
        size, bytes : int
            Rows and bytes at most.
        numeric : list of int
            Columns to be read as numbers.
        texts : list of int
            Columns to be read as texts.

        Returns
        -------
        numbers : ndarray, shape (n, k)
            The numbers.
        texts : list of list of str
            The texts, column by column.
        lines : list of int
            Line on which each row begins, from 1.

        Raises
        ------
        ValueError
            A field that is no number, a row of another length, bytes that are no text; names
            row, line and column.
        """

def csv_lines(columns: list[object]) -> bytes:
    """Return the lines of columns of one length: arrays of float64, int64, bool, or texts."""

@final
class StrawberryArm:
    """Closed forms of the strawberry arm; see `agrik_fast.arms.StrawberryArm`."""

    def __new__(
        cls,
        *,
        l1: float | None = None,
        l2: float | None = None,
        l3: float | None = None,
        d: ArrayLike | None = None,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
        friction: float | None = None,
        mass2: float | None = None,
        mass3: float | None = None,
        gravity: float | None = None,
    ) -> StrawberryArm:
        """Make an arm; what is not given is as in the paper (m, rad, N, kg)."""

    @property
    def parameters(self) -> dict[str, float | list[float]]:
        """Parameters by name."""

    @property
    def free_pose(self) -> tuple[float, float] | None:
        """Theta and beta of the free branch, rad, or None."""

    @property
    def reset_pose(self) -> NDArray[np.float64]:
        """Home and reset pose, shape (5,), m and rad."""

    @property
    def target_box(self) -> NDArray[np.float64]:
        """Bounds of the targets, shape (2, 3), m."""

    def solve(
        self,
        targets: ArrayLike,
        method: str,
        s10_share: float,
        theta_rule: str,
        theta_step: float,
    ) -> tuple[IkResult, NDArray[np.float64], NDArray[np.uint8], NDArray[np.float64]]:
        """Return the record, energies (J), places and gaps of targets, shape (..., 3), m."""

    def fk(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return tool points, shape (..., 3), m, of joint values, shape (..., 5)."""

    def energy(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return energy indices, J, of joint values, shape (..., 5)."""

    def s10_set(self, target: ArrayLike) -> tuple[tuple[float, float] | None, float]:
        """Return the set of s10 of a target, m, and by how much it is empty."""

    def theta_sets(self, target: ArrayLike, beta: float) -> dict[str, list[tuple[float, float]]]:
        """Return the sets of theta of a target at a beta, rad, by name."""

    def slopes(self, theta: float, beta: float, case: str) -> dict[str, float]:
        """Return derivatives along s10, by name."""

    def commands(self, q: ArrayLike, psi: float, h_extra: float) -> list[tuple[str, float]]:
        """Return the steps of remark 3 to a pose: (axis, target) pairs."""

    def suggest_base_shift(
        self, targets: ArrayLike, may_move: list[bool], within: float = ...
    ) -> NDArray[np.float64]:
        """Return the smallest platform translations but for `within`, m; NaN where none helps.

        Shape (..., 3).
        """

@final
class TomatoArm:
    """Closed form of the tomato arm; see `agrik_fast.arms.TomatoArm`."""

    def __new__(
        cls,
        l1: float,
        l2: float,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
    ) -> TomatoArm:
        """Make an arm from link lengths (m) and servo limits (rad)."""

    def solve(
        self, targets: ArrayLike, current: ArrayLike, branch: int | None, follow: bool
    ) -> tuple[IkResult, NDArray[np.uint8], NDArray[np.int8]]:
        """Return the record, outcomes and branches of targets, shape (..., 3), m."""

    def branches(
        self, targets: ArrayLike, pan: float
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.uint8]]:
        """Return all branches, which are valid, and outcomes of targets, shape (..., 3), m."""

    def transpose_bound(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return the fixed transpose step, 1/m^2, above which the iteration diverges."""

def ik_paced(
    chain: Chain,
    targets: ArrayLike,
    step: str,
    parameter: float,
    gain: float,
    step_length: float | None,
    q0: ArrayLike,
    position_tolerance: float,
    max_iterations: int,
) -> IkResult:
    """Solve a position task without restarts, a part of the error a step.

    Parameters
    ----------
    chain : Chain
        Three joints.
    targets : array_like, shape (..., 3), m
        Tool points.
    step : {"transpose", "pinv", "dls"}
        Step rule.
    parameter : float
        Its parameter: alpha (1/m^2; 0 for the automatic length), cutoff, damping (m).
    gain : float
        Share of the error a step is to remove, above 0, at most 1.
    step_length : float or None
        Instead of the gain: the longest part of the error, m.
    q0 : array_like, shape (3,) or (..., 3), rad
        Start.
    position_tolerance : float
        m.
    max_iterations : int
        Cap.

    Returns
    -------
    IkResult
        The record.
    """

def ik_record(
    q: ArrayLike,
    status: ArrayLike,
    position_error: ArrayLike,
    iterations: ArrayLike | None = None,
) -> IkResult:
    """Return the common record of answers that were found outside the core.

    Parameters
    ----------
    q : array_like, shape (..., n), rad or m
        Joint values.
    status : array_like, shape (...)
        Codes of `agrik_fast.Status`.
    position_error : array_like, shape (...), m
        Distances.
    iterations : array_like, shape (...), optional
        Steps taken; none if not given.

    Returns
    -------
    IkResult
        The record.
    """

@final
class Tuner:
    """A search for gains that reach most training goals in the fewest steps."""

    def __new__(
        cls,
        chain: Chain,
        solver: object,
        goals: ArrayLike,
        shape: str,
        method: str,
        population: int,
        sigma: float,
        seed: int,
        start: str,
        max_iterations: int,
        tolerance: float,
        orientation_tolerance: float = 1e-6,
        threads: int | None = None,
    ) -> Tuner:
        """Prepare a search.

        Parameters
        ----------
        chain : Chain
            The arm.
        solver : StateSpace, StaticGain or IkPid
            Gains to start from.
        goals : array_like, shape (n, 3), m, or (n, 4, 4)
            Training goals: tool points, or poses.
        shape : {"input", "diagonal", "full"}
            Free entries of a state space.
        method : {"pso", "cma"}
            Particle swarm or CMA-ES.
        population : int
            Gain sets a generation, >= 4.
        sigma : float
            Deviation of the first generation, > 0.
        seed : int
            Seed of the search.
        start : {"sampled", "zero", "middle"}
            Where attempts start.
        max_iterations : int
            Steps of an attempt.
        tolerance : float
            Distance that counts as reached, m.
        orientation_tolerance : float
            Angle that counts as reached, rad; for poses.
        threads : int, optional
            Number of threads.

        Raises
        ------
        ArgumentError
            A wrong value, or gains that do not fit the chain.
        """

    @property
    def dimension(self) -> int:
        """Number of parameters."""

    @property
    def evaluations(self) -> int:
        """Vectors judged so far."""

    @property
    def cost(self) -> float:
        """Cost of the best vector so far; infinite before the first generation."""

    @property
    def best(self) -> NDArray[np.float64]:
        """The best vector so far; the start before the first generation."""

    def advance(self) -> None:
        """Go on by one generation."""

    def score(self, vector: ArrayLike) -> tuple[float, int, float]:
        """Return cost, goals reached and mean steps of a vector on the training goals."""

    def gains(self, vector: ArrayLike) -> dict[str, Any]:
        """Return the gains of a vector, in the units of the solver it started from.

        Those of IK-PID are in rad per m.
        """

    def state(self) -> NDArray[np.float64]:
        """Return everything that changes while the search runs, as numbers."""

    def restore(self, state: ArrayLike) -> None:
        """Take up the search where `state` left it."""

def default_settings() -> dict[str, dict[str, object]]:
    """Return the default settings of each solver, by the solver's name.

    Returns
    -------
    dict of dict
        Field names and values as in the dataclasses of `agrik_fast.solvers`.
    """

def _panic() -> None:
    """Panic: for the test that a panic of the core is an `InternalError`."""

def check_solver(solver: object) -> None:
    """Refuse a solver whose fields are out of their ranges.

    Parameters
    ----------
    solver : str or object
        A name, or an object with the fields of that solver.

    Raises
    ------
    ArgumentError
        A field is out of its range; it is named without the class.
    """

def solver_names() -> list[str]:
    """Return the names of all solvers: step solvers, population solvers, the others."""

def limited_solver_names() -> list[str]:
    """Return the names of the solvers that take limits of each row."""

def statuses() -> dict[str, int]:
    """Return the codes of `agrik_fast.Status` by their names in lower case, in order."""

def set_num_threads(n: int | None) -> None:
    """Set the number of threads of batch calls in this process.

    Parameters
    ----------
    n : int or None
        At least 1; None goes back to ``AGRIK_NUM_THREADS`` or one per core.

    Raises
    ------
    ArgumentError
        `n` is below 1.

    Examples
    --------
    >>> ik.set_num_threads(1)
    >>> ik.get_num_threads()
    1
    >>> ik.set_num_threads(None)
    """

def get_num_threads() -> int:
    """Return the number of threads that a batch call uses by default.

    Examples
    --------
    >>> ik.get_num_threads() >= 1
    True
    """

def simd_level() -> str:
    """Return the instruction set that the batch loops use in this process.

    Returns
    -------
    str
        "scalar", "neon", "avx2" or "avx512": the highest that the machine has, or the one
        that the environment variable ``AGRIK_SIMD`` names. A name that the machine does not
        have is a `RuntimeWarning` when the compiled module is first used.

    Examples
    --------
    >>> ik.simd_level() in ("scalar", "neon", "avx2", "avx512")
    True
    """

@final
class HarvestStation:
    """An arm on a slide, with bodies, in a crop; see `agrik_fast.harvest.plan`."""

    def __new__(
        cls,
        bodies: Bodies,
        scene: Scene,
        statics: Sequence[int],
        static_skip: Sequence[tuple[int, int]],
        touching: Sequence[int],
        level: int | None = None,
        split: str | None = None,
        moved: ArrayLike | None = None,
    ) -> HarvestStation:
        """Put an arm with bodies into a crop.

        Parameters
        ----------
        bodies : Bodies
            The arm with its bodies.
        scene : Scene
            The crop.
        statics : sequence of int
            Objects that are never touched but may be near.
        static_skip : sequence of (int, int)
            Pairs of a body and one of them that do not mind each other.
        touching : sequence of int
            Bodies that may touch a target.
        level : int, optional
            Boxes count as 8^level spheres; without it as they are.
        split : {"equal", "near-cubic"}, optional
            How they are cut into cells.
        moved : array_like, shape (3,), m, optional
            How far the arm and `statics` are from where they stand.

        Raises
        ------
        ArgumentError
            The arm is not six joints with a spherical wrist on a slide; an index out of range.
        """

    def plan(
        self,
        points: ArrayLike,
        objects: Sequence[Sequence[int]],
        names: Sequence[str],
        settings: Mapping[str, Any] | None = None,
        scan_all: bool = False,
        threads: int | None = None,
    ) -> dict[str, Any]:
        """Decide for targets, shape (n, 3), m; with `scan_all` by a scan of everything."""

    def plan_paths(
        self,
        points: ArrayLike,
        objects: Sequence[Sequence[int]],
        names: Sequence[str],
        start: ArrayLike,
        motion: dict[str, Any],
        touch_radius: float,
        settings: dict[str, Any] | None = None,
        blockers: bool = True,
        threads: int | None = None,
    ) -> dict[str, Any]:
        """Decide for targets, and plan the ways from `start` into their postures.

        Besides the columns of `plan` the record has ``paths`` (as `motion_plan` returns them),
        ``goals`` (all postures that were goals) and ``blockers_path``: None, or indices, what is
        known of their number (codes as of `motion.Fewest`) and how many it is at least.
        """

    def blockers(
        self,
        points: ArrayLike,
        objects: Sequence[Sequence[int]],
        names: Sequence[str],
        settings: Mapping[str, Any] | None = None,
        threads: int | None = None,
    ) -> list[tuple[list[int], bool, dict[str, Any]] | None]:
        """Name the fewest removable objects in the way of each target."""

    def inside(self, points: ArrayLike, objects: Sequence[Sequence[int]]) -> list[int]:
        """Return the object in which each point lies, if none of its own; -1 for none."""

    def table(
        self,
        point: ArrayLike,
        objects: Sequence[int],
        psi: float,
        tilt: float = 0.0,
        shift: float = 0.0,
        settings: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        """All postures of one approach to a target, as rows of a table."""

    def approaches(
        self,
        point: ArrayLike,
        objects: Sequence[int],
        settings: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        """Scan approach angles: psi, open, rank, and the distances hard and soft, m."""

@final
class HarvestProgramme:
    """The non-linear programme of one target; see `agrik_fast.harvest.Programme`."""

    def __new__(
        cls,
        bodies: Bodies,
        scene: Scene,
        statics: Sequence[int],
        static_skip: Sequence[tuple[int, int]],
        touching: Sequence[int],
        point: ArrayLike,
        objects: Sequence[int],
        weights: ArrayLike,
        level: int | None = None,
        split: str | None = None,
    ) -> HarvestProgramme:
        """Put an arm with bodies into a crop, with a target.

        Parameters
        ----------
        bodies, scene, statics, static_skip, touching, level, split
            As for `HarvestStation`.
        point : array_like, shape (3,), m
            The grip point.
        objects : sequence of int
            Objects of the target.
        weights : array_like, shape (4,)
            Of position (1/m), orientation and nearness, and the distance that is enough, m.

        Raises
        ------
        ArgumentError
            A weight out of its range, or all of them zero; an index out of range.
        """

    def terms(self, q: ArrayLike) -> dict[str, Any]:
        """Return the terms of the cost at joint values, shape (..., dof)."""

    def search(
        self,
        algorithm: str,
        seeds: Sequence[int],
        options: Mapping[str, Any] | None = None,
        threads: int | None = None,
    ) -> dict[str, Any]:
        """Search from seeds by "ga" or "de"."""

def harvest_words() -> tuple[list[str], list[str]]:
    """Return the names of the statuses and of the stages of a decision, at their codes."""

def collision_near(
    collider: Collider,
    q: ArrayLike,
    reach: ArrayLike,
    within: ArrayLike,
    own: ArrayLike,
    threads: int | None = None,
) -> dict[str, Any]:
    """List all objects and pairs of bodies that are near at joint values, shape (n, dof).

    Objects no farther from a body than `within`, shape (n, bodies), and pairs of bodies nearer
    than `own`, shape (n,), m. Columns of one entry each: ``row``, ``body``, ``other`` (index of
    the object; -1 less the index of the other body of a pair), ``distance`` (m), ``motion`` (by
    how much they come nearer to each other at most while joint values stay within `reach`,
    shape (n, dof), m), ``on_body`` and ``normal`` (shape (k, 3), m, from the other to the
    body), ``rates`` (how the distance changes with each joint value, shape (k, dof)).
    """

def collision_shifted_own(
    collider: Collider, q: ArrayLike, shifts: ArrayLike, threads: int | None = None
) -> NDArray[np.float64]:
    """Distance of the nearest pair of bodies at joint values (n, dof), m.

    The bodies of each posture are shifted by vectors, shape (n, bodies, 3), m.
    """

def motion_blockers(
    collider: Collider, start: ArrayLike, goals: ArrayLike, settings: dict[str, Any]
) -> dict[str, Any] | None:
    """Find the fewest removable objects without which there is a path to one of some goals.

    See `agrik_fast.motion.blockers`; ``objects`` are indices, ``path`` is as `motion_plan`
    returns it. None where no path is found without all of them.
    """

def motion_check(
    collider: Collider,
    path: ArrayLike,
    to: ArrayLike | None = None,
    settings: dict[str, Any] | None = None,
    threads: int | None = None,
) -> dict[str, Any]:
    """Say what is known of the straight ways between the rows of a path; see `motion.check`.

    With `to` of those from the rows of `path` to its rows, one each.
    """

def motion_corners(
    collider: Collider,
    start: ArrayLike,
    corner: ArrayLike,
    end: ArrayLike,
    settings: dict[str, Any],
    threads: int | None = None,
) -> NDArray[np.bool_]:
    """Say of triangles of postures, whose vertices are rows of three arrays, which are free."""

def motion_plan(
    collider: Collider, start: ArrayLike, goals: ArrayLike, settings: dict[str, Any]
) -> dict[str, Any]:
    """Plan from a posture to one of some goals, shape (m, dof), the best first.

    See `agrik_fast.motion.plan`.
    """

def motion_words() -> tuple[list[str], list[str], list[str]]:
    """Return the names of outcomes, statuses of plans and ways to find one, at their codes."""
