"""The tuner: finds gains, goes on after a kill, refuses what is not its own."""

from __future__ import annotations

import dataclasses
import io

import numpy as np
import pytest
from typer.testing import CliRunner

import agrik_fast as ik
from agrik_fast.cli._app import app
from agrik_fast.cli._tune import reporting
from agrik_fast.errors import ArgumentError, GainFileError, UnknownNameError
from agrik_fast.solvers import gain_file
from agrik_fast.tuning import Report, Tuning, goals, tune
from agrik_fast.tuning import _search as tuning_module

ARM = ik.Robot.load("hydrolek")
QUICK = Tuning(goals=300, evaluations=400, runs=1, refinement=100)


class Killed(Exception):
    """Stands in for a kill between two generations."""


def kill_after(evaluations):
    def report(state):
        if state.evaluations >= evaluations:
            raise Killed

    return report


def test_a_short_search_betters_the_frozen_inverse():
    start = tuning_module.template(ARM, QUICK)
    test = goals.joint_uniform(ARM, 1000, 1)
    before = ARM.ik(test, solver=start, position_tolerance=1e-3).success.sum()
    content = tune(ARM, dataclasses.replace(QUICK, goals=600, evaluations=1200))
    assert content.success is not None
    assert content.success.solved >= 960 and content.success.solved > before
    again = ARM.ik(test, solver=content.make(), position_tolerance=1e-3)
    assert int(again.success.sum()) == content.success.solved


@pytest.mark.parametrize("solver", ["static-gain", "ik-pid"])
@pytest.mark.parametrize("method", ["pso", "cma"])
def test_other_solvers_and_methods(solver, method):
    content = tune(ARM, dataclasses.replace(QUICK, solver=solver, method=method))
    assert content.success is not None and content.success.solved >= 900
    assert content.solver == solver and content.training.origin.startswith(method)


@pytest.mark.parametrize(("shape", "numbers"), [("input", 15), ("diagonal", 24), ("full", 90)])
def test_shapes_have_so_many_parameters(shape, numbers):
    quick = dataclasses.replace(QUICK, shape=shape, goals=20, evaluations=40, refinement=30)
    content = tune(ARM, quick)
    assert content.training.origin == f"pso, {numbers} parameters"
    gains = content.make()  # a spectral radius of 1 or more would warn
    assert isinstance(gains, ik.solvers.StateSpace) and gains.spectral_radius < 1


def test_more_searching_is_never_chosen_where_it_does_worse():
    solved = []
    for refinement in (0, 200):
        content = tune(ARM, dataclasses.replace(QUICK, refinement=refinement))
        training = content.training
        assert training.validation_goals == 10_000
        streams = {training.seed, training.validation_seed, content.success.seed}
        assert len(streams) == 3
        solved.append(training.validation_solved)
        again = ARM.ik(
            goals.joint_uniform(ARM, 10_000, training.validation_seed),
            solver=dataclasses.replace(content.make(), max_iterations=400),
            position_tolerance=1e-3,
        )
        assert int(again.success.sum()) == training.validation_solved
    assert solved[1] >= solved[0]


@pytest.mark.parametrize("robot", ["tomato", "redundant7"])
def test_other_robots_can_be_tuned(robot):
    arm = ik.Robot.load(robot)
    content = tune(arm, dataclasses.replace(QUICK, goals=100, start="middle"))
    assert content.robot == robot
    content.make()


# In the first search, in the second one, in the refinement, in the search of the wider
# shape, in its refinement.
@pytest.mark.parametrize(
    ("method", "kill"), [("pso", 200), ("cma", 600), ("pso", 900), ("pso", 1250), ("cma", 1400)]
)
def test_a_killed_run_goes_on_to_the_same_gains(tmp_path, monkeypatch, method, kill):
    monkeypatch.setattr(tuning_module, "PERIOD_S", -1.0)
    tuning = dataclasses.replace(QUICK, goals=50, method=method, runs=2, shape="diagonal")
    whole = tune(ARM, tuning)
    checkpoint = tmp_path / "run.npz"
    with pytest.raises(Killed):
        tune(ARM, tuning, checkpoint=checkpoint, report=kill_after(kill))
    assert checkpoint.exists()
    resumed = tune(ARM, tuning, checkpoint=checkpoint, resume=True)
    assert resumed == whole
    assert not checkpoint.exists()


def test_checkpoints_of_other_runs_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(tuning_module, "PERIOD_S", -1.0)
    tuning = dataclasses.replace(QUICK, goals=50)
    checkpoint = tmp_path / "run.npz"
    with pytest.raises(Killed):
        tune(ARM, tuning, checkpoint=checkpoint, report=kill_after(100))
    stored = checkpoint.read_bytes()
    with pytest.raises(GainFileError, match="did not end"):
        tune(ARM, tuning, checkpoint=checkpoint)
    with pytest.raises(GainFileError, match="another run: seed 0, not 3"):
        tune(ARM, dataclasses.replace(tuning, seed=3), checkpoint=checkpoint, resume=True)
    with pytest.raises(GainFileError, match="another run: robot"):
        tune(ik.Robot.load("ur5"), tuning, checkpoint=checkpoint, resume=True)
    assert checkpoint.read_bytes() == stored  # nothing is lost
    checkpoint.write_bytes(stored[: len(stored) // 2])
    with pytest.raises(GainFileError, match="no whole checkpoint"):
        tune(ARM, tuning, checkpoint=checkpoint, resume=True)
    with pytest.raises(GainFileError, match="no such checkpoint"):
        tune(ARM, tuning, checkpoint=tmp_path / "none.npz", resume=True)


def test_usual_settings_belong_to_the_solver():
    assert Tuning.usual("state-space") == Tuning()
    pid = Tuning.usual("ik-pid", goals=50)
    assert (pid.solver, pid.method, pid.goals) == ("ik-pid", "cma", 50)
    assert pid.evaluations < Tuning().evaluations


def test_words_are_checked():
    with pytest.raises(UnknownNameError, match="unknown method 'psso'"):
        Tuning(method="psso")
    with pytest.raises(UnknownNameError, match="unknown shape"):
        Tuning(shape="round")
    with pytest.raises(ArgumentError, match="refinement"):
        Tuning(refinement=-1)


def test_the_command_writes_a_gain_file(tmp_path):
    output = tmp_path / "gains.toml"
    arguments = ["tune", "hydrolek", "-o", str(output)]
    arguments += ["--goals", "100", "--evaluations", "80", "--refinement", "50"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert gain_file.read(output).robot == "hydrolek"
    assert [path.name for path in tmp_path.iterdir()] == ["gains.toml"]
    again = CliRunner().invoke(app, arguments)
    assert again.exit_code == 2 and "exists already" in again.output


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()])
def test_progress_is_shown(stream):
    with reporting(stream) as report:
        # A run that goes on from a checkpoint begins in the middle.
        report(Report(evaluations=1000, wanted=4840, cost=0.5))
        report(Report(evaluations=4841, wanted=4841, cost=0.25))
    text = stream.getvalue()
    assert "gain sets, cost 0.2500" in text
    if stream.isatty():
        assert "\u2501" in text and "4841/4841" in text  # rich's bar
    else:
        assert text.splitlines()[0] == "1000 of 4840 gain sets, cost 0.5000"
        assert "4841 of 4841" in text


def test_streams_are_those_of_the_specification():
    u = goals.splitmix64(1, 6)
    wanted = [0.5665615751722809, 0.7457817572627011, 0.9710027535867962]
    np.testing.assert_allclose(u[:3], wanted, rtol=0, atol=1e-16)
    points = goals.volume_uniform(ARM, 200, 2, draws=20_000)
    assert points.shape == (200, 3) and len(np.unique(points, axis=0)) == 200


def test_gains_for_poses():
    quick = dataclasses.replace(
        QUICK, solver="static-gain", method="cma", task="pose", goals=100, evaluations=600
    )
    content = tune(ARM, quick)
    assert content.training.origin == "cma, 36 parameters"
    assert content.success is not None
    assert content.success.tolerance_rad == quick.orientation_tolerance == 0.01
    gains = content.make()
    assert np.shape(gains.K) == (6, 6)
    assert gains.rotation_length_m == pytest.approx(0.3 * ARM.reach_radius)
    poses = goals.joint_uniform_poses(ARM, 1000, 1)
    tolerances = {"position_tolerance": 1e-3, "orientation_tolerance": 0.01}
    again = ARM.ik(poses, solver=gains, **tolerances)
    assert int(again.success.sum()) == content.success.solved
    start = ARM.ik(poses, solver=tuning_module.template(ARM, quick), **tolerances)
    assert content.success.solved > start.success.sum() + 50
    other = tuning_module.template(ARM, dataclasses.replace(quick, rotation_length=0.1))
    assert other.rotation_length_m == 0.1
    # Other runs' checkpoints are another task's.
    assert quick.identity(ARM) != dataclasses.replace(quick, task="position").identity(ARM)


def test_what_belongs_to_poses_is_refused_without_them():
    with pytest.raises(ArgumentError, match="rotation_length"):
        Tuning(rotation_length=0.1)
    with pytest.raises(ArgumentError, match="rotation_length"):
        Tuning(solver="ik-pid", task="pose", rotation_length=0.1)
    with pytest.raises(UnknownNameError, match="unknown task"):
        Tuning(task="poses")
    for wrong in (0.0, 4.0, float("nan")):
        with pytest.raises(ArgumentError, match="orientation_tolerance"):
            Tuning(task="pose", orientation_tolerance=wrong)


def test_the_command_tunes_for_poses(tmp_path):
    output = tmp_path / "pose.toml"
    arguments = ["tune", "hydrolek", "-o", str(output), "--task", "pose", "--solver"]
    arguments += ["static-gain", "--goals", "50", "--evaluations", "40", "--runs", "1"]
    arguments += ["--refinement", "0", "--tol-rad", "0.02", "--rotation-length", "0.2"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    content = gain_file.read(output)
    assert content.success.tolerance_rad == 0.02 and content.units.rotation_length_m == 0.2
