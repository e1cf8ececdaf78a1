"""The two-step method on made-up crops, each posture checked by a second opinion."""

from __future__ import annotations

import numpy as np
import pytest

import agrik_fast as ik
import numpy_harvest
from agrik_fast import harvest
from agrik_fast.collision import Scene, SceneObject, Target, greenhouse
from agrik_fast.harvest import Stage, Status

STATUSES = {
    "C1": Status.OK,
    "C2": Status.NO_COLLISION_FREE,
    "C3": Status.APPROACH_BLOCKED,
    "C4": Status.OK,
    "too_far": Status.OUT_OF_REACH,
    "too_low": Status.OUT_OF_REACH,
}


@pytest.fixture(scope="module")
def scene() -> Scene:
    return harvest.example_scene()


def balls(scene: Scene) -> dict[str, np.ndarray]:
    return {one.name: one.spheres * 1e3 for one in scene.objects if len(one.spheres)}


def check(scene: Scene, one: harvest.Decision, keep_mm: float = 5.0) -> None:
    target = scene.targets[one.name]
    q = one.q.copy()
    q[0] *= 1e3
    pose = numpy_harvest.tool(q)
    point = np.array(target.point) * 1e3
    assert np.abs(pose[:3, 3] - point - [0, 0, 1e3 * one.shift]).max() < 1e-9
    if one.tilt == 0:
        assert abs(pose[2, 0] + 1) < 1e-12
        assert np.abs(pose[:3, 2] - [np.cos(one.psi), np.sin(one.psi), 0]).max() < 1e-12
    assert (numpy_harvest.LIMITS[:, 0] <= q).all()
    assert (q <= numpy_harvest.LIMITS[:, 1]).all()
    exact = numpy_harvest.distance(q, balls(scene), target.objects)
    assert abs(exact - 1e3 * one.exact_distance) < 1e-9
    assert 1e3 * one.distance <= exact + 1e-9
    assert exact >= keep_mm
    half = np.diff(numpy_harvest.LIMITS[1:], axis=1)[:, 0] / 2
    margin = np.minimum(q[1:] - numpy_harvest.LIMITS[1:, 0], numpy_harvest.LIMITS[1:, 1] - q[1:])
    assert abs((margin / half).min() - one.freedom) < 1e-12


@pytest.mark.parametrize("distance", ["exact", "tree"])
@pytest.mark.parametrize("refine", [False, True])
def test_statuses(scene: Scene, distance: str, refine: bool) -> None:
    settings = harvest.Settings(refine=refine)
    found = harvest.plan("cucumber", scene, settings=settings, distance=distance)
    assert dict(zip(found.names, map(Status, found.status), strict=True)) == STATUSES
    assert found.ok.sum() == 2
    for one in found:
        assert one.ok == (one.status == Status.OK)
        if one.ok:
            check(scene, one)
        assert one.attempts or one.status in (Status.APPROACH_BLOCKED, Status.OUT_OF_REACH)


def test_numbers_of_the_reference(scene: Scene) -> None:
    exact = harvest.plan("cucumber", scene, ["C1", "C4"], method="full")
    assert 1e3 * exact["C1"].distance == pytest.approx(23.3, abs=0.05)
    assert 1e3 * exact["C4"].distance == pytest.approx(60.5, abs=0.05)
    assert exact["C4"].freedom == pytest.approx(0.30, abs=0.005)
    refined = harvest.Settings(refine=True)
    tree = harvest.plan("cucumber", scene, "C1", settings=refined, distance="tree")["C1"]
    assert 1e3 * tree.distance == pytest.approx(18.4, abs=0.05)
    assert 1e3 * tree.exact_distance == pytest.approx(23.2, abs=0.05)
    assert np.degrees(tree.psi) == pytest.approx(37.2, abs=0.05)
    assert tree.refined


@pytest.mark.parametrize("distance", ["exact", "tree"])
def test_the_full_scan_agrees(scene: Scene, distance: str) -> None:
    two = harvest.plan("cucumber", scene, distance=distance)
    full = harvest.plan("cucumber", scene, distance=distance, method="full")
    merged = np.where(two.status == Status.APPROACH_BLOCKED, Status.NO_COLLISION_FREE, two.status)
    assert (merged == full.status).all()
    assert (full.score >= two.score).all()


@pytest.mark.parametrize("distance", ["exact", "tree"])
def test_without_what_blocks_they_are_free(scene: Scene, distance: str) -> None:
    found = harvest.blockers("cucumber", scene, ["C2", "C3", "C1", "too_far"], distance=distance)
    assert found["too_far"] is None
    assert found["C1"] is not None
    assert found["C1"].names == ()
    for name, count in (("C2", 1), ("C3", 3)):
        blockers = found[name]
        assert blockers is not None
        assert blockers.exact
        assert len(blockers.names) == count
        assert all(scene[one].kind == "leaf" for one in blockers.names)
        cleared = scene.without(*blockers.names)
        one = harvest.plan("cucumber", cleared, name, distance=distance)[name]
        assert one.status == Status.OK
        check(cleared, one)


def test_recovery() -> None:
    scene = harvest.example_scene()
    spoilt = [[0.1838, 0.0623, 1.2533], [0.1665, -0.1802, 1.2886], [0.1918, -0.3177, 1.1925]]
    scene = scene.with_objects(SceneObject.cloud("spoilt", spoilt, 0.025, kind="leaf"))
    without = harvest.Settings(recovery=False)
    assert harvest.plan("cucumber", scene, "C1", settings=without).status[0] == (
        Status.NO_COLLISION_FREE
    )
    one = harvest.plan("cucumber", scene, "C1")["C1"]
    assert one.status == Status.OK
    assert one.stage == Stage.NEXT_ANGLE
    assert len(one.attempts) == 4
    assert [attempt.admissible for attempt in one.attempts[:3]] == [0, 0, 0]
    check(scene, one)


def test_any_thread_count_gives_the_same(scene: Scene) -> None:
    targets = {
        f"t{k}": Target((0.64, 0.04 + 0.01 * k, 1.07), ("C1", "stalk_C1")) for k in range(15)
    }
    settings = harvest.Settings(refine=True, tilt=0.1, shift=0.02)
    one = harvest.plan("cucumber", scene, targets, settings=settings, threads=1)
    two = harvest.plan("cucumber", scene, targets, settings=settings, threads=3)
    for name, column in one.columns.items():
        if name != "attempts":
            assert (column == two.columns[name]).all(), name


def test_words_are_those_of_the_core() -> None:
    statuses, stages = ik._native.harvest_words()
    assert statuses == [status.name for status in Status]
    assert stages == [stage.name.lower() for stage in Stage]


def test_bad_input(scene: Scene) -> None:
    leaf = scene["leaf_a"].spheres[0, :3]
    with pytest.raises(ik.ArgumentError, match="inside the obstacle 'leaf_a'"):
        harvest.plan("cucumber", scene, {"in_leaf": Target(leaf)})
    with pytest.raises(ik.ArgumentError, match="'C1' twice"):
        harvest.plan("cucumber", scene, ["C1", "C4", "C1"])
    both = Target((0.6, 0.0, 1.4))
    with pytest.raises(ik.ArgumentError, match="'same' twice"):
        harvest.plan("cucumber", scene, [("same", both), ("same", both)])
    with pytest.raises(ik.ArgumentError, match=r"robot.*slide.*first joint 'panda_joint1' turns"):
        harvest.plan("panda", scene, "C1")
    with pytest.raises(ik.ArgumentError, match=r"robot.*spherical wrist"):
        harvest.plan("strawberry", scene, "C1")
    with pytest.raises(ik.ArgumentError, match="without targets"):
        harvest.evaluate(Scene(scene.objects))
    with pytest.raises(ik.ArgumentError, match="all zero"):
        harvest.Settings(distance_weight=0, freedom_weight=0)
    with pytest.raises(ik.ArgumentError, match="all zero"):
        harvest.Weights(0, 0, 0)
    with pytest.raises(ik.UnknownNameError, match="C1"):
        harvest.plan("cucumber", scene, ["C9"])
    with pytest.raises(ik.UnknownNameError, match="tree"):
        harvest.plan("cucumber", scene, distance="three")  # type: ignore[arg-type]
    with pytest.raises(ik.ArgumentError, match=r"shape \(3,\)"):
        harvest.plan("cucumber", scene, np.zeros(3))
    bad = harvest.plan("cucumber", scene, np.array([[np.nan, 0, 1], [0.64, 0.04, 1.4]]))
    assert bad.status[0] == Status.BAD_INPUT
    assert np.isfinite(bad.q).all()
    assert (bad.distance == bad.distance).all()


def test_a_crop() -> None:
    crop = greenhouse(seed=3, plants=12, leaves=8, fruits=3, y0=-1.5, y1=1.5)
    seen = []
    found = harvest.evaluate(crop, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (36, 36)
    assert sum(found.shares().values()) == pytest.approx(1)
    assert found.share == found.decisions.ok.mean()
    assert found.seconds > 0
    rows = list(found.rows())
    assert len(rows) == 36
    blocked = np.isin(found.decisions.status, [Status.APPROACH_BLOCKED, Status.NO_COLLISION_FREE])
    assert set(found.blockers) == {
        name for name, one in zip(found.decisions.names, blocked, strict=True) if one
    }
    helped = 0
    for name, blockers in found.blockers.items():
        if blockers is not None and helped < 5:
            cleared = crop.without(*blockers.names)
            assert harvest.plan("cucumber", cleared, name).status[0] == Status.OK
            helped += 1
    assert helped > 0
    counts = dict(found.leaves())
    assert sum(counts.values()) == sum(len(b.names) for b in found.blockers.values() if b)
