"""The fewest removable objects without which there is a path, against all sets of them."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import harvest, motion
from agrik_fast.collision import Scene
from agrik_fast.errors import ArgumentError
from gantries import centre, gantry, least_doors, opens, passages, rooms

START, GOAL = (0, 0), (3, 3)


def of(scene: Scene, size: int, **settings: Any) -> motion.PathBlockers | None:
    """Return what stands between the first room and the last."""
    return motion.blockers(
        gantry(size), centre((0, 0)), centre((size - 1, size - 1)), scene,
        settings=motion.Settings(**settings),
    )  # fmt: skip


def test_more_doors_in_a_row_are_no_answer() -> None:
    """The way that goes through when all doors are open is not the one with the fewest."""
    size = 4
    # Along the diagonal four doors of their own; round the corner one, in two places.
    free = {((0, 0), (0, 1)), ((0, 2), (0, 3)), ((0, 3), (1, 3)), ((2, 3), (3, 3))}
    doors = {
        "a": [((0, 1), (1, 1))],
        "b": [((1, 1), (2, 1))],
        "c": [((2, 1), (2, 2))],
        "d": [((2, 2), (2, 3))],
        "far": [((0, 1), (0, 2)), ((1, 3), (2, 3))],
    }
    listed = {one for each in doors.values() for one in each}
    walls = [one for one in passages(size) if one not in free | listed]
    assert least_doors(size, walls, doors, START, GOAL) == 1
    found = of(rooms(size, walls, doors), size)
    assert found is not None
    assert found.names == ("far",) and found.at_least == 1
    assert found.fewest in (motion.Fewest.PROVEN, motion.Fewest.SEARCHED)
    without = rooms(size, walls, doors).without("far")
    assert motion.check(gantry(size), found.path, without, clear=0.002).safe
    told = motion.check(gantry(size), found.path, without, clear=0.002, cap=0.05)
    np.testing.assert_allclose(found.path.clearance, told.clearance, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_the_number_is_that_of_all_sets(seed: int) -> None:
    size, rng = 3, np.random.default_rng(seed)
    walls, doors = [], {f"door{k}": [] for k in range(5)}  # type: ignore[var-annotated]
    for one in passages(size):
        draw = rng.uniform()
        if draw < 0.25:
            walls.append(one)
        elif draw < 0.85:
            doors[f"door{rng.integers(5)}"].append(one)
    doors = {name: shut for name, shut in doors.items() if shut}
    truth = least_doors(size, walls, doors, (0, 0), (size - 1, size - 1))
    found = of(rooms(size, walls, doors), size)
    if truth is None:
        assert found is None
        return
    assert found is not None
    assert found.fewest != motion.Fewest.STOPPED
    assert len(found.names) == truth == found.at_least
    assert opens(size, walls, doors, found.names, (0, 0), (size - 1, size - 1))
    again = of(rooms(size, walls, doors), size)
    assert again is not None and again.names == found.names
    assert again.path.path.tobytes() == found.path.path.tobytes()


def test_what_shuts_the_start_and_the_goal_in_is_a_proof() -> None:
    size = 3
    doors = {
        "first": [((0, 0), (0, 1)), ((0, 0), (1, 0))],
        "last": [((1, 2), (2, 2)), ((2, 1), (2, 2))],
        "other": [((0, 1), (1, 1))],
    }
    found = of(rooms(size, [], doors), size)
    assert found is not None
    assert found.names == ("first", "last")
    assert found.fewest == motion.Fewest.PROVEN and found.at_least == 2
    assert found.path.ok and found.plans >= 3 and found.checks > 0


def test_an_effort_that_ends_is_told() -> None:
    size = 3
    doors = {f"door{k}": [one] for k, one in enumerate(passages(size))}
    settings = {"rounds": 30, "prove": False}
    full = of(rooms(size, [], doors), size, **settings)
    assert full is not None and full.fewest == motion.Fewest.SEARCHED
    assert len(full.names) == 4
    # So few that the first plans take all of them.
    short = of(rooms(size, [], doors), size, max_checks=full.checks // 16, **settings)
    assert short is not None and short.fewest == motion.Fewest.STOPPED
    assert 1 <= short.at_least <= len(short.names)
    assert len(short.names) >= 4
    assert motion.check(
        gantry(size), short.path, rooms(size, [], doors).without(*short.names), clear=0.002
    ).safe


def test_nothing_in_the_way_and_nothing_that_helps() -> None:
    size = 2
    free = of(rooms(size, [], {"door": [((0, 0), (0, 1))]}), size)
    assert free is not None and free.names == () and free.at_least == 0
    assert free.fewest == motion.Fewest.PROVEN and free.path.ok
    assert of(rooms(size, passages(size), {}), size, rounds=5) is None
    for argument, given in (("start", [0.0]), ("goals", [[np.nan, 0.0]])):
        arguments = {"start": [0.1, 0.1], "goals": [0.1, 0.2], argument: given}
        with pytest.raises(ArgumentError, match=argument):
            motion.blockers(gantry(2), **arguments)


FRUIT_START = [0.75, 1.21107, -1.390711, 0.720078, -1.544961, 1.591286, 5.612817]


def test_of_a_fruit_they_are_fewest_and_the_same_on_all_threads() -> None:
    """With ways that cost little alone: the leaves that such a way needs gone."""
    arm, scene = ik.Robot.load("cucumber"), harvest.example_scene()
    cheap = motion.Settings(rounds=0, retreats=False, prove=False)

    def of(scene: Scene, threads: int = 1) -> harvest.Decision:
        return harvest.plan(
            arm, scene, ["C1"], path=True, start=FRUIT_START, path_settings=cheap, threads=threads
        )["C1"]

    found = of(scene)
    assert found.reachable_posture and not found.reachable_path
    names = found.blockers_path
    assert names is not None and len(names) >= 1
    assert found.blockers_fewest == motion.Fewest.SEARCHED
    assert found.blockers_at_least == len(names)
    assert of(scene, 2).blockers_path == names
    removable = [one.name for one in scene.objects if one.removable]
    for count in range(1, len(names)):
        for gone in itertools.combinations(removable, count):
            assert not of(scene.without(*gone)).reachable_path, gone
    without = of(scene.without(*names))
    assert without.reachable_path and without.blockers_path is None
    assert without.blockers_fewest is None and without.blockers_at_least is None
