"""The compiled core: chains, kinematics and solvers.

Users go through `agrik_fast.Robot`, which hands its arguments on; this module checks them
and raises the classes of `agrik_fast.errors`. Tasks and solvers are read by their names and
fields, so that it knows none of their classes.
"""

from typing import Any, TypedDict, final, type_check_only

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Branches",
    "Chain",
    "IkResult",
    "StrawberryArm",
    "TargetSolver",
    "TomatoArm",
    "Tuner",
    "__version__",
    "_panic",
    "check_solver",
    "default_settings",
    "get_num_threads",
    "ik_paced",
    "ik_record",
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
    def from_urdf(text: str, base_link: str | None = None, tip_link: str | None = None) -> Chain:
        """Build a chain from the text of a URDF.

        Parameters
        ----------
        text : str
            XML text.
        base_link, tip_link : str, optional
            First and last link; default: the only root and the only leaf.

        Returns
        -------
        Chain
            The chain from base to tip.

        Raises
        ------
        UrdfError
            No URDF, no single serial chain, or an unknown link.
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

    @property
    def lower(self) -> NDArray[np.float64]:
        """Smallest values, shape (dof,), rad or m; -inf for continuous joints."""

    @property
    def upper(self) -> NDArray[np.float64]:
        """Largest values, shape (dof,), rad or m; inf for continuous joints."""

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
        position_tolerance: float | None = None,
        orientation_tolerance: float | None = None,
        first_index: int | None = None,
    ) -> IkResult:
        """Solve a batch of targets; see `agrik_fast.Robot.ik`."""

    def solver(
        self,
        task: object = None,
        solver: object = None,
        seed: int | None = None,
        tool: ArrayLike | None = None,
        position_tolerance: float | None = None,
        orientation_tolerance: float | None = None,
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
        position_tolerance: float | None = None,
        orientation_tolerance: float | None = None,
    ) -> tuple[IkResult, NDArray[np.bool_]]:
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
        position_tolerance: float | None = None,
        orientation_tolerance: float | None = None,
    ) -> Branches:
        """All branches of a batch of poses; see `agrik_fast.Robot.ik_all`."""

    def arm_angle(self, q: ArrayLike) -> NDArray[np.float64]:
        """Arm angles, shape (...), rad, of joint values, shape (..., dof), of an S-R-S arm."""

    def arm_angle_intervals(
        self, target: ArrayLike, tool: ArrayLike | None = None
    ) -> list[list[tuple[float, float]]]:
        """Arm angles that the limits allow for one pose: for each branch (lower, upper), rad."""

    @property
    def closed_form(self) -> tuple[str | None, str | None]:
        """Family of the chain's closed form, or why it has none: (name, reason)."""

@final
class Branches:
    """Every branch of the targets of one `Robot.ik_all` call."""

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

@final
class TargetSolver:
    """A solver for one target at a time, from `Robot.solver`.

    Each call overwrites the values of the one before and, but for the feedback laws with
    matrices, allocates no memory after the first.
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
            from the seed.

        Returns
        -------
        bool
            Whether the target was reached: by a final FK check, within the limits.

        Raises
        ------
        ArgumentError
            A wrong shape or type; a transform that is not rigid.
        """

    @property
    def q(self) -> NDArray[np.float64]:
        """Joint values, shape (n,), rad or m: one array, overwritten by each call."""

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

@final
class IkResult:
    """Answers of one `Robot.ik` call; arrays have the targets' leading shape."""

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
        self, targets: ArrayLike, may_move: list[bool], within: float = 1e-8
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
    """

def get_num_threads() -> int:
    """Return the number of threads that a batch call uses by default."""

def simd_level() -> str:
    """Return the instruction set that the batch loops use in this process.

    Returns
    -------
    str
        "scalar", "neon", "avx2" or "avx512": the highest that the machine has, or the one
        that the environment variable ``AGRIK_SIMD`` names. A name that the machine does not
        have is a `RuntimeWarning` when the compiled module is first used.
    """
