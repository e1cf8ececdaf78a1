"""One list of statuses and one of solvers, in the core; everything else says the same."""

import re
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import _native
from agrik_fast._names import solver_names
from agrik_fast.errors import UnknownNameError
from cli_runner import run_command


def test_statuses_are_the_cores() -> None:
    assert {status.name.lower(): status.value for status in ik.Status} == _native.statuses()
    # Files hold names by the place of their codes.
    assert [status.value for status in ik.Status] == list(range(len(ik.Status)))


def test_solver_names_are_those_that_a_robot_takes() -> None:
    arm = ik.Robot.load("puma560")
    pose = arm.fk(np.full(6, 0.3))
    with pytest.raises(UnknownNameError) as caught:
        arm.ik(pose, solver="ml")
    assert sorted(caught.value.known) == sorted(solver_names())
    for name in solver_names():
        task = "pose" if name == "closed_form" else "position"
        assert arm.ik(pose, task=task, solver=name).status in list(ik.Status)


def test_every_solver_class_has_its_name_in_the_list() -> None:
    classes = [getattr(ik.solvers, name) for name in ik.solvers.__all__]
    named = {it.name for it in classes if isinstance(it, type)}
    # "plain" takes the steps of a solver object, "auto" chooses among the others.
    assert named - {"plain"} == set(solver_names()) - {"auto"}


def test_help_and_docstring_name_every_solver() -> None:
    text = run_command("solve", "--help").stdout
    (option,) = re.findall(r"--solver.*?\[default:\s+\(?lm\)?\]", text, re.DOTALL)
    words = re.sub(r"\s+", " ", option).split(" ", 2)[2]
    listed = re.split(r", | or ", re.split(r"[.;]", words)[0])
    assert listed == list(solver_names())
    (entry,) = re.findall(r"solver : solver or a name.*?q0 :", ik.Robot.ik.__doc__ or "", re.DOTALL)
    quoted = re.findall(r'"([\w-]+)"', entry.partition("names are")[2])
    assert list(dict.fromkeys(quoted)) == list(solver_names())


@pytest.mark.parametrize("page", ["README.md", "docs/solvers.md"])
def test_pages_name_every_solver(repo_root: Path, page: str) -> None:
    text = (repo_root / page).read_text(encoding="utf-8")
    assert [name for name in solver_names() if f"`{name}`" not in text] == []
