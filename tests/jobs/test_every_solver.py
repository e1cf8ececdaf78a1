"""A file solved by every solver into every kind of result file."""

from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast._names import solver_names
from agrik_fast.io import read_results
from agrik_fast.io._results import RESULT_SUFFIXES
from agrik_fast.jobs import SolveRequest, solve_file
from cli_runner import run_command

ROWS = 40
# These are for full poses of an arm that has a closed form; the others reach any point.
BY_BRANCHES = ("closed_form", "auto")


def targets_of(arm: ik.Robot, poses: bool) -> np.ndarray:
    """Reachable targets with one that is out of reach and one that is no number."""
    goals = arm.fk(arm.random_q(ROWS, seed=6))
    goals[7, :3, 3] = 20.0
    goals[11, 0, 3] = np.nan
    return goals if poses else goals[:, :3, 3]


@pytest.mark.parametrize("suffix", RESULT_SUFFIXES)
@pytest.mark.parametrize("solver", solver_names())
def test_every_solver_writes_every_kind(tmp_path: Path, solver: str, suffix: str) -> None:
    poses = solver in BY_BRANCHES
    arm = ik.Robot.load("puma560" if poses else "hydrolek")
    goals = targets_of(arm, poses)
    np.save(tmp_path / "goals.npy", goals)
    output = tmp_path / f"out{suffix}"
    request = SolveRequest(arm.name, tmp_path / "goals.npy", output, solver=solver)
    summary = solve_file(request)
    _, rows = read_results(output)
    whole = arm.ik(goals, solver=solver)
    np.testing.assert_array_equal(rows.status, whole.status)
    np.testing.assert_array_equal(rows.q, whole.q)
    np.testing.assert_array_equal(rows.success, whole.success)
    assert summary.rows == ROWS
    assert summary.solved == whole.success.sum() >= ROWS / 2
    assert rows.status[7] == ik.Status.OUT_OF_REACH
    assert rows.status[11] == ik.Status.BAD_INPUT


@pytest.fixture
def points(tmp_path: Path) -> Path:
    """Some points just out of the HydroLek's reach, where its feedback laws come to rest."""
    arm = ik.Robot.load("hydrolek")
    reached = arm.fk(arm.random_q(5000, seed=3))[:, :3, 3]
    farthest = reached[np.argsort(np.linalg.norm(reached, axis=1))[-20:]]
    np.save(tmp_path / "points.npy", 1.05 * farthest)
    return tmp_path / "points.npy"


@pytest.mark.parametrize("suffix", RESULT_SUFFIXES)
def test_a_search_that_stalls_is_told_in_every_kind(
    tmp_path: Path, points: Path, suffix: str
) -> None:
    output = tmp_path / f"out{suffix}"
    summary = solve_file(SolveRequest("hydrolek", points, output, solver="state-space"))
    _, rows = read_results(output)
    assert summary.counts[ik.Status.STALLED] > 0
    for status in ik.Status:
        assert np.count_nonzero(rows.status == status) == summary.counts[status]


def test_the_status_columns_are_those_that_occur(tmp_path: Path, points: Path) -> None:
    words = ("solve", "hydrolek", points, "-o", tmp_path / "r.csv", "--solver", "state-space")
    result = run_command(*words)
    assert result.exit_code == 0, result.output
    _, rows = read_results(tmp_path / "r.csv")
    stalled = int(np.count_nonzero(rows.status == ik.Status.STALLED))
    assert stalled > 0
    heading, row, _ = result.stdout.splitlines()
    at = heading.index("stalled")
    assert row[at : at + len("stalled")].split() == [str(stalled)]
    assert "non finite" not in heading
