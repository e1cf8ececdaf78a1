"""Trajectories in files, read back by other libraries."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import yaml

import agrik_fast as ik
from agrik_fast import motion
from agrik_fast.io import ResultFileError


@pytest.fixture(scope="module")
def trajectory() -> motion.Trajectory:
    arm = ik.Robot.load("cucumber")
    return motion.time_law(arm, arm.random_q(3, seed=2), rate=50.0)


def test_tables(trajectory: motion.Trajectory, tmp_path: Path) -> None:
    from pyarrow import parquet

    for suffix in ("csv", "parquet", "npz"):
        trajectory.save(tmp_path / f"t.{suffix}")
    with (tmp_path / "t.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:3] == ["time_s", "d1_m", "theta2_rad"]
    assert header[8:10] == ["d1_m_s", "theta2_rad_s"]
    assert header[15:17] == ["d1_m_s2", "theta2_rad_s2"]
    table = np.array(rows, dtype=float)
    blocks = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    whole = np.column_stack([trajectory.times, *blocks])
    assert (table == whole).all()
    read = parquet.read_table(tmp_path / "t.parquet")
    assert read.column_names == header
    assert (np.column_stack([read[name].to_numpy() for name in header]) == whole).all()
    with np.load(tmp_path / "t.npz", allow_pickle=False) as arrays:
        assert tuple(arrays["joint_names"]) == trajectory.joint_names
        assert (arrays["times"] == trajectory.times).all()
        assert (arrays["accelerations"] == trajectory.accelerations).all()


def check_message(message: dict[str, object], trajectory: motion.Trajectory) -> None:
    assert list(message) == ["header", "joint_names", "points"]
    assert message["joint_names"] == list(trajectory.joint_names)
    points = message["points"]
    assert isinstance(points, list)
    stamps = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in points]
    np.testing.assert_allclose(stamps, trajectory.times, atol=1e-9)
    assert (np.diff(stamps) > 0).all()
    for name in ("positions", "velocities", "accelerations"):
        assert (np.array([p[name] for p in points]) == getattr(trajectory, name)).all()
    assert set(points[-1]["velocities"]) == {0.0}
    assert points[0]["effort"] == []


@pytest.mark.parametrize("suffix", ["json", "yaml", "YML"])
def test_ros_messages_as_text(trajectory: motion.Trajectory, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"t.{suffix}"
    trajectory.save(path)
    text = path.read_text(encoding="utf-8")
    check_message(json.loads(text) if suffix == "json" else yaml.safe_load(text), trajectory)


def test_a_bag_is_read_back(trajectory: motion.Trajectory, tmp_path: Path) -> None:
    from rosbags.highlevel import AnyReader

    trajectory.write_bag(tmp_path / "bag", "/arm/joint_trajectory")
    with AnyReader([tmp_path / "bag"]) as reader:
        (connection,) = reader.connections
        assert connection.topic == "/arm/joint_trajectory"
        assert connection.msgtype == "trajectory_msgs/msg/JointTrajectory"
        ((_, _, data),) = list(reader.messages())
        message = reader.deserialize(data, connection.msgtype)
    assert tuple(message.joint_names) == trajectory.joint_names
    for name in ("positions", "velocities", "accelerations"):
        read = np.array([getattr(point, name) for point in message.points])
        assert (read == getattr(trajectory, name)).all()
    last = message.points[-1].time_from_start
    assert last.sec + 1e-9 * last.nanosec == pytest.approx(trajectory.duration, abs=1e-9)


def test_points_nearer_than_a_nanosecond_are_one() -> None:
    arm = ik.Robot.load("ur5")
    tiny = motion.time_law(arm, [arm.home, arm.home + 1e-26], rate=None)
    stamps = [point["time_from_start"]["nanosec"] for point in tiny.to_ros()["points"]]
    assert stamps == sorted(set(stamps))
    assert tiny.to_ros()["points"][-1]["velocities"] == [0.0] * 6


def test_refusals(trajectory: motion.Trajectory, tmp_path: Path) -> None:
    with pytest.raises(ik.ArgumentError, match=r"path.*\.csv, \.parquet"):
        trajectory.save(tmp_path / "t.txt")
    (tmp_path / "t.csv").write_text("kept", encoding="utf-8")
    with pytest.raises(ResultFileError, match="exists already"):
        trajectory.save(tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text(encoding="utf-8") == "kept"
    trajectory.save(tmp_path / "t.csv", force=True)
    with pytest.raises(ResultFileError, match="cannot be written"):
        trajectory.save(tmp_path / "nowhere" / "t.csv")
    with pytest.raises(ik.ArgumentError, match="force"):
        trajectory.save(tmp_path / "u.csv", force="yes")  # type: ignore[arg-type]
    with pytest.raises(ik.ArgumentError, match="frame_id"):
        trajectory.to_ros(3)  # type: ignore[arg-type]
    for topic in ("", "a b", "/", 5):
        with pytest.raises(ik.ArgumentError, match="topic"):
            trajectory.write_bag(tmp_path / "bag", topic)  # type: ignore[arg-type]
    (tmp_path / "bag").mkdir()
    with pytest.raises(ResultFileError, match="exists already"):
        trajectory.write_bag(tmp_path / "bag")


def test_a_missing_library_is_named(
    trajectory: motion.Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    from agrik_fast.errors import MissingExtraError

    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    with pytest.raises(MissingExtraError, match="ros"):
        trajectory.write_bag(tmp_path / "bag")
