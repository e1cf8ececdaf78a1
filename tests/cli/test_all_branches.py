"""`agrik-fast solve --all-branches`: a row for each branch within the limits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import agrik_fast as ik
from agrik_fast.cli._app import app
from agrik_fast.io._results import RESULT_SUFFIXES, read_results


@pytest.mark.parametrize("suffix", RESULT_SUFFIXES)
def test_one_row_a_branch(tmp_path: Path, suffix: str) -> None:
    arm = ik.Robot.load("ur5")
    poses = arm.fk(arm.random_q(12, seed=1))
    poses[3, :3, 3] += 20.0
    targets, results = tmp_path / "targets.npy", tmp_path / f"results{suffix}"
    np.save(targets, poses)
    done = CliRunner().invoke(
        app, ["solve", "ur5", str(targets), "-o", str(results), "--all-branches"]
    )
    assert done.exit_code == 0, done.output
    _, rows = read_results(results)
    found = arm.ik_all(poses)
    each = np.maximum(found.valid.sum(axis=1), 1)
    assert (rows.ids.astype(int) == np.repeat(np.arange(1, 13), each)).all()
    assert rows.success.sum() == found.valid.sum()
    assert (rows.q[rows.success] == found.q[found.valid]).all()
    assert rows.position_error[rows.success].max() < 1e-9
    (lost,) = np.nonzero(~rows.success)[0]
    assert rows.status[lost] == ik.Status.OUT_OF_REACH
    assert (arm.lower <= rows.q[lost]).all()


def test_bad_rows_and_refusals(tmp_path: Path) -> None:
    targets = tmp_path / "targets.csv"
    targets.write_text(
        "x_m,y_m,z_m,qx,qy,qz,qw\n0.3,0.2,0.4,0,0,0,1\n0.3,nan,0.4,0,0,0,1\n9,0.2,0.4,0,0,0,1\n"
    )

    def run(name: str, out: str, *more: str) -> tuple[int, str]:
        given = ["solve", name, str(targets), "-o", str(tmp_path / out), "--all-branches", *more]
        done = CliRunner().invoke(app, given)
        assert "Traceback" not in done.output
        return done.exit_code, done.output

    code, text = run("ur5", "ur5.csv")
    assert code == 0, text
    _, rows = read_results(tmp_path / "ur5.csv")
    status = {int(i): set(rows.status[rows.ids.astype(int) == int(i)]) for i in (1, 2, 3)}
    wanted = {1: {ik.Status.CONVERGED}, 2: {ik.Status.BAD_INPUT}, 3: {ik.Status.OUT_OF_REACH}}
    assert status == wanted
    assert (rows.ids.astype(int) == 1).sum() == 8
    # Nothing here solves an arm with slides between its joints: its rows say so.
    code, _ = run("strawberry", "strawberry.csv")
    _, rows = read_results(tmp_path / "strawberry.csv")
    assert (code, set(rows.status)) == (0, {ik.Status.UNSUPPORTED, ik.Status.BAD_INPUT})
    code, text = run("ur5", "ur5.csv")
    assert code == 2
    assert "exists already" in text


def test_poses_for_too_few_joints_keep_the_nearest_posture(tmp_path: Path) -> None:
    rows = [[0.0, 0.3, 0.0, 1.57], [0.4, 0, 0, 0], [0.3, 0, 0, 0.2], [0.1, 0.05, 0.1, 0.3]]
    arm = ik.Robot.from_dh(rows, name="four")
    arm.save(tmp_path / "four.toml")
    poses = arm.fk(arm.random_q(4, seed=2))
    poses[1, :3, 3] += [0.02, -0.01, 0.03]
    targets, results = tmp_path / "targets.npy", tmp_path / "results.csv"
    np.save(targets, poses)
    given = ["solve", str(tmp_path / "four.toml"), str(targets), "-o", str(results)]
    done = CliRunner().invoke(app, [*given, "--all-branches"])
    assert done.exit_code == 0, done.output
    _, written = read_results(results)
    found = arm.ik_all(poses)
    missed = written.ids.astype(int) == 2
    assert missed.sum() == 1
    assert written.success[~missed].all()
    assert (written.status[missed] == ik.Status.OVERDETERMINED).all()
    np.testing.assert_allclose(written.q[missed][0], found.q[1, 0], atol=1e-12)
    assert written.position_error[missed][0] == pytest.approx(float(found.position_error[1]))
    assert written.orientation_error[missed][0] == pytest.approx(float(found.orientation_error[1]))
