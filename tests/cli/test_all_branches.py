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
