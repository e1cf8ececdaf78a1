"""The command `view`: what it starts, writes and refuses."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cli_runner import one_line, run_command


def test_ctrl_c_ends_the_viewer_within_a_second_or_two(repo_root: Path) -> None:
    command = [sys.executable, "-m", "agrik_fast", "view", "tomato", "--port", "0", "--no-browser"]
    # A group of its own: the signal is for it alone.
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as running:
        assert running.stdout is not None and running.stderr is not None
        line = running.stdout.readline()
        assert re.fullmatch(r"tomato: http://127\.0\.0\.1:\d+ \(Ctrl-C ends it\)\n", line), line
        begin = time.monotonic()
        os.kill(running.pid, signal.SIGINT)
        assert running.wait(timeout=30) == 130
        # 0.3 s alone; beside thirty other programs on two processors up to 2.1 s.
        assert time.monotonic() - begin < 5
        assert running.stdout.read() == ""
        assert running.stderr.read() == "agrik-fast: interrupted, the viewer has ended\n"


def test_a_page_is_written_and_not_replaced(tmp_path: Path) -> None:
    page = tmp_path / "arm.html"
    result = run_command("view", "ur5", "--export", page)
    assert result.exit_code == 0, result.output
    assert result.stdout == f"page: {page}\n"
    assert "exists already" in one_line(run_command("view", "ur5", "--export", page))
    assert run_command("view", "ur5", "--export", page, "--force").exit_code == 0


def test_targets_and_paths_are_played_in_the_page(tmp_path: Path, repo_root: Path) -> None:
    targets = repo_root / "examples/targets/strawberry_table3.csv"
    plain, played = tmp_path / "plain.html", tmp_path / "played.html"
    assert run_command("view", "tomato", "--export", plain).exit_code == 0
    goals = repo_root / "examples/targets/tomato_points.npy"
    for option in ("--targets", "--path"):
        result = run_command("view", "tomato", option, goals, "--export", played, "--force")
        assert result.exit_code == 0, result.output
        assert played.stat().st_size > plain.stat().st_size + 100
    assert targets.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nobody"], "nobody"),
        (["tomato", "--show", "x"], "--show"),
        (["tomato", "--scene", "nowhere.toml"], "nowhere"),
        (["tomato", "--targets", "nowhere.csv"], "nowhere"),
        (["tomato", "--path", "nowhere.csv"], "nowhere"),
        (["tomato", "--export", "page.txt"], ".html"),
        (["tomato", "--solver", "nowhere.toml"], "nowhere.toml"),
    ],
)
def test_faults_are_one_line(words: list[str], said: str) -> None:
    assert said in one_line(run_command("view", *words, "--no-browser", "--port", 0))


def test_without_the_extra_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    words = one_line(run_command("view", "tomato", "--no-browser", "--port", 0))
    assert "agrik_fast[viewer]" in words
