"""Errors at postures and along paths: the reference's numbers, and errors drawn at random."""

from __future__ import annotations

import itertools
import json
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import harvest, motion
from agrik_fast.collision import Box, Scene, SceneObject
from spec_scenes import ROOT, scenes

REFERENCE = json.loads((ROOT / "tests/data/motion/sensitivity.json").read_text())
# What the reference's own simulations miss by, of 1,500 draws of the tool and 500 of the path.
DRAWS = 2000


def case(row: dict[str, Any]) -> tuple[ik.Robot, Scene, np.ndarray]:
    """Return arm, scene and posture of a row of the reference; what it lets touch is exempt."""
    arm = ik.Robot.load("cucumber")
    scene = harvest.example_scene() if row["scene"] == "scene" else scenes("cucumber")[row["scene"]]
    q = np.array([row["q"][0] / 1000, *row["q"][1:]])
    # The reference lets the gripper touch the fruit's stalk too, which a greenhouse's targets
    # do not name.
    stalk = f"stalk_{row['target']}"
    touching = [(body, stalk) for body in arm.collision_rules.may_touch_target]
    minded = Scene(scene.objects, targets=scene.targets, exemptions=touching)
    return arm, minded.aiming_at(row["target"]), q


@pytest.mark.parametrize("number", range(len(REFERENCE["rows"])))
def test_formulas_are_the_references(number: int) -> None:
    row = REFERENCE["rows"][number]
    arm, scene, q = case(row)
    found = motion.sensitivity(arm, scene, q)
    assert found.bodies == tuple(arm.compiled_bodies().names)
    np.testing.assert_allclose(1e3 * found.clearance, row["D_b"], atol=6e-4)
    assert 1e3 * found.clearance.min() == pytest.approx(row["D"], abs=1e-6)
    sigma = 1e3 * np.sqrt(np.diag(found.covariance))
    np.testing.assert_allclose(sigma, row["tcp_sigma_mm"], atol=6e-4)
    assert 1e3 * found.rms == pytest.approx(row["rms_tcp"], abs=6e-4)
    # Where several points are equally near, either is the nearest.
    np.testing.assert_allclose(1e3 * found.deviation, row["sigma_D"], atol=6e-3)
    assert found.nearest == pytest.approx(row["p_single"], abs=3e-4)
    assert found.free_of_nearest == pytest.approx(row["p_union_lower"], abs=3e-4)
    assert found.free <= found.free_of_nearest + 1e-9
    assert (found.guaranteed < found.clearance).all()


@pytest.mark.parametrize("number", range(len(REFERENCE["rows"])))
def test_formulas_agree_with_draws(number: int) -> None:
    row = REFERENCE["rows"][number]
    arm, scene, q = case(row)
    found = motion.sensitivity(arm, scene, q)
    drawn = motion.simulate(arm, scene, q, draws=DRAWS, seed=number)
    assert found.rms == pytest.approx(drawn.rms, rel=0.05)
    assert 1e3 * drawn.rms == pytest.approx(row["mc_rms"], rel=0.05)
    error = np.sqrt(max(drawn.free * (1 - drawn.free), 1e-4) / DRAWS)
    assert found.free <= drawn.free + 3 * error
    if row["D"] >= 1.4 * max(row["sigma_D"]):
        assert found.free == pytest.approx(drawn.free, abs=0.03)


def test_threads_change_nothing_and_seeds_do() -> None:
    arm, scene, q = case(REFERENCE["rows"][2])
    one = motion.simulate(arm, scene, q, draws=300, threads=1)
    two = motion.simulate(arm, scene, q, draws=300, threads=2)
    assert (one.clearance == two.clearance).all()
    other = motion.simulate(arm, scene, q, draws=300, seed=1)
    assert (one.clearance != other.clearance).any()


def shelf() -> tuple[ik.Robot, Scene, np.ndarray]:
    """Return a Panda that passes a box."""
    arm = ik.Robot.load("panda")
    start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    path = start + np.linspace(0, 1, 4)[:, None] * np.array([0.9, 0.2, 0, 0.1, 0, 0, 0.3])
    box = Box([0.5, 0.635, 0.35], [0.1, 0.1, 0.1])
    return arm, Scene([SceneObject.of("box", box)]), path


def test_paths_are_certified_and_the_bounds_hold() -> None:
    arm, scene, path = shelf()
    errors = motion.Errors(vision=0.01)
    found = motion.path_sensitivity(arm, scene, path, errors, resolution=5e-4)
    coarse = motion.path_sensitivity(arm, scene, path, errors, resolution=2e-2)
    dense = np.concatenate(
        [a + np.linspace(0, 1, 300)[:, None] * (b - a) for a, b in itertools.pairwise(path)]
    )
    least = float(scene.clearance(arm, dense).min())
    # Never more than what is sampled, and less by the resolution at most.
    assert least - 2e-3 <= found.certified <= least
    assert coarse.certified <= found.certified
    assert set(found.segment) == {0, 1, 2}
    drawn = motion.simulate(arm, scene, dense[::30], errors, draws=DRAWS)
    assert 0.3 < drawn.free < 1.0
    error = np.sqrt(drawn.free * (1 - drawn.free) / DRAWS)
    assert found.free <= drawn.free + 3 * error
    assert found.free <= found.segment_free.min()
    assert found.free <= found.nearest
    single = motion.sensitivity(
        arm, scene, dense[int(scene.clearance(arm, dense).argmin())], errors
    )
    assert found.free <= single.nearest + 1e-6


def test_guarantees_hold_for_the_worst_errors() -> None:
    arm, scene, path = shelf()
    errors = motion.Errors(
        joint=1e-3, slide=1e-3, length=0.0, backlash=2e-3, vision=2e-3, camera=1e-3
    )
    found = motion.path_sensitivity(arm, scene, path, errors)
    assert found.is_guaranteed == bool(found.guaranteed.min() > 0)
    rng = np.random.default_rng(4)
    for posture in path:
        told = motion.sensitivity(arm, scene, posture, errors)
        for _ in range(50):
            moved = posture + (errors.joint + errors.backlash / 2) * rng.choice([-1, 1], 7)
            turn, shift = errors.camera * rng.choice([-1, 1], 3), rng.choice([-1, 1], 3)
            pose = np.eye(4)
            pose[:3, 3] = errors.vision * shift
            pose[:3, :3] += np.cross(turn, np.eye(3)).T
            pose[:3, :3] = np.linalg.qr(pose[:3, :3])[0]
            pose[:3, :3] *= np.sign(np.diag(pose[:3, :3]))
            left = scene.moved(pose).clearance(arm, moved)
            assert left >= told.guaranteed.min() - 1e-5


def test_motions_are_looked_at_as_they_are() -> None:
    arm, scene, path = shelf()
    trajectory = motion.time_law(arm, path, blend=0.3)
    found = motion.path_sensitivity(arm, scene, trajectory)
    points = trajectory.at(np.linspace(0, trajectory.duration, 2000))[0]
    least = float(scene.clearance(arm, points).min())
    assert least - 5e-3 <= found.certified <= least
    assert set(found.segment) == {0}
    other = ik.Robot.load("ur5")
    with pytest.raises(ik.ArgumentError, match=r"path.*other joints"):
        motion.path_sensitivity(other, scene, trajectory)


@pytest.mark.parametrize("name", ["panda", "ur5", "strawberry", "iiwa14"])
def test_any_arm_has_lengths(name: str) -> None:
    arm = ik.Robot.load(name)
    scene = Scene([])
    q = arm.random_q(seed=4)
    if not arm.bodies:
        with pytest.raises(ik.ArgumentError, match="bodies"):
            motion.sensitivity(arm, scene, q)
        return
    none = dict.fromkeys(("joint", "slide", "length", "backlash", "vision", "camera"), 0.0)
    for number in ("joint", "length", "vision", "camera"):
        errors = motion.Errors(**{**none, number: 1e-3})
        found = motion.sensitivity(arm, scene, q, errors)
        drawn = motion.simulate(arm, scene, q, errors, draws=DRAWS)
        assert found.rms == pytest.approx(drawn.rms, rel=0.05), number
        assert found.bodies == ()
        # The posture is drawn: bodies of the arm may be in each other.
        assert found.free_of_nearest == 1.0 and (drawn.clearance == np.inf).all()


def test_bad_input() -> None:
    arm, scene, path = shelf()
    for call in (motion.sensitivity, motion.simulate):
        with pytest.raises(ik.ArgumentError, match="arm"):
            call("panda", scene, path[0])  # type: ignore[arg-type]
        with pytest.raises(ik.ArgumentError, match="scene"):
            call(arm, "box", path[0])  # type: ignore[arg-type]
        with pytest.raises(ik.ArgumentError, match="q"):
            call(arm, scene, path[0, :3])
        with pytest.raises(ik.ArgumentError, match="finite"):
            call(arm, scene, np.full(7, np.nan))
        with pytest.raises(ik.ArgumentError, match="errors"):
            call(arm, scene, path[0], 0.1)  # type: ignore[arg-type]
    with pytest.raises(ik.ArgumentError, match="draws"):
        motion.simulate(arm, scene, path[0], draws=0)
    with pytest.raises(ik.ArgumentError, match="q"):
        motion.simulate(arm, scene, np.zeros((0, 7)))
    with pytest.raises(ik.ArgumentError, match="resolution"):
        motion.path_sensitivity(arm, scene, path, resolution=0.0)
    with pytest.raises(ik.ArgumentError, match=r"resolution.*100000 postures"):
        motion.path_sensitivity(arm, scene, path, resolution=1e-9)
    with pytest.raises(ik.ArgumentError, match="waypoints"):
        motion.path_sensitivity(arm, scene, path[:, :3])
    with pytest.raises(ik.ArgumentError, match="vision"):
        motion.Errors(vision=-1.0)
    with pytest.raises(ik.ArgumentError, match="bodies"):
        motion.sensitivity(ik.Robot.from_dh([[1, 0, 0, 0]]), scene, [0.0])
