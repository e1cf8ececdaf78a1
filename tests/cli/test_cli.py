"""The command line as a whole: a fast start, `--version`, and `agrik-fast info`."""

import re
import subprocess
import sys

import pytest

from agrik_fast import Robot
from cli_runner import one_line, run_command

HELP = """
import sys
sys.argv = ["agrik-fast", *{words!r}]
from agrik_fast.cli import main
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
heavy = {{"numpy", "pyarrow", "rich", "matplotlib", "agrik_fast._native"}}
print("heavy:", sorted(heavy & set(sys.modules)))
"""


@pytest.mark.parametrize(
    ("words", "heavy"),
    [
        (["--help"], []),
        # The compiled module without NumPy: the solvers' names are the core's.
        (["solve", "--help"], ["agrik_fast._native"]),
        (["info", "--help"], []),
        (["paper", "--help"], []),
    ],
)
def test_help_imports_nothing_heavy(words: list[str], heavy: list[str]) -> None:
    script = HELP.format(words=words)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert "Usage: agrik-fast" in done.stdout
    assert done.stdout.strip().endswith(f"heavy: {heavy}")


def test_module_and_version() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "agrik_fast.cli", "--help"],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert "solve" in done.stdout
    assert "info" in done.stdout
    result = run_command("--version")
    assert re.fullmatch(r"agrik-fast \d+\.\d+\.\d+\S*\n", result.stdout)


@pytest.mark.parametrize("name", Robot.names())
def test_info_names_joints_limits_reach_and_source(name: str) -> None:
    result = run_command("info", name)
    assert result.exit_code == 0, result.output
    robot = Robot.load(name)
    assert result.stdout.startswith(f"{name}: ")
    for joint in robot.joint_names:
        assert re.search(rf"^  {re.escape(joint)} ", result.stdout, re.MULTILINE)
    assert f"Joints ({robot.dof})" in result.stdout
    assert f"within {robot.reach_radius:.4f} m" in result.stdout
    assert ("Denavit-Hartenberg rows" in result.stdout) == (robot.dh is not None)
    assert "Source\n" in result.stdout


def test_info_without_a_name_lists_the_robots() -> None:
    lines = run_command("info").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(Robot.names())


def test_info_of_an_unknown_robot() -> None:
    assert "did you mean 'puma560'?" in one_line(run_command("info", "pumma560"))
