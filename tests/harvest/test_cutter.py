"""Gripper and cutter as two bodies, and the cut on the stalk."""

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import Robot, harvest
from agrik_fast.collision import Box, Scene, greenhouse


@pytest.fixture(scope="module")
def scene() -> Scene:
    return harvest.example_scene()


def test_two_bodies_fill_the_room_of_one() -> None:
    one = {body.name: body.shape for body in Robot.load("cucumber").bodies}["gripper"]
    two = {body.name: body.shape for body in harvest.with_cutter().bodies}
    gripper, cutter = two["gripper"], two["cutter"]
    assert isinstance(one, Box) and isinstance(gripper, Box) and isinstance(cutter, Box)
    low = np.array([gripper.centre, cutter.centre]) - np.array([gripper.half, cutter.half])
    high = np.array([gripper.centre, cutter.centre]) + np.array([gripper.half, cutter.half])
    np.testing.assert_allclose(low.min(axis=0), np.subtract(one.centre, one.half), atol=1e-15)
    np.testing.assert_allclose(high.max(axis=0), np.add(one.centre, one.half), atol=1e-15)
    # The tool's x axis points down while the arm picks: the cutter is above.
    assert high[1, 0] == pytest.approx(low[0, 0], abs=1e-15)
    assert cutter.half[0] == pytest.approx(0.02)


def test_decisions_stay_as_they_are(scene: Scene) -> None:
    one = harvest.plan("cucumber", scene)
    two = harvest.plan(harvest.with_cutter(), scene)
    assert (one.status == two.status).all()
    assert (one.q == two.q).all()
    np.testing.assert_allclose(one.distance, two.distance, rtol=0, atol=1e-12)


def test_rules_of_the_gripper_hold_for_the_cutter() -> None:
    rules = harvest.with_cutter().collision_rules
    assert rules.may_touch_target == ("gripper", "flange", "cutter")
    assert rules.pairs is not None
    assert ("base", "cutter") in rules.pairs and ("base", "gripper") in rules.pairs


def test_the_cut_is_on_the_stalk(scene: Scene) -> None:
    found = harvest.plan("cucumber", scene)
    cut = harvest.cuts("cucumber", scene, found)
    assert cut.ok.tolist() == found.ok.tolist()
    # Worked out by hand: the stalk of C1 leans from the fruit's top, spheres of 8 mm.
    arm = Robot.load("cucumber")
    for name in ("C1", "C4"):
        at = (arm.fk(found[name].q) @ [-0.07, 0.0, 0.0, 1.0])[:3]
        spheres = scene[f"stalk_{name}"].spheres
        wanted = (np.linalg.norm(spheres[:, :3] - at, axis=1) - spheres[:, 3]).min()
        assert cut.distance[found.names.index(name)] == pytest.approx(max(0.0, wanted), abs=1e-7)
    assert np.isinf(cut.distance[~found.ok]).all()


def test_a_cut_beside_the_stalk_is_none(scene: Scene) -> None:
    found = harvest.plan("cucumber", scene, ["C1"])
    beside = harvest.Cutter(point=(-0.07, 0.05, 0.0))
    cut = harvest.cuts("cucumber", scene, found, beside)
    assert not cut.ok[0]
    assert 0.02 < cut.distance[0] < 0.06


def test_an_evaluation_says_so() -> None:
    crop = greenhouse(seed=1, plants=4, leaves=8, fruits=2, clear_band=(0.65, 1.3))
    found = harvest.evaluate(crop, stops=[-0.3, 0.3], blockers=False)
    assert found.decisions.ok.sum() >= 4
    assert found.cut.ok[found.decisions.ok].all()
    rows = [row for row in found.rows() if row["status"] == "OK"]
    assert all(row["cut_ok"] and 0.0 <= row["cut_mm"] <= 10.0 for row in rows)
    # The vehicle's place counts: the same decisions, had it not moved, would cut elsewhere.
    still = harvest.cuts("cucumber", crop, found.decisions)
    assert not still.ok.any()


def test_bad_input(scene: Scene) -> None:
    found = harvest.plan("cucumber", scene, ["C1"])
    with pytest.raises(ik.ArgumentError, match=r"robot.*a box named 'gripper'"):
        harvest.with_cutter("panda")
    with pytest.raises(ik.ArgumentError, match=r"height.*less than the gripper's 0.145 m"):
        harvest.with_cutter("cucumber", harvest.Cutter(height=0.2))
    with pytest.raises(ik.ArgumentError, match="reach"):
        harvest.Cutter(reach=-0.01)
    with pytest.raises(ik.ArgumentError, match="point"):
        harvest.Cutter(point=(np.nan, 0.0, 0.0))
    with pytest.raises(ik.ArgumentError, match=r"decisions.*harvest.plan"):
        harvest.cuts("cucumber", scene, "C1")  # type: ignore[arg-type]
    with pytest.raises(ik.ArgumentError, match=r"scene.*no target 'C1'"):
        harvest.cuts("cucumber", Scene([]), found)
    with pytest.raises(ik.ArgumentError, match=r"decisions.*7 values for an arm of 6"):
        harvest.cuts("ur5", scene, found)
