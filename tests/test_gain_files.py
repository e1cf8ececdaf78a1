"""Gain files: bundled sets, both formats, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from agrik_fast import gain_file
from agrik_fast.errors import GainFileError, UnknownNameError
from agrik_fast.solvers import IkPid, StateSpace


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
        StateSpace.load("hydrolek_pid_published_tuned")
    assert IkPid.load("hydrolek_pid_published_tuned").kp == 0.012


def test_an_unknown_set_names_the_nearest():
    with pytest.raises(UnknownNameError, match="hydrolek_k15_cma"):
        StateSpace.load("hydrolek_k15_cmaes")


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


def test_text_that_is_no_toml_is_refused(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("= 3")
    with pytest.raises(GainFileError, match="cannot be read"):
        gain_file.read(path)
