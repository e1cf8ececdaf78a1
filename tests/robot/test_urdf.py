"""URDF through Python: what is read, which chain is chosen, how bad texts are refused."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik

LIMIT = '<limit lower="-1" upper="2" effort="1" velocity="1"/>'


def joint(name: str, kind: str, parent: str, child: str, inside: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{inside}</joint>\n'
    )


def robot(links: str, *joints: str, name: str = "r") -> str:
    declared = "".join(f'<link name="{link}"/>\n' for link in links.split())
    return f'<robot name="{name}">\n{declared}{"".join(joints)}</robot>'


ARM = robot(
    "base upper lower flange",
    joint(
        "turn",
        "continuous",
        "base",
        "upper",
        '<origin xyz="0 0 0.5" rpy="0 0 1.5"/><axis xyz="0 0 3"/>',
    ),
    joint("bend", "revolute", "upper", "lower", f'<origin xyz="1 0 0"/><axis xyz="0 1 0"/>{LIMIT}'),
    joint("slide", "prismatic", "lower", "flange", '<axis xyz="2 0 0"/><limit upper="0.5"/>'),
    name="arm",
)

GRIPPER = robot(
    "palm left right",
    joint("l", "prismatic", "palm", "left", '<axis xyz="0 1 0"/><limit lower="0" upper="0.04"/>'),
    joint(
        "r",
        "prismatic",
        "palm",
        "right",
        '<axis xyz="0 -1 0"/><limit lower="0" upper="0.1"/><mimic joint="l" multiplier="2"/>',
    ),
    name="gripper",
)


def test_the_chain_of_a_text() -> None:
    arm = ik.Robot.from_urdf(ARM)
    assert arm.name == "arm"
    assert arm.dof == 3
    assert arm.joint_names == ("turn", "bend", "slide")
    assert arm.joint_types == ("continuous", "revolute", "prismatic")
    np.testing.assert_array_equal(arm.lower, [-np.inf, -1, 0])
    np.testing.assert_array_equal(arm.upper, [np.inf, 2, 0.5])


def test_forward_kinematics_and_jacobian() -> None:
    turn, bend, slide = 0.4, -0.3, 0.25
    arm = ik.Robot.from_urdf(ARM)
    heading = 1.5 + turn
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    along = np.cos(bend) * ahead - np.sin(bend) * np.array([0, 0, 1])
    position = np.array([0, 0, 0.5]) + ahead + slide * along
    pose = arm.fk([turn, bend, slide])
    np.testing.assert_allclose(pose[:3, 3], position, rtol=0, atol=1e-15)
    np.testing.assert_allclose(pose[:3, 0], along, rtol=0, atol=1e-15)
    jacobian = arm.jacobian([turn, bend, slide])
    np.testing.assert_allclose(jacobian[:, 2], [*along, 0, 0, 0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(jacobian[3:, 0], [0, 0, 1], rtol=0, atol=1e-15)


def test_targets_are_solved_within_the_limits() -> None:
    arm = ik.Robot.from_urdf(ARM)
    targets = arm.fk(arm.random_q(100, seed=1))
    result = arm.ik(targets)
    assert result.success.all()
    assert (result.q >= arm.lower).all()
    assert (result.q <= arm.upper).all()
    np.testing.assert_allclose(arm.fk(result.q), targets, rtol=0, atol=1e-5)


def test_path_and_text_are_the_same(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(ARM, encoding="utf-8")
    q = [0.1, 0.2, 0.3]
    expected = ik.Robot.from_urdf(ARM).fk(q)
    for arm in (
        ik.Robot.from_urdf(file),
        ik.Robot.from_urdf(str(file)),
        ik.Robot.load(file),
        ik.Robot.load(str(file)),
        pickle.loads(pickle.dumps(ik.Robot.from_urdf(file))),
    ):
        np.testing.assert_array_equal(arm.fk(q), expected)


def test_a_path_that_leads_nowhere(tmp_path: Path) -> None:
    with pytest.raises(ik.ArgumentError, match=r"`path_or_text`.*missing\.urdf"):
        ik.Robot.from_urdf(tmp_path / "missing.urdf")


def test_a_file_that_is_no_text(tmp_path: Path) -> None:
    file = tmp_path / "mesh.urdf"
    file.write_bytes(b"\xff\xff\x00binary")
    with pytest.raises(ik.UrdfError, match=r"mesh\.urdf: line 1: is not UTF-8"):
        ik.Robot.from_urdf(file)


def test_an_empty_file(tmp_path: Path) -> None:
    file = tmp_path / "empty.urdf"
    file.touch()
    with pytest.raises(ik.UrdfError, match="the text is empty"):
        ik.Robot.from_urdf(file)


def test_a_part_of_the_tree() -> None:
    part = ik.Robot.from_urdf(ARM, base_link="upper", tip_link="lower")
    assert part.joint_names == ("bend",)
    np.testing.assert_allclose(part.fk([0.0])[:3, 3], [1, 0, 0], rtol=0, atol=1e-15)


def test_a_finger_that_follows_another() -> None:
    finger = ik.Robot.from_urdf(GRIPPER, tip_link="right")
    assert finger.joint_names == ("l",)
    # Twice 0.04 m is less than the follower's own 0.1 m.
    np.testing.assert_array_equal(finger.upper, [0.04])
    np.testing.assert_allclose(finger.fk([0.03])[:3, 3], [0, -0.06, 0], rtol=0, atol=1e-16)
    np.testing.assert_allclose(finger.jacobian([0.03])[:3, 0], [0, -2, 0], rtol=0, atol=1e-16)


@pytest.mark.parametrize(
    ("base", "tip", "message"),
    [
        (None, None, "2 links could be the tip, name one as tip_link: 'left', 'right'"),
        (None, "lfet", "unknown tip link 'lfet'; did you mean 'left'?"),
        ("pam", "left", "unknown base link 'pam'; did you mean 'palm'?"),
        (None, "camera", "unknown tip link 'camera'. Links: 'palm', 'left', 'right'"),
        ("left", None, "no joint below base link 'left'"),
        ("palm", "palm", "base link and tip link are both 'palm'"),
    ],
)
def test_links_that_make_no_chain(base: str | None, tip: str | None, message: str) -> None:
    with pytest.raises(ik.UrdfError) as caught:
        ik.Robot.from_urdf(GRIPPER, base, tip)
    assert message in str(caught.value)


AB = joint("j1", "revolute", "a", "b", LIMIT)
BA = joint("j2", "revolute", "b", "a", LIMIT)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<sdf></sdf>", "the root element is <sdf>, not <robot>"),
        ("a < b", "not well-formed XML at line 1"),
        ("<robot>\n<link name='a'></robot>", "not well-formed XML at line 2"),
        ("<robot>\n<link name='a'>", "the text ends inside <link>, which starts on line 2"),
        ("<robot/>", "no <link> in <robot>"),
        ("<robot><xacro:include filename='x'/></robot>", "this looks like a xacro file"),
        ("<robot>\n<link/></robot>", "line 2: <link> without a name"),
        (robot("a"), "no joint below base link 'a'"),
        (robot("a b", joint("j", "fixed", "a", "b")), "no movable joint between base and tip"),
        (robot("a b", AB, BA), "cyclic: from link 'a' joints 'j1', 'j2' lead back to it"),
        (robot("a b c", AB), "disconnected: 2 links have no parent joint ('a', 'c')"),
        (robot("a b c", AB, joint("k", "fixed", "c", "b")), "is the child of two joints"),
        (robot("a b a", AB), "a second link named 'a'"),
        (robot("a b c", AB, joint("j1", "fixed", "b", "c")), "a second joint named 'j1'"),
        (robot("a", AB), "joint 'j1' (line 3): unknown child link 'b'"),
        (robot("a b", "<joint name='j'/>"), "joint 'j' (line 4): no <parent link=\"...\"/>"),
    ],
)
def test_texts_that_are_no_tree(text: str, message: str) -> None:
    with pytest.raises(ik.UrdfError) as caught:
        ik.Robot.from_urdf(text)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "inside", "message"),
    [
        ("revolute", "", 'is revolute and needs <limit lower="..." upper="..."/>'),
        ("prismatic", '<limit effort="1"/>', "is prismatic and needs <limit"),
        ("revolute", '<limit lower="2" upper="1"/>', "lower limit 2 > upper limit 1"),
        ("revolute", '<limit lower="x" upper="1"/>', "lower: expected a finite number, got 'x'"),
        ("continuous", '<axis xyz="0 0 0"/>', "the axis is zero, expected a direction"),
        ("continuous", '<axis xyz="0 1"/>', "expected three finite numbers, got '0 1'"),
        ("continuous", '<origin xyz="0 0 nan"/>', "expected three finite numbers"),
        ("continuous", '<origin rpy="0 0 ${pi}"/>', "a xacro expression: expand the file first"),
        ("continuous", "<mimic/>", "<mimic> names no joint"),
        ("continuous", '<mimic joint="k"/>', "<mimic>: unknown joint 'k'"),
        ("continuous", '<mimic joint="j"/>', "<mimic> leads back to itself"),
        ("floating", "", "is floating: it has several degrees of freedom"),
        ("planar", "", "is planar: it has several degrees of freedom"),
        ("ball", "", "has the unknown type 'ball'"),
        ("", "", "has no type"),
    ],
)
def test_joints_that_cannot_be_used(kind: str, inside: str, message: str) -> None:
    with pytest.raises(ik.UrdfError) as caught:
        ik.Robot.from_urdf(robot("a b", joint("j", kind, "a", "b", inside)))
    assert "joint 'j' (line 4)" in str(caught.value)
    assert message in str(caught.value)


def test_the_error_is_a_value_error() -> None:
    assert issubclass(ik.UrdfError, ik.AgrikError)
    assert issubclass(ik.UrdfError, ValueError)
