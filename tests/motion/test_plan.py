"""Plans: against the problems of the reference, a second judge, and at their limits."""

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
from agrik_fast.collision import Body, Capsule, CollisionRules, Scene, SceneObject, Sphere
from agrik_fast.errors import ArgumentError

LoadRobot = Callable[[str], ik.Robot]
REST = np.array([0, 0, 0, -1.5, 0, 1.5, 0])
"""A posture of the panda that is free."""
DATA = Path(__file__).resolve().parents[2] / "rust/agrik-motion/tests/data"


def problems(name: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((DATA / f"problems_{name}.json").read_text())
    return found


def panda_problem(name: str) -> tuple[Any, Any]:
    row = next(row for row in problems("panda") if row["name"] == name)
    return np.array(row["start"]), np.array(row["goals"])


@pytest.mark.parametrize("row", [r for r in problems("panda") if r["robot"] == "panda"],
                         ids=lambda row: row["name"])  # fmt: skip
def test_problems_of_the_panda(row: dict[str, Any], load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), spec_scenes.scenes("panda")[row["scene"]]
    found = motion.plan(arm, row["start"], row["goals"] or np.zeros((0, 7)), scene)
    assert found.status.name == row["status"]
    if not found.ok:
        return
    np.testing.assert_array_equal(found.path[0], row["start"])
    np.testing.assert_array_equal(found.path[-1], found.goal)
    judged = path_checker.judge("panda", found.path, scene, arm.self_pairs.asked)
    assert judged.within_limits
    assert 0.002 <= found.certified <= judged.least + 1e-9
    assert motion.check(arm, found, scene, clear=0.002).safe


def with_ball(arm: ik.Robot) -> ik.Robot:
    """Return the arm of the window problem, which has a ball for a hand."""
    file = json.loads((DATA / "panda_tool.json").read_text())
    ball = next(body for body in file["bodies"] if body["name"] == "toolball")
    kept = [body for body in arm.bodies if body.name not in ("hand", "fingers")]
    assert [body.name for body in kept] == [body["name"] for body in file["bodies"][:-1]]
    # The last frame of the file is the joint's; ours is the flange's, 107 mm behind it.
    x, y, z = ball["centre"]
    shape = Sphere([x, y, z - 0.107], ball["radius"])
    rules = CollisionRules(pairs=[tuple(pair) for pair in file["self_pairs"]])
    return arm.with_bodies([*kept, Body("toolball", kept[-1].frame, shape)], rules)


def test_a_ball_that_is_shut_in_is_a_proof(load_robot: LoadRobot) -> None:
    row = next(row for row in problems("panda") if row["name"] == "window")
    arm, scene = with_ball(load_robot("panda")), spec_scenes.scenes("panda")["window"]
    found = motion.plan(arm, row["start"], row["goals"], scene)
    assert found.status.name == row["status"] == "PATH_IMPOSSIBLE"
    proof = found.proof
    assert proof is not None and proof.body == "toolball"
    assert proof.radius == pytest.approx(row["certificate"]["ball"])
    # The same by a search of our own through the cells, from the goal on.
    spheres = np.concatenate([one.spheres for one in scene.objects])
    least = proof.radius - proof.cell * np.sqrt(3) / 2

    def cell_of(point: Any) -> tuple[int, ...]:
        return tuple(np.rint((point - proof.origin) / proof.cell).astype(int).tolist())

    def is_open(cell: tuple[int, ...]) -> bool:
        centre = proof.origin + np.array(cell) * proof.cell
        away = np.linalg.norm(spheres[:, :3] - centre, axis=1) - spheres[:, 3]
        return bool(away.min() > least)

    inside = proof.goals if proof.at_goal else proof.start[None]
    outside = {cell_of(p) for p in (proof.start[None] if proof.at_goal else proof.goals)}
    todo = [cell_of(p) for p in inside]
    seen, count = set(todo), 0
    while todo:
        cell = todo.pop()
        count += 1
        assert cell not in outside
        for step in np.ndindex(3, 3, 3):
            near = tuple(c + s - 1 for c, s in zip(cell, step, strict=True))
            if near not in seen:
                seen.add(near)
                if is_open(near):
                    todo.append(near)
    assert count == proof.cells
    # What is not shut in is not proven: without the shell there is a path.
    assert motion.plan(arm, row["start"], row["goals"]).ok


def test_a_target_may_be_all_its_postures(load_robot: LoadRobot) -> None:
    scene = spec_scenes.scenes("panda")["bench"]
    start, goals = panda_problem("bench2")
    arm = load_robot("panda")
    pose = arm.fk(goals[0])
    found = motion.plan(arm, start, pose, scene)
    assert found.ok and len(found.goals) > 3
    np.testing.assert_allclose(arm.fk(found.path[-1]), pose, atol=1e-6)
    ur5 = load_robot("ur5")
    q = ur5.random_q(seed=3)
    branches, reached = motion.goals_of(ur5, ur5.fk(q))
    assert reached and len(branches) >= 2
    np.testing.assert_allclose(ur5.fk(branches), np.broadcast_to(ur5.fk(q), (len(branches), 4, 4)),
                               atol=1e-6)  # fmt: skip


def test_reasons_come_in_their_order(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), spec_scenes.scenes("panda")["bench"]
    start, goals = panda_problem("bench0")
    far = np.eye(4)
    far[0, 3] = 5.0

    def status(first: Any, aim: Any) -> str:
        return motion.plan(arm, first, aim, scene).status.name

    beyond = start.copy()
    beyond[1] = 3.0
    hits = next(q for q in arm.random_q(200, seed=1) if scene.collides(arm, q))
    assert status(beyond, goals) == "START_OUT_OF_LIMITS"
    assert status(hits, far) == "START_IN_COLLISION"
    assert status(start, far) == "OUT_OF_REACH"
    assert status(start, np.full((4, 4), np.nan)) == "BAD_INPUT"
    assert status(start, beyond) == "JOINT_LIMITS"
    assert status(start, hits) == "NO_COLLISION_FREE"
    assert status(start, np.zeros((0, 7))) == "NO_GOAL"
    assert status(start, start) == "OK"
    found = motion.plan(arm, hits, goals, scene)
    assert found.contact is not None and found.contact.distance <= 0.002
    late = motion.plan(arm, start, goals, scene, settings=motion.Settings(time_limit=1e-9))
    assert late.status.name == "TIME_LIMIT"
    few = motion.Settings(max_checks=50)
    assert motion.plan(arm, start, goals, scene, settings=few).status.name == "NO_PATH_FOUND"


def test_an_empty_scene_is_crossed_straight(load_robot: LoadRobot) -> None:
    arm = load_robot("ur5")
    start, goal = arm.home, arm.home + np.array([1.0, 0.1, 0.1, 0.2, 0.3, 0.4])
    found = motion.plan(arm, start, goal)
    assert found.how == "straight" and len(found.path) == 2
    # The same, again and in another place of the goals.
    again = motion.plan(arm, start, [goal, goal + 0.1])
    assert again.path.tobytes() == found.path.tobytes()


def test_the_same_seed_gives_the_same_bytes(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), spec_scenes.scenes("panda")["bench"]
    start, goals = panda_problem("bench0")
    paths = [
        motion.plan(arm, start, goals, scene, settings=motion.Settings(seed=seed))
        for seed in (1, 1, 2, 3)
    ]
    assert all(path.ok for path in paths)
    assert paths[0].path.tobytes() == paths[1].path.tobytes()


def test_a_fruit_on_the_way_is_not_swept_by_the_gripper(load_robot: LoadRobot) -> None:
    """The target may be touched near it alone; with a zone without end it is touched on the way."""
    from agrik_fast.collision import Target

    arm = load_robot("panda")
    rules = arm.collision_rules.may_touch_target
    assert rules
    a, b = REST.copy(), REST.copy()
    a[0], b[0] = -0.8, 0.8
    at = arm.fk(REST)[:3, 3]
    fruit = SceneObject.of("fruit", Sphere(at, 0.03))
    there = Target((at[0], at[1], at[2] + 1.0), ("fruit",))

    def check(radius: float) -> motion.Checked:
        scene = Scene([fruit], targets={"fruit": there}, touch_radius=radius)
        return motion.check(arm, [a, b], scene.aiming_at("fruit"))

    strict, simple = check(0.15), check(10.0)
    assert strict.status == motion.Outcome.HIT
    assert strict.contact is not None and strict.contact.other == "fruit"
    assert simple.safe or simple.contact.body not in rules  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"start": [0.0] * 6}, "start"),
        ({"start": [np.nan] * 7}, "start"),
        ({"goals": [[0.0] * 6]}, "goals"),
        ({"goals": [[np.inf] * 7]}, "goals"),
        ({"settings": 3}, "settings"),
        ({"prefer": "far"}, "prefer"),
        ({"scene": "bench"}, "scene"),
    ],
)
def test_bad_input_is_named(arguments: dict[str, Any], words: str, load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    given: dict[str, Any] = {"start": REST, "goals": REST, **arguments}
    with pytest.raises((ArgumentError, ValueError), match=words):
        motion.plan(arm, **given)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("clear", -0.1),
        ("cap", float("nan")),
        ("n_goals", 0),
        ("step", 0.0),
        ("rounds", -1),
        ("max_checks", 0),
        ("seed", -1),
        ("time_limit", 0.0),
        ("prove", 1),
    ],
)
def test_settings_are_checked(name: str, value: Any) -> None:
    with pytest.raises(ArgumentError, match=name):
        motion.Settings(**{name: value})


def test_a_held_thing_is_part_of_the_arm(load_robot: LoadRobot) -> None:
    arm = load_robot("panda").attach(Capsule([0, 0, 0], [0, 0, 0.4], 0.02), "tool", name="stick")
    start, goal = REST.copy(), REST.copy()
    goal[0] = 1.2
    post = SceneObject.of("post", Sphere([0.75, 0.35, 0.2], 0.08))
    found = motion.plan(arm, start, goal, Scene([post]))
    assert found.status in (motion.PathStatus.OK, motion.PathStatus.NO_PATH_FOUND)
    if found.ok:
        assert motion.check(arm, found, Scene([post]), clear=0.002).safe
