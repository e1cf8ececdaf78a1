"""``agrik-fast plan`` and ``agrik-fast harvest --path``."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import harvest, motion
from agrik_fast.collision import Capsule, Scene, SceneObject
from cli_runner import run_command

START = "0.75,1.21107,-1.390711,0.720078,-1.544961,1.591286,5.612817"


@pytest.fixture
def bench(tmp_path: Path) -> Path:
    """Return a scene file with a post."""
    file = tmp_path / "scene.json"
    post = SceneObject.of("post", Capsule([0.5, 0, 0], [0.5, 0, 1], 0.05))
    Scene([post]).save(file)
    return file


def test_a_trajectory_is_written_that_is_free(bench: Path, tmp_path: Path) -> None:
    output = tmp_path / "trajectory.csv"
    ran = run_command(
        "plan", "panda", "--scene", bench, "--start=-1,0,0,-1.5,0,1.5,0",
        "--target=q=1,0,0,-1.5,0,1.5,0", "-o", output,
    )  # fmt: skip
    assert ran.exit_code == 0, ran.stderr
    assert "OK: rrt_connect" in ran.stderr
    rows = output.read_text().splitlines()
    names = rows[0].split(",")
    arm = ik.Robot.load("panda")
    table = np.array([[float(x) for x in row.split(",")] for row in rows[1:]])
    q = table[:, [names.index(f"{name}_rad") for name in arm.joint_names]]
    np.testing.assert_allclose(q[0], [-1, 0, 0, -1.5, 0, 1.5, 0])
    np.testing.assert_allclose(q[-1], [1, 0, 0, -1.5, 0, 1.5, 0])
    assert motion.check(arm, q, Scene.load(bench)).safe


def test_where_there_is_no_path_the_reason_is_said(bench: Path, tmp_path: Path) -> None:
    output = tmp_path / "trajectory.csv"
    ran = run_command(
        "plan", "panda", "--scene", bench, "--start=-1,0,0,-1.5,0,1.5,0",
        "--target=5,0,0,0,0,0", "-o", output,
    )  # fmt: skip
    assert ran.exit_code == 3
    assert "OUT_OF_REACH" in ran.stderr
    assert not output.exists()
    for bad in ("--target=nowhere", "--start=1,2", "--target=1,2"):
        ran = run_command(
            "plan", "panda", "--scene", bench, "--target=0.3,0.3,0.3", bad, "-o", output
        )
        assert ran.exit_code == 2
        assert "Traceback" not in ran.stderr and bad.split("=")[0] in ran.stderr


def test_ways_to_fruits_are_written(tmp_path: Path) -> None:
    file = tmp_path / "crop.json"
    harvest.example_scene("cucumber_thin").save(file)
    folder = tmp_path / "out"
    ran = run_command("harvest", file, "-o", folder, "--no-pictures", "--path", "--start", START)
    assert ran.exit_code == 0, ran.stderr
    content = json.loads((folder / "paths.json").read_text())
    assert content["robot"] == "cucumber"
    assert {row["path"] for row in content["paths"]} >= {"OK"}
