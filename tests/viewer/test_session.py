"""What the viewer knows and does, without a window."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from browser import project

import agrik_fast as ik
from agrik_fast.collision import Scene, SceneObject, Sphere
from agrik_fast.viewer._camera import FIELD_OF_VIEW, viewpoint
from agrik_fast.viewer._reach import HALF, reach
from agrik_fast.viewer._session import Session, comfortable
from agrik_fast.viewer._words import headline, joints_at_limits, length
from agrik_fast.viewer._worker import Worker

NAMES = ik.Robot.names()


def session(name: str, scene: Scene | None = None) -> Session:
    return Session(ik.Robot.load(name), name, scene)


@pytest.mark.parametrize("name", NAMES)
def test_every_robot_begins_well_inside_its_limits(name: str) -> None:
    found = session(name)
    robot = found.robot
    assert found.outcome.reached
    assert found.outcome.headline.startswith("CONVERGED")
    assert (found.q > robot.lower).all() and (found.q < robot.upper).all()
    assert np.abs(robot.fk(found.q) - found.target).max() < 1e-9
    assert not found.outcome.hits


@pytest.mark.parametrize(("width", "height"), [(1000, 640), (390, 844)], ids=["desk", "phone"])
@pytest.mark.parametrize("name", NAMES)
def test_arm_and_handle_are_in_the_picture(name: str, width: int, height: int) -> None:
    found = session(name)
    arm = found.robot.frames_of(found.q)[:, :3, 3]
    tips = found.target[:3, 3] + 0.3 * found.robot.reach_radius * np.eye(3)
    position, look_at = viewpoint(arm, tips, 0.1, width / height)
    camera = SimpleNamespace(
        position=position,
        look_at=look_at,
        up_direction=[0.0, 0.0, 1.0],
        fov=FIELD_OF_VIEW,
        image_width=width,
        image_height=height,
    )
    for point in (*arm, *tips):
        x, y = project(camera, point)
        assert 0 < x < width and 0 < y < height


def test_a_posture_at_first_keeps_clear_of_the_scene() -> None:
    arm = ik.Robot.load("panda")
    tip = arm.fk(comfortable(arm))[:3, 3]
    scene = Scene([SceneObject.of("ball", Sphere(tip, 0.05))])
    assert not scene.collides(arm, comfortable(arm, scene))


def test_words_for_a_target_beyond_reach() -> None:
    found = session("redundant7")
    before = found.q.copy()
    target = found.target.copy()
    target[:3, 3] = found.robot.reach_center
    target[0, 3] += found.robot.reach_radius + 0.2
    outcome = found.aim(target)
    assert not outcome.reached
    assert outcome.headline.startswith("UNREACHABLE: ")
    assert outcome.headline.endswith(" cm beyond reach")
    # The arm stays, a pale copy goes as near as it can.
    assert (found.q == before).all()
    assert not np.allclose(outcome.q, before)
    tip = found.robot.fk(outcome.q)[:3, 3]
    assert np.linalg.norm(tip - target[:3, 3]) == pytest.approx(outcome.position_error)


def test_words_for_a_joint_at_its_limit() -> None:
    found = session("strawberry")
    target = found.target.copy()
    target[:3, 3] = found.robot.fk(found.robot.lower)[:3, 3] - [0.0, 0.1, 0.0]
    outcome = found.aim(target)
    assert outcome.headline.startswith("LIMIT: s10 at its lower limit")
    q, lower, upper = np.array([[0.0, 0.5, 9.0], [0.0, 0.0, -np.inf], [1.0, 0.5, np.inf]])
    assert joints_at_limits("abc", q, lower, upper) == [("a", "lower"), ("b", "upper")]


def test_words_for_a_search_that_ends_at_its_cap() -> None:
    words = headline(
        ik.Status.NOT_FOUND,
        seconds=0.1,
        iterations=5000,
        position_error=0.012,
        orientation_error=np.radians(3.0),
        at_limits=[],
        pair=("", ""),
        beyond=-0.3,
    )
    assert words == "ITERATION_CAP: nearest posture 1.2 cm and 3.0° away after 5000 iterations"


def test_words_for_collisions() -> None:
    found = session("panda")
    assert found.outcome.nearness.startswith("clearance ")
    tip = found.target[:3, 3]
    ball = Scene([SceneObject.of("ball", Sphere(tip, 0.06))])
    found.scene = ball
    found.outcome = found.solve()
    assert found.outcome.reached and found.outcome.hits and not found.outcome.good
    assert found.outcome.nearness.startswith("COLLISION: ")
    assert found.outcome.nearness.endswith(" hits ball")
    found.avoid = True
    outcome = found.solve()
    assert not outcome.reached
    assert outcome.headline.startswith("COLLISION: ")
    assert "hits" in outcome.headline and "every posture found" in outcome.headline


def test_lengths_are_said_in_units_that_suit_them() -> None:
    assert [length(x) for x in (2.5, 0.042, 0.0042, 2e-10, 0.0)] == [
        "2.50 m",
        "4.2 cm",
        "4.2 mm",
        "2e-10 m",
        "0 m",
    ]


@pytest.mark.parametrize("name", ["cucumber", "panda", "tomato", "strawberry6", "so101"])
def test_the_script_gives_the_same_posture(name: str) -> None:
    found = session(name)
    text = found.python()
    assert len(text.splitlines()) == 4
    names: dict[str, object] = {}
    exec(text, names)
    result = names["result"]
    assert result.success  # type: ignore[attr-defined]
    assert np.abs(result.q - found.q).max() < 1e-6  # type: ignore[attr-defined]


def test_undo_and_redo_walk_through_the_targets() -> None:
    found = session("ur5")
    start = found.target.copy()
    places = [start.copy() for _ in range(3)]
    for k, pose in enumerate(places, 1):
        pose[2, 3] -= 0.01 * k
        found.aim(pose)
    assert found.undo() and np.allclose(found.target, places[1])
    assert found.undo() and found.undo()
    assert np.allclose(found.target, start)
    assert not found.undo()
    assert found.redo() and np.allclose(found.target, places[0])
    assert np.abs(found.robot.fk(found.q) - found.target).max() < 1e-6


def test_number_fields_do_what_the_handle_does() -> None:
    found = session("puma560")
    outcome = found.aim_numbers(found.numbers())
    assert outcome.reached and outcome.iterations == 0
    x, y, z, *turn = found.numbers()
    found.aim_numbers([x, y, z - 0.02, *turn])
    assert found.target[2, 3] == pytest.approx(z - 0.02)
    assert found.outcome.reached


@pytest.mark.parametrize("name", ["puma560", "ur5", "redundant7", "so101", "tomato", "xarm6"])
def test_every_branch_reaches_the_target(name: str) -> None:
    found = session(name)
    branches = found.branches()
    assert branches
    assert branches[0].distance < 1e-6  # the arm's own posture is one of them
    for branch in branches:
        tip = found.robot.fk(branch.q)
        assert np.abs(tip[:3, 3] - found.target[:3, 3]).max() < 1e-6
    last = branches[-1]
    outcome = found.choose(last.q)
    assert outcome.reached and np.abs(found.q - last.q).max() < 1e-9


def test_the_elbow_turns_while_the_tool_stands_still() -> None:
    found = session("redundant7")
    angle = float(np.degrees(found.robot.arm_angle(found.q)))
    outcome = found.turn_elbow(angle + 20)
    assert outcome.reached
    assert np.degrees(found.robot.arm_angle(found.q)) == pytest.approx(angle + 20, abs=1e-4)
    assert np.abs(found.robot.fk(found.q) - found.target).max() < 1e-6
    assert found.elbow_intervals().startswith("elbow: ")
    assert "°" in found.elbow_intervals()


def test_moving_joints_takes_the_target_along() -> None:
    found = session("hydrolek")
    q = found.q + 0.01
    found.move_joints(q)
    assert np.abs(found.target - found.robot.fk(q)).max() < 1e-12
    found.move_joints(found.robot.upper + 1.0)
    assert (found.q <= found.robot.upper).all()


def test_a_solver_that_cannot_is_told_in_words() -> None:
    found = session("cucumber")
    found.solver = "closed_form"
    outcome = found.solve()
    assert not outcome.reached
    assert outcome.headline.startswith("CLOSED_FORM: ")


# ---- reach ---------------------------------------------------------------------------------


@pytest.mark.parametrize("quantity", ["reachable", "manipulability", "clearance"])
def test_reach_has_a_colour_for_each_point(quantity: str) -> None:
    arm = ik.Robot.load("panda")
    found = reach(arm, 3000, quantity, Scene())
    assert found.places.shape == (3000, 3) and found.colours.shape == (3000, 3)
    assert np.linalg.norm(found.places - arm.reach_center, axis=1).max() <= arm.reach_radius
    assert (len(np.unique(found.colours, axis=0)) > 20) == (quantity != "reachable")
    part = found.slice("y", 0.1)
    assert 0 < len(part.places) < 1000
    assert np.abs(part.places[:, 1] - 0.1).max() <= HALF


# ---- the worker ------------------------------------------------------------------------------


def test_a_slow_job_never_has_a_queue_and_the_last_is_not_lost() -> None:
    done: list[int] = []
    begun = threading.Event()
    go_on = threading.Event()

    def slow() -> None:
        begun.set()
        go_on.wait(10)
        done.append(0)

    failures: list[Exception] = []
    worker = Worker(failures.append)
    worker.submit("drag", slow)
    assert begun.wait(10)
    for number in range(1, 50):
        worker.submit("drag", lambda number=number: done.append(number))
    go_on.set()
    assert worker.settle(10)
    # The one that was under way, and the newest: nothing between.
    assert done == [0, 49]
    worker.submit("drag", lambda: 1 / 0)  # type: ignore[arg-type, return-value]
    worker.submit("other", lambda: done.append(50))
    assert worker.settle(10)
    assert [type(each) for each in failures] == [ZeroDivisionError]
    assert done[-1] == 50
    worker.stop()
    start = time.monotonic()
    worker.stop()
    assert time.monotonic() - start < 5
