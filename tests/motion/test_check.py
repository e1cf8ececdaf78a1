"""Continuous checks of paths: against references, a second judge, and at their limits."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
import path_checker
import spec_scenes
from agrik_fast import motion
from agrik_fast.collision import Box, Scene, SceneObject, Sphere
from agrik_fast.errors import ArgumentError, SceneFileError

LoadRobot = Callable[[str], ik.Robot]
REST = np.array([0, 0, 0, -1.5, 0, 1.5, 0])
"""A posture of the panda that is free."""
DATA = Path(__file__).resolve().parents[2] / "rust/agrik-motion/tests/data"


def segments(name: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((DATA / f"segments_{name}.json").read_text())
    return found


def metres(name: str, q: Any) -> Any:
    """Return joint values of a file in m and rad."""
    values = np.array(q, dtype=float)
    if name == "cucumber":
        values[..., 0] *= 1e-3
    return values


@pytest.mark.parametrize("name", ["cucumber", "panda"])
def test_segments_have_the_outcomes_of_the_reference(name: str, load_robot: LoadRobot) -> None:
    arm, scenes = load_robot(name), spec_scenes.scenes(name)
    for row in segments(name):
        path = metres(name, [row["qa"], row["qb"]])
        scene = scenes[row["scene"]]
        found = motion.check(arm, path, scene)
        assert found.status.name == row["status"]
        assert motion.check(arm, path[::-1], scene).status == found.status
        if found.safe:
            judged = path_checker.judge(name, path, scene, arm.self_pairs.asked)
            assert found.certified <= judged.least + 1e-9
            assert found.contact is None and found.witness is None and found.segment == -1
        else:
            assert found.contact is not None and found.contact.distance <= 0
            assert scene.collides(arm, found.witness)
            assert found.contact.body in [body.name for body in arm.bodies]


def test_a_path_from_elsewhere_is_checked(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    poses = np.repeat(arm.fk(REST)[None], 40, axis=0)
    poses[:, 1, 3] += np.linspace(0, 0.1, 40)
    way = arm.follow(poses, q0=REST)
    assert way.success.all()
    assert motion.check(arm, way).safe
    at = poses[20, :3, 3]
    hit = motion.check(arm, way, Scene([SceneObject.of("ball", Sphere(at, 0.03))]))
    assert hit.status == motion.Outcome.HIT
    assert hit.contact is not None and hit.contact.other == "ball" and not hit.contact.is_own
    # A thing that no sample of 40 meets.
    assert repr(hit).startswith("Checked(39 pieces, HIT")


def test_a_wire_between_two_samples_is_not_missed(load_robot: LoadRobot) -> None:
    """A thing so thin that postures on both sides of it are free."""
    from agrik_fast.collision import Capsule

    arm = load_robot("panda")
    a, b = REST.copy(), REST.copy()
    a[0], b[0] = -0.6, 0.6
    x, _, z = arm.fk(REST)[:3, 3]
    wire = SceneObject.of("wire", Capsule([x, 0, z - 0.02], [x, 0, z + 0.02], 0.0005))
    ends = motion.check_segments(arm, [a, b], [a, b], Scene([wire]))
    assert ends.safe
    assert motion.check(arm, [a, b], Scene([wire])).status == motion.Outcome.HIT


def test_limits_clearances_and_batches(load_robot: LoadRobot) -> None:
    arm = load_robot("cucumber")
    scene = spec_scenes.scenes("cucumber")["scene"]
    q = arm.random_q(60, seed=4)
    found = motion.check_segments(arm, q[:-1], q[1:], scene, clear=0.01)
    path = motion.check(arm, q, scene, clear=0.01)
    for threads in (1, 2, 7):
        again = motion.check(arm, q, scene, clear=0.01, threads=threads)
        for name in ("outcome", "clearance", "at", "checks"):
            np.testing.assert_array_equal(getattr(again, name), getattr(path, name))
            np.testing.assert_array_equal(getattr(found, name), getattr(path, name))
    assert path.within_limits
    assert not motion.check(arm, arm.upper + 0.1).within_limits
    # What is told is what was asked for, and never more.
    near = motion.check(arm, q, scene, cap=0.02)
    assert (near.clearance <= 0.02).all()
    grazing = motion.check(arm, q[:2], scene, max_checks=5)
    assert grazing.status != motion.Outcome.SAFE


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"path": [[0.0] * 6]}, "shape"),
        ({"path": np.zeros((0, 7))}, "one row or more"),
        ({"path": [[np.nan] * 7]}, "finite"),
        ({"clear": -1.0}, "clear"),
        ({"clear": np.nan}, "clear"),
        ({"own_clear": -1.0}, "own_clear"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"max_checks": 0}, "checks"),
        ({"cap": 0.001, "clear": 0.01}, "cap"),
        ({"scene": 3}, "scene"),
        ({"arm": "panda"}, "arm"),
        ({"threads": 0}, "threads"),
    ],
)
def test_bad_input_is_named(arguments: dict[str, Any], words: str, load_robot: LoadRobot) -> None:
    given: dict[str, Any] = {"arm": load_robot("panda"), "path": [[0.0] * 7], **arguments}
    with pytest.raises(ArgumentError, match=words):
        motion.check(**given)


def test_an_arm_without_bodies_is_told_what_to_add() -> None:
    arm = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], name="planar")
    with pytest.raises(ArgumentError, match=r"\[\[collision\]\].*<collision>.*with_bodies"):
        motion.check(arm, [[0, 0], [1, 1]])
    with pytest.raises(ArgumentError, match="which has no bodies"):
        motion.plan(arm, [0, 0], [1, 1])


def test_scenes_that_are_wrong_are_refused(load_robot: LoadRobot) -> None:
    with pytest.raises(ArgumentError, match="radius"):
        Sphere([0, 0, 0], float("nan"))
    with pytest.raises(ArgumentError, match="radius"):
        Sphere([0, 0, 0], -1.0)
    with pytest.raises(ArgumentError, match="half"):
        Box([0, 0, 0], [0.1, -0.1, 0.1])
    ball = SceneObject.of("ball", Sphere([0, 0, 0], 1.0))
    with pytest.raises(ArgumentError, match="ball"):
        Scene([ball, ball])
    for pair, word in ((("finger", "ball"), "finger"), (("hand", "bell"), "bell")):
        with pytest.raises((ArgumentError, SceneFileError), match=word):
            motion.check(load_robot("panda"), [[0.0] * 7], Scene([ball], exemptions=[pair]))


def test_a_million_points_are_no_matter(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    points = np.random.default_rng(1).uniform(-2, 2, (1_000_000, 3))
    points = points[np.linalg.norm(points - [0, 0, 0.3], axis=1) > 1.3]
    assert len(points) > 800_000
    rows = np.concatenate([points, np.full((len(points), 1), 0.002)], axis=1)
    crop = Scene([SceneObject("crop", spheres=rows)])
    goal = REST + np.array([0.8, 0.1, 0, 0, 0, 0, 0])
    found = motion.plan(arm, REST, goal, crop)
    assert found.how == "straight"
    assert 0.002 <= found.certified <= crop.clearance(arm, np.stack([REST, goal])).min()


def test_scenes_without_end_and_far_away(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    path = np.array([REST, REST + 0.1])
    alone = motion.check(arm, path)
    assert alone.safe
    far = Scene([SceneObject.of("far", Sphere([1e4, 0, 0], 1.0))])
    np.testing.assert_array_equal(motion.check(arm, path, far).clearance, alone.clearance)
    assert motion.check(arm, REST).outcome.shape == (1,)
    assert motion.check(arm, [REST, REST]).safe
