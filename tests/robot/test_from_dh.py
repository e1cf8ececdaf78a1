"""`Robot.from_dh`: both conventions, both forms of rows, and every refusal's message."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
import numpy_fk
from urdf_text import joint, urdf

HALF = np.pi / 2
PLANAR = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0]]


def as_file(rows: np.ndarray, convention: str, types: list[str]) -> dict[str, Any]:
    """The rows as `numpy_fk` reads them."""
    keys = ("a_m", "alpha_rad", "d_m", "theta_rad")
    table = [
        {"name": f"q{i}", "type": kind, **dict(zip(keys, row, strict=True))}
        for i, (row, kind) in enumerate(zip(rows.tolist(), types, strict=True), start=1)
    ]
    return {"convention": convention, "dh": table}


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_fk_agrees_with_plain_numpy(convention: Any) -> None:
    rng = np.random.default_rng(0)
    rows = rng.uniform(-1, 1, (5, 4))
    types = ["revolute", "prismatic", "continuous", "fixed", "revolute"]
    arm = ik.Robot.from_dh(
        rows, convention, limits=np.tile([-1.0, 1.0], (5, 1)), joint_types=types, name="mixed"
    )
    assert (arm.name, arm.dof) == ("mixed", 4)
    assert arm.joint_names == ("q1", "q2", "q3", "q5")
    np.testing.assert_array_equal(arm.upper, [1, 1, np.inf, 1])
    q = arm.random_q((4, 5), seed=1)
    expected = numpy_fk.fk(as_file(rows, convention, types), q)
    np.testing.assert_allclose(arm.fk(q), expected, rtol=0, atol=1e-14)


def test_rows_may_be_dictionaries_with_degrees() -> None:
    arm = ik.Robot.from_dh(
        [
            {"a": 0, "alpha_deg": 90, "d": 0.3},
            {"a": 0.4, "alpha": 0.0, "d": 0, "theta_deg": -90},
        ]
    )
    same = ik.Robot.from_dh([[0, HALF, 0.3, 0], [0.4, 0, 0, -HALF]])
    np.testing.assert_array_equal(arm.fk([0.3, 0.4]), same.fk([0.3, 0.4]))
    assert arm.dh is not None
    assert arm.dh[1].theta == -HALF


def test_base_and_tool_are_applied() -> None:
    base, tool = np.eye(4), np.eye(4)
    base[:3, 3], tool[:3, 3] = [1, 2, 3], [0, 0, 0.25]
    arm = ik.Robot.from_dh(PLANAR, base=base, tool=tool)
    np.testing.assert_allclose(arm.fk([0, 0])[:3, 3], [2.5, 2, 3.25], atol=1e-15)


def test_arrays_of_any_kind_are_copied() -> None:
    rows = np.asfortranarray(np.array(PLANAR, dtype=np.float32))
    rows.flags.writeable = False
    tool = np.eye(4)
    arm = ik.Robot.from_dh(rows, tool=tool)
    tool[0, 3] = 9.0
    np.testing.assert_allclose(arm.with_base(np.eye(4)).fk([0, 0])[0, 3], 1.5)


NOT_RIGID = np.diag([1.0, 1.0, 2.0, 1.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rows": []}, r"`rows`: expected shape \(n, 4\), .*, got shape \(0,\)"),
        ({"rows": [[0, 0, 0]]}, r"`rows`: expected shape \(n, 4\), .*, got shape \(1, 3\)"),
        ({"rows": [[0, 0, np.nan, 0]]}, r"`rows\[0\]`: expected finite numbers, got \[0\.0, 0\.0"),
        ({"rows": [["x", 0, 0, 0]]}, "`rows`: expected an array of numbers"),
        ({"rows": [{"a": 0, "alpha": 0}]}, r"`rows\[0\]`: expected a key 'd', got keys"),
        ({"rows": [{"a": 0, "d": 0}]}, r"expected a key 'alpha' or 'alpha_deg', got keys \['a'"),
        (
            {"rows": [{"a": 0, "alpa": 0, "d": 0}]},
            r"unknown rows\[0\] key 'alpa'; did you mean 'alpha' or 'alpha_deg'\?",
        ),
        (
            {"rows": [{"a": 0, "alpha": 0, "alpha_deg": 0, "d": 0}]},
            r"`rows\[0\]`: expected one of the two, got 'alpha' and 'alpha_deg'",
        ),
        ({"rows": [{"a": "1", "alpha": 0, "d": 0}]}, r"`rows\[0\]\['a'\]`: expected a finite num"),
        ({"rows": [{"a": 0, "alpha": 0, "d": 0}, [0]]}, r"`rows\[1\]`: expected a dictionary"),
        ({"convention": "craig"}, "unknown convention 'craig'. Known: standard, modified"),
        ({"convention": "modifed"}, "unknown convention 'modifed'; did you mean 'modified'"),
        ({"joint_types": ["revolute", "spherical"]}, "unknown joint type 'spherical'"),
        ({"joint_types": ["revolute"]}, "`joint_types`: expected 2, one per row, got 1 entries"),
        ({"joint_types": "revolute"}, "`joint_types`: expected a sequence of strings"),
        ({"joint_types": ["continuous", "prismatic"]}, "got None, but row 1 is prismatic"),
        ({"joint_names": ["a", "b", "c"]}, "`joint_names`: expected 2, one per row, got 3"),
        ({"joint_names": ["a", "a"]}, "expected a unique name"),
        ({"joint_types": ["fixed", "fixed"]}, "at least one movable joint"),
        ({"limits": [-1, 1]}, r"`limits`: expected shape \(2, 2\), got shape \(2,\)"),
        ({"limits": [[-1, 1], [2, 1]]}, r"`limits\[1\]`: expected lower <= upper, got lower 2 > "),
        ({"limits": [[-1, 1], [np.nan, 1]]}, r"`limits\[1\]`: expected numbers"),
        ({"base": np.eye(3)}, r"`base`: expected .*\(4, 4\)"),
        ({"base": NOT_RIGID}, "`base`: expected .*rigid"),
        ({"tool": NOT_RIGID}, "`tool`: expected .*rigid"),
        ({"tool": np.full((4, 4), np.nan)}, "`tool`: expected"),
    ],
)
def test_faults_are_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ik.ArgumentError, match=message):
        ik.Robot.from_dh(**{"rows": PLANAR, **arguments})


DEGREES = {
    "alpha": ([[0.1, 90, 0.2, 0]], None, r"alpha of row 0 is 90 rad, more than a turn"),
    "theta": ([[0.1, 1.5, 0.2, 180]], None, r"theta of row 0 is 180 rad"),
    "limits": ([[0.1, 1.5, 0.2, 0]], [(-170, 170)], r"joint 'q1' turns from -170 to 170 rad"),
    "two": ([[0.1, 90, 0.2, 0]] * 2, None, r"\(and 1 more like it\): was it meant in degrees\?"),
}


@pytest.mark.parametrize("case", DEGREES)
def test_degrees_in_the_place_of_radians_are_noticed(case: str) -> None:
    rows, limits, words = DEGREES[case]
    with pytest.warns(ik.errors.RobotWarning, match=words):
        ik.Robot.from_dh(rows, limits=limits, name="an arm")


def test_angles_that_are_radians_bring_no_warning() -> None:
    # A turn and more, a joint of many turns, a slide of some metres.
    ik.Robot.from_dh([[0, 6.28, 0, -6.28]], limits=[(-6.2831853, 12.0)])
    ik.Robot.from_dh([[0, 1, 0, 0]], limits=[(-31.4159, 31.4159)])
    ik.Robot.from_dh([[0, 1, 0, 0]], limits=[(-100, 100)], joint_types=["prismatic"])


def test_degrees_in_files_are_noticed(tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    ik.Robot.from_dh([[0.3, 1.5, 0.2, 0]], limits=[(-1.25, 1.5)]).save(file)
    file.write_text(file.read_text().replace("-1.25", "-75.0"))
    with pytest.warns(
        ik.errors.RobotWarning, match=r"arm\.toml: joint 'q1' turns from -75 to 1\.5 rad"
    ):
        ik.Robot.load(file)
    text = urdf(["a", "b"], [joint("j", "a", "b", limit=(-90, 90))])
    with pytest.warns(ik.errors.RobotWarning, match=r"joint 'j' turns from -90 to 90 rad"):
        ik.Robot.from_urdf(text)
