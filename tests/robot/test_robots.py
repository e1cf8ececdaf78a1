"""The bundled robots: their numbers, their kinematics, and how they are loaded."""

from __future__ import annotations

import copy
import json
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
import numpy_fk
from agrik_fast.robot import _prepared, _sources
from agrik_fast.robot._definition import from_robot_file

GOLDEN = json.loads(
    (Path(__file__).parents[1] / "data" / "golden_kinematics.json").read_text(encoding="utf-8")
)
NAMES = (
    *("cucumber", "hydrolek", "panda", "puma560", "redundant7"),
    *("strawberry", "strawberry6", "tomato", "ur5"),
)
PEERS = {"redundant7": "R7", "hydrolek": "H6", "puma560": "P6", "ur5": "UR5", "panda": "Panda"}

Load = Callable[[str], ik.Robot]


def to_si(pose: Any) -> np.ndarray:
    """A golden pose (3 or 4 rows) with its translation in m, not mm."""
    matrix = np.eye(4)
    matrix[: len(pose)] = pose
    matrix[:3, 3] /= 1000
    return matrix


def golden_poses() -> list[tuple[str, list[float], np.ndarray]]:
    """(robot, q in rad and m, pose in the robot's base frame) of all golden full poses."""
    cucumber = GOLDEN["cucumber"]["cases"] + GOLDEN["cucumber"]["special"]
    return [
        *(("cucumber", [c["q"][0] / 1000, *c["q"][1:]], to_si(c["tcp_world"])) for c in cucumber),
        *(("hydrolek", c["q"], to_si(c["pose_dh"])) for c in GOLDEN["hydrolek"]["fk"]),
        *(("redundant7", c["q"], to_si(c["T"])) for c in GOLDEN["redundant7"]["fk"]),
    ]


@pytest.mark.parametrize("implementation", ["library", "numpy"])
def test_fk_meets_the_specifications_poses(implementation: str, load_robot: Load) -> None:
    for name, q, expected in golden_poses():
        pose = load_robot(name).fk(q) if implementation == "library" else numpy_fk.fk(name, q)
        # The specification names 1e-9 mm and 1e-12.
        np.testing.assert_allclose(pose[:3, 3], expected[:3, 3], rtol=0, atol=1e-12)
        np.testing.assert_allclose(pose[:3, :3], expected[:3, :3], rtol=0, atol=1e-12)


@pytest.mark.parametrize("implementation", ["library", "numpy"])
def test_fk_meets_the_tomato_points(implementation: str, load_robot: Load) -> None:
    cases = GOLDEN["tomato"]["fk"]
    q = np.array([case["q"] for case in cases])
    pose = load_robot("tomato").fk(q) if implementation == "library" else numpy_fk.fk("tomato", q)
    np.testing.assert_allclose(pose[:, :3, 3], [c["e"] for c in cases], rtol=0, atol=1e-12)


@pytest.mark.parametrize("implementation", ["library", "numpy"])
def test_fk_meets_the_strawberry_targets(implementation: str, load_robot: Load) -> None:
    scale = [1e-3, 1e-3, 1e-3, 1, 1]
    for case in GOLDEN["strawberry"]["cases"]:
        q = np.array(case["q"]) * scale
        tool = load_robot("strawberry").fk(q) if implementation == "library" else None
        point = (numpy_fk.fk("strawberry", q) if tool is None else tool)[:3, 3]
        # Joint values are printed with nine decimals: 5e-10 rad at 160 mm.
        np.testing.assert_allclose(point * 1000, case["p"], rtol=0, atol=2e-7)


def test_fk_of_the_strawberry_arm_is_the_specifications_formula(load_robot: Load) -> None:
    c = {k: v for k, v in GOLDEN["strawberry"]["constants"].items() if k != "sphere"}
    q = load_robot("strawberry").random_q(200, seed=1)
    s10, s21, s32 = (q[:, :3] * 1000).T
    theta, beta = q[:, 3:].T
    r = c["l2"] + c["l3"] * np.cos(beta)
    x = s21 + c["d_x"] - r * np.sin(theta)
    y = s10 + c["l1"] - c["d_y"] + c["l3"] * np.sin(beta)
    z = -s32 + c["d_z"] - r * np.cos(theta)
    point = load_robot("strawberry").fk(q)[:, :3, 3] * 1000
    np.testing.assert_allclose(point, np.stack([x, y, z], axis=-1), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_fk_agrees_with_plain_numpy(name: str, load_robot: Load) -> None:
    arm = load_robot(name)
    q = arm.random_q((10, 20), seed=2)
    np.testing.assert_allclose(arm.fk(q), numpy_fk.fk(name, q), rtol=0, atol=1e-13)
    np.testing.assert_allclose(arm.fk_links(q)[..., -1, :, :], arm.fk(q), rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_is_the_derivative_of_plain_numpy_fk(name: str, load_robot: Load) -> None:
    arm = load_robot(name)
    q = arm.random_q(5, seed=3)
    step = 1e-6
    for column in range(arm.dof):
        change = np.zeros(arm.dof)
        change[column] = step
        ahead, behind = numpy_fk.fk(name, q + change), numpy_fk.fk(name, q - change)
        linear = (ahead - behind)[:, :3, 3] / (2 * step)
        turn = ahead[:, :3, :3] @ np.swapaxes(behind[:, :3, :3], -1, -2) / (2 * step)
        skew = (turn - np.swapaxes(turn, -1, -2)) / 2
        angular = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1)
        found = arm.jacobian(q)[..., column]
        np.testing.assert_allclose(found[:, :3], linear, rtol=0, atol=1e-8)
        np.testing.assert_allclose(found[:, 3:], angular, rtol=0, atol=1e-8)


def test_jacobian_meets_the_specifications(load_robot: Load) -> None:
    for case in GOLDEN["hydrolek"]["jacobian"]:
        found = load_robot("hydrolek").jacobian(case["q"])
        found[:3] *= 1000
        np.testing.assert_allclose(found, case["J6_dh"], rtol=1e-12, atol=1e-9)
    for case in GOLDEN["tomato"]["fk"]:
        found = load_robot("tomato").jacobian(case["q"])[:3]
        np.testing.assert_allclose(found, case["J"], rtol=0, atol=1e-12)


def test_hydrolek_has_the_papers_frame(load_robot: Load) -> None:
    arm = load_robot("hydrolek")
    for case in GOLDEN["hydrolek"]["fk"]:
        expected = to_si(case["pose_paper"])
        pose = arm.frames["paper"] @ arm.fk(case["q"])
        np.testing.assert_allclose(pose, expected, rtol=0, atol=1e-12)
        turned = arm.in_frame("paper").fk(case["q"])
        np.testing.assert_allclose(turned, expected, rtol=0, atol=1e-12)


def test_cucumber_has_frame_0_of_appendix_b(load_robot: Load) -> None:
    arm = load_robot("cucumber").in_frame("frame0")
    np.testing.assert_array_equal(arm.frames["frame0"], np.eye(4))
    for case in GOLDEN["cucumber"]["cases"]:
        q = [case["q"][0] / 1000, *case["q"][1:]]
        np.testing.assert_allclose(arm.fk(q), to_si(case["tcp_frame0"]), rtol=0, atol=1e-12)


def test_joints_of_the_papers_robots(load_robot: Load) -> None:
    joints = {
        "strawberry": ("s10", "s21", "s32", "theta", "beta"),
        "cucumber": ("d1", "theta2", "theta3", "theta4", "theta5", "theta6", "theta7"),
        "tomato": ("phi1", "phi2", "phi3"),
    }
    for name, expected in joints.items():
        assert load_robot(name).joint_names == expected
    types = load_robot("strawberry").joint_types
    assert types == ("prismatic",) * 3 + ("revolute",) * 2
    assert load_robot("cucumber").joint_types == ("prismatic",) + ("revolute",) * 6
    limits = np.stack([load_robot("strawberry").lower, load_robot("strawberry").upper], axis=-1)
    expected_limits = [[0.075, 0.66], [0.08, 0.92], [0.061, 0.251], [-58, 52], [0, 73]]
    expected_limits[3:] = np.radians(expected_limits[3:]).tolist()
    np.testing.assert_allclose(limits, expected_limits, rtol=1e-15)


def test_tomato_limits_keep_every_pulse_in_its_range(load_robot: Load) -> None:
    arm = load_robot("tomato")
    offset = np.array([90.0, -90.0, 0.0])
    us_per_deg = np.array([8.485, 8.485, 10.0])
    first, last = np.array([800.0, 800.0, 900.0]), np.array([2200.0, 2200.0, 2100.0])
    for limit in (arm.lower, arm.upper):
        pulse = 1500 + (np.degrees(limit) - offset) * us_per_deg
        assert (pulse >= first - 1e-9).all()
        assert (pulse <= last + 1e-9).all()
        # The limits waste no more than one timer tick of half a microsecond.
        assert np.minimum(pulse - first, last - pulse).max() < 0.5


@pytest.mark.parametrize("name", PEERS)
def test_dh_and_limits_are_those_of_the_peer_benchmarks(name: str, load_robot: Load) -> None:
    arm, peer = load_robot(name), GOLDEN["peers"][PEERS[name]]
    assert arm.dh is not None
    for ours, theirs in (("d", "d"), ("a", "a"), ("alpha", "alpha"), ("theta", "off")):
        values = [getattr(row, ours) for row in arm.dh]
        np.testing.assert_allclose(values, peer[theirs], rtol=1e-15)
    np.testing.assert_allclose(arm.lower, peer["lo"], rtol=1e-15)
    np.testing.assert_allclose(arm.upper, peer["hi"], rtol=1e-15)


def test_five_solutions_of_the_published_pose(load_robot: Load) -> None:
    arm = load_robot("redundant7")
    reached = arm.fk(GOLDEN["redundant7"]["valid_solutions_table_I"])
    np.testing.assert_allclose(reached[:, :3, 3], [[0.334, 0.471, 0.539]] * 5, atol=1e-12)
    np.testing.assert_allclose(reached, np.broadcast_to(reached[0], (5, 4, 4)), atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_every_number_has_a_provenance(name: str) -> None:
    content = numpy_fk.load(name)
    assert content["source"]["title"]
    places = [content.get("base", {}), content.get("tool", {}), *content.get("frames", {}).values()]
    for table in (*places, *content.get("dh", []), *content.get("joint", [])):
        for key, value in table.items():
            stem, _, unit = key.rpartition("_")
            number = stem if unit in ("m", "mm", "rad", "deg") else key
            given = number in ("rotation", "axis", "lower", "upper") or number != key
            if given and (np.any(value) or number in ("lower", "upper")):
                assert number in table["provenance"], (name, table.get("name"), key)


@pytest.mark.parametrize("name", NAMES)
def test_the_reach_bounds_hold(name: str, load_robot: Load) -> None:
    arm = load_robot(name)
    points = arm.fk(arm.random_q(2000, seed=4))[:, :3, 3]
    distance = np.linalg.norm(points - arm.reach_center, axis=-1)
    assert (distance <= arm.reach_radius + 1e-12).all()
    assert distance.max() > 0.5 * arm.reach_radius
    assert (points >= arm.reach_box[0] - 1e-12).all()
    assert (points <= arm.reach_box[1] + 1e-12).all()


def test_names_lists_all_robots() -> None:
    others = (
        "ur3e",
        "ur5e",
        "ur10e",
        "fr3",
        "xarm6",
        "xarm7",
        "gen3",
        "iiwa14",
        "so101",
        "widowx250",
    )
    assert ik.Robot.names() == tuple(sorted((*NAMES, *others)))


@pytest.mark.parametrize("name", sorted(set(ik.Robot.names()) - set(NAMES)))
def test_arms_of_makers_say_where_they_are_from_and_are_solved(name: str) -> None:
    arm = ik.Robot.load(name)
    assert arm.source["url"].startswith("https://")
    assert "icence" in arm.source["note"]
    moving = [joint for joint in arm.joint_names if f"{joint}.axis" in arm.provenance]
    assert moving == list(arm.joint_names)
    q = arm.random_q(500, seed=4)
    # Five joints do not follow a pose with rounding, only the points of one.
    task = "pose" if arm.dof > 5 else "position"
    found = arm.ik(arm.fk(q), task)
    assert found.success.mean() >= 0.998
    np.testing.assert_allclose(
        arm.fk(found.q)[:, :3, 3][found.success],
        arm.fk(q)[:, :3, 3][found.success],
        rtol=0,
        atol=1e-6,
    )


def test_published_reach_and_limits_of_universal_robots() -> None:
    """UR e-Series limits are two turns; the lengths are those of the maker's DH tables."""
    lengths = {"ur3e": (0.24355, 0.2132), "ur5e": (0.425, 0.3922), "ur10e": (0.6127, 0.57155)}
    for name, (upper, fore) in lengths.items():
        arm = ik.Robot.load(name)
        assert np.isclose(arm.upper[[0, 1, 3, 4]], 2 * np.pi).all()
        # The UR3e's last joint turns without end.
        assert np.isinf(arm.upper[5]) if name == "ur3e" else np.isclose(arm.upper[5], 2 * np.pi)
        links = arm.fk_links(np.zeros(6))[:, :3, 3]
        steps = np.linalg.norm(np.diff(links, axis=0), axis=1)
        assert np.isclose(steps, upper, atol=1e-9).any()
        assert np.isclose(np.abs(np.diff(links, axis=0)), fore, atol=1e-9).any()


def test_descriptions_reach_the_user(load_robot: Load) -> None:
    arm = load_robot("cucumber")
    assert arm.name == "cucumber"
    assert arm.source["doi"] == "10.1016/j.biosystemseng.2010.01.007"
    assert arm.provenance["theta4.a"] == "X"
    assert arm.provenance_marks["X"].startswith("proxy")
    assert arm.convention == "modified"
    assert arm.dh is not None
    assert (arm.dh[3].name, arm.dh[3].a) == ("theta4", 0.25)
    assert repr(arm) == "Robot('cucumber', dof=7)"
    assert load_robot("tomato").dh is None


def test_a_robot_file_can_lie_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "my_arm.toml"
    shutil.copy(numpy_fk.ROBOTS / "ur5.toml", path)
    assert ik.Robot.load(path).name == "ur5"
    assert ik.Robot.load(str(path)).dof == 6


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pumma560", "unknown robot 'pumma560'; did you mean 'puma560'? Known: cucumber, "),
        ("UR5", "unknown robot 'UR5'; did you mean 'ur5' or 'ur5e'"),
        ("xyz", "unknown robot 'xyz'. Known: cucumber, fr3"),
        ("no/such.toml", "'no/such.toml', which is no file"),
        ("arm.step", "a robot's name or a .toml, .urdf, .xml, .xacro file, got 'arm.step'"),
    ],
)
def test_unknown_robots_are_refused(name: str, message: str) -> None:
    with pytest.raises(ik.ArgumentError) as caught:
        ik.Robot.load(name)
    assert message in str(caught.value)


def test_mimic_joints_follow(tmp_path: Path) -> None:
    path = tmp_path / "gripper.toml"
    path.write_text("""
format = 1
name = "gripper"
q_order = ["slide", "turn"]
[base]
xyz_mm = [0, 0, 100]
rpy_deg = [10, 20, 30]
[[joint]]
name = "turn"
type = "continuous"
rpy_deg = [0, 90, 0]
axis = [0, 3, 0]
[[joint]]
name = "plate"
type = "fixed"
xyz_mm = [5, 0, 0]
[[joint]]
name = "slide"
type = "prismatic"
axis = [1, 0, 0]
lower_mm = 0
upper_mm = 40
[[joint]]
name = "follower"
type = "prismatic"
axis = [0, 1, 0]
lower_mm = -100
upper_mm = 100
mimic = { joint = "slide", multiplier = -2, offset_mm = 3 }
[tool]
xyz_mm = [0, 0, 50]
""")
    arm = ik.Robot.load(path)
    assert arm.joint_names == ("slide", "turn")
    assert arm.joint_types == ("prismatic", "continuous")
    np.testing.assert_array_equal(arm.lower, [0.0, -np.inf])
    content = numpy_fk.tomllib.loads(path.read_text())
    q = arm.random_q(50, seed=5)
    assert (np.abs(q[:, 1]) <= np.pi).all()
    np.testing.assert_allclose(arm.fk(q), numpy_fk.fk(content, q), rtol=0, atol=1e-14)


def test_with_tool_and_with_base_replace(load_robot: Load) -> None:
    arm = load_robot("cucumber")
    q = arm.random_q(seed=6)
    tool, base = np.eye(4), np.eye(4)
    tool[2, 3], base[0, 3] = 0.09, 1.0
    flange = arm.with_tool(np.eye(4)).fk(q)
    np.testing.assert_allclose(arm.with_tool(tool).fk(q), flange @ tool, atol=1e-14)
    moved = arm.with_base(base)
    frame0 = arm.in_frame("frame0").fk(q)
    np.testing.assert_allclose(moved.fk(q), base @ frame0, atol=1e-14)
    assert not moved.frames
    assert moved.with_tool(tool).joint_names == arm.joint_names
    with pytest.raises(ik.UnknownNameError, match="unknown frame 'frame1'; did you mean 'frame0'"):
        arm.in_frame("frame1")


@pytest.mark.parametrize("name", ["tomato", "cucumber", "ur5"])
def test_robots_can_be_pickled_and_copied(name: str, load_robot: Load) -> None:
    arm = load_robot(name).with_tool(np.diag([1.0, -1.0, -1.0, 1.0]))
    q = arm.random_q(3, seed=7)
    for twin in (pickle.loads(pickle.dumps(arm)), copy.deepcopy(arm)):
        np.testing.assert_array_equal(twin.fk(q), arm.fk(q))
        assert (twin.name, twin.joint_names, twin.dh) == (arm.name, arm.joint_names, arm.dh)


def test_random_q_is_seeded_and_inside_the_limits(load_robot: Load) -> None:
    arm = load_robot("strawberry")
    q = arm.random_q((3, 4), seed=8)
    assert q.shape == (3, 4, 5)
    assert arm.random_q(seed=8).shape == (5,)
    assert ((q >= arm.lower) & (q <= arm.upper)).all()
    np.testing.assert_array_equal(q, arm.random_q((3, 4), seed=8))
    assert (q != arm.random_q((3, 4), seed=9)).all()
    with pytest.raises(ik.ArgumentError, match="`n`: expected a whole number >= 0, got -1"):
        arm.random_q(-1)


@pytest.mark.parametrize("method", ["fk", "fk_links", "jacobian"])
def test_joint_values_of_another_shape_are_refused(method: str, load_robot: Load) -> None:
    call = getattr(load_robot("ur5"), method)
    assert call(np.zeros((0, 6))).shape[0] == 0
    with pytest.raises(ik.ArgumentError, match=r"`q`: expected .*6.*, got .*\(5,\)"):
        call(np.zeros(5))
    with pytest.raises(ik.ArgumentError, match="`q`"):
        call(0.0)
    with pytest.raises(ik.ArgumentError, match="`q`: expected an array of numbers, got an array"):
        call(["a"] * 6)
    with pytest.raises(ik.ArgumentError, match="`q`: expected an array of numbers, got rows of"):
        call([[0.0] * 6, [0.0]])


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = (
        "import sys, agrik_fast; agrik_fast.errors\n"
        "heavy = {'numpy', 'pydantic', 'agrik_fast._native'} & set(sys.modules); print(heavy)\n"
        "agrik_fast.Robot.from_dh([[1, 0, 0, 0]]); print('pydantic' in sys.modules)\n"
        "print(sorted(set(agrik_fast.__all__) - set(dir(agrik_fast))))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:3] == ["set()", "False", "[]"]


def test_public_names_are_all_there() -> None:
    for name in ik.__all__:
        assert getattr(ik, name) is not None
    with pytest.raises(AttributeError, match="module 'agrik_fast' has no attribute 'robots'"):
        _ = ik.robots  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ik.Robot.names())
def test_what_stands_beside_a_bundled_file_is_what_the_file_says(name: str) -> None:
    """`python tools/prepare_robots.py` after a change of a file."""
    path = _sources.BUNDLED / f"{name}.toml"
    written = path.with_suffix(".json").read_text(encoding="utf-8")
    assert written == _prepared.text(from_robot_file(path))
    quick, whole = ik.Robot.load(name), ik.Robot.load(path)
    assert quick == whole
    assert (quick.source, quick.provenance, quick.dh) == (whole.source, whole.provenance, whole.dh)


def test_a_first_answer_needs_neither_pydantic_nor_what_comes_with_it() -> None:
    script = (
        "import sys, numpy as np; from agrik_fast import Robot\n"
        "assert Robot.load('ur5').ik(np.eye(4)).status.size == 1\n"
        "print({'pydantic', 'typer', 'rich', 'scipy', 'pyarrow', 'matplotlib', 'tomli_w', "
        "'importlib.metadata'} & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.strip() == "set()"
