"""The tabs of the viewer, without a browser: scene, reach, path, export."""

import csv
import io
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hands import press
from viser import UploadedFile

from agrik_fast.collision import Scene
from agrik_fast.viewer import Viewer, view


def upload(viewer: Viewer, widget: Any, name: str, content: bytes) -> None:
    """Do what the server does with a file that a browser sends."""
    widget._impl.value = UploadedFile(name, content)
    press(viewer, widget)


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    with view("panda", port=0, open_browser=False) as shown:
        yield shown


def test_home_undo_and_redo_are_buttons(viewer: Viewer) -> None:
    first = viewer.target
    buttons = next(
        handle
        for handle in viewer._panel.server.gui._gui_input_handle_from_uuid.values()
        if getattr(handle, "options", ()) == ("home", "undo", "redo")
    )
    viewer.aim(first[:3, 3] - [0.0, 0.0, 0.03])
    moved = viewer.target
    press(viewer, buttons, "undo")
    assert np.allclose(viewer.target, first)
    press(viewer, buttons, "redo")
    assert np.allclose(viewer.target, moved)
    press(viewer, buttons, "home")
    assert np.abs(viewer.q - viewer.robot.home).max() < 1e-9


def test_a_scene_is_written_read_hidden_and_kept_clear_of(viewer: Viewer, tmp_path: Path) -> None:
    panel, tab = viewer._panel, viewer._tabs.scene
    press(viewer, tab._add)
    press(viewer, tab._add)
    assert panel.session.scene is not None
    assert panel.session.scene.names == ("sphere 1", "sphere 2")
    content = press(viewer, tab._save)["scene.json"]
    press(viewer, tab._empty)
    assert panel.session.scene is None
    upload(viewer, tab._load, "bench.json", content)
    assert panel.session.scene is not None
    assert panel.session.scene.names == ("sphere 1", "sphere 2")
    file = tmp_path / "scene.json"
    file.write_bytes(content)
    assert Scene.load(file).names == panel.session.scene.names
    assert panel.stage._obstacles
    press(viewer, tab._shown, False)
    assert not panel.stage._obstacles and panel.session.scene is not None
    press(viewer, tab._shown, True)
    assert panel.stage._obstacles
    # The target is inside the sphere: with collisions kept clear of there is no posture.
    assert panel.session.outcome.hits
    press(viewer, tab._avoid, True)
    assert not panel.session.outcome.reached
    assert "COLLISION: " in panel._status.content
    upload(viewer, tab._load, "bench.json", b"{")
    assert "bench.json" in panel._status.content
    assert panel.session.scene.names == ("sphere 1", "sphere 2")


@pytest.mark.parametrize("axis", [0, 1, 2], ids="xyz")
def test_reach_is_cut_where_the_slider_says(viewer: Viewer, axis: int) -> None:
    tab, stage = viewer._tabs.reach, viewer._panel.stage
    press(viewer, tab._on, True)
    press(viewer, tab._count, "10 000")
    press(viewer, tab._plane, "xyz"[axis])
    # Through the tool at first.
    assert tab._at.value == pytest.approx(viewer.target[axis, 3], abs=0.006)
    press(viewer, tab._at, 0.25)
    assert stage._cloud is not None
    places = stage._cloud.points
    assert 0 < len(places) < 3000
    assert np.abs(places[:, axis] - 0.25).max() <= 0.0201
    press(viewer, tab._quantity, "manipulability")
    assert len(np.unique(stage._cloud.colors, axis=0)) > 20
    press(viewer, tab._sliced, False)
    assert len(stage._cloud.points) == 10_000


def test_recorded_targets_become_a_way_that_is_stepped(viewer: Viewer) -> None:
    tab = viewer._tabs.path
    press(viewer, tab._kind, "recorded")
    press(viewer, tab._make)
    assert "record this target" in viewer._panel._status.content
    start = viewer.target[:3, 3].copy()
    for k in range(3):
        viewer.aim(start - [0.0, 0.0, 0.01 * k])
        press(viewer, tab._record)
    assert tab._words.content == "3 recorded"
    press(viewer, tab._make)
    assert tab.way is not None and not tab.way.bad.any()
    tips = viewer.robot.fk(tab.way.q)[:, :3, 3]
    for k in range(3):
        assert np.linalg.norm(tips - (start - [0, 0, 0.01 * k]), axis=1).min() < 1e-5
    press(viewer, tab._step, "on")
    assert tab._time.value == 2
    assert (viewer.q == tab.way.q[1]).all()
    press(viewer, tab._step, "back")
    press(viewer, tab._step, "back")
    assert tab._time.value == 1
    press(viewer, tab._time, len(tab.way.q))
    assert (viewer.q == tab.way.q[-1]).all()


def test_a_file_of_targets_is_stepped_through(viewer: Viewer, tmp_path: Path) -> None:
    tab = viewer._tabs.path
    goals = viewer.robot.fk(viewer.robot.random_q(4, seed=3))
    np.save(tmp_path / "goals.npy", goals)
    upload(viewer, tab._load, "goals.npy", (tmp_path / "goals.npy").read_bytes())
    assert tab._number.visible and tab._number.max == 4
    press(viewer, tab._number, 3)
    assert np.allclose(viewer.target, goals[2])


def test_a_fast_way_is_drawn_no_more_than_sixty_times_a_second(viewer: Viewer) -> None:
    tab = viewer._tabs.path
    tab._radius.value = 0.03
    press(viewer, tab._kind, "circle")
    press(viewer, tab._make)
    assert tab.way is not None
    shown: list[int] = []
    tab._panel.worker.submit, submit = (  # type: ignore[method-assign]
        lambda kind, job, after=0.0: (shown.append(tab._time.value), submit(kind, job, after))[1],
        tab._panel.worker.submit,
    )
    tab._speed.value = 4.0
    begin = time.monotonic()
    tab.play()
    while tab._time.value < len(tab.way.q):
        assert time.monotonic() - begin < 30
        time.sleep(0.01)
    took = time.monotonic() - begin
    assert len(shown) <= 60 * took + 1
    assert shown[-1] == len(tab.way.q)


def test_what_is_shown_is_taken_away_as_files(viewer: Viewer) -> None:
    gui = viewer._panel.server.gui
    buttons = {
        getattr(handle, "label", ""): handle for handle in gui._gui_input_handle_from_uuid.values()
    }
    page = press(viewer, buttons["page without a server (HTML)"])["arm.html"].decode()
    assert "__VISER_EMBED_DATA__" in page
    content = press(viewer, buttons["target and joint values (CSV)"])["arm.csv"].decode()
    rows = list(csv.reader(io.StringIO(content)))
    assert rows[0][:3] == ["x_m", "y_m", "z_m"] and len(rows) == 2
    numbers = np.array(rows[1], dtype=float)
    assert (numbers[6:] == viewer.q).all()
    assert np.abs(numbers[:3] - viewer.target[:3, 3]).max() < 1e-6
    from PIL import Image

    image = Image.open(io.BytesIO(press(viewer, buttons["picture (PNG)"])["arm.png"]))
    assert image.size == (640, 480)
    # What is clear is white on paper.
    assert image.getpixel((10, 10)) == (255, 255, 255) and image.getpixel((630, 10)) == (0, 0, 0)
