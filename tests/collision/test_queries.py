"""Queries of scenes: against references, by brute force, at their limits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import agrik_fast as ik
import numpy_collision
import numpy_fk
import spec_scenes
from agrik_fast.collision import (
    Body,
    Box,
    Capsule,
    Convex,
    HalfSpace,
    Scene,
    SceneObject,
    Sphere,
    Target,
    greenhouse,
)
from agrik_fast.errors import ArgumentError, UnknownNameError

LoadRobot = Callable[[str], ik.Robot]
# A digit of the reference's files is 1e-7 of their unit.
DIGIT = 0.51e-7


@pytest.mark.parametrize("name", ["cucumber", "panda"])
def test_every_body_is_as_far_away_as_the_reference_says(name: str, load_robot: LoadRobot) -> None:
    arm, rows, scale = load_robot(name), spec_scenes.postures(name), spec_scenes.PER_METRE[name]
    compared = 0
    for where, scene in spec_scenes.scenes(name).items():
        mine = [row for row in rows if where in row]
        if not mine:
            continue
        q = spec_scenes.joint_values(name, mine)
        found = scene.distances(arm, q)
        expected = np.array([row[where]["D"] for row in mine], dtype=float)
        known = np.isfinite(expected)
        np.testing.assert_allclose(
            found.distance[known] * scale, expected[known], rtol=0, atol=DIGIT
        )
        # What stands on the ground is not asked about it.
        assert (np.isinf(found.distance) == ~known).all()
        least = np.array([row[where]["min"] for row in mine])
        np.testing.assert_allclose(scene.clearance(arm, q) * scale, least, rtol=0, atol=DIGIT)
        nearest = found.object_names[np.arange(len(q)), found.distance.argmin(axis=1)]
        assert nearest.tolist() == [row[where]["object"] for row in mine]
        own = np.array([row["self"] for row in mine])
        np.testing.assert_allclose(found.own_distance * scale, own, rtol=0, atol=DIGIT)
        assert found.own_names.tolist() == [row["self_pair"] for row in mine]
        hits = (least <= 0) | (own <= 0)
        assert scene.collides(arm, q).tolist() == hits.tolist()
        both = scene.clearance(arm, q, own=True)
        assert ((both <= 0) == hits).all()
        cap = 0.05
        np.testing.assert_array_equal(
            scene.clearance(arm, q, cap=cap), np.minimum(scene.clearance(arm, q), cap)
        )
        np.testing.assert_array_equal(
            scene.collides(arm, q, clear=0.02), (least / scale <= 0.02) | (own <= 0)
        )
        compared += len(q)
    assert compared == 300


@pytest.mark.parametrize("name", ["cucumber", "panda", "ur5", "redundant7"])
def test_a_second_program_finds_the_same_distances(name: str, load_robot: LoadRobot) -> None:
    arm = load_robot(name)
    q = arm.random_q(6 if name == "cucumber" else 12, seed=11)
    where = "greenhouse2" if name == "cucumber" else "bench"
    scene = spec_scenes.scenes("cucumber" if name == "cucumber" else "panda")[where]
    asked = arm.self_pairs.asked
    outside, inside = numpy_collision.least_distances(name, q, scene, asked)
    np.testing.assert_allclose(scene.clearance(arm, q, cap=0.3), outside, rtol=0, atol=1e-9)
    own = np.minimum(scene.distances(arm, q).own_distance, 0.3)
    # Cores that meet have no depth that means anything.
    apart = (own > 0) | (inside > 0)
    np.testing.assert_allclose(own[apart], inside[apart], rtol=0, atol=1e-9)
    assert ((own <= 0) == (inside <= 1e-12)).all()


def test_witness_points_are_as_far_apart_as_is_said(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), spec_scenes.scenes("panda")["greenhouse5"]
    q = arm.random_q(200, seed=2)
    found = scene.distances(arm, q)
    apart = found.distance > 0
    apart &= np.isfinite(found.distance)
    gap = np.linalg.norm(found.on_body - found.on_object, axis=-1)
    np.testing.assert_allclose(gap[apart], found.distance[apart], rtol=0, atol=1e-12)
    own = np.linalg.norm(found.own_points[:, 0] - found.own_points[:, 1], axis=-1)
    free = found.own_distance > 0
    np.testing.assert_allclose(own[free], found.own_distance[free], rtol=0, atol=1e-12)
    assert found.bodies == tuple(body.name for body in arm.bodies)
    assert found.objects == scene.names


def test_the_gradient_is_that_of_finite_differences(load_robot: LoadRobot) -> None:
    for name, where in (("panda", "greenhouse5"), ("cucumber", "greenhouse1")):
        arm, scene = load_robot(name), spec_scenes.scenes(name)[where]
        q = arm.random_q(300, seed=5)
        for own in (False, True):
            clearance, slope = scene.gradient(arm, q, own=own)
            np.testing.assert_array_equal(clearance, scene.clearance(arm, q, own=own))
            step = 1e-6
            sides = [
                scene.clearance(arm, q[:, None] + sign * step * np.eye(arm.dof), own=own)
                for sign in (1, -1)
            ]
            ahead, behind = (side - clearance[:, None] for side in sides)
            # Where another pair becomes the nearest within the step, the slope has a corner.
            smooth = (clearance > 1e-3) & (np.abs(ahead + behind).max(axis=1) < 1e-9)
            assert smooth.sum() > 100
            np.testing.assert_allclose(
                slope[smooth], (ahead - behind)[smooth] / (2 * step), atol=2e-4
            )
    far, none = scene.gradient(arm, q[0], cap=1e-9)
    assert (none == 0).all() and far <= 1e-9


def test_shapes_threads_and_repetition(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), spec_scenes.scenes("panda")["wall"]
    q = arm.random_q((3, 500), seed=1)
    one = scene.distances(arm, q, threads=1)
    assert one.distance.shape == (3, 500, 12) and one.own_points.shape == (3, 500, 2, 3)
    for threads in (2, 7):
        many = scene.distances(arm, q, threads=threads)
        for field in vars(one):
            assert np.array_equal(getattr(one, field), getattr(many, field)), field
        for ask in (scene.collides, scene.clearance):
            assert np.array_equal(ask(arm, q, threads=1), ask(arm, q, threads=threads))
    assert scene.collides(arm, q[0, 0]).shape == ()
    assert scene.clearance(arm, q[:0]).shape == (0, 500)
    gap, slope = scene.gradient(arm, q[0, 0])
    assert gap.shape == () and slope.shape == (7,)
    assert scene.collider(arm) is scene.collider(arm)


def test_an_empty_scene_is_infinitely_far_away(load_robot: LoadRobot) -> None:
    for name in ("panda", "cucumber", "tomato"):
        arm = load_robot(name)
        q = arm.random_q(50, seed=1)
        assert np.isinf(Scene().clearance(arm, q)).all()
        found = Scene().distances(arm, q)
        assert np.isinf(found.distance).all() and (found.nearest == -1).all()
        assert (found.object_names == "").all() and np.isfinite(found.own_distance).all()
        own = found.own_distance <= 0
        assert Scene().collides(arm, q).tolist() == own.tolist()
        assert Scene([SceneObject("nothing")]).collides(arm, q).tolist() == own.tolist()
        gap, slope = Scene().gradient(arm, q)
        assert np.isinf(gap).all() and (slope == 0).all()


def test_a_scene_ten_kilometres_away(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    q = arm.random_q(20, seed=1)
    away = np.eye(4)
    away[:3, 3] = 6_000.0, -8_000.0, 0.0
    near = spec_scenes.scenes("panda")["greenhouse5"]
    far = near.moved(away)
    gap = far.clearance(arm, q)
    outside, _ = numpy_collision.least_distances("panda", q, far, (), near=1e6)
    np.testing.assert_allclose(gap, outside, rtol=1e-12)
    assert (np.abs(gap - 10_000) < 3).all()
    assert far.collides(arm, q).tolist() == Scene().collides(arm, q).tolist()
    # An arm that stands there as well sees what it saw here, to the digits that are left.
    there = arm.with_base(away)
    np.testing.assert_allclose(far.clearance(there, q), near.clearance(arm, q), atol=1e-8)


def test_a_million_points(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    random = np.random.default_rng(8)
    points = random.uniform(-1.5, 1.5, (1_000_000, 3))
    radii = random.uniform(0.0, 0.004, len(points))
    scene = Scene([SceneObject.cloud("cloud", points, radii)])
    q = arm.random_q(2, seed=3)
    found = scene.distances(arm, q)
    solids = numpy_collision.solids_of_arm("panda", q)
    for k, (name, (frame, solid)) in enumerate(solids.items()):
        assert found.bodies[k] == name
        if frame == 0:
            continue
        for row in range(len(q)):
            least = (solid.take(slice(row, row + 1)).distance_of(points) - radii).min()
            assert found.distance[row, k] == pytest.approx(least - solid.radius, abs=1e-12)


def test_exemptions_and_skipped_objects(load_robot: LoadRobot) -> None:
    arm = load_robot("cucumber")
    q = arm.random_q(100, seed=6)
    scene = spec_scenes.scenes("cucumber")["scene"]
    base = scene.distances(arm, q)
    assert not (base.object_names[:, 0] == "vehicle").any()  # static_skip of the robot file
    free = Scene(scene.objects, exemptions=[("elbow", one.name) for one in scene.objects])
    found = free.distances(arm, q)
    elbow = base.bodies.index("elbow")
    assert np.isinf(found.distance[:, elbow]).all()
    others = [k for k in range(len(base.bodies)) if k != elbow]
    np.testing.assert_array_equal(found.distance[:, others], base.distance[:, others])
    wrong = Scene(scene.objects, exemptions=[("elbo", "slide")])
    with pytest.raises(UnknownNameError, match="unknown body of an exemption 'elbo'; did you"):
        wrong.collides(arm, q)


def test_the_target_may_be_touched_near_it_and_only_there(load_robot: LoadRobot) -> None:
    # The tool point between the fingers.
    arm = load_robot("panda").with_tool(ik.rotations.pose((0, 0, 0.1034)))
    q = np.array([0.3, 0.4, 0.1, -1.6, 0.2, 2.0, 0.4])
    tool = arm.fk(q)[:3, 3]
    # The hand, which may touch the fruit, is round the tool point; the wrist is not.
    fruit = SceneObject.of("fruit", Sphere(tuple(tool), 0.02))
    leaf = SceneObject.of("leaf", Sphere(tuple(tool), 0.02))
    targets = {"fruit": Target(tuple(tool), ("fruit",))}
    scene = Scene([fruit], targets=targets)
    assert scene.collides(arm, q)
    aimed = scene.aiming_at("fruit")
    assert not aimed.collides(arm, q)
    assert Scene([fruit, leaf], targets=targets).aiming_at("fruit").collides(arm, q)
    # The same fruit on the way there is an obstacle.
    elsewhere = {"fruit": Target(tool + np.array([0, 0, 0.2]), ("fruit",))}
    assert Scene([fruit], targets=elsewhere).aiming_at("fruit").collides(arm, q)
    wide = Scene([fruit], targets=elsewhere, touch_radius=0.21)
    assert not wide.aiming_at("fruit").collides(arm, q)
    # Bodies that may not touch it never do.
    wrist = np.array(numpy_fk.frames("panda", q)[6])[:3, 3]
    inner = SceneObject.of("fruit", Sphere(tuple(wrist), 0.02))
    assert Scene([inner], targets=targets).aiming_at("fruit").collides(arm, q)


def test_wrong_questions_are_named(load_robot: LoadRobot) -> None:
    arm, scene = load_robot("panda"), greenhouse(1)
    q = np.zeros(7)
    for ask in (scene.collides, scene.clearance, scene.distances, scene.gradient):
        with pytest.raises(ArgumentError) as caught:
            ask(arm, np.zeros(6))
        assert caught.value.argument == "q"
        with pytest.raises(ArgumentError) as caught:
            ask(arm, [np.nan] * 7)
        assert caught.value.argument == "q"
        with pytest.raises(ArgumentError, match="expected a Robot"):
            ask("panda", q)
        with pytest.raises(ArgumentError, match="threads"):
            ask(arm, q, threads=0)
    with pytest.raises(ArgumentError, match="clear"):
        scene.collides(arm, q, clear=-0.1)
    with pytest.raises(ArgumentError, match="cap"):
        scene.clearance(arm, q, cap=float("nan"))
    with pytest.raises(ArgumentError, match="own"):
        scene.clearance(arm, q, own="yes")


# ---- one body against one object, of every pair of kinds ------------------------------------


def numbers(low: float = -1.0, high: float = 1.0) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


points = st.tuples(numbers(), numbers(), numbers())


def rotation(turn: tuple[float, float, float]) -> np.ndarray:
    return ik.rotations.pose((0, 0, 0), rpy=tuple(3 * x for x in turn))[:3, :3]


solids = st.one_of(
    st.builds(Sphere, points, numbers(0.0, 0.5)),
    st.builds(Capsule, points, points, numbers(0.0, 0.5)),
    st.builds(
        lambda c, h, t, r: Box(c, h, rotation(t), r),
        points, st.tuples(*[numbers(0.0, 0.5)] * 3), points, numbers(0.0, 0.2),
    ),
)  # fmt: skip


def plain(shape: Sphere | Capsule | Box) -> numpy_collision.Solid:
    if isinstance(shape, Sphere):
        return numpy_collision.Solid("segment", (np.array(shape.centre),) * 2, shape.radius)
    if isinstance(shape, Capsule):
        ends = np.array(shape.a), np.array(shape.b)
        return numpy_collision.Solid("segment", ends, shape.radius)
    parts = np.array(shape.centre), np.array(shape.half), np.array(shape.rotation)
    return numpy_collision.Solid("box", parts, shape.radius)


# A rod through a plate, neither of whose edges is near.
@example(
    Box((0, 0, 0), (0, 0, 0.5), rotation((0, 1, 0)), 0), Box((0, 0, 0), (0, 0.5, 0.5), np.eye(3), 0)
)
@given(solids, solids)
def test_pairs_of_solids(one: Sphere | Capsule | Box, other: Sphere | Capsule | Box) -> None:
    arm = ik.Robot.from_dh([[0, 0, 0, 0]]).with_bodies([Body("body", 1, one)])
    scene = Scene([SceneObject.of("thing", other)])
    ours = float(scene.clearance(arm, [0.0]))
    theirs = float(numpy_collision.distance(plain(one), plain(other)))
    assert bool(scene.collides(arm, [0.0])) == (ours <= 0)
    if one.radius + other.radius + theirs > 1e-12:
        assert ours == pytest.approx(theirs, abs=1e-8)
    else:  # the cores meet: how deep has no meaning
        assert ours <= 1e-8
    plane = HalfSpace((0.0, 0.6, 0.8), 0.1)
    under = float(Scene([SceneObject.of("ground", plane)]).clearance(arm, [0.0]))
    expected = numpy_collision.halfspace_distance(plain(one), np.array(plane.normal), 0.1)
    assert under == pytest.approx(float(expected), abs=1e-12)


@given(st.lists(points, min_size=4, max_size=12), solids)
def test_hulls_are_between_their_corners_and_their_boxes(
    corners: list[tuple[float, float, float]], other: Sphere | Capsule | Box
) -> None:
    arm = ik.Robot.from_dh([[0, 0, 0, 0]]).with_bodies([Body("hull", 1, Convex(corners))])
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    box = arm.with_bodies([Body("box", 1, Box((low + high) / 2, (high - low) / 2))])
    scene = Scene([SceneObject.of("thing", other)])
    at_corners = min(
        float(scene.clearance(arm.with_bodies([Body("point", 1, Sphere(p, 0.0))]), [0.0]))
        for p in corners
    )
    ours = float(scene.clearance(arm, [0.0]))
    if at_corners > 0 and ours > 0:
        assert float(scene.clearance(box, [0.0])) - 1e-9 <= ours <= at_corners + 1e-9
