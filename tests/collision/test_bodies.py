"""Bodies of arms: from robot files, put on at run time, and which pairs of them are asked."""

from __future__ import annotations

import math
import pickle
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import agrik_fast as ik
import spec_scenes
from agrik_fast.collision import (
    Body,
    Box,
    Capsule,
    CollisionRules,
    Convex,
    Cover,
    Scene,
    SceneObject,
    Sphere,
)
from agrik_fast.errors import ArgumentError, RobotFileError, UnknownNameError
from agrik_fast.robot._file import parse

LoadRobot = Callable[[str], ik.Robot]
ARM = """
format = 1
name = "two"
convention = "standard"
[provenance]
A = "assumed"
[[dh]]
name = "q1"
type = "revolute"
a_mm = 500
alpha_deg = 0
d_m = 0
theta_rad = 0
lower_deg = -180
upper_deg = 180
[[dh]]
name = "q2"
type = "revolute"
a_m = 0.25
alpha_rad = 0
d_m = 0
theta_deg = 0
lower_deg = -90
upper_deg = 90
"""
BODIES = """
[[collision]]
name = "foot"
frame = "base"
shape = "box"
centre_mm = [0, 0, -100]
half_mm = [50, 60, 70]
rpy_deg = [0, 0, 90]
radius_mm = 5
overestimate_mm = 3
provenance = { shape = "A: drawn" }
[[collision]]
name = "upper"
frame = 1
shape = "capsule"
a_mm = [-500, 0, 0]
b_m = [0, 0, 0]
radius_m = 0.04
[[collision]]
name = "lower"
frame = "q2_link"
shape = "convex"
vertices_mm = [[-250, 0, 0], [0, 0, 0], [0, 20, 0], [0, 0, 20]]
[[collision]]
name = "tip"
frame = "tool"
shape = "sphere"
centre_m = [0, 0, 0]
radius_mm = 30
[[collision]]
name = "paper"
frame = 3
shape = "cover"
centre_mm = [0, 0, 0]
half_mm = [10, 20, 30]
level = 1
[collision_rules]
may_touch_target = ["tip"]
static_skip = [["foot", "floor"]]
exclude = [["foot", "tip"]]
"""


def write(folder: object, text: str, name: str = "two.toml") -> object:
    path = folder / name  # type: ignore[operator]
    path.write_text(text)
    return path


def faults(text: str) -> dict[str, str]:
    with pytest.raises(RobotFileError) as caught:
        parse(text.encode(), "arm.toml")
    return dict(caught.value.faults)


def test_bodies_of_a_robot_file(tmp_path: object) -> None:
    arm = ik.Robot.load(write(tmp_path, ARM + BODIES))  # type: ignore[arg-type]
    foot, upper, lower, tip, paper = arm.bodies
    assert isinstance(foot.shape, Box) and foot.frame == "base"
    np.testing.assert_allclose(foot.shape.rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-16)
    assert foot.shape.half == (0.05, 0.06, 0.07) and foot.shape.radius == 0.005
    assert foot.overestimate == 0.003 and foot.provenance == "assumed: drawn"
    assert upper.shape == Capsule((-0.5, 0, 0), (0, 0, 0), 0.04) and upper.overestimate is None
    assert isinstance(lower.shape, Convex) and lower.shape.vertices[2] == (0, 0.02, 0)
    assert tip.shape == Sphere((0, 0, 0), 0.03)
    assert isinstance(paper.shape, Cover) and paper.shape.level == 1
    assert paper.overestimate == pytest.approx((math.hypot(0.01, 0.02, 0.03) - 0.01) / 2)
    assert arm.collision_rules.static_skip == (("foot", "floor"),)
    assert [arm.frame_number(body.frame) for body in arm.bodies] == [0, 1, 2, 3, 3]
    again = pickle.loads(pickle.dumps(arm))
    assert again.bodies == arm.bodies and again.collision_rules == arm.collision_rules
    for other in (arm.with_tool(np.eye(4)), arm.with_base(np.eye(4))):
        assert other.bodies == arm.bodies


def test_self_pairs_have_reasons(tmp_path: object) -> None:
    arm = ik.Robot.load(write(tmp_path, ARM + BODIES))  # type: ignore[arg-type]
    pairs = arm.self_pairs
    reasons = {one.bodies: one.reason for one in pairs.excluded}
    assert set(pairs.asked).isdisjoint(reasons)
    assert len(pairs.asked) + len(reasons) == 10
    assert reasons["lower", "tip"] == reasons["tip", "paper"] == "same link"
    assert reasons["foot", "upper"] == reasons["upper", "lower"] == "adjacent"
    assert reasons["foot", "tip"] == "excluded"
    assert ("foot", "lower") in pairs.asked
    listed = BODIES.replace('exclude = [["foot", "tip"]]', 'pairs = [["tip", "foot"]]')
    only = ik.Robot.load(write(tmp_path, ARM + listed, "listed.toml"))  # type: ignore[arg-type]
    assert only.self_pairs.asked == (("foot", "tip"),)
    assert {one.reason for one in only.self_pairs.excluded} == {
        "same link", "adjacent", "not listed",
    }  # fmt: skip


def test_structural_pairs_say_how_often_they_hit(load_robot: LoadRobot) -> None:
    excluded = {one.bodies: one for one in load_robot("panda").self_pairs.excluded}
    elbow = excluded["elbow", "forearm"]
    assert elbow.reason == "structural"
    # The specification saw 0.43 of its postures.
    assert elbow.share == pytest.approx(0.43, abs=0.03)
    assert excluded["wrist5", "link7"].reason == "structural"


@pytest.mark.parametrize("arm", ["panda", "cucumber"])
def test_self_pairs_are_the_reference_s(arm: str, load_robot: LoadRobot) -> None:
    expected = {frozenset(pair) for pair in spec_scenes.read(arm)["self_pairs"]}
    assert {frozenset(pair) for pair in load_robot(arm).self_pairs.asked} == expected


def test_all_faults_of_the_tables_are_told(tmp_path: object) -> None:
    found = faults(
        ARM
        + """
[[collision]]
name = "a"
frame = "q3_link"
shape = "sphere"
centre_m = [0, 0, nan]
radius_m = -1
half_m = [1, 1, 1]
[[collision]]
name = "a"
frame = 4
shape = "box"
centre_m = [0, 0, 0]
centre_mm = [0, 0, 0]
half_m = [1, 1, -1]
rotation = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]
[[collision]]
name = "c"
frame = -1
shape = "capsul"
[[collision]]
name = "d"
frame = 0
shape = "capsule"
a_m = [0, 0, 0]
rpy_deg = [0, 0, 0]
level = 2
provenance = { a = "Q", z = "A" }
[[collision]]
name = "e"
frame = 0
shape = "convex"
vertices_m = []
radius = 3
[collision_rules]
may_touch_target = ["b"]
static_skip = [["b", "anything"]]
pairs = [["a", "c"], ["a", "a"], ["d"]]
exclude = [["a", "f"]]
"""
    )
    expected = {
        "[[collision]] row 1, frame": "no frame is named 'q3_link'; did you mean 'q2_link'?",
        "[[collision]] row 1, centre_m": "finite",
        "[[collision]] row 1, radius_m": "greater than or equal to 0",
        "[[collision]] row 1, half_m": "a sphere has none",
        "[[collision]] row 2, name": "'a' is the name of row 1 too",
        "[[collision]] row 2, frame": "expected at most 3, got 4",
        "[[collision]] row 2, centre": "given twice",
        "[[collision]] row 2, half": "expected half lengths >= 0",
        "[[collision]] row 2, rotation": "expected orthonormal rows",
        "[[collision]] row 3, shape": "'sphere', 'capsule', 'box', 'convex' or 'cover'",
        "[[collision]] row 4, b": "missing; expected b_m or b_mm",
        "[[collision]] row 4, radius": "missing; expected radius_m or radius_mm",
        "[[collision]] row 4, rpy_deg": "a capsule is not turned",
        "[[collision]] row 4, level": "a capsule has none",
        "[[collision]] row 4, provenance.a": "mark 'Q' is not explained",
        "[[collision]] row 4, provenance.z": "names no number of this table",
        "[[collision]] row 5, vertices_m": "at least 1 item",
        "[[collision]] row 5, radius": "unknown key, its name ends in a unit; did you mean 'rad",
        "[collision_rules], may_touch_target": "no body is named 'b'",
        "[collision_rules], static_skip row 1": "no body is named 'b'",
        "[collision_rules], pairs row 2": "'a' twice, expected two bodies",
        "[collision_rules], exclude row 1": "no body is named 'f'",
        "[collision_rules], exclude": "given with pairs",
    }
    for place, words in expected.items():
        assert place in found, (place, sorted(found))
        assert words in found[place], (place, found[place])
    others = {place for place in found if place not in expected}
    # pydantic counts rows of lists, and tries both kinds of frame.
    assert all(re.match(r"\[\[?collision", place) for place in others), others
    assert len(others) <= 3, others


@pytest.mark.parametrize("name", spec_scenes.WITH_BODIES)
def test_bundled_arms_have_bodies_with_provenance(name: str, load_robot: LoadRobot) -> None:
    arm = load_robot(name)
    assert len(arm.bodies) >= 4
    assert all(body.provenance for body in arm.bodies)
    # The foot of the cucumber's arm is its slide; that of the UR arms is a link of its own.
    foot = set() if name == "cucumber" or (name.startswith("ur") and name != "ur5") else {0}
    assert {arm.frame_number(body.frame) for body in arm.bodies} >= {1} | foot
    pairs = arm.self_pairs
    count = len(arm.bodies)
    assert len(pairs.asked) + len(pairs.excluded) == count * (count - 1) // 2
    # An arm that hits itself most of the time would be drawn wrongly; the capsules of the short
    # links of a UR3e reach out of them by up to 5 cm.
    share = Scene().collides(arm, arm.random_q(2000, seed=1)).mean()
    assert share < (0.6 if name == "ur3e" else 0.4), share
    # The stretched elbow of a Panda at q = 0 is nearer than its limits let it come.
    assert name == "panda" or not Scene().collides(arm, arm.home)
    assert arm.collision_rules.may_touch_target


def test_tools_and_held_objects(load_robot: LoadRobot) -> None:
    panda = load_robot("panda")
    fruit = Sphere((0, 0, 0.05), 0.03)
    arm = panda.attach(fruit, "tool", name="fruit")
    assert arm.bodies[:-1] == panda.bodies and arm.bodies[-1].frame == "tool"
    assert "fruit" in arm.collision_rules.may_touch_target
    assert arm.compiled_bodies().attached == [False] * 12 + [True]
    assert panda.bodies == load_robot("panda").bodies  # which never changes
    # Pairs with what is put on are asked, by the same rules.
    asked = {pair for pair in arm.self_pairs.asked if "fruit" in pair}
    assert ("link0", "fruit") in asked and ("fingers", "fruit") not in asked
    assert len(asked) == len(panda.bodies) - sum(
        "fruit" in one.bodies for one in arm.self_pairs.excluded
    )
    # It moves with the tool, and meets the scene there.
    q = panda.random_q(1, seed=3)[0]
    tool = panda.fk(q)
    where = tool @ [0, 0, 0.05, 1]
    scene = Scene([SceneObject.of("ball", Sphere(where[:3] + np.array([0, 0, 0.5]), 0.1))])
    found = scene.distances(arm, q)
    assert found.distance[-1] == pytest.approx(0.5 - 0.1 - 0.03, abs=1e-12)
    two = panda.attach([fruit, Capsule((0, 0, 0), (0, 0, 0.1), 0.01)], name="part")
    assert [body.name for body in two.bodies[-2:]] == ["part0", "part1"]
    assert two.frame_number(two.bodies[-1].frame) == 7  # the last link
    stick = Body("stick", 3, Capsule((0, 0, 0), (0, 0, 0.1), 0.01))
    held = arm.attach(stick, may_touch_target=False)
    assert held.bodies[-1] == stick and "stick" not in held.collision_rules.may_touch_target
    assert held.detach("fruit").bodies[-1] == stick
    assert held.detach().bodies == panda.bodies
    assert held.detach().collision_rules == panda.collision_rules
    for call, place in [
        (lambda: arm.attach(fruit, name="fruit"), "bodies"),
        (lambda: arm.attach("fruit"), "bodies"),
        (lambda: arm.attach([3]), "bodies"),
        (lambda: arm.attach(fruit, 9, name="f"), "frame"),
        (lambda: arm.attach(fruit, "tol", name="f"), "frame"),
        (lambda: arm.detach("hand"), "attached body"),
    ]:
        with pytest.raises(ArgumentError) as caught:
            call()  # type: ignore[no-untyped-call]
        assert caught.value.argument == place


def test_pairs_with_what_is_attached_are_asked_though_a_list_does_not_name_them(
    load_robot: LoadRobot,
) -> None:
    arm = load_robot("cucumber").attach(Sphere((0, 0, 0.3), 0.05), name="fruit")
    pairs = set(arm.self_pairs.asked)
    assert ("base", "fruit") in pairs and ("gripper", "fruit") not in pairs
    assert {pair for pair in pairs if "fruit" not in pair} == {
        tuple(pair) for pair in load_robot("cucumber").self_pairs.asked
    }


def test_bodies_given_in_python() -> None:
    arm = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], name="planar")
    assert arm.bodies == ()
    links = [Body(f"link{k}", k, Capsule((-1, 0, 0), (0, 0, 0), 0.05)) for k in (1, 2)]
    own = arm.with_bodies(links, CollisionRules(static_skip=[("link1", "wall")]))
    assert own.bodies == tuple(links)
    assert own.self_pairs.excluded[0].reason == "adjacent"
    with pytest.raises(ArgumentError, match="the name 'link1' twice"):
        arm.with_bodies([links[0], links[0]])
    with pytest.raises(UnknownNameError, match="unknown body of static_skip 'link3'"):
        arm.with_bodies(links, CollisionRules(static_skip=[("link3", "wall")]))
    with pytest.raises(UnknownNameError, match="unknown frame 'hand'"):
        arm.with_bodies([Body("a", "hand", Sphere((0, 0, 0), 1))])
    with pytest.raises(ArgumentError, match="expected either pairs or exclude"):
        CollisionRules(pairs=[("a", "b")], exclude=[("a", "c")])
    for wrong in ({"name": ""}, {"frame": -1}, {"shape": 3}, {"overestimate": -1}):
        with pytest.raises(ArgumentError):
            Body(**{"name": "a", "frame": 0, "shape": links[0].shape, **wrong})


def test_an_arm_without_bodies_says_how_it_gets_some() -> None:
    arm = ik.Robot.from_dh([[1, 0, 0, 0]], name="bare")
    for call in (
        lambda: Scene().collides(arm, [0.0]),
        lambda: Scene().clearance(arm, [0.0]),
        lambda: arm.self_pairs,
        lambda: arm.ik([1.0, 0, 0], scene=Scene()),
    ):
        with pytest.raises(ArgumentError, match="'bare', which has no bodies") as caught:
            call()  # type: ignore[no-untyped-call]
        for way in ("[[collision]]", "<collision>", "Robot.with_bodies", "Robot.attach"):
            assert way in str(caught.value)


def test_frames_are_named_as_the_links_are(tmp_path: Path) -> None:
    joint = 'type = "revolute"\naxis = [0, 0, 1]\nlower_deg = -90\nupper_deg = 90\n'
    body = '[[collision]]\nname = "tube"\nframe = "shoulder"\nshape = "sphere"\n'
    text = (
        'format = 1\nname = "one"\n[provenance]\nA = "assumed"\n'
        f'[[joint]]\nname = "q1"\nlink = "shoulder"\n{joint}'
        'provenance = { axis = "A", lower = "A", upper = "A" }\n'
        f'{body}centre_m = [0, 0, 0.1]\nradius_m = 0.05\nprovenance = {{ shape = "A" }}\n'
    )
    file = tmp_path / "one.toml"
    file.write_text(text)
    robot = ik.Robot.load(file)
    assert robot.bodies[0].frame == "shoulder"
    assert robot.link_names[0] == "shoulder"
