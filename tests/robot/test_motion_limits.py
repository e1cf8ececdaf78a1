"""How fast joints may move: read, kept, changed, refused."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik

ROWS = """
format = 1
name = "two"
convention = "standard"
[provenance]
A = "assumed"
[[dh]]
name = "slide"
type = "prismatic"
a_m = 0
alpha_deg = 90
d_m = 0
theta_deg = 0
lower_mm = 0
upper_mm = 500
velocity_mm_s = 250
acceleration_m_s2 = 2
jerk_mm_s3 = 8000
provenance = { velocity = "A: a guess", jerk = "A" }
[[dh]]
name = "turn"
type = "continuous"
a_m = 0.2
alpha_deg = 0
d_m = 0
theta_deg = 0
velocity_deg_s = 90
"""

URDF = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="one" type="revolute"><parent link="a"/><child link="b"/>
  <limit lower="-1" upper="1" velocity="{one}" effort="1"/></joint>
<joint name="two" type="continuous"><parent link="b"/><child link="c"/>
  <limit velocity="0" effort="0"/></joint>
<joint name="three" type="revolute"><parent link="c"/><child link="d"/>
  <limit lower="-1" upper="1" velocity="3"/><mimic joint="one" multiplier="-2"/></joint></robot>"""


def limits(robot: ik.Robot) -> list[list[float]]:
    table = (robot.velocity_limits, robot.acceleration_limits, robot.jerk_limits)
    return [row.tolist() for row in table]


def loaded(tmp_path: Path, text: str) -> ik.Robot:
    path = tmp_path / "two.toml"
    path.write_text(text, encoding="utf-8")
    return ik.Robot.load(path)


def test_robot_files_tell_them_in_any_unit(tmp_path: Path) -> None:
    robot = loaded(tmp_path, ROWS)
    assert limits(robot) == [[0.25, np.pi / 2], [2.0, np.inf], [8.0, np.inf]]
    assert robot.provenance["slide.velocity"] == "A: a guess"


@pytest.mark.parametrize("change", ["save", "pickle", "copy", "with_tool", "with_base"])
def test_they_are_kept(tmp_path: Path, change: str) -> None:
    robot = loaded(tmp_path, ROWS)
    if change == "save":
        robot.save(tmp_path / "again.toml")
        again = ik.Robot.load(tmp_path / "again.toml")
        assert again == robot
        assert again.provenance["slide.velocity"] == "A: a guess"
    elif change == "pickle":
        again = pickle.loads(pickle.dumps(robot))
        assert again == robot
    elif change == "copy":
        again = copy.deepcopy(robot)
    else:
        pose = np.eye(4)
        pose[2, 3] = 0.1
        again = getattr(robot, change)(pose)
    assert limits(again) == limits(robot)


def test_equality_sees_them_and_the_fingerprint_of_the_geometry_does_not(tmp_path: Path) -> None:
    robot = loaded(tmp_path, ROWS)
    other = robot.with_motion_limits(velocity=[0.1, 1.0])
    assert other != robot
    assert other.fingerprint == robot.fingerprint
    assert limits(other)[0] == [0.1, 1.0]
    assert limits(other)[1:] == limits(robot)[1:]


def test_urdf_velocities_are_read_and_0_says_nothing() -> None:
    robot = ik.Robot.from_urdf(URDF.format(one=2))
    # The third joint turns twice as fast as the first, which it follows.
    assert limits(robot) == [[1.5, np.inf], [np.inf] * 2, [np.inf] * 2]
    assert limits(robot.with_motion_limits(jerk=9.0))[2] == [9.0, 9.0]


def test_a_saved_urdf_keeps_them(tmp_path: Path) -> None:
    robot = ik.Robot.from_urdf(URDF.format(one=1)).with_motion_limits(acceleration=4.0)
    robot.save(tmp_path / "r.toml")
    assert limits(ik.Robot.load(tmp_path / "r.toml")) == [[1.0, np.inf], [4.0] * 2, [np.inf] * 2]


@pytest.mark.parametrize("word", ["-1", "nan", "quick"])
def test_urdf_velocities_that_are_none_are_refused(word: str) -> None:
    with pytest.raises(ik.UrdfError, match=r"'one' \(line 2\): <limit> velocity: expected a"):
        ik.Robot.from_urdf(URDF.format(one=word))


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        (
            "velocity_mm_s = 250",
            "velocity_deg_s = 1",
            r"row 1, velocity_deg_s: wrong unit for a pr",
        ),
        ("velocity_mm_s = 250", "velocity_mm_s = 0", r"row 1, velocity: expected a number above 0"),
        ("velocity_mm_s = 250", "velocity_mm = 2", r"velocity_mm: unknown key; did you mean 'velo"),
        (
            "velocity_mm_s = 250",
            "velocity = 250",
            r"velocity: unknown key, its name ends in a unit; did you mean 'velocity_m_s', "
            r"'velocity_mm_s', 'velocity_rad_s' or 'velocity_deg_s'\?",
        ),
        ("jerk_mm_s3 = 8000", "jerk_mm_s3 = nan", r"jerk_mm_s3: input should be a finite number"),
        ("velocity_deg_s = 90", "velocity_rad_s = -2", r"row 2, velocity: .* above 0, got -2"),
        (
            "velocity_mm_s = 250",
            "velocity_mm_s = 250\nvelocity_m_s = 1",
            r"given twice, as velocity_m_s and velocity_mm_s",
        ),
        ('type = "continuous"', 'type = "fixed"', r"row 2, velocity_deg_s: a fixed joint does not"),
        ('jerk = "A"', 'effort = "A"', r"provenance\.effort: names no number of this table"),
    ],
)
def test_faults_of_files_are_told(tmp_path: Path, old: str, new: str, fault: str) -> None:
    with pytest.raises(ik.RobotFileError, match=fault):
        loaded(tmp_path, ROWS.replace(old, new))


@pytest.mark.parametrize("value", [[1.0, 2.0, 3.0], 0.0, -1.0, np.nan, [1.0, np.nan], "fast", None])
def test_other_limits_are_checked(value: object) -> None:
    robot = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]])
    assert limits(robot) == [[np.inf] * 2] * 3
    if value is None:
        assert limits(robot.with_motion_limits()) == limits(robot)
        return
    with pytest.raises(ik.ArgumentError, match="velocity"):
        robot.with_motion_limits(velocity=value)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", [name for name in ik.Robot.names() if name])
def test_bundled_arms_have_all_of_them_and_say_where_from(name: str) -> None:
    robot = ik.Robot.load(name)
    table = np.array(limits(robot))
    assert np.isfinite(table).all()
    assert (table > 0).all()
    for joint in robot.joint_names:
        for number in ("velocity", "acceleration", "jerk"):
            assert robot.provenance[f"{joint}.{number}"].partition(":")[0] in robot.provenance_marks


def test_the_schema_knows_their_keys() -> None:
    from agrik_fast.robot import file_schema

    row = file_schema()["$defs"]["JointTable"]["properties"]
    assert {"velocity_mm_s", "acceleration_deg_s2", "jerk_rad_s3"} <= set(row)
