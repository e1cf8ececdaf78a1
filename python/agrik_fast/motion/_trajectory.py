"""A motion that others can play: joint values, velocities and accelerations by time."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, float_array, real_number
from .._tables import Postures
from ..errors import ArgumentError
from . import _trajectory_files
from ._points import Points

__all__ = ["Trajectory"]

# Points that a trajectory may be sampled at.
_MOST = 10_000_000
# A last interval of a fixed rate shorter than this share of the others is none.
_WHOLE = 1e-6


class Trajectory(Postures):
    """Joint values by time, from rest to rest; `time_law` makes it.

    The motion itself is continuous: `at` evaluates it at any time. What files and controllers
    get are its points, at a fixed rate or one at each change of the jerk (`sampled`).

    Examples
    --------
    >>> import agrik_fast as ik
    >>> from agrik_fast import motion
    >>> arm = ik.Robot.load("ur5")
    >>> q = arm.home
    >>> trajectory = motion.time_law(arm, [q, q + 0.2, q])
    >>> trajectory.positions.shape == (len(trajectory), 6)
    True
    >>> trajectory.velocities[-1].any()
    np.False_
    """

    __slots__ = ("_motion", "_names", "_points", "_rate", "_recipe", "_types")

    def __init__(
        self,
        recipe: Mapping[str, Any],
        joint_names: tuple[str, ...],
        joint_types: tuple[str, ...],
        rate: float | None,
        motion: _native.Motion | None = None,
    ) -> None:
        self._recipe = dict(recipe)
        self._motion = _native.Motion(**self._recipe) if motion is None else motion
        self._names = joint_names
        self._types = joint_types
        self._rate = rate
        times = self._motion.times if rate is None else _grid(self._motion.duration, rate)
        q, v, a, j = self._motion.at(times)
        self._points: tuple[FloatArray, ...] = (times, q, v, a, j)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the columns."""
        return self._names

    @property
    def joint_types(self) -> tuple[str, ...]:
        """Types of the joints: "revolute", "continuous" or "prismatic"."""
        return self._types

    @property
    def duration(self) -> float:
        """Duration, s."""
        return self._motion.duration

    @property
    def rate(self) -> float | None:
        """Points a second; None for one point at each change of the jerk."""
        return self._rate

    @property
    def times(self) -> FloatArray:
        """When the points are passed, shape (n,), s; strictly increasing from 0."""
        return self._points[0]

    @property
    def positions(self) -> FloatArray:
        """Joint values at the points, shape (n, dof), rad or m."""
        return self._points[1]

    @property
    def velocities(self) -> FloatArray:
        """Joint velocities at the points, shape (n, dof), rad/s or m/s; 0 at both ends."""
        return self._points[2]

    @property
    def accelerations(self) -> FloatArray:
        """Joint accelerations at the points, shape (n, dof), rad/s^2 or m/s^2."""
        return self._points[3]

    @property
    def jerks(self) -> FloatArray:
        """Joint jerks just behind the points, shape (n, dof), rad/s^3 or m/s^3."""
        return self._points[4]

    @property
    def deviation(self) -> float:
        """How far rounded corners leave their waypoints at most, in a joint value, rad or m."""
        return self._motion.deviation

    @property
    def acceleration_limits(self) -> FloatArray:
        """Limits of the joints' acceleration that hold, shape (dof,), rad/s^2 or m/s^2."""
        limits: FloatArray = self._recipe["limits"][1].copy()
        return limits

    @property
    def phase_times(self) -> FloatArray:
        """When the jerk along the way changes, shape (n,), s: begin and end among them."""
        return self._motion.times

    def at(self, times: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Evaluate the motion.

        Parameters
        ----------
        times : array_like, shape (...), s
            Any times; before 0 and behind the end the arm rests.

        Returns
        -------
        positions, velocities, accelerations : ndarray, shape (..., dof)
            Rad or m, rad/s or m/s, rad/s^2 or m/s^2.

        Raises
        ------
        ArgumentError
            Times that are no finite numbers.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> from agrik_fast import motion
        >>> arm = ik.Robot.load("ur5")
        >>> trajectory = motion.time_law(arm, [arm.home, arm.home + 0.5])
        >>> q, v, a = trajectory.at(trajectory.duration / 2)
        >>> bool(abs(q - 0.25).max() < 1e-12)
        True
        """
        asked = float_array("times", times)
        if not np.isfinite(asked).all():
            raise ArgumentError("times", "NaN or infinity", "finite numbers")
        found = self._motion.at(np.ascontiguousarray(asked.ravel()))
        q, v, a = (block.reshape(*asked.shape, len(self._names)) for block in found[:3])
        return q, v, a

    def sampled(self, rate: float | None) -> Trajectory:
        """Return the same motion with other points.

        Parameters
        ----------
        rate : float or None, 1/s
            Points a second, the last point at the very end; None for one point at each
            change of the jerk.

        Returns
        -------
        Trajectory
            The same motion.

        Raises
        ------
        ArgumentError
            A rate that is no number above 0, or gives more than 10 million points.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> from agrik_fast import motion
        >>> arm = ik.Robot.load("ur5")
        >>> trajectory = motion.time_law(arm, [arm.home, arm.home + 0.5])
        >>> len(trajectory.sampled(None))
        7
        """
        return Trajectory(self._recipe, self._names, self._types, checked_rate(rate), self._motion)

    def save(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """Write the points to a file.

        Parameters
        ----------
        path : str or path
            By its suffix: ``.csv``, ``.parquet`` (needs the extra ``parquet``), ``.npz``; or
            ``.json``, ``.yaml``, ``.yml`` in the shape of ROS's
            ``trajectory_msgs/JointTrajectory``.
        force : bool, default False
            Replace an existing file.

        Raises
        ------
        ArgumentError
            Another suffix.
        agrik_fast.io.ResultFileError
            The file exists or cannot be written, or a library is missing.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import agrik_fast as ik
        >>> from agrik_fast import motion
        >>> arm = ik.Robot.load("ur5")
        >>> path = pathlib.Path(tempfile.mkdtemp()) / "trajectory.csv"
        >>> motion.time_law(arm, [arm.home, arm.home + 0.5]).save(path)
        >>> path.read_text().split(",")[:2]
        ['time_s', 'shoulder_pan_rad']
        """
        _trajectory_files.save(self._as_points(), path, force=force)

    def to_ros(self, frame_id: str = "") -> dict[str, Any]:
        """Return the points in the shape of ROS's ``trajectory_msgs/JointTrajectory``.

        Parameters
        ----------
        frame_id : str, default ""
            For the header.

        Returns
        -------
        dict
            ``header``, ``joint_names`` and ``points``, each of these with ``positions``,
            ``velocities``, ``accelerations``, ``effort`` (empty) and ``time_from_start``
            (``sec``, ``nanosec``); lists of plain numbers.

            Of points nearer in time than a nanosecond, which the message cannot tell apart,
            the last one stands there.

        Raises
        ------
        ArgumentError
            A `frame_id` that is no text.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> from agrik_fast import motion
        >>> arm = ik.Robot.load("ur5")
        >>> message = motion.time_law(arm, [arm.home, arm.home + 0.5]).to_ros()
        >>> message["points"][0]["time_from_start"]
        {'sec': 0, 'nanosec': 0}
        """
        return _trajectory_files.message(self._as_points(), frame_id)

    def write_bag(self, path: str | PathLike[str], topic: str = "/joint_trajectory") -> None:
        """Write the points as one message to a new ROS 2 bag.

        Parameters
        ----------
        path : str or path
            Folder that is made for it.
        topic : str, default "/joint_trajectory"
            Where the message is published when the bag is played.

        Raises
        ------
        agrik_fast.io.ResultFileError
            The folder exists or cannot be written.
        MissingExtraError
            The extra ``ros`` (rosbags, pure Python) is not installed.
        ArgumentError
            A topic that is none.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import agrik_fast as ik
        >>> from agrik_fast import motion
        >>> arm = ik.Robot.load("ur5")
        >>> folder = pathlib.Path(tempfile.mkdtemp()) / "bag"
        >>> motion.time_law(arm, [arm.home, arm.home + 0.5]).write_bag(folder)
        >>> sorted(file.name for file in folder.iterdir())
        ['bag.db3', 'metadata.yaml']
        """
        from ._ros_bag import write

        write(self._as_points(), path, topic)

    def to_dict(self) -> dict[str, Any]:
        """Return the points' arrays by their names.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> from agrik_fast import motion
        >>> arm = ik.Robot.load("ur5")
        >>> list(motion.time_law(arm, [arm.home, arm.home + 0.5]).to_dict())[:3]
        ['joint_names', 'times', 'positions']
        """
        names = ("times", "positions", "velocities", "accelerations", "jerks")
        arrays = {name: getattr(self, name) for name in names}
        return {"joint_names": self.joint_names, **arrays}

    @property
    def _rows(self) -> FloatArray:
        return self.positions

    def _columns(self) -> dict[str, Any]:
        return dict(_trajectory_files.columns(self._as_points()))

    def _as_points(self) -> Points:
        return Points(
            self._names,
            self._types,
            self.times,
            self.positions,
            self.velocities,
            self.accelerations,
        )

    def __repr__(self) -> str:
        how = "a point a phase" if self._rate is None else f"{self._rate:g} points a second"
        return f"Trajectory({self.duration:.6g} s, {len(self)} points, {how})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Trajectory, (self._recipe, self._names, self._types, self._rate)


def checked_rate(rate: float | None) -> float | None:
    """Return a rate of points, 1/s."""
    return None if rate is None else real_number("rate", rate, 0.0, open_low=True, unit="1/s")


def _grid(duration: float, rate: float) -> FloatArray:
    """Return times at a fixed rate from 0, and the end."""
    count = duration * rate
    if count > _MOST:
        got = f"{rate:g}, {count:.3g} points"
        raise ArgumentError("rate", got, f"at most {_MOST} points")
    whole = int(count)
    if count - whole <= _WHOLE and whole > 0:
        whole -= 1
    times = np.arange(whole + 1) / rate
    return np.append(times, duration) if duration > 0 else times
