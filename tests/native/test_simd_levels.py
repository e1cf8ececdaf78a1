"""Every instruction set of this machine: chosen by the environment, in the module, and sound.

The environment is read once per process, so each level has processes of its own.
"""

import itertools
import os
import re
import subprocess
import sys
from array import array
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import _native as native
from machine_code import assert_holds_fast_path, count_fused, count_fused_neon

TESTS = Path(__file__).parents[1]
NAMES = ("scalar", "avx2", "avx512", "neon")
SHOW = "import agrik_fast; print(agrik_fast.simd_level())"


def run(level: str | None, *words: object) -> subprocess.CompletedProcess[str]:
    """Run Python with `AGRIK_SIMD` set to a level, or without it."""
    environment = {key: value for key, value in os.environ.items() if key != "AGRIK_SIMD"}
    if level is not None:
        environment["AGRIK_SIMD"] = level
    return subprocess.run(
        [sys.executable, *map(str, words)],
        env=environment,
        cwd=TESTS.parent,
        capture_output=True,
        text=True,
        check=False,
    )


def is_available(level: str) -> bool:
    return run(level, "-W", "ignore", "-c", SHOW).stdout.strip() == level


AVAILABLE = [level for level in NAMES if is_available(level)]


def test_the_highest_level_is_chosen_by_default() -> None:
    assert "scalar" in AVAILABLE
    done = run(None, "-W", "error", "-c", SHOW)
    assert done.stdout.strip() in AVAILABLE
    highest = max(AVAILABLE, key=["scalar", "neon", "avx2", "avx512"].index)
    assert done.stdout.strip() == highest


@pytest.mark.parametrize("level", AVAILABLE)
def test_the_environment_chooses_without_a_warning(level: str) -> None:
    done = run(f" {level} ", "-W", "error", "-c", SHOW)
    assert (done.stdout.strip(), done.stderr) == (level, "")


def test_an_empty_wish_is_none() -> None:
    assert run("", "-W", "error", "-c", SHOW).stdout == run(None, "-c", SHOW).stdout


@pytest.mark.parametrize("wish", ["avx3", "AVX2", "neon avx2"])
def test_an_unknown_level_is_warned_of(wish: str) -> None:
    done = run(wish, "-c", SHOW)
    assert done.stdout == run(None, "-c", SHOW).stdout
    (warning,) = re.findall(r"RuntimeWarning: (.*)", done.stderr)
    names = ", ".join(sorted(AVAILABLE, key=["scalar", "neon", "avx2", "avx512"].index))
    assert warning.startswith(
        f'environment variable AGRIK_SIMD: expected one of {names} on this machine, got "{wish}"'
    )
    assert warning.endswith(f"; using {done.stdout.strip()}")


@pytest.mark.timeout(600)
@pytest.mark.parametrize("level", AVAILABLE)
def test_bad_input_and_determinism_hold(level: str) -> None:
    files = [TESTS / "robot/test_bad_input.py", TESTS / "native/test_determinism.py"]
    done = run(level, "-m", "pytest", "-q", "-p", "no:cacheprovider", *files)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"\d+ passed", done.stdout)
    assert not re.search(r"skipped|failed|error", done.stdout.splitlines()[-1])


SOLVE = """
import sys
import numpy as np
import agrik_fast as ik

assert ik.simd_level() == sys.argv[1]
answers = {}
for name in ("redundant7", "puma560", "cucumber", "strawberry"):
    robot = ik.Robot.load(name)
    poses = robot.fk(robot.random_q(1500, seed=3))
    targets = poses if robot.dof > 5 else poses[:, :3, 3]
    result = robot.ik(targets, threads=1)
    answers[f"{name} q"] = result.q
    answers[f"{name} success"] = result.success
    answers[f"{name} iterations"] = result.iterations
np.savez(sys.argv[2], **answers)
"""


@pytest.mark.timeout(300)
def test_levels_agree(tmp_path: Path) -> None:
    answers = {}
    for level in AVAILABLE:
        done = run(level, "-W", "error", "-c", SOLVE, level, tmp_path / f"{level}.npz")
        assert done.returncode == 0, done.stderr
        with np.load(tmp_path / f"{level}.npz") as archive:
            answers[level] = dict(archive)
    fused = [answers[level] for level in AVAILABLE if level != "scalar"]
    for one, other in itertools.pairwise(fused):
        for name, values in one.items():
            assert values.tobytes() == other[name].tobytes(), name
    for name in ("redundant7", "puma560", "cucumber", "strawberry"):
        shares = [found[f"{name} success"].mean() for found in answers.values()]
        assert min(shares) >= 0.999
        assert max(shares) - min(shares) <= 1e-3
        robot = ik.Robot.load(name)
        poses = robot.fk(robot.random_q(1500, seed=3))
        for level, found in answers.items():
            success = found[f"{name} success"]
            reached = robot.fk(found[f"{name} q"])[:, :3, 3]
            away = np.linalg.norm(reached - poses[:, :3, 3], axis=1)
            assert away[success].max() <= 1e-6, level


# ---- the compiled module -----------------------------------------------------------------------


def test_the_counting_itself() -> None:
    zmm = bytes.fromhex("62f2edc8b8c3 62d2fd4898c1")
    ymm = bytes.fromhex("c4e2edb8c3 c4c2fd98c1")
    # The same on scalars (sd), on single precision (W = 0), and on 128 bits (xmm).
    other = bytes.fromhex("c4e2edb9c3 62f26d48b8c3 c4e26db8c3 c4e2e9b8c3 62f2ed08b8c3")
    assert count_fused(zmm + other + ymm) == (1 + 1, 1 + 1)
    fused = array("I", [0x4E62CC20, 0x4EFDCFDF, 0x4FC91907, 0x4FD35107])
    # On single precision, on one double, and operations that are not fused.
    others = array("I", [0x4E22CC20, 0x4FA91107, 0x1F420C20, 0x5FC91907, 0x4E62D420, 0x4FC99907])
    assert count_fused_neon((fused + others).tobytes() + b"\0") == 4


def test_the_fast_path_is_in_the_module() -> None:
    assert_holds_fast_path(Path(str(native.__file__)).read_bytes())
