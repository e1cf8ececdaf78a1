"""All that may be met, against draws: more than one object near a body, and pairs of bodies."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import _native, motion
from agrik_fast.collision import Body, Box, Capsule, Scene, SceneObject, Sphere
from agrik_fast.motion._case import Case

LoadRobot = Callable[[str], ik.Robot]
DRAWS = 4000
# Corners of the room round an arm, m.
LOW, HIGH = (-0.8, -0.8, -0.3), (0.8, 0.8, 1.3)


def standard_error(share: float, draws: int = DRAWS) -> float:
    """Return that of a share that was drawn, at least that of one draw."""
    return math.sqrt(max(share * (1 - share), 1 / draws) / draws)


def between_walls(gap: float) -> tuple[ik.Robot, Scene]:
    """Return a ball at the end of an arm of one joint, and four walls round it, `gap` away."""
    arm = ik.Robot.from_dh([[1.0, 0, 0, 0]], name="boom")
    arm = arm.with_bodies([Body("ball", 1, Sphere([0, 0, 0], 0.05))])
    walls = []
    for k, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        at = np.array([1.0 + x * (0.15 + gap), y * (0.15 + gap), 0.0])
        half = [0.1, 0.4, 0.4] if x else [0.4, 0.1, 0.4]
        walls.append(SceneObject.of(f"wall{k}", Box(at.tolist(), half)))
    return arm, Scene(walls)


@pytest.mark.parametrize("share", [1.5, 2.0, 2.5])
def test_a_body_between_walls_may_meet_each_of_them(share: float) -> None:
    errors = motion.Errors(joint=0, slide=0, length=0, vision=5e-3)
    arm, scene = between_walls(5e-3 * share)
    found = motion.sensitivity(arm, scene, [0.0], errors)
    drawn = motion.simulate(arm, scene, [0.0], errors, draws=DRAWS)
    assert len(found.risks) == 4 and set(found.risks.other) == set(scene.names)
    # Nothing but the vision is off, and walls are flat: two intervals of a normal variable.
    exact = math.erf(share / math.sqrt(2)) ** 2
    error = standard_error(exact)
    assert drawn.free == pytest.approx(exact, abs=3.5 * error)
    assert found.free <= exact <= found.nearest
    assert found.free <= drawn.free + 3 * error
    np.testing.assert_allclose(found.risks.hit, 0.5 * math.erfc(share / math.sqrt(2)), rtol=1e-9)
    # The union counts twice what goes wrong in both directions at once, and no more.
    assert found.free == pytest.approx(exact, abs=(1 - exact) ** 2 + 1e-12)
    # What was told before: one wall of four, and more than is true.
    assert found.free_of_nearest > exact + 5 * error
    assert found.free < found.free_of_nearest <= found.nearest


def test_objects_beyond_four_deviations_of_the_nearest_do_not_count() -> None:
    errors = motion.Errors(joint=0, slide=0, length=0, vision=5e-3)
    arm, _ = between_walls(0.01)
    near = SceneObject.of("near", Box([1.16, 0, 0], [0.1, 0.4, 0.4]))

    def told(way: float) -> set[str]:
        # 10 mm to the near wall, `way` to the other.
        far = SceneObject.of("far", Box([1.0 - 0.05 - way - 0.1, 0, 0], [0.1, 0.4, 0.4]))
        return set(motion.sensitivity(arm, Scene([near, far]), [0.0], errors).risks.other)

    assert told(0.0299) == {"near", "far"}
    assert told(0.0301) == {"near"}


def folded(load_robot: LoadRobot) -> tuple[ik.Robot, np.ndarray, tuple[str, str]]:
    """Return a Panda two bodies of which are 3 mm apart, and these."""
    arm = load_robot("panda")
    scene = Scene([])
    q = arm.random_q(4000, seed=11)
    near = scene.distances(arm, q)
    at = np.abs(near.own_distance - 0.003)
    best = int(at.argmin())
    assert at[best] < 0.002
    names = tuple(arm.compiled_bodies().names[k] for k in near.own_pair[best])
    return arm, q[best], names  # type: ignore[return-value]


def test_pairs_of_bodies_count(load_robot: LoadRobot) -> None:
    arm, q, names = folded(load_robot)
    errors = motion.Errors(joint=math.radians(0.3), length=1e-3, vision=5e-3, camera=1e-2)
    scene = Scene([])
    found = motion.sensitivity(arm, scene, q, errors)
    drawn = motion.simulate(arm, scene, q, errors, draws=DRAWS, seed=3)
    assert found.bodies == () and found.nearest == found.free_of_nearest == 1.0
    assert found.risks.is_own.all()
    first = (found.risks.body[0], found.risks.other[0])
    assert set(first) == set(names)
    assert (drawn.clearance == np.inf).all() and drawn.free < 1
    error = standard_error(drawn.free)
    assert found.free <= drawn.free + 3 * error
    assert found.free == pytest.approx(drawn.free, abs=0.03 + 3 * error)
    assert 0.3 < found.free < 0.999
    # Distances of the pair at most risk vary as the formula says; what is seen has no part.
    assert float(np.std(drawn.own)) == pytest.approx(found.risks.deviation[0], rel=0.15)
    blind = motion.sensitivity(arm, scene, q, motion.Errors(errors.joint, 5e-4, 1e-3, vision=0.0))
    np.testing.assert_allclose(blind.risks.deviation, found.risks.deviation, rtol=1e-12)


def test_pairs_count_along_a_path(load_robot: LoadRobot) -> None:
    arm, q, names = folded(load_robot)
    scene, errors = Scene([]), motion.Errors(joint=math.radians(0.3), length=1e-3)
    away = q + np.array([0.3, 0.02, 0.0, -0.02, 0.0, 0.0, 0.4])
    path = np.array([away, q, away + np.array([0.1, 0, 0, 0, 0, 0, 0.1])])
    found = motion.path_sensitivity(arm, scene, path, errors, resolution=2e-4)
    posture = motion.sensitivity(arm, scene, q, errors)
    assert found.free_of_nearest == 1.0
    assert found.free <= posture.free + 1e-9
    coarse = motion.path_sensitivity(arm, scene, path, errors)
    assert coarse.free <= found.free + 1e-9 and coarse.free == pytest.approx(found.free, abs=0.1)
    assert set(found.risks.segment.tolist()) == {0, 1}
    assert {found.risks.body[0], found.risks.other[0]} == set(names)
    dense = np.concatenate([a + np.linspace(0, 1, 40)[:, None] * (b - a)
                            for a, b in itertools.pairwise(path)])  # fmt: skip
    drawn = motion.simulate(arm, scene, dense, errors, draws=DRAWS)
    assert found.free <= drawn.free + 3 * standard_error(drawn.free)
    assert found.segment_free.min() >= found.free
    assert found.segment_free.min() <= drawn.free + 3 * standard_error(drawn.free)


def test_all_objects_count_along_a_path() -> None:
    """Past two walls at once, out of which each is the nearest half of the way."""
    arm = ik.Robot.from_dh([[0.5, 0, 0, 0], [0.5, 0, 0, 0]], name="planar")
    arm = arm.with_bodies([Body("ball", 2, Sphere([0, 0, 0], 0.05))])
    errors = motion.Errors(joint=0, slide=0, length=0, vision=5e-3)
    path = np.array([[0.9, -1.8], [0.8, -1.6]])
    ends = arm.fk(path)[:, :3, 3]
    assert np.abs(ends[:, 1]).max() < 1e-9
    walls = [
        SceneObject.of(name, Box([0.65, side * 0.16, 0], [0.5, 0.1, 0.4]))
        for name, side in (("left", -1), ("right", 1))
    ]
    found = motion.path_sensitivity(arm, Scene(walls), path, errors, resolution=2e-4)
    drawn = motion.simulate(
        arm, Scene(walls), path[0] + np.linspace(0, 1, 30)[:, None] * (path[1] - path[0]), errors,
        draws=DRAWS,
    )  # fmt: skip
    exact = math.erf(2 / math.sqrt(2))
    error = standard_error(exact)
    assert drawn.free == pytest.approx(exact, abs=3.5 * error)
    assert exact - 0.02 <= found.free <= exact
    assert found.free_of_nearest > exact + 5 * error
    assert sorted(found.risks.other) == ["left", "right"]


@pytest.mark.parametrize("name", ["panda", "cucumber"])
def test_what_is_near_is_what_each_object_says_by_itself(name: str, load_robot: LoadRobot) -> None:
    arm = load_robot(name)
    rng = np.random.default_rng(2)
    things = [
        SceneObject.of(f"ball{k}", Sphere(rng.uniform(-1, 1, 3).tolist(), 0.1)) for k in range(6)
    ]
    things.append(SceneObject.of("rod", Capsule([0.6, -0.5, 0.2], [0.6, 0.5, 0.9], 0.02),
                                 Box([0.3, 0.6, 0.4], [0.1, 0.1, 0.1])))  # fmt: skip
    things.append(
        SceneObject("leaf", spheres=rng.uniform(-1, 1, (40, 4)) * [1, 1, 1, 0] + [0, 0, 0, 0.02])
    )
    scene = Scene(things)
    bodies = arm.compiled_bodies()
    q = arm.random_q(5, seed=8)
    each = [Scene([one]).distances(arm, q).distance for one in things]
    within = np.full((len(q), len(bodies.names)), 0.5)
    own = np.full(len(q), 0.2)
    reach = np.full_like(q, 1e-3)
    found = _native.collision_near(scene.collider(arm), q, reach, within, own)
    got = {
        (int(row), int(body), int(other)): k
        for k, (row, body, other) in enumerate(
            zip(found["row"], found["body"], found["other"], strict=True)
        )
    }
    assert len(got) == len(found["row"])
    count = 0
    for row in range(len(q)):
        for other, distances in enumerate(each):
            for body, distance in enumerate(distances[row]):
                told = got.get((row, body, other))
                assert (told is not None) == bool(distance <= 0.5)
                if told is not None:
                    count += 1
                    assert found["distance"][told] == pytest.approx(distance, abs=1e-12)
    assert count > 50
    pairs = [k for k in got.values() if found["other"][k] < 0]
    nearest = scene.distances(arm, q).own_distance
    for row in range(len(q)):
        mine = [found["distance"][k] for k in pairs if found["row"][k] == row]
        if nearest[row] < 0.2:
            assert min(mine) == pytest.approx(nearest[row], abs=1e-12)
        else:
            assert mine == []
    assert (found["motion"] >= 0).all()
    check_rates(arm, scene, q, found, got)


def check_rates(arm: ik.Robot, scene: Scene, q: np.ndarray, found: dict, got: dict) -> None:  # type: ignore[type-arg]
    """Compare rates with differences, but where another point becomes the nearest."""
    step = 1e-6
    collider = scene.collider(arm)
    far, count = np.full((1, len(arm.compiled_bodies().names)), 10.0), 0
    for (row, body, other), k in list(got.items())[::7]:
        if found["distance"][k] <= 0:
            continue
        for variable in range(arm.dof):
            ends = []
            for sign in (1, -1):
                moved = q[row : row + 1] + sign * step * np.eye(arm.dof)[variable]
                near = _native.collision_near(
                    collider, moved, np.zeros_like(moved), far, np.array([10.0])
                )
                here = (near["body"] == body) & (near["other"] == other)
                ends.append(float(near["distance"][here][0]))
            rate = (ends[0] - ends[1]) / (2 * step)
            count += abs(rate - found["rates"][k, variable]) < 1e-5
    tried = sum(found["distance"][k] > 0 for k in list(got.values())[::7]) * arm.dof
    assert count >= 0.97 * tried


def test_bounds_hold_at_any_posture(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    rng = np.random.default_rng(5)
    things = [
        SceneObject.of(
            f"ball{k}", Sphere(rng.uniform([-0.8, -0.8, -0.3], [0.8, 0.8, 1.3]).tolist(), 0.05)
        )
        for k in range(25)
    ]
    scene = Scene(things)
    q = arm.random_q(400, seed=6)
    q = q[scene.clearance(arm, q) > 0.002][:12]
    for k, posture in enumerate(q):
        found = motion.sensitivity(arm, scene, posture)
        drawn = motion.simulate(arm, scene, posture, draws=2000, seed=k)
        assert found.free <= found.free_of_nearest <= found.nearest
        assert found.free <= drawn.free + 3 * standard_error(drawn.free, 2000)
        order = found.risks.hit
        assert (np.diff(order) <= 1e-15).all()


def test_numbers_that_do_not_match_are_refused(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    case = Case(arm, Scene([]), None)
    q, bodies = np.zeros((2, 7)), len(case.names)
    good = {"reach": np.zeros((2, 7)), "within": np.zeros((2, bodies)), "own": np.zeros(2)}
    for name, value in (
        ("reach", np.zeros(3)),
        ("reach", np.full((2, 7), -1.0)),
        ("within", np.zeros(3)),
        ("within", np.full((2, bodies), np.nan)),
        ("own", np.zeros(5)),
    ):
        given = {**good, name: value}
        with pytest.raises(ik.ArgumentError, match=name):
            _native.collision_near(case.collider, q, given["reach"], given["within"], given["own"])
    with pytest.raises(ik.ArgumentError, match="shifts"):
        _native.collision_shifted_own(case.collider, q, np.zeros((1, bodies, 3)))


def test_in_an_empty_scene_nothing_is_met(load_robot: LoadRobot) -> None:
    arm = load_robot("panda")
    rest = np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    found = motion.sensitivity(arm, Scene([]), rest)
    assert found.risks.is_own.all() and found.nearest == found.free_of_nearest == 1.0
    alone = motion.sensitivity(arm.with_bodies(arm.bodies[-1:]), Scene([]), rest)
    assert len(alone.risks) == 0 and alone.free == 1.0
