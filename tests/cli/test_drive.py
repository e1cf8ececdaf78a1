"""``agrik-fast drive``: rigs from target to target, and what it says when it cannot."""

import io
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from agrik_fast.cli import _drive
from cli_runner import one_line, run_command
from rigs import needs_simulator

GOOD = "x_mm,y_mm,z_mm\n426,345,-331.6\n580,310,-377.9\n"


def targets(folder: Path, text: str, name: str = "targets.csv") -> Path:
    file = folder / name
    file.write_text(text)
    return file


@needs_simulator
def test_strawberry_drives_to_every_target(tmp_path: Path) -> None:
    file = targets(tmp_path, GOOD)
    log = tmp_path / "frames.log"
    result = run_command(
        "drive", "strawberry", "--port", "simulated", "--targets", file, "--log", log
    )
    assert result.exit_code == 0, result.output
    assert result.stdout == "2 of 2 targets were driven to\n"
    lines = result.stderr.splitlines()
    assert len(lines) == 2
    for line in lines:
        assert re.fullmatch(
            r"strawberry: target \d \(.*\) mm: reached, [45]\.\d\d s, h_extra \d+ mm, "
            r"encoders within 0\.[0-4]\d mm",
            line,
        )
    assert "CONFIGURE" in log.read_text()


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self) -> bool:
        return True


@needs_simulator
def test_a_terminal_has_a_live_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("TERM", "xterm")
    stream, rows = Terminal(), list[_drive.Row]()
    request = _drive.DriveRequest("strawberry", "simulated", targets(tmp_path, GOOD))
    _drive.drive(request, rows, stream)
    text = stream.getvalue()
    for seen in ("strawberry rig", "x, mm", "time, s", "on its way", "reached", "homing", "moving"):
        assert seen in text, seen
    assert text.count("strawberry rig") > 5
    assert _drive.count(rows) == "2 of 2 targets were driven to"


@needs_simulator
def test_tomato_drives_to_every_target(tmp_path: Path) -> None:
    file = targets(tmp_path, "x_m,y_m,z_m\n0.2,0.05,0.1\n0.15,-0.06,0.08\n")
    result = run_command("drive", "tomato", "--targets", file, "--near")
    assert result.exit_code == 0, result.output
    assert result.stdout == "2 of 2 targets were driven to\n"


@needs_simulator
def test_the_paper_s_table_without_units_is_in_millimetres(tmp_path: Path) -> None:
    file = targets(tmp_path, "row,x,y,z,J_NCOS\n1,426,345,-331.6,5950.5\n")
    result = run_command("drive", "strawberry", "--targets", file, "--method", "as")
    assert result.exit_code == 0, result.output
    file = targets(tmp_path, "row,x,y,z\n1,0.426,0.345,-0.3316\n")
    told = one_line(run_command("drive", "strawberry", "--targets", file))
    assert "`--targets`: expected columns x_m,y_m,z_m or x_mm,y_mm,z_mm" in told
    assert "name no unit and hold small numbers" in told


@needs_simulator
def test_a_target_out_of_reach_in_the_middle_of_a_list(tmp_path: Path) -> None:
    file = targets(tmp_path, GOOD + "426,1200,-331.6\n450,285,-368.6\n445,325,-323.1\n")
    result = run_command("drive", "strawberry", "--targets", file)
    assert result.exit_code == 2
    *reached, failed, told = result.stderr.splitlines()
    assert len(reached) == 2 and failed.endswith("failed")
    assert told == (
        "agrik-fast: target 3 (426.0, 1200.0, -331.6) mm: the target (426.0, 1200.0, -331.6) mm "
        "is out of reach: slide s10 lacks 324.1 mm; motors are off; "
        "not driven to: targets 4 to 5"
    )
    assert "Traceback" not in result.output


@needs_simulator
def test_a_way_through_the_plant(tmp_path: Path) -> None:
    file = targets(tmp_path, "x_mm,y_mm,z_mm\n580,310,-377.9\n")
    told = one_line_of_last(run_command("drive", "strawberry", "--targets", file, "--h-extra", 30))
    assert "gripper and plant would touch (16.8 mm deep) on the step 4 of the way out" in told
    assert "it was the last of the list" in told


def one_line_of_last(result: object) -> str:
    """Return the last line on stderr of a command that failed as it should."""
    assert result.exit_code == 2 and "Traceback" not in result.output  # type: ignore[attr-defined]
    return result.stderr.splitlines()[-1]  # type: ignore[attr-defined, no-any-return]


def test_unplugged(tmp_path: Path) -> None:
    file = targets(tmp_path, GOOD)
    told = one_line(run_command("drive", "strawberry", "--port", "/dev/ttyNO", "--targets", file))
    assert told == "agrik-fast: /dev/ttyNO: cannot be opened: no such file or directory"


def test_wrong_device(tmp_path: Path) -> None:
    file = targets(tmp_path, GOOD)
    told = one_line(run_command("drive", "strawberry", "--port", "loop://", "--targets", file))
    assert "loop://: what is there sends back what it gets: no board of this project" in told


def test_wrong_words(tmp_path: Path) -> None:
    file = targets(tmp_path, GOOD)
    assert "unknown rig 'tomatoe'; did you mean 'tomato'?" in one_line(
        run_command("drive", "tomatoe", "--targets", file)
    )
    assert "cannot be read: no such file" in one_line(
        run_command("drive", "tomato", "--targets", tmp_path / "none.csv")
    )
    empty = targets(tmp_path, "x_mm,y_mm,z_mm\n", "empty.csv")
    assert "empty.csv" in one_line(run_command("drive", "tomato", "--targets", empty))


def test_calibration_of_another_rig(tmp_path: Path) -> None:
    from importlib import resources

    text = (resources.files("agrik_fast.drivers") / "bundled/tomato.toml").read_text("utf-8")
    (tmp_path / "mine.toml").write_text(text)
    file = targets(tmp_path, GOOD)
    told = one_line(
        run_command(
            "drive", "strawberry", "--targets", file, "--calibration", tmp_path / "mine.toml"
        )
    )
    assert "mine.toml: 1 fault; [rig], name: a calibration of the tomato rig, expected one" in told


@needs_simulator
def test_words_of_options_are_in_their_errors(tmp_path: Path) -> None:
    file = targets(tmp_path, GOOD)
    told = one_line_of_last(run_command("drive", "strawberry", "--targets", file, "--psi", 120))
    assert "`psi`: expected -90.00 to 90.00 degrees, got 120.00 degrees" in told
    told = one_line_of_last(
        run_command("drive", "strawberry", "--targets", file, "--method", "best")
    )
    assert "unknown method 'best'" in told


@needs_simulator
@pytest.mark.skipif(not hasattr(signal, "SIGINT") or os.name == "nt", reason="POSIX signals")
def test_ctrl_c_stops_the_motors_first(tmp_path: Path) -> None:
    rows = "".join(f"{400 + i},345,-331.6\n" for i in range(200))
    file = targets(tmp_path, "x_mm,y_mm,z_mm\n" + rows)
    log = tmp_path / "frames.log"
    words = ["-m", "agrik_fast.cli", "drive", "strawberry", "--targets", file, "--log", log]
    process = subprocess.Popen(
        [sys.executable, *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # As a shell starts a program in the foreground.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    end = time.monotonic() + 60
    while time.monotonic() < end and not (log.exists() and "MOVE" in log.read_text()):
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert re.search(r"agrik-fast: interrupted, motors are stopped; \d+ of 200 targets", errors)
    assert "Traceback" not in errors
    frames = [line.split() for line in log.read_text().splitlines()]
    # The last thing that the board was told, and what it answered.
    assert [frame[2] for frame in frames[-2:]] == ["STOP", "ACK"]
    assert frames[-1][4] == "00"


def test_help_needs_no_simulator() -> None:
    result = run_command("drive", "--help")
    assert result.exit_code == 0
    assert "Ctrl-C stops the motors first" in result.stdout
