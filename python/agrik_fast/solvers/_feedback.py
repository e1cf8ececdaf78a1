"""Feedback laws: step solvers that need no Jacobian."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import ClassVar, Self, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from .._checks import Matrix, matrix, real_number, truth_value, word
from ..errors import ArgumentError
from ._loop import FeedbackLoop

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

_DEGREE = math.pi / 180


def _set(instance: object, name: str, value: object) -> None:
    object.__setattr__(instance, name, value)


def _check_meaning(solver: StateSpace | StaticGain | Broyden | IkPid) -> None:
    """Check the units that gains are in and the robot that they are for."""
    kind = type(solver).__name__
    real_number(f"{kind}.length_unit_m", solver.length_unit_m, 0, open_low=True, unit="m")
    real_number(f"{kind}.angle_unit_rad", solver.angle_unit_rad, 0, open_low=True, unit="rad")
    robot: object = solver.robot
    if robot is not None and not isinstance(robot, str):
        raise ArgumentError(f"{kind}.robot", repr(robot), "a robot's name or None")


def _check_axes(solver: StateSpace | StaticGain | Broyden) -> None:
    kind = type(solver).__name__
    frame = matrix(f"{kind}.frame", solver.frame)
    turned = np.array(frame)
    if turned.shape != (3, 3) or not np.allclose(turned @ turned.T, np.eye(3), atol=1e-9):
        raise ArgumentError(f"{kind}.frame", str(turned.tolist()), "a rotation matrix (3, 3)")
    _set(solver, "frame", frame)
    if solver.rotation_length_m is not None:
        real_number(
            f"{kind}.rotation_length_m", solver.rotation_length_m, 0, open_low=True, unit="m"
        )


def _shape(rows: Matrix) -> tuple[int, int]:
    return len(rows), len(rows[0])


class _FromFile:
    """Solvers whose gains a file can hold."""

    __slots__ = ()

    @classmethod
    def load(cls, source: str | PathLike[str], *, as_tuned: bool | None = None) -> Self:
        """Return the solver of a gain file, or of a bundled set by its name.

        Short for ``solvers.load_gains(source, kind, as_tuned=as_tuned)`` with this class as
        the kind.

        Examples
        --------
        >>> ik.solvers.StateSpace.load("hydrolek_k15_cma", as_tuned=True).max_restarts
        0
        """
        from . import load_gains

        return load_gains(source, cls, as_tuned=as_tuned)


@dataclass(frozen=True, slots=True, kw_only=True)
class CyclicCoordinateDescent(FeedbackLoop):
    """One joint after the other to its best value, tip first; named "ccd".

    Every joint in turn is moved to where it brings the tool point nearest to the target,
    in closed form and inside its limits. For positions only.

    Parameters
    ----------
    start : {"sampled", "zero", "middle"}
    max_iterations : int, default 500
    max_restarts : int, default 20
        The loop's, see `FeedbackLoop`.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    References
    ----------
    Olsen and Petersen, "Inverse kinematics by numerical and analytical cyclic coordinate
    descent", Robotica 29(4), 2011.

    Examples
    --------
    >>> arm = ik.Robot.load("hydrolek")
    >>> point = arm.fk(np.full(6, 0.1))[:3, 3]
    >>> bool(arm.ik(point, solver=ik.solvers.CyclicCoordinateDescent()).success)
    True
    """

    name: ClassVar[str] = "ccd"
    max_iterations: int = 500
    max_restarts: int = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class IkPid(_FromFile, FeedbackLoop):
    """One joint after the other by a PID law of the error's length; named "ik-pid".

    Each joint in turn is tried on either side of where it is, at the distance
    ``kp |e| + ki sum |e| + kd (|e| - |e before|)``; the best of the three places wins.
    Burrell, Montazeri, Monk and Taylor, Algorithm I, as corrected: the test for
    convergence follows every joint.

    Parameters
    ----------
    kp, ki, kd : float
        Gains, in units of angle per unit of length; default 0.012, 0 and 0.08, in degrees
        per mm. Those are the published ones but for ki, published as 1e-7, which keeps the
        error from falling below some hundredths of a millimetre; all three are the bundled
        set "hydrolek_pid_published_tuned".
    length_unit_m : float, default 0.001
        The gains' unit of length, m.
    angle_unit_rad : float, default pi/180
        The gains' unit of angle, rad. Prismatic joints move the same number of metres.
    order : {"tip-first", "base-first"}
        Which joint of a sweep moves first; default "tip-first", as published.
    literal : bool, default False
        As printed: the second try starts from the first one after saturation.
    incremental : bool, default True
        Tries turn the tool about one axis instead of a full pass of forward kinematics;
        the same answers, sooner.
    start : {"sampled", "zero", "middle"}
    max_iterations : int, default 1000
    max_restarts : int, default 20
        The loop's, see `FeedbackLoop`.
    robot : str, optional
        Name of the robot the gains were tuned for; others are refused.

    Raises
    ------
    ArgumentError
        A field is out of its range.

    Examples
    --------
    >>> ik.solvers.IkPid(kp=0.02, kd=0.1).order
    'tip-first'
    """

    name: ClassVar[str] = "ik-pid"
    kp: float = 0.012
    ki: float = 0.0
    kd: float = 0.08
    length_unit_m: float = 1e-3
    angle_unit_rad: float = _DEGREE
    order: str = "tip-first"
    literal: bool = False
    incremental: bool = True
    max_iterations: int = 1000
    max_restarts: int = 20
    robot: str | None = None

    def __post_init__(self) -> None:
        for name in ("kp", "ki", "kd"):
            real_number(f"IkPid.{name}", getattr(self, name), -math.inf)
        _check_meaning(self)
        word("order", self.order, ("tip-first", "base-first"))
        truth_value("IkPid.literal", self.literal)
        truth_value("IkPid.incremental", self.incremental)
        FeedbackLoop.__post_init__(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class StateSpace(_FromFile, FeedbackLoop):
    """A linear discrete-time system from error to joint values; named "state-space".

    ``dq = C x``, then ``x <- A x + B e``, from ``x = 0``; joint values saturate at their
    limits. Burrell, Montazeri, Monk and Taylor, equations (14), (15), Algorithm II.
    Without matrices: a quarter of the pseudo-inverse of the posture in the middle of the
    limits, or of one about it where that is singular, as B, with A zero and C the identity.

    Parameters
    ----------
    A, B, C : array_like, optional
        Shapes (states, states), (states, 3 or 6) and (n, states). B has 3 columns for
        position tasks and 6 for poses and base-frame masks; x has no unit of its own.
    length_unit_m : float, default 1
        Unit of the position error that B was made for, m; also what prismatic joints are
        moved by.
    angle_unit_rad : float, default 1
        Unit of the change of revolute joints that C gives, rad.
    frame : array_like, shape (3, 3), default identity
        Rotation that leads directions of the robot's first link to the axes of the error.
    rotation_length_m : float, optional
        Length that one radian of orientation error counts as, m; default 0.3 times the
        reach.
    start : {"sampled", "zero", "middle"}
    max_iterations : int, default 400
    max_restarts : int, default 20
        The loop's, see `FeedbackLoop`.
    robot : str, optional
        Name of the robot the gains were tuned for; others are refused.

    Warns
    -----
    UserWarning
        The spectral radius of A is 1 or more: x can grow without bound.

    Raises
    ------
    ArgumentError
        Matrices whose sizes do not fit, or a field out of its range.

    Examples
    --------
    >>> ik.solvers.StateSpace.load("hydrolek_full90_cma", as_tuned=True).start
    'zero'
    """

    name: ClassVar[str] = "state-space"
    A: Matrix | None = None
    B: Matrix | None = None
    C: Matrix | None = None
    length_unit_m: float = 1.0
    angle_unit_rad: float = 1.0
    frame: Matrix = IDENTITY
    rotation_length_m: float | None = None
    max_iterations: int = 400
    max_restarts: int = 20
    robot: str | None = None

    def __post_init__(self) -> None:
        given = [self.A is not None, self.B is not None, self.C is not None]
        if any(given) and not all(given):
            raise ArgumentError("StateSpace.A, B, C", "some of them", "all three or none")
        if self.A is not None and self.B is not None and self.C is not None:
            for name in "ABC":
                _set(self, name, matrix(f"StateSpace.{name}", getattr(self, name)))
            states = len(self.A)
            if _shape(self.A) != (states, states):
                raise ArgumentError("StateSpace.A", f"shape {_shape(self.A)}", "a square matrix")
            rows, columns = _shape(self.B)
            if rows != states or columns not in (3, 6):
                expected = f"shape ({states}, 3) or ({states}, 6)"
                raise ArgumentError("StateSpace.B", f"shape {_shape(self.B)}", expected)
            if _shape(self.C)[1] != states:
                expected = f"shape (n, {states})"
                raise ArgumentError("StateSpace.C", f"shape {_shape(self.C)}", expected)
            radius = self.spectral_radius
            if radius >= 1:
                warnings.warn(
                    f"StateSpace.A: spectral radius {radius:.3f}, not below 1: the state can "
                    "grow without bound",
                    stacklevel=3,
                )
        _check_meaning(self)
        _check_axes(self)
        FeedbackLoop.__post_init__(self)

    @property
    def spectral_radius(self) -> float:
        """Largest absolute eigenvalue of A; 0 without matrices."""
        return 0.0 if self.A is None else float(abs(np.linalg.eigvals(np.array(self.A))).max())

    def static_gain(self) -> NDArray[np.float64]:
        """Return ``C (I - A)^-1 B``, what the system settles to, in its own units.

        Examples
        --------
        >>> solver = ik.solvers.StateSpace.load("hydrolek_full90_cma", as_tuned=True)
        >>> solver.static_gain().shape
        (6, 3)
        """
        if self.A is None or self.B is None or self.C is None:
            raise ArgumentError("StateSpace", "no matrices", "A, B and C")
        a, b, c = np.array(self.A), np.array(self.B), np.array(self.C)
        return cast("NDArray[np.float64]", c @ np.linalg.solve(np.eye(len(a)) - a, b))


@dataclass(frozen=True, slots=True, kw_only=True)
class StaticGain(_FromFile, FeedbackLoop):
    """A constant matrix from error to joint values; named "static-gain".

    ``dq = K e``, saturated at the limits. What a tuned state space does, with fewer
    numbers. Without a matrix: half the pseudo-inverse of the posture in the middle of
    the limits, or of one about it where that is singular.

    Parameters
    ----------
    K : array_like, shape (n, 3) or (n, 6), optional
        The matrix.
    length_unit_m : float, default 1
        Unit of the position error, m; also what prismatic joints are moved by.
    angle_unit_rad : float, default 1
        Unit of the change of revolute joints, rad.
    frame : array_like, shape (3, 3), default identity
        Rotation that leads directions of the robot's first link to the axes of the error.
    rotation_length_m : float, optional
        Length that one radian of orientation error counts as, m; default 0.3 times the
        reach.
    start : {"sampled", "zero", "middle"}
    max_iterations : int, default 400
    max_restarts : int, default 20
        The loop's, see `FeedbackLoop`.
    robot : str, optional
        Name of the robot the gains were tuned for; others are refused.

    Raises
    ------
    ArgumentError
        A matrix of the wrong size, or a field out of its range.

    Examples
    --------
    >>> solver = ik.solvers.StaticGain(K=np.full((6, 3), 0.1))
    >>> np.shape(solver.K)
    (6, 3)
    """

    name: ClassVar[str] = "static-gain"
    K: Matrix | None = None
    length_unit_m: float = 1.0
    angle_unit_rad: float = 1.0
    frame: Matrix = IDENTITY
    rotation_length_m: float | None = None
    max_iterations: int = 400
    max_restarts: int = 20
    robot: str | None = None

    def __post_init__(self) -> None:
        _check_gain(self)
        _check_meaning(self)
        _check_axes(self)
        FeedbackLoop.__post_init__(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Broyden(FeedbackLoop):
    """A matrix that learns from every step what it did; named "broyden".

    ``dq = K e`` as with `StaticGain`, then ``K <- K + (dq - K de) de^T / |de|^2``: Broyden's
    second update of an inverse Jacobian. No Jacobian is ever computed. After `patience`
    steps without improvement the first matrix is taken again.

    Parameters
    ----------
    K : array_like, shape (n, 3) or (n, 6), optional
        The first matrix; default half the pseudo-inverse of the posture in the middle of
        the limits, or of one about it where that is singular.
    patience : int, default 8
        Steps without improvement before K is forgotten; 1 to 2**32 - 1.
    length_unit_m : float, default 1
        Unit of the position error, m; also what prismatic joints are moved by.
    angle_unit_rad : float, default 1
        Unit of the change of revolute joints, rad.
    frame : array_like, shape (3, 3), default identity
        Rotation that leads directions of the robot's first link to the axes of the error.
    rotation_length_m : float, optional
        Length that one radian of orientation error counts as, m; default 0.3 times the
        reach.
    start : {"sampled", "zero", "middle"}
    max_iterations : int, default 100
    max_restarts : int, default 100
        The loop's, see `FeedbackLoop`.
    robot : str, optional
        Name of the robot the gains were tuned for; others are refused.

    Raises
    ------
    ArgumentError
        A matrix of the wrong size, or a field out of its range.

    References
    ----------
    Broyden, "A class of methods for solving nonlinear simultaneous equations",
    Mathematics of Computation 19(92), 1965.

    Examples
    --------
    >>> arm = ik.Robot.load("hydrolek")
    >>> point = arm.fk(np.full(6, 0.1))[:3, 3]
    >>> bool(arm.ik(point, solver=ik.solvers.Broyden()).success)
    True
    """

    name: ClassVar[str] = "broyden"
    K: Matrix | None = None
    patience: int = 8
    length_unit_m: float = 1.0
    angle_unit_rad: float = 1.0
    frame: Matrix = IDENTITY
    rotation_length_m: float | None = None
    max_iterations: int = 100
    max_restarts: int = 100
    robot: str | None = None

    def __post_init__(self) -> None:
        _check_gain(self)
        _check_meaning(self)
        _check_axes(self)
        FeedbackLoop.__post_init__(self)

    @classmethod
    def from_gain(cls, gain: StaticGain | StateSpace, **fields: object) -> Broyden:
        """Return Broyden's method that starts from another solver's (settled) matrix.

        Parameters
        ----------
        gain : StaticGain or StateSpace
            Where K, the units, the frame, the start and the robot are taken from.
        **fields
            Other fields of the new solver.

        Examples
        --------
        >>> gain = ik.solvers.StaticGain(K=np.full((6, 3), 0.1))
        >>> ik.solvers.Broyden.from_gain(gain, patience=4).patience
        4
        """
        settled: object = gain.K if isinstance(gain, StaticGain) else gain.static_gain()
        given: dict[str, object] = {
            "K": settled,
            "length_unit_m": gain.length_unit_m,
            "angle_unit_rad": gain.angle_unit_rad,
            "frame": gain.frame,
            "rotation_length_m": gain.rotation_length_m,
            "start": gain.start,
            "robot": gain.robot,
        }
        return cls(**(given | fields))  # type: ignore[arg-type]


def _check_gain(solver: StaticGain | Broyden) -> None:
    if solver.K is None:
        return
    name = f"{type(solver).__name__}.K"
    rows = matrix(name, cast("Sequence[Sequence[float]]", solver.K))
    if _shape(rows)[1] not in (3, 6):
        raise ArgumentError(name, f"shape {_shape(rows)}", "shape (n, 3) or (n, 6)")
    _set(solver, "K", rows)


Feedback: TypeAlias = CyclicCoordinateDescent | IkPid | StateSpace | StaticGain | Broyden
"""Any feedback solver."""
