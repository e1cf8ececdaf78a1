"""The viewer in a real browser: one page after the other, as a person would use it."""

import re
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import urlparse

import numpy as np
import pytest
from browser import (
    BROWSER,
    Page,
    chromium,
    drag_axis,
    drag_times,
    project,
    the_camera,
    wait_for,
)
from PIL import Image

import agrik_fast as ik
from agrik_fast.viewer import Viewer, export_html, view

pytestmark = [*BROWSER, pytest.mark.timeout(300)]
# The target is left of the panel.
DESKTOP, PHONE = (1000, 640), (390, 844)
START = ik.Robot.load("redundant7").fk([-2.4, 0.6, 0.1, 0.9, 0.2, 0.8, 0.0])


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    with view("redundant7", port=0, open_browser=False) as shown:
        yield shown


@pytest.fixture(scope="module")
def opened(page: Page, viewer: Viewer) -> Page:
    page.size(*DESKTOP)
    page.open(viewer.url)
    return page


@pytest.fixture
def desktop(opened: Page, viewer: Viewer) -> Page:
    """The viewer's page at the size of a desk, a target in the middle of what can be reached."""
    # A busy browser may still be telling of the drag before.
    before = None
    while before is None or not np.array_equal(before, viewer.target):
        before = viewer.target
        time.sleep(0.5)
    # Whatever a test before has left.
    if viewer.robot.name != "redundant7":
        panel = viewer._panel
        panel.worker.submit("robot", lambda: panel._choose_robot("redundant7"))
        assert panel.worker.settle(60.0)
    opened.tab("Target")
    viewer.aim(START)
    wait_for(lambda: "CONVERGED" in opened.status, "the status")
    return opened


@pytest.mark.parametrize("axis", [0, 1, 2], ids="xyz")
def test_dragging_an_arrow_moves_target_and_arm(desktop: Page, viewer: Viewer, axis: int) -> None:
    before = viewer.target
    text = desktop.status
    drag_axis(desktop, viewer, axis, 0.05)
    wait_for(lambda: not np.array_equal(viewer.target, before), "another target")
    wait_for(lambda: desktop.status != text, "another status")
    viewer._panel.worker.settle(30.0)
    moved = viewer.target[:3, 3] - before[:3, 3]
    along = before[:3, axis]
    # Along that axis, and no other: the arrow was hit, not the ring or the ground.
    assert abs(moved @ along) > 0.01
    assert np.linalg.norm(moved - (moved @ along) * along) < 1e-4
    assert np.abs(viewer.robot.fk(viewer.q) - viewer.target).max() < 1e-6
    drawn = viewer._panel.stage.drawn()
    assert np.abs(drawn - viewer.robot.frames_of(viewer.q)).max() < 1e-6


def test_nothing_but_the_own_server_is_asked(desktop: Page, viewer: Viewer) -> None:
    own = urlparse(viewer.url).netloc
    for address in desktop.requested():
        parts = urlparse(address)
        assert parts.scheme in ("data", "blob") or parts.netloc == own, address


def test_the_first_screen_says_what_it_is(desktop: Page, viewer: Viewer) -> None:
    assert re.search(r"CONVERGED\s+[\d.]+ ms\s+\d+ iterations?", desktop.status)
    assert "clearance" in desktop.status
    for label in ("robot", "solver", "task", "x [m]", "yaw [deg]", "all branches"):
        assert desktop.labelled(label).is_displayed(), label
    # Something stands in the middle, which is not the white of an empty page.
    picture = desktop.picture()
    middle = picture[100:600, 200:650].astype(int)
    colourful = (middle.max(axis=2) - middle.min(axis=2)) > 60
    assert colourful.sum() > 500


def test_number_fields_do_what_the_handle_does(desktop: Page, viewer: Viewer) -> None:
    # As many digits as the field has.
    height = round(float(viewer.target[2, 3]) - 0.03, 3)
    desktop.write("z [m]", f"{height:.3f}")
    wait_for(lambda: abs(viewer.target[2, 3] - height) < 1e-9, "the target")
    wait_for(lambda: f"{height:.3f} m" in desktop.status, "the status")
    viewer._panel.worker.settle(30.0)
    assert np.abs(viewer.robot.fk(viewer.q) - viewer.target).max() < 1e-6


def test_a_target_beyond_reach_is_told_in_words_and_colour(desktop: Page, viewer: Viewer) -> None:
    desktop.write("x [m]", "2.5")
    wait_for(lambda: "UNREACHABLE: " in desktop.status, "the words")
    assert re.search(r"UNREACHABLE: [\d.]+ c?m beyond reach", desktop.status)
    colour = "return getComputedStyle(document.getElementById('agrik-status')).color"
    assert desktop.driver.execute_script(colour) == "rgb(168, 67, 0)"
    viewer.aim(START)
    wait_for(lambda: "CONVERGED" in desktop.status, "the words")
    assert desktop.driver.execute_script(colour) == "rgb(0, 80, 125)"


def test_the_keyboard_undoes_and_redoes(desktop: Page, viewer: Viewer) -> None:
    from selenium.webdriver.common.keys import Keys

    before = viewer.target
    viewer.aim(before[:3, 3] - [0.0, 0.0, 0.03])
    moved = viewer.target
    for key, wanted in (("z", before), ("y", moved)):
        desktop.driver.switch_to.active_element.send_keys(Keys.CONTROL, key, Keys.NULL)
        wait_for(lambda wanted=wanted: np.allclose(viewer.target, wanted), f"Ctrl-{key}")


# What has the focus: its name, and where it is; the page itself has none.
_FOCUS = """
const e = document.activeElement, box = e.getBoundingClientRect();
if (e === document.body) return ["", 0, 0];
const label = e.id && document.querySelector(`label[for="${CSS.escape(e.id)}"]`);
return [(label ? label.textContent : e.innerText).trim(), box.top, box.left]
"""


def test_the_tab_key_goes_through_the_panel_in_reading_order(desktop: Page) -> None:
    from selenium.webdriver.common.keys import Keys

    desktop.driver.execute_script("arguments[0].focus()", desktop.labelled("robot"))
    seen: list[tuple[str, float, float]] = [tuple(desktop.driver.execute_script(_FOCUS))]
    while (len(seen) < 60 and seen[-1][0] != "robot") or len(seen) == 1:
        desktop.driver.switch_to.active_element.send_keys(Keys.TAB)
        seen.append(tuple(desktop.driver.execute_script(_FOCUS)))
    names = [name for name, *_ in seen]
    fields = ["x [m]", "y [m]", "z [m]", "roll [deg]", "pitch [deg]", "yaw [deg]"]
    wanted = ["robot", "solver", "task", *fields, "home", "undo", "redo", "all branches"]
    assert names[: len(wanted)] == wanted
    # All round: the heads of the tabs come before what the tab holds, and nothing keeps the focus.
    assert names[-1] == "robot"
    tabs = ["Target", "Joints", "Scene", "Reach", "Path", "Rig", "Export"]
    assert names[-len(tabs) - 1 : -1] == tabs
    # Down the panel, and from left to right in a row.
    for (_, above, left), (name, below, right) in pairwise(seen[: names.index("")]):
        assert right > left if abs(below - above) < 12 else below > above, name


def test_branches_by_the_keyboard(desktop: Page, viewer: Viewer) -> None:
    desktop.click(desktop.labelled("all branches"))
    wait_for(lambda: len(viewer._panel.stage._branches) > 1, "branches")
    before = viewer.q
    slider = wait_for(
        lambda: [s for s in desktop.find("[role=slider]") if s.is_displayed()], "a slider"
    )[0]
    desktop.keys(slider, "\ue014")  # arrow right
    wait_for(lambda: not np.allclose(viewer.q, before), "another branch")
    assert np.abs(viewer.robot.fk(viewer.q) - viewer.target).max() < 1e-6
    desktop.click(desktop.labelled("all branches"))
    wait_for(lambda: not viewer._panel.stage._branches, "no branches")


def test_solver_and_robot_are_chosen_by_their_labels(desktop: Page, viewer: Viewer) -> None:
    desktop.choose("solver", "dls")
    wait_for(lambda: viewer._panel.session.solver == "dls", "the solver")
    # There and back: nodes that come again must not keep the turn of those before.
    for name in ("cucumber", "redundant7"):
        desktop.choose("robot", name)
        wait_for(lambda name=name: viewer.robot.name == name, f"the robot {name}", 60)
        wait_for(lambda: "CONVERGED" in desktop.status, "the status")
    viewer.aim(START)
    viewer._panel.worker.settle(30.0)
    base = viewer._panel.stage._parts[0]
    assert base.role == "base"
    link = next(part for part in viewer._panel.stage._parts if part.role == "link")
    middle = link.vertices.mean(axis=0)

    def orange() -> bool:
        x, y = project(the_camera(viewer), middle).round().astype(int)
        red, green, blue = desktop.picture()[y - 2 : y + 3, x - 2 : x + 3].mean(axis=(0, 1))
        return red > green + 15 and green > blue + 30

    # The lowest link stands upright where it is: a stale turn would leave the ground there.
    wait_for(orange, "the lowest link where it is")


def test_reach_map_is_shown_and_hidden(desktop: Page, viewer: Viewer) -> None:
    desktop.tab("Reach")
    desktop.click(desktop.labelled("reach map"))
    wait_for(lambda: viewer._panel.stage._cloud is not None, "the cloud")
    wait_for(lambda: "points shown" in desktop.text("body"), "its words")
    desktop.click(desktop.labelled("reach map"))
    wait_for(lambda: viewer._panel.stage._cloud is None, "no cloud")


def test_joints_by_the_keyboard(desktop: Page, viewer: Viewer) -> None:
    desktop.tab("Joints")
    before = viewer.q
    slider = wait_for(
        lambda: [s for s in desktop.find("[role=slider]") if s.is_displayed()], "a slider"
    )[0]
    desktop.keys(slider, "\ue012", "\ue012")  # arrow left
    wait_for(lambda: viewer.q[0] != before[0], "another angle")
    viewer._panel.worker.settle(30.0)
    assert np.abs(viewer.robot.fk(viewer.q) - viewer.target).max() < 1e-6


def test_a_way_is_made_and_played(desktop: Page, viewer: Viewer) -> None:
    desktop.tab("Path")
    desktop.choose("way", "circle")
    desktop.write("circle radius [m]", "0.05")
    desktop.button("make the way")
    path = viewer._tabs.path
    wait_for(lambda: path.way is not None, "a way")
    desktop.button("play")
    wait_for(lambda: path._time.value > 5, "the arm on its way")
    desktop.button("pause")
    assert "pose" in desktop.status


def test_what_is_taken_away(desktop: Page, viewer: Viewer) -> None:
    desktop.tab("Export")
    desktop.button("copy as Python")
    wait_for(lambda: viewer._tabs.export._script.visible, "the script")
    area = wait_for(lambda: desktop.find("textarea"), "a place for it")[0]
    script = wait_for(lambda: area.get_attribute("value"), "its text")
    page_of = desktop.driver
    grant = {"permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"]}
    page_of.execute_cdp_cmd("Browser.grantPermissions", {"origin": viewer.url, **grant})
    desktop.button("copy to the clipboard")
    desktop.button("copied")
    read = "navigator.clipboard.readText().then(arguments[0])"
    assert page_of.execute_async_script(read) == script
    names: dict[str, Any] = {}
    exec(script, names)
    assert np.abs(names["result"].q - viewer.q).max() < 1e-6


def test_files_are_saved(desktop: Page, viewer: Viewer, tmp_path: Path) -> None:
    allowed = {"behavior": "allow", "downloadPath": str(tmp_path)}
    desktop.driver.execute_cdp_cmd("Browser.setDownloadBehavior", allowed)
    desktop.tab("Export")
    for label, name in (
        ("target and joint values (CSV)", "arm.csv"),
        ("picture (PNG)", "arm.png"),
        ("page without a server (HTML)", "arm.html"),
    ):
        desktop.button(label)
        wait_for(lambda name=name: (tmp_path / name).exists(), name, 60.0)
    last = (tmp_path / "arm.csv").read_text(encoding="utf-8").splitlines()[1]
    # The arm may have gone on a little after its values were saved.
    np.testing.assert_allclose([float(x) for x in last.split(",")[6:]], viewer.q, atol=0.01)
    picture = np.asarray(Image.open(tmp_path / "arm.png").convert("RGB")).astype(int)
    # An arm, on white.
    assert picture.max() == 255
    assert ((picture.max(axis=2) - picture.min(axis=2)) > 60).sum() > 500


def test_the_time_from_drag_to_text(desktop: Page, viewer: Viewer) -> None:
    times = drag_times(desktop, viewer, moves=7)
    # What a hand waits for: the benchmark prints how short it is, here it must not be long.
    assert np.median(times) <= 2.0, times


@pytest.mark.parametrize("name", ["redundant7", "panda"])
def test_on_a_phone_the_arm_is_in_view_and_a_finger_drags(page: Page, name: str) -> None:
    page.size(*PHONE, phone=True)
    with view(name, port=0, open_browser=False) as viewer:
        by_a_finger(page, viewer)


def by_a_finger(page: Page, viewer: Viewer) -> None:
    page.open(viewer.url)
    wait_for(lambda: "CONVERGED" in page.status, "the status")
    canvas = page.find("canvas")[0]
    assert canvas.size["width"] == PHONE[0]
    # The panel takes no more than two fifths of the height, and shows the status.
    script = (
        "let e=document.getElementById('agrik-status');"
        "while(!e.className.includes('Paper-root')) e=e.parentElement;"
        "return e.getBoundingClientRect().height"
    )
    assert page.driver.execute_script(script) <= 0.4 * PHONE[1]
    before = viewer.target
    stage, camera = viewer._panel.stage, the_camera(viewer)
    assert stage.handle.scale == pytest.approx(1.5 * stage.handle_size())
    for point in (*viewer.robot.frames_of(viewer.q)[:, :3, 3], *stage.handle_tips(before)):
        x, y = project(camera, point)
        assert 0 < x < PHONE[0] and 0 < y < PHONE[1]
    drag_axis(page, viewer, 0, 0.05, touch=True)
    wait_for(lambda: not np.array_equal(viewer.target, before), "another target")
    viewer._panel.worker.settle(30.0)
    assert abs((viewer.target[:3, 3] - before[:3, 3]) @ before[:3, 0]) > 0.005


def test_a_page_without_a_server_shows_and_plays(page: Page, tmp_path: Path) -> None:
    arm = ik.Robot.load("cucumber")
    rows = np.linspace(0.8 * arm.lower, 0.8 * arm.upper, 40)
    file = export_html(arm, tmp_path / "arm.html", q=rows)
    page.size(*DESKTOP)
    known = set(page.requested())
    page.open(file.as_uri())
    assert page.find("button"), "a button to play"
    first = page.picture()
    wait_for(lambda: (np.abs(page.picture().astype(int) - first) > 40).sum() > 300, "a motion")
    for address in page.requested() - known:
        assert urlparse(address).scheme in ("file", "data", "blob"), address
