"""Play in joints whose last direction is known: where they stand, and what that does."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import motion
from agrik_fast.collision import Body, Box, Scene, SceneObject, Sphere
from agrik_fast.motion._case import Case
from agrik_fast.motion._play import followed

DRAWS = 4000
PLAY = 0.01
NONE = {"joint": 0.0, "slide": 0.0, "length": 0.0, "vision": 0.0}


def boom(way: float) -> tuple[ik.Robot, Scene]:
    """Return an arm of one joint with a ball 1 m out, and a wall `way` to its left."""
    arm = ik.Robot.from_dh([[1.0, 0, 0, 0]], name="boom")
    arm = arm.with_bodies([Body("ball", 1, Sphere([0, 0, 0], 0.05))])
    wall = SceneObject.of("wall", Box([1.0, 0.15 + way, 0], [0.4, 0.1, 0.4]))
    return arm, Scene([wall])


def test_a_joint_stands_half_its_play_behind() -> None:
    arm, scene = boom(0.02)
    errors = motion.Errors(**NONE, backlash=PLAY)
    left, right, unknown = (
        motion.sensitivity(arm, scene, [0.0], errors, moving=[sign]) for sign in (1, -1, 0)
    )
    # 1 m out it is 5 mm behind, so away from the wall where it came from the right.
    assert left.bias == pytest.approx([0, -0.005, 0], abs=2e-5)
    assert right.bias == pytest.approx([0, 0.005, 0], abs=2e-5)
    assert left.rms == pytest.approx(0.005, abs=1e-5)
    assert left.clearance[0] == pytest.approx(0.025, abs=2e-5)
    assert right.clearance[0] == pytest.approx(0.015, abs=2e-5)
    assert left.deviation[0] == right.deviation[0] == 0.0
    np.testing.assert_allclose(right.guaranteed, right.clearance)
    # Not known: the variance of an even error, and no bias.
    usual = motion.sensitivity(arm, scene, [0.0], errors)
    for found in (unknown, usual):
        assert (found.bias == 0).all()
        assert found.deviation[0] == pytest.approx(PLAY / math.sqrt(12), rel=1e-6)
        assert found.clearance[0] == pytest.approx(0.02, abs=1e-9)
        assert found.guaranteed[0] == pytest.approx(0.015, abs=1e-5)
    assert usual.rms == pytest.approx(PLAY / math.sqrt(12), rel=1e-6)


@pytest.mark.parametrize("sign", [1, -1, 0])
def test_formulas_agree_with_draws(sign: int) -> None:
    arm, scene = boom(0.007)
    errors = motion.Errors(**{**NONE, "vision": 3e-3}, backlash=PLAY)
    found = motion.sensitivity(arm, scene, [0.0], errors, moving=[sign])
    drawn = motion.simulate(arm, scene, [0.0], errors, moving=[sign], draws=DRAWS)
    assert found.rms == pytest.approx(drawn.rms, rel=0.05)
    error = math.sqrt(drawn.free * (1 - drawn.free) / DRAWS)
    # Even errors are no normal ones, but nearly so beside those of the vision.
    assert found.free == pytest.approx(drawn.free, abs=3 * error + (0.02 if sign == 0 else 0.002))
    assert {1: 0.99, -1: 0.75, 0: 0.95}[sign] == pytest.approx(found.free, abs=0.1)


def test_a_joint_of_an_arm_that_goes_back_and_forth() -> None:
    arm = ik.Robot.from_dh([[0.5, 0, 0, 0], [0.5, 0, 0, 0]], name="planar")
    arm = arm.with_bodies([Body("ball", 2, Sphere([0, 0, 0], 0.05))])
    case = Case(arm, Scene([]), motion.Errors(**NONE, backlash=PLAY))
    told = np.array([[0.0, 0.3], [0.1, 0.3], [0.06, 0.3], [0.06, 0.5]])
    starts = np.concatenate([told[:1], told[:-1]])
    middles, half = 0.5 * (starts + told), 0.5 * np.abs(told - starts)

    def follow(*signs: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return followed(case, middles, half, told, told[0], np.array(signs))

    middle, reach, play = follow(0, 0)
    assert (play[:, 0] == [PLAY, 0, 0, 0]).all() and (play[:, 1] == [PLAY, PLAY, PLAY, 0]).all()
    stands = middle[:, 0] + np.array([[-1], [1]]) * reach[:, 0]
    # Forth: anywhere in the play, until it is behind; back: it stays until all is taken up.
    np.testing.assert_allclose(stands[:, 1], [-0.005, 0.095], atol=1e-15)
    np.testing.assert_allclose(stands[:, 2], [0.065, 0.095], atol=1e-15)
    np.testing.assert_allclose(stands[:, 3], [0.065, 0.065], atol=1e-15)
    np.testing.assert_allclose(middle[3, 1] + reach[3, 1] * np.array([-1, 1]), [0.295, 0.495])
    # Known before: no width where it does not move.
    middle, reach, play = follow(-1, 1)
    assert (play == 0).all()
    np.testing.assert_allclose(middle[0], [0.005, 0.295], atol=1e-15)
    assert (reach[0] == 0).all()
    np.testing.assert_allclose(reach[1, 0], 0.045, atol=1e-15)


def corner() -> tuple[ik.Robot, Scene, np.ndarray]:
    """Return a Panda that comes near a box, turns round in some joints and leaves."""
    arm = ik.Robot.load("panda")
    start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    path = start + np.array(
        [[0, 0, 0, 0, 0, 0, 0], [0.8, 0.15, 0, 0.1, 0, 0, 0.3], [0.6, 0.25, 0, 0.15, 0, 0, 0.1]]
    )
    box = Box([0.5, 0.59, 0.35], [0.1, 0.1, 0.1])
    return arm, Scene([SceneObject.of("box", box)]), path


def dense(path: np.ndarray, count: int = 120) -> np.ndarray:
    pieces = itertools.pairwise(path)
    return np.concatenate([a + np.linspace(0, 1, count)[:, None] * (b - a) for a, b in pieces])


@pytest.mark.parametrize("moving", [np.zeros(7), np.ones(7), -np.ones(7)])
def test_what_is_certified_holds_wherever_joints_stand(moving: np.ndarray) -> None:
    """With play alone nothing is nearer than certified, but for joints that do not move."""
    arm, scene, path = corner()
    errors = motion.Errors(**NONE, backlash=0.012)
    # All joints move in the path, so that no play stays unknown.
    path = path + np.array([[0.0], [0.02], [0.01]]) * np.ones(7)
    found = motion.path_sensitivity(arm, scene, path, errors, moving=moving, resolution=5e-4)
    drawn = motion.simulate(arm, scene, dense(path), errors, moving=moving, draws=200)
    assert found.certified <= drawn.clearance.min() + 1e-9
    assert found.certified >= drawn.clearance.min() - 3e-3
    trajectory = motion.time_law(arm, path)
    smooth = motion.path_sensitivity(arm, scene, trajectory, errors, moving=moving, resolution=1e-3)
    points = trajectory.at(np.linspace(0, trajectory.duration, 300))[0]
    drawn = motion.simulate(arm, scene, points, errors, moving=moving, draws=100)
    assert smooth.certified <= drawn.clearance.min() + 1e-9
    assert smooth.certified >= drawn.clearance.min() - 6e-3


def test_paths_with_play_agree_with_draws() -> None:
    arm, scene, path = corner()
    errors = motion.Errors(vision=6e-3, backlash=0.012)
    shares = []
    for moving in (None, np.ones(7), -np.ones(7)):
        found = motion.path_sensitivity(arm, scene, path, errors, moving=moving, resolution=5e-4)
        drawn = motion.simulate(arm, scene, dense(path, 25), errors, moving=moving, draws=DRAWS)
        error = math.sqrt(max(drawn.free * (1 - drawn.free), 1 / DRAWS) / DRAWS)
        assert found.free <= drawn.free + 3 * error
        shares.append((found.free, drawn.free))
    assert all(0.3 < free < 1.0 for free, _ in shares), shares


def test_without_play_directions_change_nothing() -> None:
    arm, scene, path = corner()
    usual = motion.path_sensitivity(arm, scene, path)
    told = motion.path_sensitivity(arm, scene, path, moving=np.ones(7))
    assert usual.clearance.tobytes() == told.clearance.tobytes()
    assert usual.free == told.free
    one, other = (
        motion.simulate(arm, scene, path, draws=50, moving=moving) for moving in (None, np.ones(7))
    )
    np.testing.assert_allclose(one.clearance, other.clearance, atol=1e-12)
    for bad in ([1.0], np.full(7, np.nan)):
        with pytest.raises(ik.ArgumentError, match="moving"):
            motion.path_sensitivity(arm, scene, path, moving=bad)
        with pytest.raises(ik.ArgumentError, match="moving"):
            motion.simulate(arm, scene, path, moving=bad)
        with pytest.raises(ik.ArgumentError, match="moving"):
            motion.sensitivity(arm, scene, path[0], moving=bad)
