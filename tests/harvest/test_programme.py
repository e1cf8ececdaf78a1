"""The non-linear programme: its terms by a second opinion, its searches, other arms."""

from __future__ import annotations

import numpy as np
import pytest

import agrik_fast as ik
import numpy_harvest
from agrik_fast import harvest
from agrik_fast.collision import Scene, SceneObject, Target


@pytest.fixture(scope="module")
def programme() -> harvest.Programme:
    return harvest.Programme("cucumber", harvest.example_scene("cucumber_thin"), "C1")


def test_terms_are_the_equations(programme: harvest.Programme) -> None:
    scene = harvest.example_scene("cucumber_thin")
    arm = ik.Robot.load("cucumber")
    rng = np.random.default_rng(1)
    q = rng.uniform(arm.lower, arm.upper, (60, 7))
    terms = programme.terms(q)
    balls = {one.name: one.spheres * 1e3 for one in scene.objects if len(one.spheres)}
    point = np.array(scene.targets["C1"].point) * 1e3
    for k, row in enumerate(q):
        q_mm = row * [1e3, 1, 1, 1, 1, 1, 1]
        pose = numpy_harvest.tool(q_mm)
        off = 1e-3 * np.linalg.norm(pose[:3, 3] - point)
        assert terms.position[k] == pytest.approx(off, abs=1e-12)
        r = pose[:3, :3]
        tilt = [r[0, 0], r[1, 0], 1 + r[2, 0], r[2, 1], r[2, 2]]
        assert terms.orientation[k] == pytest.approx(np.linalg.norm(tilt), abs=1e-12)
        if terms.distance[k] > 0:
            away = numpy_harvest.distance(q_mm, balls, scene.targets["C1"].objects)
            assert 1e3 * terms.distance[k] == pytest.approx(away, abs=1e-9)
        nearness = np.clip(1 - terms.distance[k] / 0.075, 0, 1)
        assert terms.nearness[k] == pytest.approx(nearness, abs=1e-12)
    total = terms.position + terms.orientation + terms.nearness
    assert np.abs(terms.cost - total).max() < 1e-12
    weighed = harvest.Programme(
        "cucumber", scene, "C1", weights=harvest.Weights(2.0, 3.0, 0.5)
    ).terms(q)
    total = 2 * terms.position + 3 * terms.orientation + 0.5 * terms.nearness
    assert np.abs(weighed.cost - total).max() < 1e-12


def test_the_scan_is_exact(programme: harvest.Programme) -> None:
    best = programme.null_space()
    terms = programme.terms(best.q)
    assert terms.cost < 1e-6
    assert terms.accepted()
    assert 1e3 * terms.distance == pytest.approx(86.9, abs=0.06)


def test_searches(programme: harvest.Programme) -> None:
    evolution = programme.differential([0, 1])
    assert (evolution.terms.cost < 1e-6).all()
    assert evolution.terms.accepted().all()
    genetic = programme.genetic([3], generations=150)
    assert genetic.terms.cost[0] < 0.2
    for runs in (evolution, genetic):
        for history, cost in zip(runs.history, runs.terms.cost, strict=True):
            assert (np.diff(history) <= 0).all()
            assert history[-1] == pytest.approx(cost, abs=1e-12)
    again = programme.genetic([1, 3], generations=150, threads=2)
    assert (again.q[1] == genetic.q[0]).all()
    with pytest.raises(ik.UnknownNameError, match="mutation_rate"):
        programme.genetic(0, mutation_rat=0.1)
    with pytest.raises(ik.ArgumentError, match="population"):
        programme.differential(0, population=2)


@pytest.mark.parametrize("name", ["redundant7", "panda"])
def test_any_arm_with_a_scene(name: str) -> None:
    arm = ik.Robot.load(name)
    leaves = [[0.35, 0.25, 0.5], [0.4, -0.25, 0.45], [0.5, 0.2, 0.75]]
    scene = Scene([SceneObject.cloud("leaf", leaves, 0.03, kind="leaf", removable=True)])
    # Where the arm can bring a tool whose x axis points down.
    down = np.array([[0, 0, 1, 0.45], [0, 1, 0, 0.0], [-1, 0, 0, 0.7], [0, 0, 0, 1.0]])
    assert arm.ik(down).success
    programme = harvest.Programme(arm, scene, Target(down[:3, 3]))
    runs = programme.differential([0, 1, 2], generations=2000, population=100)
    best = runs.terms.cost.argmin()
    assert runs.terms.cost[best] < 1e-6
    assert runs.terms.accepted()[best]
    pose = arm.fk(runs.q[best])
    assert np.abs(pose[:3, 3] - down[:3, 3]).max() < 1e-6
    assert abs(pose[2, 0] + 1) < 1e-6
    assert scene.clearance(arm, runs.q[best]) > 0.07
