"""Errors of joints, lengths and vision: the formulas against errors drawn at random."""

from __future__ import annotations

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import harvest
from agrik_fast.harvest import Errors


@pytest.fixture(scope="module")
def postures() -> list[harvest.Decision]:
    return list(harvest.plan("cucumber", harvest.example_scene(), ["C1", "C4"], method="full"))


def test_formulas_agree_with_draws(postures: list[harvest.Decision]) -> None:
    scene = harvest.example_scene()
    for one in postures:
        found = harvest.sensitivity("cucumber", scene, one.name, one.q)
        drawn = harvest.simulate("cucumber", scene, one.name, one.q, draws=4000)
        assert found.clearance.min() == pytest.approx(one.exact_distance, abs=1e-9)
        assert 1e3 * found.rms == pytest.approx(8.95, abs=0.1)
        assert found.rms == pytest.approx(drawn.rms, rel=0.04)
        assert found.free <= found.nearest
        assert found.free == pytest.approx(drawn.free, abs=0.02)
        assert (found.guaranteed < found.clearance).all()


def test_near_things_are_a_risk(postures: list[harvest.Decision]) -> None:
    scene, one = harvest.example_scene(), postures[0]
    errors = Errors(vision=0.02)
    found = harvest.sensitivity("cucumber", scene, one.name, one.q, errors)
    drawn = harvest.simulate("cucumber", scene, one.name, one.q, errors, draws=4000)
    assert 0.5 < found.free < 0.95
    # Distance to a convex body is convex, so the linear formula is on the safe side.
    assert found.free <= drawn.free + 0.02
    assert drawn.free == pytest.approx(found.free_of_nearest, abs=0.15)
    again = harvest.simulate("cucumber", scene, one.name, one.q, errors, draws=4000, threads=2)
    assert (again.clearance == drawn.clearance).all()


def test_distance_for_a_probability(postures: list[harvest.Decision]) -> None:
    found = harvest.sensitivity("cucumber", harvest.example_scene(), "C1", postures[0].q)
    assert found.min_distance(0.5) == pytest.approx(0, abs=1e-9)
    assert 1e3 * found.min_distance(0.99) == pytest.approx(12, abs=1.0)
    assert found.min_distance(0.84) == pytest.approx(found.deviation.max(), rel=0.01)
    with pytest.raises(ik.ArgumentError, match="probability"):
        found.min_distance(1.0)


def test_each_error_alone(postures: list[harvest.Decision]) -> None:
    scene, one = harvest.example_scene(), postures[0]
    none = dict.fromkeys(("joint", "slide", "length", "backlash", "vision", "camera"), 0.0)
    for name, size in (
        ("joint", 0.002),
        ("slide", 0.001),
        ("length", 0.001),
        ("backlash", 0.004),
        ("vision", 0.003),
        ("camera", 0.002),
    ):
        errors = Errors(**{**none, name: size})
        found = harvest.sensitivity("cucumber", scene, one.name, one.q, errors)
        drawn = harvest.simulate("cucumber", scene, one.name, one.q, errors, draws=4000)
        assert drawn.rms == pytest.approx(found.rms, rel=0.05), name
        spread = float(np.std(drawn.clearance))
        assert spread <= 1.1 * found.deviation.max(), name
    with pytest.raises(ik.ArgumentError, match="vision"):
        Errors(vision=-1.0)
