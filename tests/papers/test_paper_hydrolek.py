"""The HydroLek paper's tables: what they must show, and that all files appear."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from agrik_fast.papers import hydrolek
from agrik_fast.robot import Robot
from agrik_fast.tuning import goals

ARM = Robot.load("hydrolek")


def test_the_published_planar_angles_miss_by_two_hundredths():
    assert hydrolek.planar_claim() == pytest.approx(0.01704, abs=1e-5)


def test_table_2_has_every_method_and_its_ratios():
    rows = hydrolek.comparison(ARM, goals.joint_uniform(ARM, 60, 1), "zero")
    assert len(rows) == 4 * len(hydrolek.methods())
    by_name = {(row[0], row[1]): row for row in rows}
    reference = by_name["pseudo-inverse, closed form", 1e-3]
    assert reference[8] == 1.0 and reference[11] == 1.0
    state = by_name["state space, 90 (PSO)", 1e-3]
    assert state[11] == pytest.approx(0.64, abs=0.001)  # what the paper's ratio is
    assert all(row[3] == reference[3] for row in rows)
    assert by_name["IK-PID, published", 1e-4][10] is None


def test_success_counts_stand_beside_the_published_ones():
    rows = {(row[0], row[1]): row for row in hydrolek.success_counts(ARM)}
    wanted = {
        "IK-PID, Kp 0.02": 944,
        "IK-PID, tuned": 993,
        "state space, trial": 739,
        "state space, optimised": 990,
    }
    for name, count in wanted.items():
        row = rows[name, "zero"]
        assert abs(row[3] - count) <= 3
        assert row[6] < row[3] + 10  # the volume is harder than the joints


def test_only_one_reading_of_the_units_orders_the_gains():
    rows = {(row[0], row[1]): row[2:] for row in hydrolek.units(ARM)}
    hot, cold, tuned = rows["deg/mm", "zero"]
    assert hot < cold < tuned
    for reading in ("deg/cm", "rad/m"):
        hot, cold, _ = rows[reading, "zero"]
        assert hot > cold


def test_singular_start_statuses():
    rows = {(row[0], row[1]): row for row in hydrolek.singular_start()}
    for name in ("transpose", "pseudo-inverse", "damped, 1 m", "IK-PID, 5 degrees a unit"):
        assert rows[name, "stretched"][2] == "stalled"
    for name, solved in (("claim", 542), ("set", 837), ("full", 844)):
        row = rows[f"state space, {name}", "stretched"]
        assert row[2] == "converged"
        assert abs(row[6] - solved) <= 3
    assert rows["transpose", "nudged"][2] == "converged"


def test_traces_end_where_the_solver_ends():
    goal = hydrolek.displaced_goal(ARM, "zero")
    np.testing.assert_allclose(goal, [0.97355194196, 0.2, 0.08382483348], atol=1e-9)
    from agrik_fast.solvers import StateSpace

    solver = StateSpace.load("hydrolek_full90_pso", as_tuned=True)
    trace = hydrolek.error_trace(ARM, solver, goal, "zero", 100, 1e-3)
    assert trace[0] == pytest.approx(np.linalg.norm([0.1, 0.5, 0.2]))
    assert trace[-1] < 1e-3 and len(trace) < 60


@pytest.mark.timeout(300)
def test_everything_is_written(tmp_path):
    files = hydrolek.reproduce(tmp_path)
    names = {path.name for path in files}
    assert names == {path.name for path in tmp_path.iterdir()}
    for figure in ("figure4", "figure5", "figure6", "figure7", "units"):
        assert {f"{figure}.png", f"{figure}.svg"} <= names
    with (tmp_path / "table2_zero.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    svd = [row for row in rows if row["method"] == "pseudo-inverse, SVD"]
    assert all(float(row["ratio_to_svd"]) == 1 for row in svd)
