"""One's own arm: which links are meant, encodings, macros, packages of robots, saving."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.errors import MissingExtraError, RobotWarning
from cli_runner import one_line, run_command
from urdf_text import joint, urdf


def arm(count: int, first: str = "base", prefix: str = "") -> tuple[list[str], list[str]]:
    """Links and joints of a row of `count` joints that starts at a link."""
    links = [f"{prefix}l{i}" for i in range(count)]
    parents = [first, *links]
    joints = [
        joint(f"{prefix}j{i}", parents[i], links[i], xyz="0 0 0.2", axis="0 1 0")
        for i in range(count)
    ]
    return links, joints


def described(links: list[str], joints: list[str]) -> str:
    return urdf(["base", *links], joints)


LINKS, JOINTS = arm(6)
FINGERS = [
    joint("f1", "hand", "finger1", kind="prismatic"),
    joint("f2", "hand", "finger2", kind="prismatic", more='<mimic joint="f1"/>'),
]


def fixed(name: str, parent: str) -> str:
    return joint(f"to_{name}", parent, name, kind="fixed")


@pytest.mark.parametrize(
    ("links", "joints", "tip"),
    [
        # A leaf that nothing moves does not count.
        ([*LINKS, "mark"], [*JOINTS, fixed("mark", "base")], "l5"),
        (
            [*LINKS, "tool0", "camera"],
            [*JOINTS, fixed("camera", "l5"), fixed("tool0", "l5")],
            "tool0",
        ),
        (
            [*LINKS, "flange", "tcp"],
            [*JOINTS, fixed("flange", "l5"), fixed("tcp", "flange")],
            "tcp",
        ),
        (
            [*LINKS, "flange", "mark"],
            [*JOINTS, fixed("flange", "l5"), fixed("mark", "l2")],
            "flange",
        ),
        # Fingers end the arm where they begin.
        ([*LINKS, "hand", "finger1", "finger2"], [*JOINTS, fixed("hand", "l5"), *FINGERS], "hand"),
        # A camera that tilts rides along.
        ([*LINKS, "camera"], [*JOINTS, joint("tilt", "l1", "camera")], "l5"),
        # One leaf, by whatever name.
        ([*LINKS, "x"], [*JOINTS, fixed("x", "l5")], "x"),
    ],
)
def test_the_tip_that_is_meant(links: list[str], joints: list[str], tip: str) -> None:
    robot = ik.Robot.from_urdf(described(links, joints))
    assert robot.link_names[-2] == tip
    assert robot.dof == 6
    named = ik.Robot.from_urdf(described(links, joints), tip_link=tip)
    assert named == robot
    assert named.notes == ()
    if robot.notes:
        assert f"the tip is link '{tip}'; it could also be " in robot.notes[0]


def test_two_arms_name_no_tip_by_themselves() -> None:
    left, right = arm(6, "base", "left_"), arm(6, "base", "right_")
    text = described([*left[0], *right[0]], [*left[1], *right[1]])
    with pytest.raises(ik.UrdfError, match="2 links could be the tip, name one as tip_link"):
        ik.Robot.from_urdf(text)
    assert ik.Robot.from_urdf(text, tip_link="right_l5").joint_names[0] == "right_j0"


def test_joints_that_limits_lock_are_warned_of() -> None:
    text = described(["a", "b"], [joint("j", "base", "a"), joint("k", "a", "b", limit=(0, 0))])
    with pytest.warns(RobotWarning, match="joint k cannot move: both limits are 0") as caught:
        ik.Robot.from_urdf(text)
    assert caught[0].filename == __file__


@pytest.mark.parametrize("encoding", ["ISO-8859-1", "UTF-16", "UTF-16-LE", "GB2312", "UTF-8"])
@pytest.mark.parametrize("kind", ["file", "bytes"])
def test_xml_is_read_as_it_says_it_is_encoded(encoding: str, kind: str, tmp_path: Path) -> None:
    word = "机械臂" if encoding == "GB2312" else "Länge"
    head = f'<?xml version="1.0" encoding="{encoding}"?><!-- {word} -->'
    data = (head + described(*arm(3))).replace("l2", f"l{word}").encode(encoding)
    path = tmp_path / "ARM.URDF"
    path.write_bytes(data)
    robot = ik.Robot.load(path) if kind == "file" else ik.Robot.from_urdf(data)
    assert robot.link_names[-2] == f"l{word}"


def test_an_encoding_that_the_text_is_not_in(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    path.write_bytes(b'<?xml version="1.0" encoding="klingon"?><robot name="r"/>')
    with pytest.raises(ik.UrdfError, match=r"a\.urdf: is not text in klingon"):
        ik.Robot.load(path)
    path.write_bytes('<?xml version="1.0" encoding="ascii"?><!-- ä -->'.encode())
    with pytest.raises(ik.UrdfError, match="is not text in ascii"):
        ik.Robot.load(path)


def test_xacro_files_are_expanded(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:property name="length" value="0.25"/><link name="base"/>'
        '<xacro:macro name="part" params="name parent"><link name="${name}"/>'
        '<joint name="${name}_joint" type="revolute"><parent link="${parent}"/>'
        '<child link="${name}"/><origin xyz="${2 * length} 0 0"/>'
        '<limit lower="-1" upper="1"/></joint></xacro:macro>'
        '<xacro:part name="a" parent="base"/><xacro:part name="b" parent="a"/></robot>',
        encoding="utf-8",
    )
    robot = ik.Robot.load(path)
    np.testing.assert_allclose(robot.fk([0, 0])[:3, 3], [1.0, 0, 0], rtol=0, atol=1e-15)
    path.write_text("<robot><xacro:", encoding="utf-8")
    with pytest.raises(ik.UrdfError, match="cannot be expanded"):
        ik.Robot.load(path)


def test_a_missing_extra_says_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "arm.xacro"
    path.write_text("<robot/>", encoding="utf-8")
    monkeypatch.setitem(sys.modules, "xacrodoc", None)
    monkeypatch.setitem(sys.modules, "robot_descriptions", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'agrik_fast\[xacro\]'"):
        ik.Robot.load(path)
    with pytest.raises(MissingExtraError, match=r"'agrik_fast\[descriptions\]'"):
        ik.Robot.load("ur5e_description")


DESCRIPTIONS = """
import sys
from agrik_fast import Robot
arm = Robot.load("edo_description")
print(arm.name, arm.dof)
try:
    Robot.load("edoo_description")
except ValueError as error:
    print(error)
"""


def test_robot_descriptions_by_name_from_a_repository_in_its_cache(tmp_path: Path) -> None:
    """The package downloads with git; here its cache holds a repository of that name."""
    repository = tmp_path / "first"
    (repository / "robots").mkdir(parents=True)
    (repository / "robots" / "edo_sim.urdf").write_text(described(*arm(6)), encoding="utf-8")
    git = ["git", "-C", str(repository), "-c", "user.name=a", "-c", "user.email=a@example.org"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "an arm"]):
        subprocess.run([*git, *words], check=True)
    told = subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    head = told.stdout.strip()
    # Where the package keeps the commit that its variable names.
    (tmp_path / f"edo_sim-{head}").mkdir()
    repository.rename(tmp_path / f"edo_sim-{head}" / "edo_sim")
    done = subprocess.run(
        [sys.executable, "-c", DESCRIPTIONS],
        env={
            **os.environ,
            "ROBOT_DESCRIPTIONS_CACHE": str(tmp_path),
            "ROBOT_DESCRIPTION_COMMIT": head,
        },
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == "r 6"
    assert "did you mean 'edo_description'" in done.stdout


ZOO = """
from agrik_fast import Robot
print(Robot.names())
print(Robot.load("my_arm").dof, Robot.load("my_other").dof)
for name in ("lost", "broken"):
    try:
        Robot.load(name)
    except ValueError as error:
        print(error)
"""


def test_packages_bring_robots_by_entry_points(tmp_path: Path) -> None:
    robot = ik.Robot.load("ur5")
    robot.save(tmp_path / "arm.toml")
    (tmp_path / "zoo.py").write_text(
        f"PATH = {str(tmp_path / 'arm.toml')!r}\nLOST = 'nowhere.toml'\n"
        "def path():\n    return PATH\n",
        encoding="utf-8",
    )
    info = tmp_path / "zoo-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: zoo\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[agrik_fast.robots]\nmy_arm = zoo:PATH\nmy_other = zoo:path\nlost = zoo:LOST\n"
        "broken = zoo:NOTHING\n"
    )
    env = dict(os.environ)
    env["PYTHONPATH"] = f"{tmp_path}:{env.get('PYTHONPATH', '')}"
    done = subprocess.run(
        [sys.executable, "-c", ZOO], env=env, capture_output=True, text=True, timeout=60, check=True
    )
    names, counts, lost, broken = done.stdout.splitlines()
    assert "'my_arm'" in names
    assert "'ur5'" in names
    assert counts == "6 6"
    assert "'nowhere.toml', which is no file" in lost
    assert "the entry point 'broken' (zoo:NOTHING), which cannot be loaded" in broken


@pytest.mark.parametrize("name", ik.Robot.names())
def test_saved_robots_are_equal_to_what_they_were(name: str, tmp_path: Path) -> None:
    robot = ik.Robot.load(name)
    robot.save(tmp_path / "r.toml")
    again = ik.Robot.load(tmp_path / "r.toml")
    assert again == robot
    assert hash(again) == hash(robot)
    assert again.description == robot.description
    assert again.source == robot.source
    assert again.provenance.keys() == {
        key.replace("_mm", "_m").replace("_deg", "_rad").replace(".rpy", ".rotation")
        for key in robot.provenance
    }
    q = robot.random_q(20, seed=1)
    np.testing.assert_array_equal(again.fk(q), robot.fk(q))


def test_a_urdf_becomes_a_robot_file(tmp_path: Path) -> None:
    links = [*LINKS, "hand", "finger1", "finger2"]
    robot = ik.Robot.from_urdf(described(links, [*JOINTS, fixed("hand", "l5"), *FINGERS]))
    moved = robot.with_tool(ik.rotations.pose([0, 0.1, 0.2], rpy=[0.1, 0.2, 0.3]))
    moved.save(tmp_path / "r.toml")
    again = ik.Robot.load(tmp_path / "r.toml")
    assert again == moved
    assert again != robot
    assert again.link_names == robot.link_names
    with pytest.raises(ik.RobotFileError, match="exists already"):
        robot.save(tmp_path / "r.toml")
    with pytest.raises(ik.ArgumentError, match=r"the name of a \.toml file"):
        robot.save(tmp_path / "r.yaml")
    finger = ik.Robot.from_urdf(
        described(links, [*JOINTS, fixed("hand", "l5"), *FINGERS]), tip_link="finger2"
    )
    with pytest.raises(ik.ArgumentError, match="joint 'f2', which follows 'f1'"):
        finger.save(tmp_path / "f.toml")


HOME = """format = 1
name = "r"
[[joint]]
name = "slide"
type = "prismatic"
axis = [1, 0, 0]
lower_mm = 0
upper_mm = 500
home_mm = 250
[[joint]]
name = "turn"
type = "revolute"
axis = [0, 0, 1]
lower_deg = 30
upper_deg = 90
"""


def test_home_and_values_by_name(tmp_path: Path) -> None:
    path = tmp_path / "r.toml"
    path.write_text(HOME, encoding="utf-8")
    robot = ik.Robot.load(path)
    np.testing.assert_allclose(robot.home, [0.25, np.pi / 6], rtol=1e-15)
    np.testing.assert_allclose(robot.joint_values({"turn": 0.7}), [0.25, 0.7], rtol=1e-15)
    with pytest.raises(ik.UnknownNameError, match="did you mean 'turn'"):
        robot.joint_values({"trun": 0.7})
    robot.save(tmp_path / "s.toml")
    assert ik.Robot.load(tmp_path / "s.toml") == robot
    for word, fault in (
        ("home_mm = 600", "expected a value within the limits 0 and 0.5"),
        ("home_deg = 3", "wrong unit for a prismatic joint; expected home_m or home_mm"),
    ):
        path.write_text(HOME.replace("home_mm = 250", word), encoding="utf-8")
        with pytest.raises(ik.RobotFileError, match=fault):
            ik.Robot.load(path)


def test_links_are_for_urdfs() -> None:
    with pytest.raises(ik.ArgumentError, match=r"ur5\.toml is a robot file, which has one chain"):
        ik.Robot.load("ur5", tip_link="tool0")


@pytest.mark.parametrize("made", [lambda: ik.Robot("panda"), lambda: ik.Robot(None)])
def test_the_class_is_no_way_to_load(made: object) -> None:
    with pytest.raises(ik.ArgumentError, match=r"expected Robot\.load, Robot\.from_dh or"):
        made()  # type: ignore[operator]


def test_the_command_line_names_links_tools_and_starts(tmp_path: Path) -> None:
    text = described(
        [*LINKS, "tool0", "camera"], [*JOINTS, fixed("camera", "l5"), fixed("tool0", "l2")]
    )
    (tmp_path / "arm.urdf").write_text(text, encoding="utf-8")
    (tmp_path / "t.csv").write_text("x_m,y_m,z_m\n0.2,0.0,0.9\n", encoding="utf-8")
    words = [str(tmp_path / "arm.urdf"), str(tmp_path / "t.csv"), "-o", str(tmp_path / "r.npz")]
    done = run_command("solve", *words, "--tip-link", "camera", "--q0", "0,0.1,0,0,0,0")
    assert done.exit_code == 0, done.output
    with np.load(tmp_path / "r.npz") as result:
        chosen = json.loads(str(result["metadata"]))
    assert chosen["tip_link"] == "camera"
    assert chosen["q0"] == "0.0,0.1,0.0,0.0,0.0,0.0"
    assert "--q0" in one_line(run_command("solve", *words, "--force", "--q0", "0,x"))
    assert "`--tip-link`" not in run_command("info", words[0], "--tip-link", "l3").output
    told = run_command("info", words[0])
    assert "Note: the tip is link" in told.stdout
    tool = run_command("info", words[0], "--tool", "0,0,1")
    assert tool.stdout != told.stdout
    assert "3 or 6 numbers" in one_line(run_command("info", words[0], "--tool", "1,2"))


def test_convert_writes_a_robot_file(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(described(*arm(4)), encoding="utf-8")
    done = run_command("convert", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.toml"))
    assert done.exit_code == 0, done.output
    assert ik.Robot.load(tmp_path / "arm.toml") == ik.Robot.load(tmp_path / "arm.urdf")
    assert tomllib.loads((tmp_path / "arm.toml").read_text(encoding="utf-8"))["format"] == 1
    again = run_command("convert", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.toml"))
    assert "exists already" in one_line(again)


def test_robots_and_solvers_are_listed() -> None:
    robots = run_command("robots").stdout.splitlines()
    assert [line.split()[0] for line in robots] == list(ik.Robot.names())
    solvers = run_command("solvers").stdout.splitlines()
    assert next(line.split()[0] for line in solvers) == "lm"
    assert all(len(line.split()) > 3 for line in solvers)


def test_masked_poses_from_a_file(tmp_path: Path) -> None:
    robot = ik.Robot.load("strawberry")
    poses = robot.fk(robot.random_q(20, seed=3))
    np.save(tmp_path / "t.npy", poses)
    words = ["strawberry", str(tmp_path / "t.npy"), "-o", str(tmp_path / "r.npz")]
    done = run_command("solve", *words, "--mask", "1,1,1,0,0,1")
    assert done.exit_code == 0, done.output
    with np.load(tmp_path / "r.npz") as result:
        direct = robot.ik(poses, ik.tasks.Masked((1, 1, 1, 0, 0, 1)))
        np.testing.assert_array_equal(result["q"], direct.q)
    assert direct.success.mean() > 0.9
    assert "six weights" in one_line(run_command("solve", *words, "--task", "masked", "--force"))


def test_schemas_are_of_the_files_that_are_read() -> None:
    kinds = {"robot": "joint", "gains": "gains", "scene": "objects", "calibration": "servo"}
    for kind, key in kinds.items():
        schema = json.loads(run_command("schema", kind).stdout)
        assert key in schema["properties"]
        assert schema["additionalProperties"] is False
    assert "unknown kind of file 'scenery'" in one_line(run_command("schema", "scenery"))


def test_no_warning_for_what_is_bundled() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in ik.Robot.names():
            assert ik.Robot.load(name).notes == ()
