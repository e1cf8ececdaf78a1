"""Robots, paths, plans, trajectories and solvers as dictionaries, tables and notebook cells."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import motion


@pytest.fixture(scope="module")
def arm() -> ik.Robot:
    return ik.Robot.load("panda")


def ways(arm: ik.Robot) -> dict[str, Any]:
    q = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    line = arm.line(q, arm.fk(q)[:3, 3] + [0.0, 0.1, 0.0])
    return {
        "line": line,
        "corners": arm.joint_path([q, q + 0.1, q], blend=0.2),
        "trajectory": motion.time_law(arm, line),
        "follow": arm.follow(arm.fk([q, q + 0.01, q + 0.02]), q),
        "plan": motion.plan(arm, q, q + 0.2, ik.Scene([])),
    }


def postures_of(way: Any) -> np.ndarray:
    return np.asarray(way.positions if isinstance(way, motion.Trajectory) else way.q)


@pytest.mark.parametrize("name", ["line", "corners", "trajectory", "follow", "plan"])
def test_ways_are_rows_of_postures_and_tables(arm: ik.Robot, name: str) -> None:
    way = ways(arm)[name]
    q = postures_of(way)
    assert len(way) == len(q) > 1
    assert np.array_equal(way[-1], q[-1]) and np.array_equal(way[:2], q[:2])
    assert np.array_equal(np.array(list(way)), q)
    frame, table = way.to_pandas(), way.to_arrow()
    assert len(frame) == table.num_rows == len(q)
    assert list(frame.columns) == table.column_names
    first = [column for column in frame.columns if column != "time_s"][: arm.dof]
    assert np.array_equal(frame[first].to_numpy(), q)
    assert any(np.array_equal(value, q) for value in way.to_dict().values() if value is not None)
    html = way._repr_html_()
    assert html.startswith("<table><caption>") and html.count("<tr>") >= min(len(q), 10)
    for again in (pickle.loads(pickle.dumps(way)), copy.copy(way), copy.deepcopy(way)):
        assert repr(again) == repr(way) and np.array_equal(postures_of(again), q)


def test_a_plan_without_a_path_is_an_empty_table(arm: ik.Robot) -> None:
    far = motion.plan(arm, arm.home, np.zeros((0, 7)), ik.Scene([]))
    assert len(far) == 0 and not list(far) and len(far.to_pandas()) == 0
    assert "<table>" in far._repr_html_()


def test_a_robot_is_a_table_of_its_joints(arm: ik.Robot) -> None:
    frame = arm.to_pandas()
    assert frame["joint"].tolist() == list(arm.joint_names)
    assert np.array_equal(
        frame[["lower", "upper", "home"]].to_numpy().T, [arm.lower, arm.upper, arm.home]
    )
    assert arm.to_arrow().num_rows == arm.dof and "panda_joint7" in arm._repr_html_()
    assert arm.to_dict()["name"] == "panda" and len(arm.to_dict()["dh"]) >= arm.dof


def test_a_solver_says_its_last_answer(arm: ik.Robot) -> None:
    q = arm.random_q(2, seed=1)
    solver = arm.solver()
    solver.solve(arm.fk(q[0]), q[1])
    last = solver.result
    assert isinstance(last, ik.IkResult) and last.success and np.array_equal(last.q, solver.q)
    assert last.position_error == solver.position_error and last.iterations == solver.iterations
    assert repr(solver).startswith("TargetSolver(panda, IkResult(1 target: 1 converged, q=[")
    assert repr(arm.solver(max_change=0.1)) == "TargetSolver(panda, a loop, nothing asked yet)"
    assert solver.to_dict()["status"] == ik.Status.CONVERGED
    assert len(solver.to_pandas()) == solver.to_arrow().num_rows == 1
    assert solver._repr_html_().startswith("<table>")
    kept = solver.result
    solver.solve(arm.fk(q[1]), q[0])
    assert np.array_equal(kept.q, last.q) and not np.array_equal(kept.q, solver.q)


def test_the_branches_of_one_target_say_where_they_are() -> None:
    arm = ik.Robot.load("ur5")
    with pytest.raises(TypeError, match=r"no length; its branches are q\[valid\]"):
        len(arm.ik_all(arm.fk(arm.home + 0.3)))


def test_decisions_of_a_harvest_are_a_table() -> None:
    found = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1", "C3"])
    frame = found.to_pandas()
    assert frame["target"].tolist() == ["C1", "C3"] and len(frame) == len(found)
    assert np.array_equal(frame[[f"q_{k}" for k in range(7)]].to_numpy(), found.q)
    assert found.to_dict()["names"] == found.names and "<table>" in found._repr_html_()
