"""What the specification's acceptance list asks of plans, beside what other files try of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
import spec_scenes
from agrik_fast import motion
from agrik_fast.collision import Scene, SceneObject, Sphere, Target

TESTS = Path(__file__).parents[1]
PROBLEMS = json.loads(
    (TESTS.parent / "rust/agrik-motion/tests/data/problems_panda.json").read_text()
)
FEASIBLE = [row for row in PROBLEMS if row["robot"] == "panda" and row["status"] == "OK"]
SEEDS = range(40)


def test_other_seeds_find_ways_too() -> None:
    """Different seeds: the same class of status in 99 % of the feasible set or more."""
    arm, scenes = ik.Robot.load("panda"), spec_scenes.scenes("panda")
    found: Counter[str] = Counter()
    for row in FEASIBLE:
        for seed in SEEDS:
            settings = motion.Settings(seed=seed)
            path = motion.plan(arm, row["start"], row["goals"], scenes[row["scene"]],
                               settings=settings)  # fmt: skip
            found[path.status.name] += 1
    assert found.total() == len(FEASIBLE) * len(SEEDS) >= 100
    assert found["OK"] >= 0.99 * found.total(), found


PLANS = """
import hashlib, json, sys
import agrik_fast as ik
import spec_scenes
from agrik_fast import harvest, motion

assert ik.simd_level() == sys.argv[1]
arm, scenes = ik.Robot.load("panda"), spec_scenes.scenes("panda")
whole = hashlib.sha256()
for row in json.loads(open(sys.argv[2]).read()):
    if row["robot"] == "panda" and row["goals"]:
        path = motion.plan(arm, row["start"], row["goals"], scenes[row["scene"]])
        whole.update(path.path.tobytes() + path.clearance.tobytes() + bytes([path.status]))
start = [0.75, 1.21107, -1.390711, 0.720078, -1.544961, 1.591286, 5.612817]
found = harvest.plan("cucumber", harvest.example_scene(), path=True, start=start)
for path in found.paths:
    whole.update(path.path.tobytes() + path.clearance.tobytes() + bytes([path.status]))
print(whole.hexdigest())
"""


@pytest.mark.timeout(300)
def test_paths_are_the_same_bytes_at_every_level_with_fused_arithmetic() -> None:
    def run(level: str, *words: str) -> subprocess.CompletedProcess[str]:
        path = os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])
        environment = {**os.environ, "AGRIK_SIMD": level, "PYTHONPATH": path}
        return subprocess.run(
            [sys.executable, "-W", "ignore", *words],
            env=environment, cwd=TESTS.parent, capture_output=True, text=True, check=False,
        )  # fmt: skip

    show = "import agrik_fast; print(agrik_fast.simd_level())"
    levels = [level for level in ("avx2", "avx512", "neon")
              if run(level, "-c", show).stdout.strip() == level]  # fmt: skip
    data = TESTS.parent / "rust/agrik-motion/tests/data/problems_panda.json"
    answers = set()
    for level in levels:
        done = run(level, "-c", PLANS, level, str(data))
        assert done.returncode == 0, done.stderr
        answers.add(done.stdout.strip())
    assert len(answers) <= 1


def fruit_between() -> tuple[ik.Robot, Any, np.ndarray, np.ndarray]:
    """Return an arm, how a scene looks with a touch radius, and two postures beside a fruit."""
    arm = ik.Robot.load("panda")
    rest = np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    a, b = rest.copy(), rest.copy()
    a[0], b[0] = -0.8, 0.8
    # Before the hand, so that no other body comes to it.
    at = (arm.fk(rest) @ [0, 0, 0.1, 1])[:3]
    fruit = SceneObject.of("fruit", Sphere(at, 0.03))
    there = Target((at[0], at[1], at[2] + 1.0), ("fruit",))

    def scene(radius: float) -> Scene:
        return Scene([fruit], targets={"fruit": there}, touch_radius=radius).aiming_at("fruit")

    return arm, scene, a, b


def test_a_plan_goes_round_the_fruit_that_it_may_touch_near_it_alone() -> None:
    arm, scene, a, b = fruit_between()
    hands = set(arm.collision_rules.may_touch_target)
    strict, simple = (motion.plan(arm, a, b, scene(radius)) for radius in (0.15, 10.0))
    assert strict.ok and simple.ok
    # Where it may be touched all along it is swept, and the strict rule says so.
    assert simple.how == "straight" != strict.how
    assert motion.check(arm, strict, scene(0.15), clear=0.002).safe
    swept = motion.check(arm, simple, scene(0.15))
    assert swept.status == motion.Outcome.HIT
    assert swept.contact is not None
    assert swept.contact.body in hands and swept.contact.other == "fruit"


def test_goals_at_the_start_and_no_way_between() -> None:
    arm = ik.Robot.load("panda")
    rest = np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    alone = motion.plan(arm, rest, rest, Scene([]))
    assert alone.ok and alone.path.shape == (1, 7) and len(alone.clearance) == 1
    assert motion.plan(arm, rest, np.zeros((0, 7)), Scene([])).status == motion.PathStatus.NO_GOAL
