"""The viewer with its server, and no browser: panel, tabs, pages, what is refused."""

import re
import socket
import time
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hands import press

import agrik_fast as ik
from agrik_fast._names import solver_names
from agrik_fast.arms import StrawberryArm
from agrik_fast.errors import ArgumentError
from agrik_fast.viewer import Viewer, export_html, playable, view
from agrik_fast.viewer._ways import picking, postures
from rigs import needs_simulator
from urdf_text import joint, urdf


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    with view("redundant7", port=0, open_browser=False) as shown:
        yield shown


def test_the_arm_is_drawn_where_it_is(viewer: Viewer) -> None:
    target = viewer.robot.fk([0.3, 0.5, 0.2, 1.0, 0.1, 0.6, 0.0])
    assert viewer.aim(target).startswith("CONVERGED")
    stage = viewer._panel.stage
    assert np.abs(stage.drawn() - viewer.robot.frames_of(viewer.q)).max() < 1e-6
    assert np.abs(viewer.robot.fk(viewer.q) - target).max() < 1e-6
    assert np.abs(np.array(stage.handle.position) - target[:3, 3]).max() < 1e-6
    assert not stage._ghost.visible


def test_an_unreachable_target_is_told_by_words_colour_and_a_pale_copy(viewer: Viewer) -> None:
    before = viewer.q
    words = viewer.aim([3.0, 0.0, 0.5])
    assert words.startswith("UNREACHABLE: ")
    panel = viewer._panel
    assert words in panel._status.content
    assert "#a84300" in panel._status.content and "dashed" in panel._status.content
    assert panel.stage._ghost.visible and panel.stage._label.visible
    assert panel.stage._label.text == words
    assert tuple(panel.stage._mark.color) == (213, 94, 0)
    assert (viewer.q == before).all()
    viewer.aim(viewer.robot.fk(before))
    assert not panel.stage._ghost.visible and not panel.stage._label.visible
    assert "#00507d" in panel._status.content and "solid" in panel._status.content


@pytest.mark.parametrize("name", ["cucumber", "strawberry6", "tomato", "panda"])
def test_another_robot_is_drawn_under_fresh_names(viewer: Viewer, name: str) -> None:
    panel = viewer._panel
    before = [node.name for node in panel.stage._frames]
    press(viewer, panel._robot, name)
    assert viewer.robot.name == name
    after = [node.name for node in panel.stage._frames]
    assert not set(before) & set(after)
    assert np.abs(panel.stage.drawn() - viewer.robot.frames_of(viewer.q)).max() < 1e-6
    assert len(panel._joints) == viewer.robot.dof
    assert panel.session.outcome.reached


def test_widgets_change_what_their_labels_say(viewer: Viewer) -> None:
    panel, tabs = viewer._panel, viewer._tabs
    press(viewer, panel._joints[0], panel._joints[0].value + 5.0)
    assert np.degrees(viewer.q[0]) == pytest.approx(panel._joints[0].value, abs=1e-6)
    press(viewer, panel._numbers[2], panel._numbers[2].value - 0.01)
    assert viewer.target[2, 3] == pytest.approx(panel._numbers[2].value, abs=1e-9)
    press(viewer, panel._task, "position")
    assert panel.session.task == "position" and panel.stage.handle.disable_rotations
    press(viewer, panel._task, "pose")
    press(viewer, panel._solver, "dls")
    assert panel.session.solver == "dls"
    press(viewer, panel._all, True)
    assert len(panel.stage._branches) == len(panel._found) > 1
    assert panel._branch_words.content.startswith("branch 1 of ")
    press(viewer, panel._branch, 2)
    assert np.abs(viewer.q - panel._found[1].q).max() < 1e-9
    press(viewer, panel._all, False)
    assert not panel.stage._branches
    press(viewer, tabs.reach._on, True)
    assert panel.stage._cloud is not None
    shown = len(panel.stage._cloud.points)
    press(viewer, tabs.reach._sliced, False)
    assert len(panel.stage._cloud.points) == 100_000 > shown > 0
    press(viewer, tabs.reach._on, False)
    assert panel.stage._cloud is None
    press(viewer, tabs.scene._add)
    assert panel.session.scene is not None and panel.session.scene.names == ("sphere 1",)
    assert "COLLISION" in panel._status.content
    assert panel.stage._obstacles
    press(viewer, tabs.scene._empty)
    assert panel.session.scene is None and not panel.stage._obstacles
    press(viewer, tabs.scene._look, "bodies")
    assert panel.show == "bodies"


# A bundled set by its file, as one that `agrik-fast tune` wrote.
GAINS = resources.files("agrik_fast.solvers") / "bundled" / "hydrolek_k15_cma.toml"


def own_solvers() -> list[Any]:
    gains = Path(str(GAINS))
    law = ik.solvers.load_gains(gains, as_tuned=False)
    quick = ik.solvers.LevenbergMarquardt(max_restarts=3)
    return [
        pytest.param(gains, gains.name, law, id="file"),
        pytest.param(str(gains), gains.name, law, id="text"),
        pytest.param(law, "StateSpace", law, id="gains"),
        pytest.param(quick, "LevenbergMarquardt", quick, id="options"),
    ]


@pytest.mark.parametrize(("given", "label", "solver"), own_solvers())
def test_a_solver_with_gains_or_options_solves(given: Any, label: str, solver: Any) -> None:
    with view("hydrolek", solver=given, port=0, open_browser=False) as viewer:
        panel = viewer._panel
        assert panel._solver.value == label
        assert panel._solver.options == (label, *solver_names())
        press(viewer, panel._task, "position")
        start = viewer.q
        target = viewer.robot.fk(start + 0.02)
        words = viewer.aim(target)
        asked = {"q0": start, "position_tolerance": 1e-6}
        expected = viewer.robot.ik(target, "position", solver=solver, **asked)
        assert expected.success and words.startswith("CONVERGED")
        np.testing.assert_array_equal(viewer.q, expected.q)
        names: dict[str, Any] = {}
        exec(panel.session.python(), names)
        assert names["result"].success
        # There are the others as well; another arm has the default again.
        press(viewer, panel._solver, "dls")
        assert viewer.aim(target).startswith("CONVERGED")
        press(viewer, panel._robot, "ur5")
        assert panel._solver.value == "lm"
        press(viewer, panel._solver, label)
        if label != "LevenbergMarquardt":
            # Gains are for one arm: words say so.
            assert "hydrolek" in viewer.status and not panel.session.outcome.reached


@pytest.mark.parametrize("solver", [3, ik.solvers.LevenbergMarquardt, "ml", Path("gone.toml")])
def test_what_is_no_solver_is_refused(solver: Any) -> None:
    with pytest.raises(ik.AgrikError, match=r"solver|gone\.toml"):
        view("hydrolek", solver=solver, port=0, open_browser=False)


def test_ways_are_made_stepped_through_and_played(viewer: Viewer) -> None:
    panel, path = viewer._panel, viewer._tabs.path
    viewer.aim(viewer.robot.fk([0.4, 0.6, 0.1, 0.9, 0.2, 0.8, 0.0]))
    path._radius.value = 0.05
    press(viewer, path._kind, "circle")
    press(viewer, path._make)
    assert path.way is not None and not path.way.bad.any(), path._words.content
    tips = viewer.robot.fk(path.way.q)[:, :3, 3]
    assert np.ptp(tips[:, 0]) == pytest.approx(0.1, abs=1e-3)
    path._stepped(3)
    assert panel.worker.settle(10)
    assert (viewer.q == path.way.q[3]).all()
    path._speed.value = 4.0
    path.play()
    end = time.monotonic() + 30
    while path._time.value < len(path.way.q) and time.monotonic() < end:
        time.sleep(0.05)
    assert panel.worker.settle(10)
    assert (viewer.q == path.way.q[-1]).all()


def test_a_way_out_of_reach_has_marks_and_words(viewer: Viewer) -> None:
    path = viewer._tabs.path
    path._by.value = (0.0, 0.0, 2.0)
    press(viewer, path._kind, "line")
    press(viewer, path._make)
    assert path.way is not None and path.way.bad.any()
    assert re.search(r"\d+ not reached", path._words.content)
    assert path._time._impl.props._marks
    viewer._panel.server.flush()


# ---- the strawberry arm: viewer, commands and driver say the same ----------------------------


def test_psi_and_hand_are_drawn_as_the_commands_say() -> None:
    arm, psi = StrawberryArm(), 0.7
    with view("strawberry6", port=0, open_browser=False) as viewer:
        target = np.eye(4)
        target[:3, 3] = [0.426, 0.345, -0.3316]
        viewer._panel.session.aim(target)
        way = picking(viewer._panel.session, psi, back=False)
        commands = arm.commands(arm.solve(target[:3, 3]).q, psi=psi)
        # Where each axis is at the end: what the last command to it says.
        said = {step.axis: step.target for step in commands}
        names = viewer.robot.joint_names
        assert way.q[-1].tolist() == pytest.approx([said[name] for name in names])
        assert way.opening[-1] == said["gripper"] == 0.0
        assert way.opening.max() == 1.0
        hand = viewer.robot.end_effector
        assert hand is not None and hand.servo in said
        viewer._tabs.path.take(way)
        stage = viewer._panel.stage
        for row in (0, len(way.q) // 2, len(way.q) - 1):
            viewer._tabs.path._show(row + 1)
            frames = viewer.robot.frames_of(way.q[row])
            assert np.abs(stage.drawn() - frames).max() < 1e-6
            assert stage.opening() == pytest.approx(way.opening[row])
        # The parts that the one servo moves, and no others, are what moves in the picture.
        assert [mesh.name for mesh, _ in stage._fingers] == list(hand.moves)
        # psi turns the tool about its own axis, by as much as the command says.
        still = way.q[-1].copy()
        still[5] = 0.0
        turn = viewer.robot.fk(still)[:3, :3].T @ viewer.robot.fk(way.q[-1])[:3, :3]
        assert np.arccos((np.trace(turn) - 1) / 2) == pytest.approx(psi)


@needs_simulator
def test_the_simulated_rig_moves_the_arm_that_is_shown() -> None:
    from agrik_fast.drivers import StrawberryRig

    with view("strawberry6", port=0, open_browser=False) as viewer:
        rig = viewer._tabs.rig
        assert rig.start() == "strawberry rig: homed"
        target = np.eye(4)
        target[:3, 3] = [0.426, 0.345, -0.3316]
        viewer._panel.session.aim(target)
        rig._psi.value = 40.0
        words = rig.drive()
        assert words.startswith("picked in ")
        assert viewer._panel.worker.settle(30)
        assert isinstance(rig._rig, StrawberryRig)
        status = rig._rig.status()
        arm = StrawberryArm()
        commands = arm.commands(arm.solve(target[:3, 3]).q, psi=np.radians(40.0))
        said = {step.axis: step.target for step in commands}
        wanted = [said[name] for name in viewer.robot.joint_names]
        # Driver and commands, driver and picture: within what encoders and servos tell apart.
        assert np.abs(status.q - wanted).max() < 2e-3
        assert np.abs(viewer.q - status.q).max() < 2e-3
        assert np.abs(viewer._panel.stage.drawn() - viewer.robot.frames_of(viewer.q)).max() < 1e-6


def test_commands_become_postures_one_axis_at_a_time() -> None:
    arm = StrawberryArm()
    steps = arm.commands(arm.solve([0.426, 0.345, -0.3316]).q, psi=0.3)
    q, opening = postures(np.append(arm.reset_pose, 0.0), list(steps))
    moved = np.abs(np.diff(q, axis=0)) > 1e-12
    hand = np.abs(np.diff(opening)) > 1e-12
    assert (moved.sum(axis=1) + hand <= 1).all()


# ---- files and refusals ------------------------------------------------------------------------


def test_a_page_without_a_server_is_one_file(tmp_path: Path) -> None:
    arm = ik.Robot.load("cucumber")
    rows = np.linspace(arm.lower, arm.upper, 20)
    file = export_html(arm, tmp_path / "arm.html", q=rows, scene=ik.collision.greenhouse(seed=1))
    text = file.read_text(encoding="utf-8")
    assert "__VISER_EMBED_DATA__" in text
    assert 500_000 < len(text) < 4_000_000
    outside = re.findall(r"""(?:src|href)\s*=\s*["'](https?://[^"']+)""", text)
    assert outside == []
    with pytest.raises(ik.AgrikError, match="exists already"):
        export_html(arm, file)
    assert export_html(arm, file, force=True) == file


def test_results_of_solve_are_played_as_they_are(tmp_path: Path) -> None:
    from agrik_fast.io import read_results
    from agrik_fast.jobs import SolveRequest, solve_file

    arm = ik.Robot.load("ur5")
    goals = tmp_path / "goals.npy"
    np.save(goals, arm.fk(arm.random_q(5, seed=1)))
    found = tmp_path / "found.csv"
    solve_file(SolveRequest(robot="ur5", targets=goals, output=found))
    q, targets = playable(arm, found)
    assert targets is None and q is not None
    assert (q == read_results(found)[1].q).all()
    q, targets = playable(arm, goals)
    assert q is None and targets is not None and targets.shape == (5, 4, 4)
    with pytest.raises(ArgumentError, match="joints"):
        playable(ik.Robot.load("panda"), found)
    with view("ur5", path=found, port=0, open_browser=False) as viewer:
        assert viewer._tabs.path.way is not None
        assert len(viewer._tabs.path.way.q) == 5


def test_a_busy_port_is_an_error_that_names_it() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(ArgumentError, match=str(port)):
            view("tomato", port=port, open_browser=False)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"show": "nothing"}, "show"),
        ({"port": 70000}, "port"),
        ({"host": 5}, "host"),
        ({"q": [0.0, 1.0]}, "q"),
        ({"q": [99.0, 0.0, 0.0]}, "q"),
        ({"targets": [[0.0, 1.0]]}, "targets"),
        ({"targets": [[0.0, 1.0, np.nan]]}, "targets"),
        ({"scene": "nowhere.toml"}, "nowhere"),
        ({"path": "nowhere.csv"}, "nowhere"),
        ({"show": "visuals"}, "visuals"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ik.AgrikError, match=words):
        view("tomato", **{"port": 0, "open_browser": False, **arguments})


def test_stopping_is_quick_and_may_be_done_twice() -> None:
    viewer = view("tomato", port=0, open_browser=False)
    start = time.monotonic()
    viewer.stop()
    viewer.stop()
    viewer.wait()
    assert time.monotonic() - start < 5


def test_meshes_and_solids_of_a_urdf_are_shown(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box((0.1, 0.1, 0.3)).export(tmp_path / "part.stl")
    links = ["base_link", "l1", "tool0"]
    text = urdf(links, [joint("j1", "base_link", "l1", axis="0 0 1"),
                        joint("j2", "l1", "tool0", xyz="0 0 0.3", axis="0 1 0")])  # fmt: skip
    visual = (
        '<visual><origin xyz="0 0 0.15"/><geometry><mesh filename="part.stl"/></geometry>'
        '<material name="red"><color rgba="1 0 0 1"/></material></visual>'
        '<visual><geometry><cylinder radius="0.05" length="0.2"/></geometry></visual>'
    )
    solid = '<collision><geometry><sphere radius="0.05"/></geometry></collision>'
    text = text.replace('<link name="l1"/>', f'<link name="l1">{visual}{solid}</link>')
    file = tmp_path / "arm.urdf"
    file.write_text(text, encoding="utf-8")
    arm = ik.Robot.load(file)
    assert arm.has_visuals
    parts = arm.surfaces()
    assert [part.role for part in parts] == ["visual", "visual"]
    assert parts[0].colour == (1.0, 0.0, 0.0) and parts[1].colour is None
    assert np.ptp(parts[0].vertices, axis=0) == pytest.approx([0.1, 0.1, 0.3])
    assert parts[0].vertices[:, 2].min() == pytest.approx(0.0, abs=1e-7)
    with view(file, port=0, open_browser=False) as viewer:
        assert viewer.aim(viewer.robot.fk(viewer.q)).startswith("CONVERGED")
    (tmp_path / "part.stl").unlink()
    with pytest.warns(UserWarning, match=re.escape("part.stl")):
        assert {part.role for part in ik.Robot.load(file).surfaces()} >= {"link", "joint"}
