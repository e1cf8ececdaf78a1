"""The command line with bodies and scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
import spec_scenes
from agrik_fast.collision import Scene
from agrik_fast.io import read_results
from agrik_fast.io._results import RESULT_SUFFIXES
from cli_runner import one_line, run_command

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "examples/scenes/bench.toml"


@pytest.mark.parametrize("name", spec_scenes.WITH_BODIES)
def test_bodies_and_self_pairs_are_printed(name: str) -> None:
    arm = ik.Robot.load(name)
    text = run_command("info", name, "--body").stdout
    assert text.startswith(f"Bodies of {name} ({len(arm.bodies)})")
    for body in arm.bodies:
        (line,) = [line for line in text.splitlines() if line.split()[:1] == [body.name]]
        assert body.provenance in line
    pairs = arm.self_pairs
    text = run_command("info", name, "--self-pairs").stdout
    assert f"asked whether they hit each other ({len(pairs.asked)})" in text
    assert f"Pairs that are not ({len(pairs.excluded)})" in text
    for a, b in pairs.asked:
        assert f"  {a} - {b}\n" in text
    for pair in pairs.excluded:
        assert f"  {pair.bodies[0]} - {pair.bodies[1]}: {pair.reason}" in text
    both = run_command("info", name, "--body", "--self-pairs").stdout
    assert both.startswith("Bodies of") and "Pairs of bodies" in both


def test_overestimates_and_warnings_of_a_urdf(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="r"><link name="base"/><link name="tip"><collision><geometry>'
        '<cylinder radius="0.05" length="0.4"/></geometry></collision></link>'
        '<link name="eye"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'
        '<joint name="a" type="continuous"><parent link="base"/><child link="tip"/></joint>'
        '<joint name="b" type="fixed"><parent link="tip"/><child link="eye"/></joint></robot>'
    )
    result = run_command("info", path, "--body")
    assert result.exit_code == 0, result.output
    assert "no <collision>, which nothing will be found to hit: eye" in result.stderr
    (line,) = [line for line in result.stdout.splitlines() if line.split()[:1] == ["tip"]]
    assert line.split() == ["tip", "tip", "capsule", "length", "400,", "r", "50", "50.0", "URDF"]
    text = path.read_text().replace('<cylinder radius="0.05" length="0.4"/>',
                                    '<mesh filename="package://x/y.stl"/>')  # fmt: skip
    path.write_text(text)
    words = one_line(run_command("info", path, "--body"))
    assert "link 'tip': mesh file 'package://x/y.stl' is missing; looked for at" in words
    assert run_command("info", path).exit_code == 0
    assert "ROBOT" in one_line(run_command("info", "--body"))


@pytest.mark.parametrize("suffix", RESULT_SUFFIXES)
def test_solve_among_things(tmp_path: Path, suffix: str) -> None:
    arm, scene = ik.Robot.load("ur5"), Scene.load(BENCH)
    q = arm.random_q(400, seed=3)
    free = arm.fk(q[~scene.collides(arm, q)][:60])
    blocked = ik.rotations.pose((0.65, 0.35, 0.455), rpy=(0.1, 0, 0))  # inside the shelf
    goals = np.concatenate([free, [blocked]])
    np.save(tmp_path / "goals.npy", goals)
    output = tmp_path / f"out{suffix}"
    result = run_command(
        "solve", "ur5", tmp_path / "goals.npy", "-o", output, "--scene", BENCH, "--clear", "0.001"
    )
    assert result.exit_code == 0, result.output
    layout, rows = read_results(output)
    whole = arm.ik(goals, scene=scene, clear=0.001)
    np.testing.assert_array_equal(rows.status, whole.status)
    np.testing.assert_array_equal(rows.q, whole.q)
    assert rows.scene is not None
    np.testing.assert_array_equal(rows.scene.clearance, whole.clearance)
    pairs = np.stack([rows.scene.body, rows.scene.object], axis=1)
    assert pairs.tolist() == whole.nearest_pair.tolist()
    assert rows.status[-1] == ik.Status.IN_COLLISION and "in collision" in result.stdout
    assert rows.success[:60].mean() >= 0.95
    if suffix in (".npz", ".parquet"):
        assert layout.metadata["scene"] == "bench.toml"
        assert layout.metadata["clear_m"] == "0.001" and layout.metadata["prefer"] == "first"
    if suffix == ".csv":
        head, first = output.read_text().splitlines()[:2]
        assert head.endswith(",restarts,clearance_m,body,object")
        assert first.split(",")[-2] in {body.name for body in arm.bodies}


def test_aim_and_preference(tmp_path: Path) -> None:
    np.save(tmp_path / "goals.npy", np.array([[0.3, -0.5, 0.5]]))
    words = ("solve", "panda", tmp_path / "goals.npy", "--scene", BENCH, "--force")
    output = tmp_path / "out.npz"
    assert run_command(*words, "-o", output).exit_code == 0
    # The middle of a ball: reached only where the ball may be touched, and not by the flange.
    _, rows = read_results(output)
    assert rows.status[0] == ik.Status.IN_COLLISION
    result = run_command(*words, "-o", output, "--aim", "ball", "--prefer", "clearance")
    assert result.exit_code == 0, result.output
    assert read_results(output)[0].metadata["prefer"] == "clearance"


def test_what_is_wrong_is_one_line(tmp_path: Path) -> None:
    np.save(tmp_path / "goals.npy", np.array([[0.3, -0.5, 0.5]]))
    words = ("solve", "ur5", tmp_path / "goals.npy", "-o", tmp_path / "out.csv")
    bad = tmp_path / "bad.toml"
    bad.write_text('objects = [{ name = "a", spheres = [[0, 0, 0, -1]] }]\n')
    for more, expected in [
        (("--scene", tmp_path / "absent.toml"), "`--scene`: expected an existing file"),
        (("--scene", tmp_path / "goals.npy"), "`--scene`: expected a .json or .toml file"),
        (("--scene", BENCH, "--aim", "bell"), "unknown target 'bell'; did you mean 'ball'?"),
        (("--aim", "ball"), "`--aim`: expected --scene as well"),
        (("--scene", BENCH, "--prefer", "best"), "unknown --prefer 'best'"),
        (("--scene", BENCH, "--clear", "-1"), "clear"),
        (("--clear", "0.1"), "scene"),
    ]:
        line = one_line(run_command(*words, *more))
        assert expected in line, (more, line)
    faults = run_command(*words, "--scene", bad)
    assert faults.exit_code == 2
    head, first, second = faults.stderr.strip().splitlines()
    assert head.endswith("bad.toml: 2 faults")
    assert first.startswith("  unit: missing: 'm' or 'mm'") and second.startswith("  objects")
    assert not (tmp_path / "out.csv").exists()
    own = tmp_path / "bare.toml"
    own.write_text(
        'format = 1\nname = "bare"\nconvention = "standard"\n[[dh]]\nname = "q"\n'
        'type = "continuous"\na_m = 1\nalpha_deg = 0\nd_m = 0\ntheta_deg = 0\n'
    )
    line = one_line(run_command("solve", own, *words[2:], "--scene", BENCH))
    assert "'bare', which has no bodies" in line and "[[collision]]" in line
    assert "bare has no bodies" in run_command("info", own, "--body").stdout
