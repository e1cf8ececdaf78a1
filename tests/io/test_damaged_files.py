"""Some of the files of `damaged_files.py`, in a process of their own for its memory."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.skipif(sys.platform != "linux", reason="the peak of memory is read from /proc")
def test_damaged_files_are_refused_in_few_lines_soon_and_with_little_memory() -> None:
    script = Path(__file__).with_name("damaged_files.py")
    command = [sys.executable, str(script), "--files", "160", "--seed", "7"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("160 damaged files: ")
    assert "0 faults" in done.stdout
