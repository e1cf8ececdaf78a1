"""The viewer in a real browser: one page after the other, as a person would use it."""

import time
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlparse

import numpy as np
import pytest
from browser import BROWSER, Page, chromium, project, wait_for

import agrik_fast as ik
from agrik_fast.viewer import Viewer, view

pytestmark = [*BROWSER, pytest.mark.timeout(300)]
DESKTOP, PHONE = (1280, 800), (390, 844)
START = ik.Robot.load("redundant7").fk([0.4, 0.6, 0.1, 0.9, 0.2, 0.8, 0.0])


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
    viewer.aim(START)
    wait_for(lambda: "CONVERGED" in opened.status, "the status")
    return opened


def the_camera(viewer: Viewer) -> Any:
    """Return the camera of the page that was opened last, settled."""
    clients = wait_for(viewer._panel.server.get_clients, "a client")
    camera = clients[max(clients)].camera
    before = None
    while before != (before := tuple(camera.position)):
        time.sleep(0.3)
    return camera


def drag_axis(page: Page, viewer: Viewer, axis: int, by: float, *, touch: bool = False) -> None:
    """Drag one arrow of the target's handle along its axis."""
    camera, handle = the_camera(viewer), viewer._panel.stage.handle
    pose = viewer.target
    along = pose[:3, axis]
    tip = pose[:3, 3] + 0.95 * handle.scale * along
    page.drag(project(camera, tip), project(camera, tip + by * along), touch=touch)


def settled(page: Page, viewer: Viewer, before: np.ndarray, seconds: float) -> float:
    """Wait until the page tells of another target; return how long that took, s."""
    begin = time.monotonic()
    text = page.status
    wait_for(lambda: not np.array_equal(viewer.target, before), "another target", seconds)
    wait_for(lambda: page.status != text or "CONVERGED" in page.status, "another status", seconds)
    return time.monotonic() - begin


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
