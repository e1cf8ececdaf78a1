"""The wheel a user gets: built, installed where there is nothing else, and put to work."""

import os
import re
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from machine_code import assert_holds_fast_path

# Building takes seconds when cargo has the release build already, minutes when it has not.
pytestmark = pytest.mark.timeout(900)


def run(*command: str | Path, cwd: Path, environment: dict[str, str] | None = None) -> str:
    """Run a command that must succeed and return what it printed."""
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(repo_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel from the checkout."""
    out = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "maturin", "build", "--release", "--quiet"]
    run(*build, "--interpreter", sys.executable, "--out", out, cwd=repo_root)
    (path,) = out.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel and its requirements in an empty environment; return its `bin`."""
    folder = tmp_path_factory.mktemp("empty")
    venv.create(folder, with_pip=True)
    scripts = folder / ("Scripts" if sys.platform == "win32" else "bin")
    run(scripts / "python", "-m", "pip", "install", "--quiet", wheel, cwd=folder)
    run(scripts / "python", "-m", "pip", "check", cwd=folder)
    return scripts


def test_one_wheel_serves_every_python_from_3_11(wheel: Path) -> None:
    # A plain `linux` tag would be refused by the index: it promises no C library.
    system = r"manylinux_2_\d+_\w+(\.manylinux\w+)*" if sys.platform == "linux" else r".*"
    assert re.fullmatch(rf"agrik_fast-[\d.]+-cp311-abi3-{system}\.whl", wheel.name)


def test_the_source_distribution_builds_and_solves(repo_root: Path, tmp_path: Path) -> None:
    run(sys.executable, "-m", "maturin", "sdist", "--out", tmp_path, cwd=repo_root)
    (source,) = tmp_path.glob("agrik_fast-*.tar.gz")
    # Quickly compiled: what is asked is whether anything is missing.
    environment = {
        **os.environ,
        "CARGO_PROFILE_RELEASE_LTO": "off",
        "CARGO_PROFILE_RELEASE_OPT_LEVEL": "0",
        "CARGO_PROFILE_RELEASE_CODEGEN_UNITS": "16",
        "CARGO_TARGET_DIR": str(repo_root / "target" / "sdist"),
    }
    pip = (sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation")
    run(*pip, "--target", tmp_path / "site", source, cwd=tmp_path, environment=environment)
    program = (
        "import sys\n"
        f"sys.path.insert(0, {str(tmp_path / 'site')!r})\n"
        "import agrik_fast as ik\n"
        f"assert ik.__file__.startswith({str(tmp_path)!r})\n"
        "arm = ik.Robot.load('puma560')\n"
        "assert arm.ik(arm.fk(arm.random_q(20, seed=1))).success.all()\n"
    )
    run(sys.executable, "-I", "-W", "error", "-c", program, cwd=tmp_path)


def test_wheel_holds_robots_types_and_licences_and_nothing_of_the_checkout(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    for robot in ("strawberry", "cucumber", "hydrolek", "tomato", "redundant7"):
        assert f"agrik_fast/robot/bundled/{robot}.toml" in names
    assert {"agrik_fast/py.typed", "agrik_fast/_native.pyi"} <= set(names)
    assert {Path(name).name for name in names} >= {"LICENSE-MIT", "LICENSE-APACHE"}
    others = {name.split("/")[0] for name in names} - {"agrik_fast"}
    assert all(re.fullmatch(r"agrik_fast-.*\.(dist-info|libs)", name) for name in others), others


def test_wheel_holds_the_fast_path_for_every_processor(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (module,) = (name for name in archive.namelist() if "/_native." in name and name[-1] != "i")
        assert_holds_fast_path(archive.read(module))


def test_readme_example_solves_its_targets(
    repo_root: Path, installed: Path, tmp_path: Path
) -> None:
    examples = re.findall(
        r"^```python\n(.*?)^```", (repo_root / "README.md").read_text(), re.DOTALL | re.MULTILINE
    )
    assert len(examples) == 2
    program = tmp_path / "example.py"
    program.write_text("".join(examples) + "\nassert res.success.all(), res.status\n")
    # Warnings are errors here too, and -I keeps the checkout out of the import path.
    run(installed / "python", "-I", "-W", "error", program, cwd=tmp_path)


def test_command_line_solves_a_file(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "targets.csv").write_text("x_m,y_m,z_m\n0.20,0.10,0.05\n0.15,-0.10,0.10\n")
    run(
        *(installed / "agrik-fast", "solve", "tomato", "targets.csv"),
        *("-o", "result.csv", "--strict"),
        cwd=tmp_path,
    )
    rows = (tmp_path / "result.csv").read_text().splitlines()
    assert len(rows) == 3
    assert all("converged" in row for row in rows[1:])


def test_help_works_and_does_not_import_numpy(installed: Path, tmp_path: Path) -> None:
    assert "solve" in run(installed / "agrik-fast", "--help", cwd=tmp_path)
    program = (
        "import sys, agrik_fast.cli\n"
        "sys.argv = ['agrik-fast', '--help']\n"
        "try:\n"
        "    agrik_fast.cli.main()\n"
        "except SystemExit as stop:\n"
        "    assert not stop.code\n"
        "heavy = {'numpy', 'pydantic', 'pyarrow', 'matplotlib'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    run(installed / "python", "-I", "-c", program, cwd=tmp_path)
