"""Trajectories in ROS 2 bags, through rosbags."""

from __future__ import annotations

import re
from os import PathLike
from typing import Any

import numpy as np

from .. import _checks
from .._checks import text
from .._files import brief
from ..errors import ArgumentError, MissingExtraError
from ..io import ResultFileError
from ._points import Points
from ._trajectory_files import message

__all__ = ["write"]

TYPE = "trajectory_msgs/msg/JointTrajectory"
# Names of topics as ROS 2 has them.
_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


def write(points: Points, path: str | PathLike[str], topic: str) -> None:
    """Write a trajectory as one message of a new bag; see `Trajectory.write_bag`."""
    folder = _checks.path("path", path)
    if not _TOPIC.fullmatch(text("topic", topic)):
        raise ArgumentError("topic", repr(topic), "a ROS topic such as '/joint_trajectory'")
    try:
        from rosbags.rosbag2 import Writer, WriterError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingExtraError("ROS 2 bags", "ros") from None
    if folder.exists():
        raise ResultFileError(folder, "exists already")
    store = get_typestore(Stores.ROS2_HUMBLE)
    data = store.serialize_cdr(_typed(store.types, message(points)), TYPE)
    try:
        with Writer(folder, version=9) as bag:
            connection = bag.add_connection(topic, TYPE, typestore=store)
            bag.write(connection, 0, data)
    except (OSError, WriterError) as error:
        raise ResultFileError(folder, f"cannot be written: {brief(error)}") from error


def _typed(types: Any, content: dict[str, Any]) -> Any:
    """Return the message as rosbags's own classes."""
    time = types["builtin_interfaces/msg/Time"]
    duration = types["builtin_interfaces/msg/Duration"]
    header, stamp = types["std_msgs/msg/Header"], content["header"]["stamp"]
    point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
    numbers = ("positions", "velocities", "accelerations", "effort")
    return types[TYPE](
        header=header(stamp=time(**stamp), frame_id=content["header"]["frame_id"]),
        joint_names=content["joint_names"],
        points=[
            point(
                **{name: np.array(row[name], dtype=np.float64) for name in numbers},
                time_from_start=duration(**row["time_from_start"]),
            )
            for row in content["points"]
        ],
    )
