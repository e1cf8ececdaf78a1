"""Inverse kinematics among things to keep clear of, judged by a second program."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
import pytest

import agrik_fast as ik
import numpy_collision
import numpy_fk
import spec_scenes
from agrik_fast.collision import Body, Box, Capsule, HalfSpace, Scene, SceneObject, Sphere
from agrik_fast.errors import ArgumentError, UnknownNameError

LoadRobot = Callable[[str], ik.Robot]
COUNT = 60
# The second program looks closely at what may be nearer than this, m.
NEAR = 0.02
CASES = [
    *((arm, where) for arm in ("panda", "ur5", "redundant7")
      for where in ("bench", "wall", "greenhouse5")),
    ("cucumber", "scene"),
    ("cucumber", "greenhouse1"),
]  # fmt: skip


@functools.cache
def scene_of(arm: str, where: str) -> Scene:
    return spec_scenes.scenes("cucumber" if arm == "cucumber" else "panda")[where]


@functools.cache
def free_postures(arm: ik.Robot, scene: Scene, count: int) -> np.ndarray:
    q = arm.random_q(20 * count, seed=17)
    free = q[scene.clearance(arm, q, own=True, cap=0.01) > 0.002]
    assert len(free) >= count
    return free[:count]


@pytest.mark.parametrize(("name", "where"), CASES)
def test_answers_are_free_and_exact_by_a_second_program(
    name: str, where: str, load_robot: LoadRobot
) -> None:
    arm, scene = load_robot(name), scene_of(name, where)
    targets = arm.fk(free_postures(arm, scene, COUNT))
    found = arm.ik(targets, scene=scene, seed=3)
    assert found.success.mean() >= 0.99, np.bincount(found.status)
    assert (found.status == ik.Status.CONVERGED).tolist() == found.success.tolist()
    q = found.q[found.success]
    distance, angle = numpy_fk.pose_error(numpy_fk.fk(name, q), targets[found.success])
    assert distance.max() <= 1e-6 and angle.max() <= 1e-6
    limits = numpy_fk.limits(name)
    assert (q >= limits[:, 0]).all() and (q <= limits[:, 1]).all()
    outside, inside = numpy_collision.least_distances(
        name, q, scene, arm.self_pairs.asked, near=NEAR
    )
    assert outside.min() > 0.0 and inside.min() > 0.0
    told = np.minimum(found.clearance[found.success], NEAR)
    np.testing.assert_allclose(told, np.minimum(outside, inside), rtol=0, atol=1e-9)


def test_the_scene_matters(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), scene_of("panda", "greenhouse5")
    targets = arm.fk(free_postures(arm, scene, COUNT))
    plain = arm.ik(targets, seed=3)
    assert plain.clearance is None and plain.nearest_pair is None
    hits = scene.collides(arm, plain.q[plain.success])
    assert hits.mean() > 0.1  # so that keeping clear is worth something
    assert not scene.collides(arm, arm.ik(targets, seed=3, scene=scene).q).any()


@pytest.mark.parametrize("solver", ["lm", "dls", "closed_form", "de"])
def test_solvers_keep_clear(solver: str, load_robot: LoadRobot) -> None:
    arm = load_robot("puma560" if solver == "closed_form" else "panda")
    scene = scene_of("panda", "bench")
    targets = arm.fk(free_postures(arm, scene, 40))
    if solver == "de":
        targets = targets[:6]
    found = arm.ik(targets, solver=solver, scene=scene)
    assert found.success.mean() > 0.8
    assert not scene.collides(arm, found.q[found.success]).any()
    bad = ~found.success & (found.status == ik.Status.IN_COLLISION)
    assert scene.collides(arm, found.q[bad]).all()


@pytest.mark.parametrize("task", ["position", "axis"])
def test_tasks_with_freedom_keep_clear(task: str, load_robot: LoadRobot) -> None:
    arm, scene = load_robot("ur5"), scene_of("ur5", "bench")
    poses = arm.fk(free_postures(arm, scene, 60))
    given = "axis" if task == "axis" else "position"
    targets = poses if task == "axis" else poses[:, :3, 3]
    found = arm.ik(targets, task=given, scene=scene, clear=0.005)
    assert found.success.mean() >= 0.95
    gaps = scene.clearance(arm, found.q[found.success])
    assert gaps.min() > 0.005
    assert not scene.collides(arm, found.q[found.success]).any()


def test_what_cannot_be_reached_freely_says_what_hits_what(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    wall = SceneObject.of("wall", Box((0.55, 0, 0.5), (0.2, 0.6, 0.6)))
    scene = Scene([wall])
    pose = ik.rotations.pose((0.5, 0.0, 0.5), rpy=(np.pi, 0, 0))
    found = arm.ik(pose, scene=scene)
    assert ik.Status(int(found.status)) is ik.Status.IN_COLLISION and not found.success
    assert float(found.clearance) <= 0.0
    body, thing = found.nearest_pair
    assert thing == "wall" and body in {one.name for one in arm.bodies}
    # It reaches all the same: the least bad posture is no other target.
    assert float(found.position_error) <= 1e-6
    assert "in collision" in repr(found)
    free = arm.ik(pose, scene=scene.without("wall"))
    assert free.success and np.isfinite(free.clearance)


def test_clear_is_kept_from_the_scene(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), scene_of("panda", "bench")
    q = arm.random_q(3000, seed=4)
    q = q[(scene.clearance(arm, q) > 0.05) & ~scene.collides(arm, q)][:80]
    found = arm.ik(arm.fk(q), scene=scene, clear=0.04)
    assert found.success.mean() >= 0.95
    assert scene.clearance(arm, found.q[found.success]).min() > 0.04
    missed = found.status == ik.Status.IN_COLLISION
    assert (scene.clearance(arm, found.q[missed], own=True) <= 0.04).all()


def test_preferences_do_what_they_say(load_robot: LoadRobot) -> None:
    for name, solver in (("puma560", "closed_form"), ("panda", "lm")):
        arm, scene = load_robot(name), scene_of("panda", "bench")
        postures = free_postures(arm, scene, 60)
        targets = arm.fk(postures)
        answers = {
            prefer: arm.ik(targets, solver=solver, scene=scene, prefer=prefer, q0=postures)
            for prefer in ("first", "near", "clearance")
        }
        gaps = {key: scene.clearance(arm, one.q, own=True) for key, one in answers.items()}
        both = answers["first"].success & answers["clearance"].success
        assert both.mean() > 0.9
        if solver == "closed_form":
            # All branches are known: none is farther away than the one chosen.
            assert (gaps["clearance"][both] >= gaps["first"][both] - 1e-12).all()
        else:
            assert gaps["clearance"][both].mean() > 1.2 * gaps["first"][both].mean()
        # The start reaches the target and is free, so nothing is nearer to it.
        near = answers["near"].success
        assert near.mean() > 0.9
        away = np.abs(answers["near"].q[near] - postures[near]).max(axis=1)
        assert np.median(away) < 1e-5


def test_any_number_of_threads_and_pieces_gives_the_same(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("redundant7"), scene_of("redundant7", "wall")
    targets = arm.fk(free_postures(arm, scene, 90))
    for prefer in ("first", "clearance"):
        one = arm.ik(targets, scene=scene, prefer=prefer, seed=5, threads=1)
        for threads in (2, 7):
            many = arm.ik(targets, scene=scene, prefer=prefer, seed=5, threads=threads)
            np.testing.assert_array_equal(one.q, many.q)
            np.testing.assert_array_equal(one.status, many.status)
        parts = arm.ik_stream([targets[:31], targets[31:]], scene=scene, prefer=prefer, seed=5)
        np.testing.assert_array_equal(one.q, np.concatenate([part.q for part in parts]))
    shaped = arm.ik(targets.reshape(9, 10, 4, 4), scene=scene, prefer="clearance", seed=5)
    assert shaped.nearest_pair.shape == (9, 10, 2) and shaped.clearance.shape == (9, 10)
    np.testing.assert_array_equal(shaped.q.reshape(90, 7), one.q)


def test_held_objects_and_targets_count(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    shelf = SceneObject.of("shelf", Box((0.6, 0.0, 0.3), (0.2, 0.4, 0.02)))
    scene = Scene([shelf])
    # 0.3 m above the shelf, tool downwards: free with the hand alone.
    pose = ik.rotations.pose((0.55, 0.0, 0.62), rpy=(np.pi, 0, 0))
    assert arm.ik(pose, scene=scene).success
    stick = Capsule((0, 0, 0.0), (0, 0, 0.4), 0.01)
    held = arm.attach(stick, "tool", name="stick")
    found = held.ik(pose, scene=scene)
    assert found.status == ik.Status.IN_COLLISION
    assert list(found.nearest_pair) == ["stick", "shelf"]
    assert held.ik(pose, scene=scene.without("shelf")).success


def test_a_scene_of_another_arm_and_other_wrong_arguments(load_robot: LoadRobot) -> None:
    panda, ur5 = load_robot("panda"), load_robot("ur5")
    scene, pose = scene_of("panda", "bench"), panda.fk(panda.random_q(seed=1))
    with pytest.raises(ArgumentError, match="scene"):
        panda.ik(pose, scene=scene.collider(ur5))
    for wrong in ("bench.toml", 3, {}):
        with pytest.raises(ArgumentError, match="scene"):
            panda.ik(pose, scene=wrong)
    for clear in (-0.1, np.nan, "much"):
        with pytest.raises(ArgumentError, match="clear"):
            panda.ik(pose, scene=scene, clear=clear)
    with pytest.raises(UnknownNameError, match="prefer"):
        panda.ik(pose, scene=scene, prefer="best")
    with pytest.raises(ArgumentError, match="scene"):
        panda.ik(pose, clear=0.1)
    # Another tool makes no other arm.
    tool = ik.rotations.pose((0, 0, 0.1))
    assert panda.with_tool(tool).ik(pose, scene=scene).status is not None


def test_rows_that_are_no_targets_stay_what_they_are(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("ur5"), scene_of("ur5", "bench")
    targets = arm.fk(free_postures(arm, scene, 6))
    targets[1, :3, 3] = 30.0
    targets[3, 0, 3] = np.nan
    found = arm.ik(targets, scene=scene)
    assert found.status[1] == ik.Status.OUT_OF_REACH
    assert found.status[3] == ik.Status.BAD_INPUT
    assert found.success[[0, 2, 4, 5]].all()
    assert not np.isnan(found.clearance).any()


def test_an_arm_of_one_s_own_in_a_scene_of_one_s_own() -> None:
    """The way from nothing to free answers, as a user would go it."""
    rows = [[0, np.pi / 2, 0.3, 0], [0.4, 0, 0, 0], [0.35, 0, 0, 0]]
    arm = ik.Robot.from_dh(rows, limits=[(-3, 3)] * 3, name="mine").with_bodies(
        [
            Body("upper", 2, Capsule((-0.4, 0, 0), (0, 0, 0), 0.04)),
            Body("lower", 3, Capsule((-0.35, 0, 0), (0, 0, 0), 0.03)),
        ]
    )
    scene = Scene(
        [
            SceneObject.of("floor", HalfSpace((0, 0, 1), 0.0)),
            SceneObject.of("ball", Sphere((0.35, 0.0, 0.55), 0.08)),
        ]
    )
    # Elbow up goes through the ball, elbow down does not.
    point = arm.fk([0.0, -0.2, 0.9])[:3, 3]
    found = arm.ik(point, scene=scene)
    assert found.success and not scene.collides(arm, found.q)
    assert float(found.clearance) == pytest.approx(float(scene.clearance(arm, found.q, own=True)))
