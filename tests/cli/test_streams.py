"""Streams that are closed, full or left, and machines that refuse: the result comes first."""

import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agrik_fast import Robot
from agrik_fast.io import read_results

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="/dev/full and limits of Linux")

COMMAND = f"{sys.executable} -m agrik_fast.cli"
SOLVE = f"{COMMAND} solve ur5 t.npy -o r.csv"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    arm = Robot.load("ur5")
    np.save(tmp_path / "t.npy", arm.fk(arm.random_q(30, seed=1)))
    return tmp_path


def shell(folder: Path, command: str, **options: Any) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        **options,
    )
    assert "Traceback" not in done.stderr and "Exception ignored" not in done.stderr, done.stderr
    return done


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def solved(folder: Path) -> bool:
    _, rows = read_results(folder / "r.csv")
    return bool(rows.success.all()) and names(folder) == ["r.csv", "t.npy"]


def test_a_full_standard_output_is_told_after_the_result(folder: Path) -> None:
    done = shell(folder, f"{SOLVE} > /dev/full")
    assert done.returncode == 5 and solved(folder)
    last = done.stderr.splitlines()[-1]
    assert last == (
        "agrik-fast: standard output cannot be written: no space left on device; results: r.csv"
    )
    done = shell(folder, f"{COMMAND} info > /dev/full")
    assert done.returncode == 5 and len(done.stderr.splitlines()) == 1
    assert shell(folder, f"{COMMAND} --help > /dev/full").returncode != 0


@pytest.mark.parametrize("closing", ["2> /dev/full", "2>&-", ">&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_closed_streams_and_a_full_stderr_change_nothing(folder: Path, closing: str) -> None:
    done = shell(folder, f"{SOLVE} {closing}")
    assert done.returncode == 0 and solved(folder)
    # Errors keep their status where nobody hears of them.
    assert shell(folder, f"{SOLVE} {closing}").returncode == 2


def test_readers_that_leave_have_what_they_wanted(folder: Path) -> None:
    done = shell(folder, f"{SOLVE} | head -c 0")
    assert (done.returncode, done.stdout) == (0, "") and solved(folder)
    done = shell(folder, f"{COMMAND} info strawberry | head -n 1")
    assert done.returncode == 0 and len(done.stdout.splitlines()) == 1
    assert shell(folder, f"{COMMAND} --version | true").returncode == 0


def test_letters_that_the_terminal_cannot_show_are_escaped(tmp_path: Path) -> None:
    urdf = (
        '<robot name="θ"><link name="a"/><link name="b"/><joint name="θ" type="continuous">'
        '<parent link="a"/><child link="b"/></joint></robot>'
    )
    (tmp_path / "arm.urdf").write_text(urdf, encoding="utf-8")
    environment = os.environ | {"PYTHONIOENCODING": "latin-1"}
    done = shell(tmp_path, f"{COMMAND} info arm.urdf", env=environment)
    assert done.returncode == 0 and "\\u03b8" in done.stdout


@pytest.mark.parametrize("suffix", ["csv", "npy", "npz", "parquet"])
def test_a_file_that_grows_too_large_leaves_nothing(folder: Path, suffix: str) -> None:
    arm = Robot.load("ur5")
    np.save(folder / "t.npy", arm.fk(arm.random_q(3000, seed=1)))
    done = shell(folder, f"ulimit -f 16; {COMMAND} solve ur5 t.npy -o r.{suffix}")
    assert done.returncode == 2
    assert (
        done.stderr.splitlines()[-1] == f"agrik-fast: r.{suffix}: cannot be written: file too large"
    )
    assert names(folder) == ["t.npy"]


def test_too_little_memory_is_said(folder: Path) -> None:
    # Rows that take no time to solve.
    np.savez(folder / "big.npz", position_m=np.full((4_000_000, 3), np.nan))

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (600 << 20, 600 << 20))

    done = shell(
        folder,
        f"{COMMAND} solve ur5 big.npz -o r.npz --threads 1",
        preexec_fn=limit,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )
    # Enough for the targets, too little for the results, which this kind gathers.
    assert done.returncode == 4, done.stderr
    assert done.stderr.splitlines()[-1] == "agrik-fast: out of memory, nothing was written"
    assert names(folder) == ["big.npz", "t.npy"]


def test_faults_of_the_program_are_told_on_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import typer

    from agrik_fast.cli._exits import FAULT, exit_codes

    for error, status, text in [
        (KeyError("x"), FAULT, "a fault of the program, please report it: KeyError (test_faults"),
        (MemoryError(), 4, "out of memory, nothing was written"),
        (ImportError("failed to map segment"), 4, "cannot be loaded: failed to map segment"),
        (RuntimeError("can't start new thread"), 4, "out of threads or memory"),
    ]:
        with pytest.raises(typer.Exit) as left, exit_codes():
            raise error
        assert left.value.exit_code == status
        told = capsys.readouterr().err
        assert told.startswith(f"agrik-fast: {text}") and len(told.splitlines()) == 1


def test_many_faults_of_a_robot_file_fit_on_a_screen(tmp_path: Path) -> None:
    (tmp_path / "r.toml").write_text("".join(f"k{k} = 1\n" for k in range(5000)))
    done = shell(tmp_path, f"{COMMAND} info r.toml")
    assert done.returncode == 2 and len(done.stderr.splitlines()) <= 22
    assert len(done.stderr) < 10_000 and "more" in done.stderr


def test_a_hang_up_that_is_to_be_ignored_is(folder: Path) -> None:
    script = f"trap '' HUP; {SOLVE} & kill -HUP $!; wait $!"
    done = shell(folder, script)
    assert done.returncode == 0 and solved(folder)
