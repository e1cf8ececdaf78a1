"""Options that several commands share: all faults at once, gain files, links and postures."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agrik_fast import Robot
from agrik_fast.io import read_results
from agrik_fast.solvers import StaticGain, gain_file, load_gains
from cli_runner import RunCommand, one_line, run_command
from urdf_text import joint, urdf


@pytest.fixture
def agrik_fast(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunCommand:
    """Run the command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return run_command


def save_points(name: str, robot: str, count: int) -> None:
    arm = Robot.load(robot)
    np.save(name, arm.fk(arm.random_q(count, seed=1))[:, :3, 3])


def test_all_faults_are_told_a_line_each(agrik_fast: RunCommand) -> None:
    words = ["tomatoe", "none.csv", "-o", "r.doc", "--tool", "1,2", "--q0", "1,x", "--mask", "1"]
    result = agrik_fast("solve", *words, "--tol", "wide")
    assert result.exit_code == 2 and "Traceback" not in result.output
    head, *lines = result.stderr.strip().splitlines()
    assert head == "agrik-fast: 7 faults"
    for start, line in zip(
        [
            "`--tol`: expected one number, or three",
            "`--tool`: expected 3 or 6 numbers",
            "`--q0`: expected 2 numbers",
            "`--mask`: expected 6 numbers",
            "r.doc: unknown suffix",
            "unknown robot 'tomatoe'; did you mean 'tomato'?",
            "none.csv: cannot be read",
        ],
        lines,
        strict=True,
    ):
        assert line.startswith(f"  {start}"), line
    assert not any(Path().iterdir())


def test_faults_that_show_later_are_told_together_too(agrik_fast: RunCommand) -> None:
    save_points("p.npy", "ur5", 2)
    result = agrik_fast("solve", "ur5", "p.npy", "-o", "r.csv", "--solver", "ml", "--q0", "1,2")
    head, *lines = result.stderr.strip().splitlines()
    assert head == "agrik-fast: 2 faults" and result.exit_code == 2
    assert lines[0] == "  `--q0`: expected 6, one a joint, got 2 numbers"
    assert lines[1].startswith("  unknown solver 'ml'")


def test_a_gain_file_is_a_solver(agrik_fast: RunCommand) -> None:
    gain_file.write(Path("g.toml"), gain_file.read("hydrolek_k15_cma"))
    save_points("p.npy", "hydrolek", 50)
    result = agrik_fast("solve", "hydrolek", "p.npy", "-o", "r.npz", "--solver", "g.toml")
    assert result.exit_code == 0, result.output
    layout, rows = read_results("r.npz")
    assert layout.metadata["solver"].startswith("StateSpace(")
    usual = load_gains("g.toml", as_tuned=False)
    arm = Robot.load("hydrolek")
    assert np.array_equal(rows.q, arm.ik(np.load("p.npy"), solver=usual).q)
    Path("bad.toml").write_text('format = 1\nsolver = "ik-pid"\nrobot = "x"\n[gains]\nkp = "a"\n')
    result = agrik_fast("solve", "hydrolek", "p.npy", "-o", "s.npz", "--solver", "bad.toml")
    lines = result.stderr.strip().splitlines()
    assert result.exit_code == 2 and lines[0] == "agrik-fast: bad.toml: 4 faults"
    assert "  gains.kp: input should be a valid number" in lines


def test_gains_for_points_are_told_where_poses_are_wanted(agrik_fast: RunCommand) -> None:
    gain_file.write(Path("g.toml"), gain_file.read("hydrolek_k15_cma"))
    gain_file.write(Path("p.toml"), gain_file.read("hydrolek_pose_cma"))
    arm = Robot.load("hydrolek")
    poses = arm.fk(arm.random_q(20, seed=1))
    np.save("poses.npy", poses)
    np.save("points.npy", poses[:, :3, 3])

    def solve(gains: str, targets: str, *more: str) -> Any:
        return agrik_fast("solve", "hydrolek", targets, "-o", "r.npz", "--solver", gains, *more)

    assert one_line(solve("g.toml", "poses.npy")) == (
        "agrik-fast: `solver`: expected gains for whole poses, or the task 'position', got "
        "gains for points (B has 3 columns)"
    )
    line = one_line(solve("p.toml", "points.npy"))
    assert "expected gains for points, got gains for whole poses" in line
    # All faults at once, each once.
    both = solve("g.toml", "poses.npy", "--q0", "1,2").stderr.splitlines()
    assert len(both) == 3 and "2 faults" in both[0]
    assert not Path("r.npz").exists()
    assert solve("g.toml", "poses.npy", "--task", "position").exit_code == 0
    assert solve("p.toml", "poses.npy", "--force", "--strict", "--q0", "1").exit_code == 2
    assert solve("p.toml", "poses.npy", "--force").exit_code == 0


def test_the_kind_of_gains_is_the_file_s_own() -> None:
    assert load_gains("hydrolek_k15_cma", as_tuned=True).name == "state-space"
    with pytest.raises(ValueError, match="gains for 'state-space', not for 'static-gain'"):
        load_gains("hydrolek_k15_cma", StaticGain, as_tuned=True)


def test_info_tells_the_pose_of_joint_values(agrik_fast: RunCommand) -> None:
    result = agrik_fast("info", "ur5e", "--q0", "0,-1.2,1.4,0,0.3,0", "--tool", "0,0,0.1")
    assert result.exit_code == 0, result.output
    pose = Robot.load("ur5e").fk([0, -1.2, 1.4, 0, 0.3, 0])
    x, y, z = pose[:3, 3] + 0.1 * pose[:3, 2]
    assert f"x {x:.6f} m, y {y:.6f} m, z {z:.6f} m" in result.stdout
    wrong = agrik_fast("info", "ur5e", "--q0", "0")
    assert wrong.stderr.strip() == "agrik-fast: `--q0`: expected 6, one a joint, got 1 number"


def test_plan_takes_links_a_tool_and_a_start(agrik_fast: RunCommand) -> None:
    start, tool = [0.1, -0.4, 0.0, -2.0, 0.0, 1.8, 0.8], np.eye(4)
    tool[2, 3] = 0.1
    arm = Robot.load("panda").with_tool(tool)
    place = arm.fk(start)[:3, 3] + [0.0, 0.1, 0.05]
    words = ["plan", "panda", "--target", ",".join(map(str, place)), "-o", "t.npz"]
    given = ",".join(map(str, start))
    result = agrik_fast(*words, "--q0", given, "--tool", "0,0,0.1")
    assert result.exit_code == 0, result.output
    q = np.load("t.npz")["positions"]
    assert np.allclose(q[0], start) and np.allclose(arm.fk(q[-1])[:3, 3], place, atol=1e-5)
    links = ["base", "a", "tool0"]
    turns = [joint("j1", "base", "a"), joint("t", "a", "tool0", kind="fixed")]
    Path("arm.urdf").write_text(urdf(links, turns))
    words = ["plan", "arm.urdf", "--target", "0,0,1", "-o", "u.csv", "--tip-link", "hand"]
    named = agrik_fast(*words)
    assert named.exit_code == 2 and "unknown tip link 'hand'" in named.stderr


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("so", {"solve", "solvers"}),
        ("solve pan", {"panda"}),
        ("info ur", {"ur10e", "ur3e", "ur5", "ur5e"}),
        ("solve panda t.csv --tip", {"--tip-link"}),
        ("solve panda t.csv --solver pin", {"pinv", "pinv-closed"}),
        ("cluster solve --robot gen", {"gen3"}),
    ],
)
def test_the_shell_completes_names(words: str, expected: set[str]) -> None:
    asked = {
        "_AGRIK_FAST_COMPLETE": "complete_bash",
        "COMP_WORDS": f"agrik-fast {words}",
        "COMP_CWORD": str(len(words.split())),
    }
    program = [sys.executable, "-m", "agrik_fast"]
    done = subprocess.run(
        program, env=os.environ | asked, capture_output=True, text=True, check=False
    )
    assert set(done.stdout.split()) == expected, done.stderr


@pytest.mark.filterwarnings("default::agrik_fast.errors.TargetWarning")
def test_degrees_and_millimetres_are_noticed(agrik_fast: RunCommand) -> None:
    Path("d.csv").write_text(
        "x_m,y_m,z_m,roll_rad,pitch_rad,yaw_rad\n0.4,0.2,0.3,180,0,90\n0.4,0.2,0.3,170,0,80\n"
    )
    result = agrik_fast("solve", "ur5", "d.csv", "-o", "d.npz", "--q0", "0,-90,90,0,0,0")
    assert result.exit_code == 0, result.output
    said = result.stderr
    assert "'roll_rad', 'pitch_rad', 'yaw_rad': more than a turn in rad" in said
    assert "was it meant in degrees, as in 'roll_deg'?" in said
    assert "q0 is -90 rad for joint 'shoulder_lift': was it meant in degrees?" in said
    Path("m.csv").write_text("x_m,y_m,z_m\n400,200,300\n,,\n".replace(",,", "nan,1,1"))
    result = agrik_fast("solve", "ur5", "m.csv", "-o", "m.npz")
    assert result.exit_code == 0, result.output
    assert "are the lengths in mm, as in x_mm,y_mm,z_mm?" in result.stderr
    np.save("huge.npy", [[1e200, 0.0, 0.0], [np.inf, 0.0, 0.0]])
    result = agrik_fast("solve", "ur5", "huge.npy", "-o", "h.npz")
    assert result.exit_code == 0 and "overflow" not in result.stderr
    Path("g.csv").write_text("x_m,y_m,z_m,roll_rad,pitch_rad,yaw_rad\n0.4,0.2,0.3,3.1,0,1.5\n")
    result = agrik_fast("solve", "ur5", "g.csv", "-o", "g.npz", "--q0", "0,-1.6,1.6,0,0,0")
    assert result.exit_code == 0 and "meant" not in result.stderr and "mm" not in result.stderr


def test_schemas_name_their_dialect(agrik_fast: RunCommand) -> None:
    for kind in ("robot", "gains", "scene", "calibration"):
        schema = json.loads(agrik_fast("schema", kind).stdout)
        assert schema["$schema"].startswith("https://json-schema.org/") and schema["properties"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["solve", "ur5"], "Missing argument 'targets'; see agrik-fast solve --help"),
        (["solve", "ur5", "t.csv", "--slover", "lm"], "No such option: --slover"),
        (["slove"], "No such command 'slove'"),
        (["--wide"], "No such option: --wide"),
        (["view", "ur5", "--port", "x"], "Invalid value for '--port'"),
        (["cluster", "clean"], "Missing argument"),
    ],
)
def test_usage_errors_are_one_line(agrik_fast: RunCommand, words: list[str], said: str) -> None:
    line = one_line(agrik_fast(*words))
    assert line.startswith("agrik-fast: ") and said in line and "--help" in line


# Commands that load a robot, with the words that they cannot do without.
COMMANDS = {
    "solve": ["solve", "ur5", "t.csv", "-o", "r.csv"],
    "info": ["info", "ur5"],
    "convert": ["convert", "ur5", "r.toml"],
    "tune": ["tune", "ur5", "-o", "g.toml"],
    "harvest": ["harvest", "s.json", "-o", "h"],
    "view": ["view", "ur5", "--no-browser", "--port", "0"],
    "plan": ["plan", "ur5", "--target", "0.3,0.2,0.4", "-o", "t.npz"],
    "cluster solve": ["cluster", "solve", "-r", "ur5", "in", "out"],
    "cluster forward": ["cluster", "forward", "-r", "ur5", "in", "out"],
    "cluster harvest": ["cluster", "harvest", "in", "out"],
}
OPTIONS = ("base-link", "tip-link", "tool", "q0", "mask", "frame", "solver")
UNFIT = {
    "info": ("mask", "solver"),
    "convert": ("q0", "mask", "solver"),
    "tune": ("q0", "mask"),
    "harvest": ("mask", "solver"),
    "view": ("mask",),
    "plan": ("mask",),
    "cluster forward": ("q0", "mask", "solver"),
    "cluster harvest": ("q0", "mask", "solver"),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_with_a_robot_knows_all_its_options(
    agrik_fast: RunCommand, command: str
) -> None:
    own = agrik_fast(*COMMANDS[command], "--help").stdout
    unfit = UNFIT.get(command, ())
    for option in OPTIONS:
        assert (f"--{option}" in own) == (option not in unfit), option
    for option in unfit:
        line = one_line(agrik_fast(*COMMANDS[command], f"--{option}", "1"))
        name = command.split()[-1]
        assert line.startswith(f"agrik-fast: `--{option}` means nothing to `{name}`: "), line
    if len(unfit) > 1:
        given = [word for option in unfit for word in (f"--{option}", "1")]
        assert len(agrik_fast(*COMMANDS[command], *given).stderr.splitlines()) == len(unfit)
    assert not any(Path().iterdir())


def test_options_that_need_others_are_refused(agrik_fast: RunCommand) -> None:
    assert "`ROBOT`: expected a robot" in one_line(agrik_fast("info", "--tip-link", "a"))
    line = one_line(agrik_fast(*COMMANDS["harvest"], "--start", "0"))
    assert line.startswith("agrik-fast: `--start`: expected --path as well")
    page = ["view", "ur5", "--export", "p.html"]
    assert "solves nothing" in one_line(agrik_fast(*page, "--solver", "lm"))
    played = agrik_fast(*page, "--q0", "0,0,0,0,0,0", "--targets", "t.csv")
    assert "which are played" in one_line(played)
    assert "`--q0`: expected 6 numbers" in one_line(agrik_fast(*COMMANDS["view"], "--q0", "1"))
    far = agrik_fast(*COMMANDS["view"], "--q0", "99,0,0,0,0,0")
    assert "`--q0`: expected 6 values within the limits" in one_line(far)
    assert "unknown solver 'ml'" in one_line(agrik_fast(*COMMANDS["view"], "--solver", "ml"))
    assert not any(Path().iterdir())


def test_a_page_shows_the_posture_that_is_given(agrik_fast: RunCommand) -> None:
    for name, q in (("a", "0,-1,1,0,0,0"), ("b", "1,-1,1,0,0,0"), ("c", "0,-1,1,0,0,0")):
        done = agrik_fast("view", "ur5", "--export", f"{name}.html", "--q0", q)
        assert done.exit_code == 0, done.output
    a, b, c = (Path(f"{name}.html").read_bytes() for name in "abc")
    assert a != b and len(a) == len(c)


def test_plan_takes_the_solver_of_points(agrik_fast: RunCommand) -> None:
    arm, start = Robot.load("panda"), [0.1, -0.4, 0.0, -2.0, 0.0, 1.8, 0.8]
    place = arm.fk(start)[:3, 3] + [0.0, 0.1, 0.05]
    target = ",".join(map(str, place))
    given = ",".join(map(str, start))
    words = ["plan", "panda", "--q0", given, "-o", "t.npz"]
    done = agrik_fast(*words, "--target", target, "--solver", "dls")
    assert done.exit_code == 0, done.output
    assert np.allclose(arm.fk(np.load("t.npz")["positions"][-1])[:3, 3], place, atol=1e-5)
    wrong = agrik_fast(*words, "--target", target, "--solver", "ml")
    assert "unknown solver 'ml'" in one_line(wrong)
    line = one_line(agrik_fast(*words, "--target", f"q={given}", "--solver", "dls"))
    assert line.startswith("agrik-fast: `--solver`: expected nothing but with a point x,y,z")


def test_what_all_branches_do_not_use_is_said(agrik_fast: RunCommand) -> None:
    arm = Robot.load("ur5")
    np.save("p.npy", arm.fk(arm.random_q(2, seed=1)))
    words = ["solve", "ur5", "p.npy", "--all-branches", "--solver", "lm", "--seed", "3"]
    said = agrik_fast(*words, "-o", "r.csv")
    assert said.exit_code == 0, said.output
    for option in ("--solver lm", "--seed 3"):
        assert f"agrik-fast: {option} is not used: --all-branches asks no solver" in said.stderr
    plain = agrik_fast("solve", "ur5", "p.npy", "--all-branches", "-o", "s.csv")
    assert plain.exit_code == 0 and "not used" not in plain.stderr
    assert Path("r.csv").read_bytes() == Path("s.csv").read_bytes()
