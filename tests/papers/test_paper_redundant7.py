"""The paper of redundant7: kinematics, angles, and what `agrik-fast paper redundant7` writes."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import euler
from agrik_fast.errors import ArgumentError
from agrik_fast.papers import redundant7
from cli_runner import one_line, run_command


@pytest.fixture(scope="module")
def reference(repo_root: Path) -> Any:
    return json.loads((repo_root / "tests/data/redundant7/reference.json").read_text())


def test_kinematics_and_angles(reference: Any) -> None:
    arm = redundant7.arm()
    for case in reference["fk"]:
        pose = arm.fk(case["q"])
        expected = np.array(case["T"])
        expected[:, 3] /= 1000
        np.testing.assert_allclose(pose[:3], expected, rtol=1e-12, atol=1e-12)
        angles, gimbal = euler.zyz_from_pose(pose)
        np.testing.assert_allclose(angles, case["zyz"], rtol=0, atol=1e-12)
        assert not gimbal
        np.testing.assert_allclose(euler.pose_from_zyz(pose[:3, 3], angles), pose, atol=1e-14)


def test_the_published_vector_fits_other_lengths(reference: Any) -> None:
    for robot, key in ((redundant7.arm(), "table"), (redundant7.fitted_arm(), "fit")):
        pose = robot.fk(redundant7.PUBLISHED_Q)
        expected = reference["published"][key]
        np.testing.assert_allclose(1000 * pose[:3, 3], expected["p"], atol=1e-9)
        np.testing.assert_allclose(euler.zyz_from_pose(pose).angles, expected["zyz"], atol=1e-12)


def test_known_solutions_and_the_elbow(reference: Any) -> None:
    arm, target = redundant7.arm(), redundant7.target()
    q = np.array(reference["valid_solutions_table_I"])
    np.testing.assert_allclose(arm.fk(q), np.broadcast_to(target, (len(q), 4, 4)), atol=1e-12)
    assert redundant7.cost(arm, q, target).max() < 1e-8
    found = arm.ik(np.broadcast_to(target, (50, 4, 4)), solver="de")
    assert found.success.all()
    np.testing.assert_allclose(np.abs(found.q[:, 3]), reference["q4_abs_required"], atol=1e-5)


def test_gimbal_and_wrapping() -> None:
    for beta, alpha in ((0.0, 0.7), (np.pi, 0.7)):
        rotation = euler.rotation_from_zyz([alpha, beta, 0.0])
        # Exactly singular: the sine of pi is not quite zero.
        rotation[2, :2] = 0
        angles, gimbal = euler.zyz_from_pose(rotation)
        assert gimbal
        np.testing.assert_allclose(angles, [alpha, beta, 0], atol=1e-15)
    difference = euler.zyz_differences([3.0, 0.1, -3.0], [-3.0, 0.3, 3.0])
    np.testing.assert_allclose(difference, [6 - 2 * np.pi, -0.2, 2 * np.pi - 6])
    for wrong in (np.zeros(3), np.zeros((2, 3))):
        with pytest.raises(ArgumentError, match="`poses`: expected shape"):
            euler.zyz_from_pose(wrong)
    with pytest.raises(ArgumentError, match="`zyz`: expected shape"):
        euler.rotation_from_zyz([1.0, 2.0])


def test_a_gimbal_target_is_solved_by_both_measures() -> None:
    arm = redundant7.arm()
    q = np.array([0.4, 0.9, 0.0, -1.5, 0.0, 0.6, 0.3])  # all in one plane: beta is 0
    assert euler.zyz_from_pose(arm.fk(q)).gimbal
    poses = np.broadcast_to(arm.fk(q), (20, 4, 4))
    for solver in (ik.solvers.DifferentialEvolution(), ik.solvers.DifferentialEvolution.paper()):
        coarse = arm.ik(poses, solver=solver, **redundant7.TOLERANCE)
        assert coarse.success.mean() >= 0.3


def rows(file: Path) -> dict[str, list[str]]:
    with file.open(encoding="utf-8") as lines:
        return {row[0]: row[1:] for row in csv.reader(lines)}


def test_all_tables_and_figures(tmp_path: Path) -> None:
    said: list[str] = []
    files = redundant7.reproduce(tmp_path / "new", repeats=60, report=said.append)
    assert len(said) == 7
    names = {file.name for file in files}
    tables = ("lengths", "single_point", "repeated", "ablation", "comparison")
    assert names >= {*(f"{name}.csv" for name in tables), "report.md"}
    figures = ("figure3", "figure4", "histogram", "postures", "scalability", "jobs")
    assert names >= {"scalability.csv", "spray.csv", "topping.csv"}
    assert names >= {f"{name}{suffix}" for name in figures for suffix in (".png", ".svg")}
    assert all(file.stat().st_size > 100 for file in files)
    lengths = rows(tmp_path / "new/lengths.csv")
    assert lengths["Table I"][0] == "312.158"
    single = rows(tmp_path / "new/single_point.csv")
    assert single["position by Table I [mm]"] == [
        "312.1582, 385.3897, 426.9383",
        "334.0000, 471.0000, 539.0000",
    ]
    assert single["ZYZ angles by Table I [rad]"][1] == "1.5708, 0.7854, 0.5236"
    published, ours = map(float, single["fitness of these joint values"])
    assert published > 100 and ours < 1e-5
    ours_q = np.array([float(x) for x in single["joint values [rad]"][1].split(", ")])
    off = redundant7.arm().fk(ours_q)[:3, 3] - redundant7.POSITION
    assert np.abs(off).max() < 1e-4  # four places
    with (tmp_path / "new/scalability.csv").open(encoding="utf-8") as lines:
        scaled = {
            (int(row["dof"]), row["generations"]): float(row["success_percent"])
            for row in csv.DictReader(lines)
        }
    assert len(scaled) == 20
    # 200 generations are enough for 7 joints and for none with 20; 1,600 for all.
    early = [scaled[dof, "200"] for dof in (7, 10, 14, 20)]
    assert early == sorted(early, reverse=True) and early[0] > 85 and early[-1] < 5
    for dof in (7, 10, 14, 20):
        assert scaled[dof, "1600"] > 85
        assert scaled[dof, "step solver"] == 100
    ablation = rows(tmp_path / "new/ablation.csv")
    share = {name: float(row[1].split()[0]) for name, row in ablation.items() if "±" in row[1]}
    assert share["published: rate per gene, median"] > 80
    assert share["rand/1, 200 generations"] < 5
    assert share["weights 1 per mm, 1 per rad"] < 10
    assert share["boundary: clamp"] < share["boundary: redraw"]
    comparison = rows(tmp_path / "new/comparison.csv")
    assert float(comparison["memetic differential evolution"][1]) > 98


def test_the_command_and_its_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said = one_line(run_command("paper", "redundant8", "-o", tmp_path / "x"))
    assert "unknown paper 'redundant8'; did you mean 'redundant7'" in said
    assert not (tmp_path / "x").exists()

    def brief(directory: Path, report: Any) -> list[Path]:
        report("done")
        return [directory / "table.csv"]

    monkeypatch.setattr(redundant7, "reproduce", brief)
    result = run_command("paper", "redundant7", "-o", tmp_path / "x")
    assert result.exit_code == 0
    assert result.stdout.strip() == str(tmp_path / "x" / "table.csv")
    assert "redundant7: done" in result.stderr


def test_arms_of_more_joints_are_built_as_table_1() -> None:
    for dof in redundant7.DEGREES_OF_FREEDOM:
        robot = redundant7.alternating_arm(dof)
        assert robot.dof == dof and robot.dh is not None
        assert sum(row.d for row in robot.dh) == pytest.approx(1.266)
        twists = np.degrees([row.alpha for row in robot.dh])
        assert twists[:-1].tolist() == [-90.0 if k % 2 == 0 else 90.0 for k in range(dof - 1)]
        assert twists[-1] == 0
    seven = np.degrees([row.alpha for row in redundant7.arm().dh or ()])
    np.testing.assert_allclose(
        seven, np.degrees([row.alpha for row in redundant7.alternating_arm(7).dh or ()])
    )


def test_the_spray_pass_keeps_the_nozzle_towards_the_canopy() -> None:
    job = redundant7.spray_pass()
    assert job.success.all() and len(job.points) == 107
    poses = job.robot.with_tool(redundant7.NOZZLE).fk(job.q)
    np.testing.assert_allclose(poses[:, :3, 3], job.points, atol=2e-6)
    np.testing.assert_allclose(poses[:, :3, 2], np.tile([1.0, 0.0, 0.0], (107, 1)), atol=2e-6)
    assert (job.q >= job.robot.lower).all() and (job.q <= job.robot.upper).all()
    assert job.largest_step <= 0.1 + 1e-12
    # The nozzle's point is 120 mm beyond the flange.
    flange = job.robot.fk(job.q)[:, :3, 3]
    np.testing.assert_allclose(job.points - flange, [[0.12, 0, 0]] * 107, atol=2e-6)


def test_cotton_topping_reaches_every_plant() -> None:
    job = redundant7.cotton_topping()
    assert job.success.all() and len(job.points) == 24
    tips = job.robot.with_tool(redundant7.CUTTER).fk(job.q)[:, :3, 3]
    np.testing.assert_allclose(tips, redundant7.topping_points(), atol=2e-6)
    assert job.largest_step < 1.5
