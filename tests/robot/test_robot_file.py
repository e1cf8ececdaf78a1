"""Robot files: every fault is found, all at once, with its place."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.errors import RobotFileError
from agrik_fast.robot._file import parse, read

DH = """
format = 1
name = "two"
convention = "standard"

[[dh]]
name = "q1"
type = "revolute"
a_mm = 500
alpha_deg = 90
d_m = 0
theta_rad = 0
lower_deg = -180
upper_rad = 3

[[dh]]
name = "q2"
type = "prismatic"
a_m = 0
alpha_rad = 0
d_m = 0.1
theta_deg = 0
lower_mm = 0
upper_m = 0.25
"""

JOINTS = """
format = 1
name = "gripper"

[[joint]]
name = "left"
type = "prismatic"
xyz_mm = [0, 10, 0]
axis = [0, 2, 0]
lower_mm = 0
upper_mm = 40

[[joint]]
name = "right"
type = "prismatic"
rpy_deg = [0, 0, 180]
axis = [0, 1, 0]
lower_m = 0
upper_m = 0.04
mimic = { joint = "left", multiplier = -1, offset_mm = 5 }
"""


def faults(text: str) -> dict[str, str]:
    """Faults of a file as place: message; each place once."""
    with pytest.raises(RobotFileError) as caught:
        parse(text.encode(), "arm.toml")
    found = caught.value.faults
    assert len({fault.place for fault in found}) == len(found)
    for fault in found:
        assert f"{fault.place}: {fault.message}" in str(caught.value) or not fault.place
    return dict(found)


def test_dh_rows_are_converted_to_metres_and_radians() -> None:
    content = parse(DH.encode(), "arm.toml")
    assert content.dh[0].values() == (0.5, np.pi / 2, 0.0, 0.0)
    assert content.dh[0].limits == (-np.pi, 3.0)
    assert content.dh[1].limits == (0.0, 0.25)


def test_joint_rows_are_converted_to_transforms() -> None:
    left, right = parse(JOINTS.encode(), "arm.toml").joint
    assert left.matrix()[:3, 3].tolist() == [0.0, 0.01, 0.0]
    np.testing.assert_allclose(right.matrix(), np.diag([-1.0, -1.0, 1.0, 1.0]), atol=1e-15)
    assert right.mimic is not None
    assert (right.mimic.joint, right.mimic.multiplier, right.mimic.offset) == ("left", -1.0, 0.005)


def test_rpy_turns_about_the_fixed_axes_in_turn() -> None:
    text = DH + "[tool]\nrpy_deg = [90, 90, 0]\n"
    # x to z by the second turn; y to z by the first, then to x by the second.
    expected = [[0, 1, 0], [0, 0, -1], [-1, 0, 0]]
    rotation = parse(text.encode(), "arm.toml").tool.matrix()[:3, :3]
    np.testing.assert_allclose(rotation, expected, atol=1e-15)


def test_all_faults_are_reported_at_once() -> None:
    text = """
format = 1
nam = "x"
convention = "craig"

[base]
xyz_m = [0, 0]

[[dh]]
name = "q1"
type = "revolut"
a_m = "long"
alpha_deg = 0
d_m = 0
theta_deg = 0

[[dh]]
name = "q2"
type = "revolute"
a_m = 0
alpa_deg = 90
d_m = nan
theta_deg = 0
lower_deg = 20
upper_deg = -20

[[dh]]
name = "q2"
type = "prismatic"
a_m = 0
a_mm = 0
alpha_deg = 0
d_m = 0
theta_deg = 0
lower_deg = 0
upper_m = true
"""
    assert faults(text) == {
        "name": "missing",
        "nam": "unknown key; did you mean 'name'?",
        "convention": "input should be 'standard' or 'modified', got 'craig'",
        "[base], xyz_m": "list should have at least 3 items after validation, not 2, got [0, 0]",
        "[[dh]] row 1, type": (
            "input should be 'revolute', 'continuous', 'prismatic' or 'fixed', got 'revolut'"
        ),
        "[[dh]] row 1, a_m": "input should be a valid number, got 'long'",
        "[[dh]] row 2, alpa_deg": "unknown key; did you mean 'alpha_deg'?",
        "[[dh]] row 2, alpha": "missing; expected alpha_rad or alpha_deg",
        "[[dh]] row 2, d_m": "input should be a finite number, got nan",
        "[[dh]] row 2, lower": "expected lower <= upper, got 0.349066 > -0.349066",
        "[[dh]] row 3, name": "'q2' is the name of row 2 too",
        "[[dh]] row 3, a": "given twice, as a_m and a_mm",
        "[[dh]] row 3, lower_deg": "wrong unit for a prismatic joint; expected lower_m or lower_mm",
        "[[dh]] row 3, lower": "missing; expected lower_m or lower_mm",
        "[[dh]] row 3, upper_m": "input should be a valid number, got True",
    }


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ('type = "revolute"\n', "", "[[dh]] row 1, type", "missing"),
        ("a_mm = 500\n", "", "[[dh]] row 1, a", "missing; expected a_m or a_mm"),
        ('"revolute"', '"continuous"', "[[dh]] row 1, lower_deg", "a continuous joint has no lim"),
        ('convention = "standard"', "", "convention", "missing: [[dh]] rows are 'standard' or"),
        ("format = 1", "format = 2", "format", "input should be 1, got 2"),
        ("format = 1", 'format = "1"', "format", "input should be 1, got '1'"),
        ('name = "two"', 'name = ""', "name", "string should have at least 1 character, got ''"),
        ('name = "two"', 'name = "two"\nq_order = ["q1"]', "q_order", "expected each of q1, q2"),
        (
            "d_m = 0.1",
            'd_m = 0.1\nprovenance = { d = "P" }',
            "[[dh]] row 2, provenance.d",
            "mark 'P' is not explained in [provenance]",
        ),
        (
            '[[dh]]\nname = "q1"',
            '[provenance]\nP = "printed"\n[tool]\nprovenance = { d = "P" }\n[[dh]]\nname = "q1"',
            "[tool], provenance.d",
            "names no number of this table",
        ),
    ],
)
def test_faults_of_dh_files(old: str, new: str, place: str, message: str) -> None:
    assert old in DH
    found = faults(DH.replace(old, new, 1))
    assert found[place].startswith(message)


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("axis = [0, 2, 0]", "axis = [0, 0, 0]", "[[joint]] row 1, axis", "expected a direction"),
        ("axis = [0, 2, 0]", "", "[[joint]] row 1, axis", "missing"),
        ("axis = [0, 2, 0]", "axis = [0, 2]", "[[joint]] row 1, axis", "list should have at least"),
        ('joint = "left"', 'joint = "lef"', "[[joint]] row 2, mimic.joint", "no joint is named"),
        ('joint = "left"', 'joint = "right"', "[[joint]] row 2, mimic.joint", "expected a moving"),
        ("offset_mm", "offset_deg", "[[joint]] row 2, mimic.offset_deg", "expected offset_m or"),
        ("multiplier", "factor", "[[joint]] row 2, mimic.factor", "unknown key"),
        ("format = 1", 'format = 1\nconvention = "modified"', "convention", "only for [[dh]] rows"),
        ("xyz_mm", "xyz_m = [0, 0, 0]\nxyz_mm", "[[joint]] row 1, xyz", "given twice"),
    ],
)
def test_faults_of_joint_files(old: str, new: str, place: str, message: str) -> None:
    assert old in JOINTS
    found = faults(JOINTS.replace(old, new, 1))
    assert found[place].startswith(message)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("[[1, 0, 0], [0, 1, 0], [0, 0, 0.999]]", "expected orthonormal rows"),
        ("[[1, 0, 0], [0, 1, 0], [0, 0, -1]]", "expected a right-handed frame"),
        ("[[1, 0, 0], [0, 1, 0]]", "list should have at least 3 items"),
    ],
)
def test_a_rotation_must_be_one(rows: str, message: str) -> None:
    found = faults(DH + f"[frames.extra]\nrotation = {rows}\n")
    assert found["[frames.extra], rotation"].startswith(message)


def test_rows_of_both_kinds_or_of_none_are_refused() -> None:
    only_joint = JOINTS.partition("[[joint]]")[2]
    both = faults(DH + "[[joint]]" + only_joint)
    assert both[""] == "expected either [[dh]] or [[joint]] rows, got both"
    none = faults('format = 1\nname = "nothing"\n')
    assert none[""] == "expected either [[dh]] or [[joint]] rows, got neither"


def test_a_chain_of_fixed_joints_is_refused() -> None:
    text = 'format = 1\nname = "x"\n[[joint]]\nname = "a"\ntype = "fixed"\n'
    assert faults(text) == {
        "[[joint]]": "expected at least one joint that moves, got fixed joints only"
    }


def test_text_that_is_not_toml_is_a_fault_with_its_line() -> None:
    assert "line 2" in faults('format = 1\nname = "x\n')[""]
    with pytest.raises(RobotFileError, match="line 1: is not UTF-8 text"):
        parse(b"\xff\xfe", "arm.toml")


def test_the_error_names_the_file_and_counts(tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text('format = 1\nname = "nothing"\n')
    with pytest.raises(RobotFileError, match=r"^broken\.toml: 1 fault\n  expected either"):
        read(path)


def test_the_error_survives_pickling() -> None:
    error = RobotFileError("arm.toml", [("name", "missing")])
    copy = pickle.loads(pickle.dumps(error))
    assert (copy.file, copy.faults, str(copy)) == (error.file, error.faults, str(error))
