"""The cucumber paper: its thirteen misprints, and the files that are made."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.papers import cucumber
from agrik_fast.papers.cucumber import MISPRINTS, Misprint

# Errors of the formulas as read, over the poses of the tests.
AS_READ = (472, 534, 115, 354, 568, 1.57, 568, 3.14, 0.754, 3.14, 3.14, 1.57, 1)


@pytest.fixture(scope="module")
def poses() -> cucumber._formulas.Pose:
    return cucumber.random_poses()


def test_thirteen_places() -> None:
    assert len(MISPRINTS) == len(AS_READ) == 13
    assert len({one.place for one in MISPRINTS}) == 13


@pytest.mark.parametrize(("misprint", "off"), list(zip(MISPRINTS, AS_READ, strict=True)))
def test_a_misprint(misprint: Misprint, off: float, poses: cucumber._formulas.Pose) -> None:
    assert misprint.corrected(poses) < 1e-9
    assert misprint.error(poses) == pytest.approx(off, rel=0.01)


def test_the_formulas_are_those_of_the_robot(poses: cucumber._formulas.Pose) -> None:
    arm = ik.Robot.load("cucumber")
    mine = arm.in_frame("frame0").fk(poses.q * [1e-3, 1, 1, 1, 1, 1, 1])
    off = mine - poses.tool * [[1, 1, 1, 1e-3]]
    off[:, 3, 3] = 0
    assert np.abs(off).max() < 1e-12


def test_tables(tmp_path: Path) -> None:
    from agrik_fast import harvest
    from agrik_fast.papers.cucumber._tables import search_runs, write_tables

    programme = harvest.Programme("cucumber", harvest.example_scene("cucumber_thin"), "C1")
    runs, seconds = search_runs(programme, seeds=2)
    files = write_tables(tmp_path, harvest.example_scene(), programme, runs, seconds)
    rows = {path.stem: list(csv.DictReader(io.StringIO(path.read_text()))) for path in files}
    assert len(rows["table1"]) == 7
    assert all(row["provenance"] for row in rows["table1"])
    assert len(rows["misprints"]) == 13
    assert {row["status"] for row in rows["decisions"] if row["target"] == "C1"} == {"OK"}
    assert [row["level"] for row in rows["spheres"][:4]] == ["0", "1", "2", "3"]
    assert float(rows["spheres"][3]["overestimate, mm"]) == pytest.approx(16.4, abs=0.1)
    assert len(rows["searches"]) == 7
    scan = rows["success"][2]
    assert scan["method"] == "null-space scan"
    assert (scan["runs"], scan["within 1 mm and 1e-3"], scan["J below 1e-6"]) == ("1", "1", "1")


def test_success_over_twenty_seeds() -> None:
    from agrik_fast import harvest
    from agrik_fast.papers.cucumber._tables import search_runs, success_rows

    programme = harvest.Programme("cucumber", harvest.example_scene("cucumber_thin"), "C1")
    rows = {row[0]: row for row in success_rows(programme, *search_runs(programme))}
    # Runs, how many reach the fruit, median J, how many end below 1e-6.
    assert rows["GA"][1:3] == [20, 15]
    assert rows["GA"][3] < 1e-3
    assert rows["DE"][1:3] == [20, 20]
    assert rows["DE"][4] == rows["DE"][1]


def test_the_simulated_cycle_adds_up() -> None:
    from agrik_fast.papers.cucumber._reproduce import _crop

    found = cucumber.field_cycle(_crop, crops=2)
    assert 0 <= found["success"] <= 1
    assert found["cycle"] == pytest.approx(65.2)
    assert found["per_cucumber"] == pytest.approx(65.2 * found["attempts"])
    sure = cucumber.field_cycle(_crop, crops=2, vision=0.0)
    assert sure["success"] >= found["success"]
    assert sure["attempts"] == pytest.approx(1)
