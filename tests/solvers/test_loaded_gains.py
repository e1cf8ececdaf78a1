"""What loading gains changes, and that it says so."""

import dataclasses
import warnings
from pathlib import Path

import pytest

import agrik_fast as ik
from agrik_fast.errors import SettingsWarning
from agrik_fast.solvers import StateSpace, gain_file, load_gains

NAME = "hydrolek_k15_cma"


def test_loading_says_which_settings_it_changes() -> None:
    with pytest.warns(SettingsWarning) as caught:
        StateSpace.load(NAME)
    message = str(caught[0].message)
    for words in (
        "max_restarts 0 (usually 20)",
        "start 'zero' (usually 'sampled')",
        "as_tuned=False",
    ):
        assert words in message
    assert caught[0].filename == __file__


def test_the_usual_settings_solve_more() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tuned = load_gains(NAME, StateSpace, as_tuned=True)
        usual = load_gains(NAME, StateSpace, as_tuned=False)
    plain = StateSpace(**{name: getattr(tuned, name) for name in ("A", "B", "C")})
    for name in ("max_iterations", "max_restarts", "start"):
        assert getattr(usual, name) == getattr(plain, name)
    arm = ik.Robot.load("hydrolek")
    goals = arm.fk(arm.random_q(500, seed=1))[:, :3, 3]
    few, many = (arm.ik(goals, solver=each).success.sum() for each in (tuned, usual))
    assert few < many
    assert many >= 499


def test_as_tuned_is_a_truth_value() -> None:
    with pytest.raises(ik.ArgumentError, match="`as_tuned`"):
        load_gains(NAME, StateSpace, as_tuned="yes")  # type: ignore[arg-type]


def test_any_text_is_read_back(tmp_path: Path) -> None:
    content = gain_file.read(NAME)
    for suffix in (".toml", ".json"):
        path = tmp_path / f"gains{suffix}"
        odd = content.model_copy(update={"description": 'tuned \U0001f353 "twice"\n\\ \x7f'})
        gain_file.write(path, odd)
        assert gain_file.read(path) == odd
        assert dataclasses.is_dataclass(gain_file.load(path, StateSpace, as_tuned=True))
