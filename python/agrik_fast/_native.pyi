"""The compiled core: chains, kinematics and solvers.

Users go through `agrik_fast.Robot`, which hands its arguments on; this module checks them
and raises the classes of `agrik_fast.errors`.
"""

from typing import TypedDict, final, type_check_only

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .solvers import Solver
from .tasks import Task

__all__ = [
    "Branches",
    "Chain",
    "IkResult",
    "__version__",
    "default_settings",
    "get_num_threads",
    "set_num_threads",
    "simd_level",
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

    def with_name(self, name: str) -> Chain:
        """Return the chain under another name."""

    def fk(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return tool poses, shape (..., 4, 4), of joint values, shape (..., dof)."""

    def fk_links(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return link poses, shape (..., links, 4, 4), of joint values, shape (..., dof)."""

    def jacobian(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return geometric Jacobians, shape (..., 6, dof), linear rows first."""

    def ik(
        self,
        targets: ArrayLike,
        task: Task | str | None = None,
        solver: Solver | str | None = None,
        q0: ArrayLike | None = None,
        seed: int | None = None,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        position_tolerance: float | None = None,
        orientation_tolerance: float | None = None,
        first_index: int | None = None,
    ) -> IkResult:
        """Solve a batch of targets; see `agrik_fast.Robot.ik`."""

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

def default_settings() -> dict[str, dict[str, float]]:
    """Return the default settings of each solver, by the solver's name.

    Returns
    -------
    dict of dict
        Field names and values as in the dataclasses of `agrik_fast.solvers`.
    """

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
    """Return the instruction set the batch loops were dispatched to on this machine."""
