"""Scenes, bodies and colliders of the compiled core: plain arrays in, answers out."""

from __future__ import annotations

import numpy as np
import pytest

from agrik_fast import _native, errors

FLOOR = np.array([[0.0, 0.0, 1.0, -0.2]])
BALL = np.array([[0.5, 0.1, 0.4, 0.1], [0.5, 0.3, 0.4, 0.1]])
POST = np.array([[0.3, -0.4, 0.0, 0.3, -0.4, 1.0, 0.05]])
SHELF = np.array([[0.6, 0.0, 0.9, 0.2, 0.3, 0.02, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.01]])
WEDGE = np.array([[-0.5, 0, 0], [-0.5, 0.3, 0], [-0.7, 0, 0], [-0.5, 0, 0.5]])


def scene(**changes: object) -> _native.Scene:
    given: dict[str, object] = {
        "names": ["floor", "balls", "post", "shelf", "wedge"],
        "removable": [False, True, False, False, True],
        "spheres": BALL,
        "sphere_labels": [1, 1],
        "capsules": POST,
        "capsule_labels": [2],
        "boxes": SHELF,
        "box_labels": [3],
        "halfspaces": FLOOR,
        "halfspace_labels": [0],
        "hulls": [WEDGE],
        "hull_radii": [0.01],
        "hull_labels": [4],
    }
    return _native.Scene(**(given | changes))  # type: ignore[arg-type]


def bodies(chain: _native.Chain, **changes: object) -> _native.Bodies:
    upright = np.eye(3)
    given: dict[str, object] = {
        "names": ["foot", "arm", "fore", "hand", "tip"],
        "frames": [0, 2, 3, 6, 7],
        "kinds": ["box", "capsule", "convex", "box", "sphere"],
        "cores": [
            ([0, 0, 0.2], [0.1, 0.1, 0.1], upright),
            [[0, 0, 0], [-0.4, 0, 0]],
            [[0, 0, 0], [0, 0.3, 0], [0.05, 0, 0], [0, 0, 0.05]],
            ([0, 0, 0.02], [0.05, 0.03, 0.02], upright),
            [0, 0, 0],
        ],
        "radii": [0, 0.06, 0.05, 0, 0.03],
    }
    return _native.Bodies(chain, **(given | changes))  # type: ignore[arg-type]


@pytest.fixture
def chain(load_robot) -> _native.Chain:
    return load_robot("puma560")._chain


def test_what_was_given_can_be_read_again(chain):
    things, arm = scene(), bodies(chain)
    assert things.names == ["floor", "balls", "post", "shelf", "wedge"]
    assert things.removable == [False, True, False, False, True]
    assert len(things) == 5
    assert arm.names == ["foot", "arm", "fore", "hand", "tip"]
    assert arm.frames == [0, 2, 3, 6, 7]
    assert arm.attached == [False] * 5
    assert len(arm) == 5
    # The hand and the tip stand on one link, arm and forearm on neighbours.
    excluded = {(i, j): why for i, j, why, _ in arm.excluded_pairs}
    assert excluded[3, 4] == "same link"
    assert excluded[1, 2] == "adjacent"
    assert set(excluded) | set(arm.self_pairs) == {(i, j) for j in range(5) for i in range(j)}
    given = bodies(chain, self_pairs=[(4, 1)], attached=[False] * 4 + [True])
    assert given.self_pairs == [(1, 4)]
    assert {why for *_, why, _ in given.excluded_pairs} == {"not listed"}
    assert given.attached[4]
    collider = _native.Collider(arm, things)
    assert collider.bodies is arm
    assert collider.scene is things


def test_distances_are_those_of_the_shapes(chain, load_robot):
    arm, things = bodies(chain), scene()
    collider = _native.Collider(arm, things)
    q = load_robot("puma560").random_q(200, seed=3).reshape(10, 20, 6)
    found = collider.distances(q)
    tip = chain.fk(q)[..., :3, 3]
    # Of the sphere at the tool the distances can be told by heart.
    balls = np.linalg.norm(tip[..., None, :] - BALL[:, :3], axis=-1).min(-1) - 0.1 - 0.03
    floor = tip[..., 2] + 0.2 - 0.03
    along = np.clip(tip[..., 2], 0, 1)
    post = np.hypot(np.hypot(tip[..., 0] - 0.3, tip[..., 1] + 0.4), tip[..., 2] - along)
    shelf = np.linalg.norm(np.maximum(np.abs(tip - SHELF[0, :3]) - SHELF[0, 3:6], 0), axis=-1)
    least = np.min([balls, floor, post - 0.08, shelf - 0.04], axis=0)
    wedge = found.object[..., 4] == 4
    assert 0 < wedge.mean() < 0.5
    np.testing.assert_allclose(found.distance[..., 4][~wedge], least[~wedge], atol=1e-12)
    assert (found.distance[..., 4][wedge] <= least[wedge]).all()
    # The foot stands where it stands.
    assert np.isinf(found.distance[..., 0]).all()
    assert (found.object[..., 0] == -1).all()
    gap = np.linalg.norm(found.on_body - found.on_object, axis=-1)
    apart = np.isfinite(found.distance) & (found.distance > 0)
    np.testing.assert_allclose(gap[apart], found.distance[apart], atol=1e-12)
    assert found.on_body.shape == (10, 20, 5, 3)
    assert found.own_pair.shape == (10, 20, 2)
    assert found.own_points.shape == (10, 20, 2, 3)
    clearance = collider.clearance(q)
    own = np.minimum(found.distance.min(-1), found.own_distance)
    np.testing.assert_array_equal(clearance, own)
    np.testing.assert_array_equal(collider.clearance(q, own=False), found.distance.min(-1))
    np.testing.assert_array_equal(collider.collides(q), clearance <= 0)
    assert 0.05 < collider.collides(q).mean() < 0.95
    np.testing.assert_array_equal(collider.clearance(q, cap=0.1), np.minimum(clearance, 0.1))
    near = collider.distances(q, cap=0.1)
    np.testing.assert_array_equal(near.object == -1, found.distance > 0.1)
    for threads in (1, 2, 5):
        np.testing.assert_array_equal(collider.clearance(q, threads=threads), clearance)
    one = collider.clearance(q[3, 4])
    assert one.shape == ()
    assert one == clearance[3, 4]


def test_gradients_are_slopes(chain, load_robot):
    collider = _native.Collider(bodies(chain), scene())
    q = load_robot("puma560").random_q(100, seed=4)
    clearance, gradient = collider.gradient(q)
    np.testing.assert_array_equal(clearance, collider.clearance(q))
    step = 1e-6 * np.eye(6)
    more, less = collider.clearance(q[:, None] + step), collider.clearance(q[:, None] - step)
    smooth = np.abs(more - 2 * clearance[:, None] + less).max(1) < 1e-10
    smooth &= np.abs(clearance) > 1e-3
    assert smooth.sum() > 50
    slopes = (more - less) / 2e-6
    np.testing.assert_allclose(gradient[smooth], slopes[smooth], atol=1e-4)


def test_exemptions_hold_always_or_near_the_target(chain):
    arm, q = bodies(chain), np.zeros(6)
    tip = chain.fk(q)[:3, 3]
    things = _native.Scene(["fruit"], spheres=[[*tip, 0.05]], sphere_labels=[0])
    pairs = [(arm.names.index(name), 0) for name in ("hand", "tip")]

    def hits(*exemptions: object) -> bool:
        return bool(_native.Collider(arm, things, *exemptions).collides(q))  # type: ignore[arg-type]

    assert hits()
    assert not hits(pairs)
    assert not hits(None, (pairs, tip, 0.15))
    assert hits(None, (pairs, tip + np.array([0.2, 0, 0]), 0.15))
    assert hits(pairs[:1])


def test_a_cover_is_its_spheres(chain):
    core = ([0.0, 0.02, 0.01], [0.05, 0.03, 0.1], np.eye(3))
    things = scene()
    previous = -np.inf
    q = np.array([0.3, 0.5, -0.4, 0.2, 0.7, 0.1])
    box = bodies(chain, names=["b"], frames=[6], kinds=["box"], cores=[core], radii=[0.0])
    exact = float(_native.Collider(box, things).clearance(q))
    for level in range(4):
        cover = bodies(
            chain,
            names=["b"],
            frames=[6],
            kinds=["cover"],
            cores=[(*core, level, "equal")],
            radii=[0.0],
        )
        found = float(_native.Collider(cover, things).clearance(q))
        assert previous <= found <= exact
        assert found >= exact - np.linalg.norm(core[1]) / 2**level
        previous = found


def test_empty_and_large_scenes(chain, load_robot):
    arm = bodies(chain)
    q = load_robot("puma560").random_q(10, seed=5)
    nothing = _native.Collider(arm, _native.Scene([]))
    assert np.isinf(nothing.clearance(q, own=False)).all()
    assert nothing.distances(q).distance.shape == (10, 5)
    rng = np.random.default_rng(0)
    points = rng.uniform(-2, 2, (1_000_000, 4))
    points[:, 3] = 0.001
    labels = rng.integers(0, 50, len(points))
    names = [f"cloud{i}" for i in range(50)]
    large = _native.Scene(names, spheres=points, sphere_labels=labels)
    found = _native.Collider(arm, large).distances(q)
    tip = chain.fk(q)[:, :3, 3]
    away = np.linalg.norm(points[None, :, :3] - tip[:, None], axis=-1) - 0.031
    np.testing.assert_allclose(found.distance[:, 4], away.min(1), atol=1e-12)
    np.testing.assert_array_equal(found.object[:, 4], labels[away.argmin(1)])


BAD_SCENES = {
    "names": (["a", "a", "b", "c", "d"], "objects"),
    "removable": ([True], "removable"),
    "spheres": ([[0, 0, 0, 1], [0, np.nan, 0, 1]], r"spheres\[1\]"),
    "sphere_labels": ([0, 5], r"sphere_labels\[1\]"),
    "capsules": ([[0, 0, 0, 0, 0, 1, -0.1]], r"capsules\[0\], radius"),
    "capsule_labels": ([0, 1], "capsule_labels"),
    "boxes": (np.concatenate([SHELF[0, :6], np.zeros(9), [0]])[None], r"boxes\[0\], rotation"),
    "box_labels": (None, "box_labels"),
    "halfspaces": ([[0, 0, 0, 1]], r"halfspaces\[0\], normal"),
    "halfspace_labels": ([0.5], r"halfspace_labels\[0\]"),
    "hulls": ([np.zeros((0, 3))], r"hulls\[0\]"),
    "hull_radii": ([1, 2], "hull_radii"),
}


@pytest.mark.parametrize("argument", BAD_SCENES)
def test_scenes_that_make_no_sense_are_refused_by_name(argument):
    value, says = BAD_SCENES[argument]
    with pytest.raises(errors.ArgumentError, match=says):
        scene(**{argument: value})
    for value in (np.zeros((2, 3)), "no"):
        if argument in ("spheres", "capsules", "boxes", "halfspaces"):
            with pytest.raises(errors.ArgumentError, match=argument):
                scene(**{argument: value})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"names": ["a", "a", "b", "c", "d"]}, "names"),
        ({"frames": [0, 1, 2, 3, 9]}, r"frames\[4\]"),
        ({"frames": [0, 1]}, "frames"),
        ({"kinds": ["sphere"] * 4 + ["ball"]}, "(cores|body)"),
        ({"radii": [0, 0, 0, 0, -1]}, r"cores\[4\], radius"),
        ({"radii": [0]}, "radii"),
        ({"self_pairs": [(0, 0)]}, "self_pairs"),
        ({"self_pairs": [(0, 5)]}, "self_pairs"),
        ({"attached": [True]}, "attached"),
    ],
)
def test_bodies_that_make_no_sense_are_refused_by_name(chain, changes, says):
    with pytest.raises((errors.ArgumentError, errors.UnknownNameError), match=says):
        bodies(chain, **changes)


def test_cores_that_make_no_sense_are_refused_by_name(chain):
    turn = np.eye(3)
    for kind, core in [
        ("sphere", [[0, 0, 0], [1, 0, 0]]),
        ("capsule", [[0, 0, 0]]),
        ("capsule", [[0, 0, 0], [0, np.inf, 0]]),
        ("box", [[0, 0, 0]]),
        ("box", ([0, 0, 0], [-1, 1, 1], turn)),
        ("box", ([0, 0, 0], [1, 1, 1], 2 * turn)),
        ("convex", np.zeros((2, 2))),
        ("cover", ([0, 0, 0], [1, 1, 1], turn)),
        ("cover", ([0, 0, 0], [1, 1, 1], turn, 4, "equal")),
        ("cover", ([0, 0, 0], [1, 1, 1], turn, 1, "thirds")),
    ]:
        with pytest.raises(errors.ArgumentError, match="cores"):
            bodies(chain, names=["b"], frames=[1], kinds=[kind], cores=[core], radii=[0.1])


def test_questions_that_make_no_sense_are_refused_by_name(chain):
    collider = _native.Collider(bodies(chain), scene())
    q = np.zeros((3, 6))
    for bad in (np.nan, np.inf, 1e300):
        wrong = q.copy()
        wrong[1, 2] = bad
        for ask in (collider.collides, collider.clearance, collider.distances, collider.gradient):
            with pytest.raises(errors.ArgumentError, match=r"q.: .*row 1"):
                ask(wrong)
    with pytest.raises(errors.ArgumentError, match="`q`: "):
        collider.collides(np.zeros(5))
    with pytest.raises(errors.ArgumentError, match="`clear`: "):
        collider.collides(q, clear=-1)
    with pytest.raises(errors.ArgumentError, match="`cap`: "):
        collider.clearance(q, cap=np.nan)
    with pytest.raises(errors.ArgumentError, match="`threads`: "):
        collider.collides(q, threads=0)
    arm, things = bodies(chain), scene()
    for exemptions in ([(9, 0)], [(0, 9)]):
        with pytest.raises(errors.ArgumentError, match="`exemptions`: "):
            _native.Collider(arm, things, exemptions)
    for touch in ([1, 2], ([], [0, 0, 0], -1), ([], [0, 0, np.nan], 1), ([(9, 9)], [0, 0, 0], 1)):
        with pytest.raises(errors.ArgumentError, match="touch"):
            _native.Collider(arm, things, None, touch)  # type: ignore[arg-type]
