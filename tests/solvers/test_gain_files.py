"""Gain files: bundled sets, both formats, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.errors import GainFileError, UnknownNameError
from agrik_fast.solvers import IkPid, StateSpace, gain_file


@pytest.mark.parametrize("name", gain_file.bundled())
def test_bundled_sets_are_whole(name):
    content = gain_file.read(name)
    solver = content.make()
    assert solver.robot == content.robot and solver.start == content.start == "zero"
    assert content.training.origin
    if content.robot == "hydrolek" and content.solver == "state-space":
        assert content.frame.name == "paper" and content.success is not None


@pytest.mark.parametrize("suffix", [".toml", ".json"])
def test_files_read_back_as_written(tmp_path, suffix):
    content = gain_file.read("hydrolek_full90_pso")
    path = tmp_path / f"gains{suffix}"
    gain_file.write(path, content)
    assert gain_file.read(path) == content
    assert list(tmp_path.iterdir()) == [path]


def test_the_kind_of_solver_is_checked():
    with pytest.raises(GainFileError, match="gains for 'ik-pid', not for 'state-space'"):
        StateSpace.load("hydrolek_pid_published_tuned", as_tuned=True)
    assert IkPid.load("hydrolek_pid_published_tuned", as_tuned=True).kp == 0.012


def test_an_unknown_set_names_the_nearest():
    with pytest.raises(UnknownNameError, match="hydrolek_k15_cma"):
        StateSpace.load("hydrolek_k15_cmaes", as_tuned=True)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"colour": 1}, "colour: extra inputs are not permitted"),
        ({"start": "anywhere"}, "start: input should be"),
        ({"units": {"length": "inch", "angle": "deg"}}, "units.length"),
        ({"gains": {"K": [[1.0, 0.0, 0.0]]}}, "expected A, B, C, got K"),
        ({"gains": {"A": [["x"]], "B": [[1.0]], "C": [[1.0]]}}, "gains.A"),
        ({"frame": {"rotation": np.ones((3, 3)).tolist()}}, "a rotation matrix"),
    ],
)
def test_files_with_faults_are_refused(tmp_path, change, message):
    content = gain_file.read("hydrolek_k15_cma").model_dump(exclude_none=True)
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(content | change))
    with pytest.raises(GainFileError) as caught:
        gain_file.read(path)
    assert message in str(caught.value) and "bad.json" in str(caught.value)


@pytest.mark.parametrize(
    ("table", "change", "message"),
    [
        ("success", {"solved": 1001}, "success: value error, solved: 1001 of 1000 goals"),
        ("success", {"solved": -1}, "success.solved: input should be greater than or equal to 0"),
        ("success", {"goals": 0}, "success.goals"),
        ("success", {"tolerance_m": 0.0}, "success.tolerance_m"),
        ("success", {"max_iterations": 0}, "success.max_iterations"),
        ("training", {"solved": 3001}, "training: value error, solved: 3001 of 3000 goals"),
        (
            "training",
            {"validation_goals": 10, "validation_solved": 11},
            "training: value error, validation_solved: 11 of 10 goals",
        ),
    ],
)
def test_numbers_that_cannot_be_are_refused(tmp_path, table, change, message):
    content = gain_file.read("hydrolek_k15_cma").model_dump(exclude_none=True)
    content[table] |= change
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(content))
    with pytest.raises(GainFileError) as caught:
        gain_file.read(path)
    assert message in str(caught.value)


def test_an_unstable_set_warns_once(tmp_path):
    content = gain_file.read("hydrolek_k15_cma").model_dump(exclude_none=True)
    content["gains"]["A"] = (1.5 * np.eye(6)).tolist()
    path = tmp_path / "unstable.json"
    path.write_text(json.dumps(content))
    with pytest.warns(UserWarning, match=r"spectral radius 1\.500") as caught:
        StateSpace.load(path, as_tuned=True)
    assert len(caught) == 1


def test_a_list_is_no_gain_file(tmp_path):
    path = tmp_path / "list.json"
    path.write_text("[1, 2]")
    with pytest.raises(GainFileError, match=r"list\.json: the whole: input should be"):
        gain_file.read(path)


def test_a_named_frame_is_the_robots():
    robot = ik.Robot.load("hydrolek")
    for name in gain_file.bundled():
        content = gain_file.read(name)
        if content.robot == "hydrolek" and content.frame.name != "base":
            turn = robot.frames[content.frame.name][:3, :3]
            np.testing.assert_array_equal(turn, content.frame.rotation)


def test_text_that_is_no_toml_is_refused(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("= 3")
    with pytest.raises(GainFileError, match=r"bad\.toml: not a TOML file: .*line 1"):
        gain_file.read(path)
