"""Inverse kinematics that keeps clear of a scene, and of the arm itself."""

from __future__ import annotations

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import _native, errors


class Things:
    """A scene, as `Robot.ik` knows one: something that makes a collider for an arm."""

    def __init__(self, scene: _native.Scene) -> None:
        self.scene = scene

    def collider(self, arm: ik.Robot) -> _native.Collider:
        """Put a capsule along each link of an arm into the scene."""
        origins = arm.fk_links(np.zeros(arm.dof))
        names, frames, cores = [], [], []
        for frame in range(1, arm.dof + 1):
            into = np.linalg.inv(origins[frame - 1])
            before = np.eye(4) if frame == 1 else origins[frame - 2]
            back = (into @ before)[:3, 3]
            if np.linalg.norm(back) > 0.01:
                names.append(f"link{frame}")
                frames.append(frame)
                cores.append(np.array([[0, 0, 0], back]))
        kinds, radii = ["capsule"] * len(names), [0.04] * len(names)
        bodies = _native.Bodies(arm._chain, names, frames, kinds, cores, radii)
        return _native.Collider(bodies, self.scene)


@pytest.fixture(scope="module")
def things() -> Things:
    posts = [[0.35, 0.3, 0, 0.35, 0.3, 1.2, 0.04], [0.4, -0.25, 0, 0.4, -0.25, 1.2, 0.04]]
    floor = [[0, 0, 1, -0.15]]
    scene = _native.Scene(
        ["posts", "floor"],
        capsules=posts,
        capsule_labels=[0, 0],
        halfspaces=floor,
        halfspace_labels=[1],
    )
    return Things(scene)


def free_targets(arm: ik.Robot, things: Things, count: int, seed: int = 0):
    q = arm.random_q(20 * count, seed=seed)
    q = q[~things.collider(arm).collides(q)][:count]
    assert len(q) == count
    return q, arm.fk(q)


@pytest.mark.parametrize("name", ["redundant7", "ur5", "puma560"])
def test_targets_of_free_postures_are_reached_freely(load_robot, things, name):
    arm = load_robot(name)
    _, targets = free_targets(arm, things, 300)
    collider = things.collider(arm)
    plain = arm.ik(targets)
    assert collider.collides(plain.q).any()
    for solver in ("lm", "auto"):
        result = arm.ik(targets, solver=solver, scene=things)
        assert result.success.all(), result
        assert not collider.collides(result.q).any()
        assert np.abs(arm.fk(result.q) - targets).max() < 1e-5
        assert (result.clearance > 0).all()
        np.testing.assert_array_equal(result.clearance, collider.clearance(result.q))
        for threads in (1, 2, 7):
            again = arm.ik(targets, solver=solver, scene=collider, threads=threads)
            np.testing.assert_array_equal(again.q, result.q)
    assert plain.clearance is None
    assert plain.nearest_pair is None


def test_preferences(load_robot, things):
    arm = load_robot("redundant7")
    _, targets = free_targets(arm, things, 40, seed=1)
    clearance, away = {}, {}
    for prefer in ("first", "near", "clearance"):
        result = arm.ik(targets, scene=things, prefer=prefer)
        assert result.success.all()
        clearance[prefer] = np.mean(result.clearance)
        away[prefer] = np.mean(result.q**2)
    assert away["near"] < away["first"]
    # A climb along the motion that leaves the tool where it is: it finds the nearest top only.
    assert clearance["clearance"] > 1.03 * max(clearance["first"], clearance["near"])


def test_a_distance_is_kept(load_robot, things):
    arm = load_robot("ur5")
    q, targets = free_targets(arm, things, 200, seed=2)
    roomy = things.collider(arm).clearance(q, own=False) > 0.05
    result = arm.ik(targets[roomy], scene=things, clear=0.05)
    assert result.success.all()
    assert (things.collider(arm).clearance(result.q, own=False) > 0.05).all()


def test_where_all_postures_hit_the_least_bad_one_says_what(load_robot):
    arm = load_robot("ur5")
    target = arm.fk([0.3, -1.2, 1.4, -0.8, -1.2, 0.4])
    ball = _native.Scene(["ball"], spheres=[[*target[:3, 3], 0.1]], sphere_labels=[0])
    result = arm.ik(np.array([target, target]), scene=Things(ball))
    assert (result.status == ik.Status.IN_COLLISION).all()
    assert not result.success.any()
    assert (result.clearance <= 0).all()
    assert (result.position_error < 1e-6).all()
    body, other = result.nearest_pair[0]
    assert body.startswith("link")
    assert other == "ball" or other.startswith("link")
    assert "2 in collision" in repr(result)
    alone = arm.ik(target, scene=Things(ball))
    assert alone.nearest_pair.shape == (2,)
    assert alone.clearance.shape == ()


def test_streams_and_starts(load_robot, things):
    arm = load_robot("ur5")
    q, targets = free_targets(arm, things, 60, seed=3)
    whole = arm.ik(targets, scene=things)
    parts = list(arm.ik_stream([targets[:25], targets[25:]], scene=things))
    np.testing.assert_array_equal(np.concatenate([part.q for part in parts]), whole.q)
    near = arm.ik(targets, q0=q, scene=things)
    np.testing.assert_allclose(near.q, q, atol=1e-5)


def test_a_scene_for_nothing_changes_nothing(load_robot):
    arm = load_robot("puma560")
    targets = arm.fk(arm.random_q(300, seed=4))
    bare = _native.Bodies(arm._chain, [], [], [], [], [])
    nothing = _native.Collider(bare, _native.Scene([]))
    for solver in ("lm", "closed_form", "auto"):
        plain = arm.ik(targets, solver=solver)
        with_scene = arm.ik(targets, solver=solver, scene=nothing)
        np.testing.assert_array_equal(with_scene.q, plain.q)
        assert np.isinf(with_scene.clearance).all()
        assert (with_scene.nearest_pair == "").all()


def test_what_makes_no_sense_is_refused_by_name(load_robot, things):
    arm, other = load_robot("ur5"), load_robot("puma560")
    target = arm.fk(np.zeros(6))
    with pytest.raises(errors.ArgumentError, match=r"`scene`: .*puma560"):
        arm.ik(target, scene=things.collider(other))
    with pytest.raises(errors.ArgumentError, match="`scene`: "):
        arm.ik(target, scene="greenhouse")  # type: ignore[arg-type]
    with pytest.raises(errors.ArgumentError, match="`clear`: "):
        arm.ik(target, scene=things, clear=-0.1)
    with pytest.raises(errors.ArgumentError, match=r"`scene`: .*since"):
        arm.ik(target, clear=0.1)
    with pytest.raises(errors.UnknownNameError, match="prefer"):
        arm.ik(target, scene=things, prefer="nearest")  # type: ignore[arg-type]


def test_another_tool_makes_no_other_arm(load_robot, things):
    arm = load_robot("ur5")
    collider = things.collider(arm)
    tool = np.eye(4)
    tool[2, 3] = 0.1
    _, targets = free_targets(arm, things, 20, seed=5)
    result = arm.ik(targets @ tool, tool=tool, scene=collider)
    assert result.success.all()
    assert not collider.collides(result.q).any()
    longer = arm.with_tool(tool)
    assert longer.ik(targets @ tool, scene=collider).success.all()
