"""What is loaded when: a first answer, the help, and libraries that are extras.

Seconds and megabytes follow from it, and cannot be counted on a machine that others use.
"""

import json
import pkgutil
import subprocess
import sys

import pytest

import agrik_fast

# Libraries of extras, and what the base installation needs for files and for words.
EXTRAS = {
    "cobs", "collada", "cryptography", "dask", "distributed", "fsspec", "jax", "matplotlib",
    "pandas", "pyarrow", "robot_descriptions", "s3fs", "scipy", "serial", "torch", "trimesh",
    "xacrodoc",
}  # fmt: skip
WORDS = {"pydantic", "rich", "tomli_w", "typer"}
# Of the standard library, what takes more than a millisecond or a megabyte.
SLOW = {
    "asyncio", "concurrent", "csv", "difflib", "hashlib", "http", "logging", "multiprocessing",
    "socket", "ssl", "subprocess", "tempfile", "tomllib", "unittest", "xml",
}  # fmt: skip


def loaded(program: str, *, without: str = "") -> set[str]:
    """Return the top names of modules that a program loads, besides those of a first one."""
    text = (
        f"import json, sys\n{without}\nbefore = set(sys.modules)\n{program}\n"
        "print(json.dumps(sorted({name.partition('.')[0] for name in set(sys.modules) - before})))"
    )
    # Not `-I`: the package may be on a path that the environment names.
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("robot", ["ur5", "cucumber"])
def test_a_first_answer_loads_little_besides_numpy(robot: str) -> None:
    program = (
        "from agrik_fast import Robot\n"
        f"arm = Robot.load({robot!r})\n"
        "arm.ik([0.3, 0.2, 0.4])\n"
        "arm.ik([[1, 0, 0, 0.3], [0, 1, 0, 0.2], [0, 0, 1, 0.4], [0, 0, 0, 1]])"
    )
    found = loaded(program, without="import numpy")
    assert "agrik_fast" in found
    assert found & (EXTRAS | WORDS | SLOW) == set()


def test_a_first_answer_leaves_parts_of_the_package_alone() -> None:
    program = (
        "import sys\nfrom agrik_fast import Robot\nRobot.load('ur5').ik([0.3, 0.2, 0.4])\n"
        "print(*sorted(name for name in sys.modules if name.startswith('agrik_fast')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    found = set(done.stdout.split())
    assert "agrik_fast.robot" in found, done.stderr
    later = {"_bodies._urdf", "_bodies._surfaces", "_bodies._visuals", "rotations", "tasks"}
    later |= {"solvers", "collision", "io", "motion", "cli"}
    assert found & {f"agrik_fast.{name}" for name in later} == set()


def test_the_help_loads_no_numpy() -> None:
    program = (
        "from agrik_fast.cli import main\n"
        "sys.argv = ['agrik-fast', '--help']\n"
        "try:\n    main()\nexcept SystemExit:\n    pass"
    )
    assert loaded(program) & (EXTRAS | {"numpy", "pydantic", "rich"}) == set()
    # Of a command, typer itself asks pydantic about the kinds of its options.
    program = program.replace("'--help'", "'cluster', 'solve', '--help'")
    assert loaded(program) & (EXTRAS | {"numpy", "rich"}) == set()


def test_extras_are_loaded_where_they_are_used() -> None:
    names = [
        found.name
        for found in pkgutil.iter_modules(agrik_fast.__path__, "agrik_fast.")
        # Of these two their libraries are all that there is.
        if found.name not in ("agrik_fast.torch", "agrik_fast.jax", "agrik_fast.__main__")
    ]
    assert "agrik_fast.cluster" in names and "agrik_fast.drivers" in names
    found = loaded("\n".join(f"import {name}" for name in names))
    assert found & EXTRAS == set()


def test_modules_need_no_import_of_their_own() -> None:
    program = "import agrik_fast as ik\nik.tuning.tune, ik.tune.Tuning, ik.cluster.run, ik.arms"
    assert "agrik_fast" in loaded(program)
    with pytest.raises(AttributeError, match="has no attribute 'tunes'"):
        _ = agrik_fast.tunes  # type: ignore[attr-defined]
