"""Harvest postures with the ways into them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
import path_checker
from agrik_fast import harvest, motion
from agrik_fast.collision import Scene, greenhouse
from agrik_fast.errors import ArgumentError

LoadRobot = Callable[[str], ik.Robot]
START = [0.75, 1.21107, -1.390711, 0.720078, -1.544961, 1.591286, 5.612817]
"""Drawn back from the crop."""


@pytest.fixture(scope="module")
def rows() -> Scene:
    """Return a row that is stripped in the band of the fruits."""
    return greenhouse(3, plants=4, leaves=8, clear_band=(0.65, 1.3))


def test_every_path_is_accepted_by_a_second_judge(load_robot: LoadRobot, rows: Scene) -> None:
    arm = load_robot("cucumber")
    named = ["C1", "C2", "C3", "C4", "too_far"]
    crops: list[tuple[Scene, Any]] = [
        (harvest.example_scene(), named),
        (rows, list(rows.targets)[:2]),
    ]
    accepted = 0
    for scene, names in crops:
        found = harvest.plan(arm, scene, names, path=True, start=START)
        for one in found:
            path = one.path
            assert path is not None
            assert one.reachable_posture == one.ok and one.reachable_path == path.ok
            if not one.ok:
                assert path.status.name == one.status.name
                continue
            assert path.status in (
                motion.PathStatus.OK,
                motion.PathStatus.NO_PATH_FOUND,
                motion.PathStatus.PATH_IMPOSSIBLE,
            )
            if not path.ok:
                continue
            np.testing.assert_array_equal(path.path[0], START)
            target = scene.targets[one.name]
            np.testing.assert_allclose(arm.fk(path.path[-1])[:3, 3], target.point, atol=1e-5)
            judged = path_checker.judge("cucumber", path.path, scene, arm.self_pairs.asked, target)
            assert judged.within_limits
            assert 0.002 <= path.certified <= judged.least + 1e-9
            accepted += 1
    assert accepted >= 3


def test_threads_make_no_difference(load_robot: LoadRobot, rows: Scene) -> None:
    arm = load_robot("cucumber")

    def of(threads: int) -> list[bytes]:
        found = harvest.plan(arm, rows, path=True, start=START, threads=threads)
        return [path.path.tobytes() + path.clearance.tobytes() for path in found.paths]

    one = of(1)
    assert one == of(2) == of(7)


def test_postures_are_those_without_paths(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("cucumber"), harvest.example_scene()
    with_paths = harvest.plan(arm, scene, path=True, start=START)
    without = harvest.plan(arm, scene)
    np.testing.assert_array_equal(with_paths.q, without.q)
    np.testing.assert_array_equal(with_paths.status, without.status)
    with pytest.raises(ArgumentError, match="path"):
        _ = without.paths
    assert without[0].path is None and not without[0].reachable_path


def test_a_start_that_is_wrong_comes_first(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("cucumber"), harvest.example_scene()
    beyond = np.array(START)
    beyond[0] = 2.0
    found = harvest.plan(arm, scene, ["C1", "too_far"], path=True, start=beyond)
    assert [path.status.name for path in found.paths] == ["START_OUT_OF_LIMITS"] * 2
    assert found["C1"].reachable_posture and not found["C1"].reachable_path
    for bad in ([0.0] * 6, [np.nan] * 7):
        with pytest.raises(ArgumentError, match="start"):
            harvest.plan(arm, scene, ["C1"], path=True, start=bad)
    with pytest.raises(ArgumentError, match="path_settings"):
        harvest.plan(arm, scene, ["C1"], path=True, path_settings=3)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="two-step"):
        harvest.plan(arm, scene, ["C1"], path=True, method="full")


def test_what_stands_in_the_way_of_a_path_is_named(load_robot: LoadRobot) -> None:
    """A wall of leaves before the arm, in which no hole is left."""
    from agrik_fast.collision import SceneObject, Sphere

    arm, scene = load_robot("cucumber"), harvest.example_scene("cucumber_thin")
    name = next(iter(scene.targets))
    free = harvest.plan(arm, scene, [name], path=True, start=START)
    assert free.reachable_path.all()
    goal = arm.fk(free.paths[0].path[-1])
    # Balls round the tool where it begins: whatever it does, it has to leave through them.
    first = arm.fk(START)[:3, 3]
    shell = []
    for k in range(400):
        z = 1 - 2 * (k + 0.5) / 400
        r, angle = np.sqrt(1 - z * z), 2.399963229728653 * k
        at = first + 0.45 * np.array([r * np.cos(angle), r * np.sin(angle), z])
        shell.append(Sphere(at, 0.03))
    ball = SceneObject.of("shell", *shell, removable=True, kind="leaf")
    shut = scene.with_objects(ball)
    found = harvest.plan(arm, shut, [name], path=True, start=START)[name]
    assert not found.reachable_path
    if found.reachable_posture and found.path.status.name != "START_IN_COLLISION":  # type: ignore[union-attr]
        assert found.blockers_path == ("shell",)
    assert goal.shape == (4, 4)


def test_a_cycle_ends_in_the_crate(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("cucumber"), harvest.example_scene()
    found = harvest.cycle(arm, scene, "C4", START, start=START)
    assert found.ok, found.status
    assert [leg.name for leg in found.legs] == ["approach", "retreat", "to_crate"]
    at = np.array(START)
    for leg in found.legs:
        np.testing.assert_array_equal(leg.path[0], at)
        at = leg.path[-1]
        assert motion.check(leg.arm, leg.path, leg.scene, clear=0.002).safe
    np.testing.assert_array_equal(at, START)
    assert [body.name for body in found.legs[1].arm.bodies][-1].startswith("fruit")
    assert "C4" not in found.legs[1].scene.names
    blocked = harvest.cycle(arm, scene, "C3", START, start=START)
    assert not blocked.ok and blocked.legs == ()
