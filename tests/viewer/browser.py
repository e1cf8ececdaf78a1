"""A browser for tests: Debian's Chromium, and how a person's hand moves in it."""

import json
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium")
DRIVER = shutil.which("chromedriver")
try:
    from selenium import webdriver
except ImportError:  # the extra is not installed: the tests say so
    webdriver = None  # type: ignore[assignment]

MISSING = [
    name
    for name, found in (
        ("chromium", CHROMIUM), ("chromedriver", DRIVER), ("selenium", webdriver),
    )
    if not found
]  # fmt: skip
WHY_NOT = f"NOT CHECKED: {', '.join(MISSING)} missing (.ci/browser installs it on Debian)"
# `make browser` sets it: there a browser that is missing is an error.
WANTED = os.environ.get("AGRIK_BROWSER") == "1"
BROWSER = [
    pytest.mark.browser,
    pytest.mark.skipif(bool(MISSING) and not WANTED, reason=WHY_NOT),
]
"""For ``pytestmark``."""

FLAGS = (
    "--headless=new --no-sandbox --disable-dev-shm-usage --use-gl=angle --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --disable-background-networking --no-first-run"
)
PATIENCE = 30.0
"""How long a busy machine may take, s."""


@contextmanager
def chromium() -> Iterator[Any]:
    """Start a browser without a window; it is ended whatever happens."""
    assert not MISSING, WHY_NOT
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in FLAGS.split():
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    driver.set_script_timeout(60)
    try:
        yield Page(driver)
    finally:
        driver.quit()


class Page:
    """A page, and what a person does with it."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver
        self.addresses: set[str] = set()

    def size(self, width: int, height: int, *, phone: bool = False) -> None:
        """Set the size of the window, px."""
        self._order(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=phone,
        )  # fmt: skip
        self._order("Emulation.setTouchEmulationEnabled", enabled=phone)

    def open(self, address: str) -> None:
        """Open a page, wait for its picture, and close the notice on slow graphics."""
        self.driver.get(address)
        wait_for(lambda: self.find("canvas"), "a canvas")
        with_notice = wait_for(lambda: self.find(".mantine-Notification-closeButton"), "the notice")
        for button in with_notice:
            self.click(button)
        # Its first picture takes a browser without a graphics card long: what it draws with is
        # compiled then.
        wait_for(lambda: self._frames(1.0) >= 3, "a picture that moves", 60.0)

    def _frames(self, seconds: float) -> int:
        """Return how many pictures are drawn in a time."""
        script = (
            "const [seconds, done] = arguments, begin = performance.now(); let n = 0;"
            "const next = () => { n++; if (performance.now() - begin > 1000 * seconds)"
            " done(n); else requestAnimationFrame(next); }; requestAnimationFrame(next)"
        )
        return int(self.driver.execute_async_script(script, seconds))

    def requested(self) -> set[str]:
        """Return all addresses that the pages asked for so far."""
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                self.addresses.add(message["params"]["request"]["url"])
            elif message["method"] == "Network.webSocketCreated":
                self.addresses.add(message["params"]["url"])
        return self.addresses

    def find(self, selector: str) -> list[Any]:
        """Return elements by a CSS selector."""
        found: list[Any] = self.driver.find_elements("css selector", selector)
        return found

    def text(self, selector: str) -> str:
        """Return the text of the first element of a selector, empty without one."""
        script = "const e=document.querySelector(arguments[0]); return e ? e.innerText : ''"
        return str(self.driver.execute_script(script, selector))

    @property
    def status(self) -> str:
        """What the viewer's status says."""
        return self.text("#agrik-status")

    def labelled(self, label: str) -> Any:
        """Return the input that a label with this very text belongs to."""
        script = (
            "for (const l of document.querySelectorAll('label')) "
            "if (l.textContent.trim() === arguments[0] && l.htmlFor) "
            "return document.getElementById(l.htmlFor); return null"
        )
        return wait_for(lambda: self.driver.execute_script(script, label), f"a field {label!r}")

    def click(self, element: Any) -> None:
        """Click an element, whatever lies over it."""
        self.driver.execute_script("arguments[0].click()", element)

    def tab(self, name: str) -> None:
        """Open a tab of the panel."""
        tabs = [tab for tab in self.find("[role=tab]") if tab.text == name]
        assert tabs, name
        tabs[0].click()

    def button(self, text: str) -> None:
        """Click a button by its text."""

        def there() -> list[Any]:
            return [each for each in self.find("button") if each.text.strip() == text]

        self.click(wait_for(there, f"a button {text!r}")[0])

    def choose(self, label: str, option: str) -> None:
        """Choose in a list by its label, as a person does: open it, click."""
        field = self.labelled(label)
        field.click()

        # In one go: between finding and clicking, a busy page may draw the list anew.
        script = (
            "for (const o of document.querySelectorAll('[role=option]')) "
            "if (o.textContent.trim() === arguments[0] && o.offsetParent) "
            "{ o.click(); return true } return false"
        )
        wait_for(lambda: self.driver.execute_script(script, option), f"an option {option!r}")

    def write(self, label: str, text: str) -> None:
        """Write into a field in place of what it holds, and leave it."""
        from selenium.webdriver.common.keys import Keys

        field = self.labelled(label)
        field.click()
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text, Keys.TAB)

    def keys(self, element: Any, *keys: str) -> None:
        """Press keys on an element."""
        self.driver.execute_script("arguments[0].focus()", element)
        self.driver.switch_to.active_element.send_keys(*keys)

    def drag(self, a: Any, b: Any, steps: int = 8, *, touch: bool = False) -> None:
        """Press at one place (px), move to another, release: a mouse, or a finger."""
        ways = [np.asarray(a) + (np.asarray(b) - a) * k / steps for k in range(1, steps + 1)]
        if touch:
            self._touch("touchStart", a)
            for place in ways:
                self._touch("touchMove", place)
            self._order("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
            return
        self._mouse("mouseMoved", a)
        # The handle has to notice what it is that the mouse is over.
        time.sleep(0.3)
        self._mouse("mousePressed", a, button="left", clickCount=1)
        for place in ways:
            self._mouse("mouseMoved", place, button="left")
        self._mouse("mouseReleased", b, button="left", clickCount=1)

    def picture(self) -> np.ndarray:
        """Return what the window shows, shape (height, width, 3)."""
        import base64
        import io

        from PIL import Image

        png = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
        image = Image.open(io.BytesIO(base64.b64decode(png["data"])))
        return np.asarray(image.convert("RGB"))

    def _mouse(self, kind: str, place: Any, **more: Any) -> None:
        x, y = map(float, place)
        held = int("button" in more and kind != "mouseReleased")
        self._order("Input.dispatchMouseEvent", type=kind, x=x, y=y, buttons=held, **more)

    def _touch(self, kind: str, place: Any) -> None:
        x, y = map(float, place)
        self._order("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y}])

    def _order(self, name: str, **values: Any) -> None:
        self.driver.execute_cdp_cmd(name, values)


def wait_for(what: Callable[[], Any], name: str, timeout: float = PATIENCE) -> Any:
    """Return the first true answer, or fail with the name of what never came."""
    end = time.monotonic() + timeout
    while True:
        found = what()
        if found:
            return found
        if time.monotonic() > end:
            raise AssertionError(f"{name} did not come within {timeout:.0f} s")
        time.sleep(0.02)


def project(camera: Any, place: Any) -> np.ndarray:
    """Return where a camera of the viewer shows a point, px: x right, y down."""
    position, look_at = np.array(camera.position), np.array(camera.look_at)
    z = (look_at - position) / np.linalg.norm(look_at - position)
    x = np.cross(z, camera.up_direction)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    across, down, away = np.stack([x, y, z]) @ (np.asarray(place) - position)
    height, width = camera.image_height, camera.image_width
    scale = height / 2 / np.tan(camera.fov / 2)
    return np.array([width / 2 + scale * across / away, height / 2 + scale * down / away])


def the_camera(viewer: Any) -> Any:
    """Return the camera of the page that was opened last, once it stands still."""
    clients = wait_for(viewer._panel.server.get_clients, "a client")
    camera = clients[max(clients)].camera
    before = None
    while before != (before := tuple(camera.position)):
        time.sleep(0.3)
    return camera


def drag_axis(page: Page, viewer: Any, axis: int, by: float, *, touch: bool = False) -> None:
    """Drag one arrow of the target's handle along its axis."""
    camera, handle = the_camera(viewer), viewer._panel.stage.handle
    pose = viewer.target
    along = pose[:3, axis]
    tip = pose[:3, 3] + 0.95 * handle.scale * along
    page.drag(project(camera, tip), project(camera, tip + by * along), touch=touch)


# In the page itself: from the first move of the pointer to the next change of the status.
_WATCH = """
window.agrikTimes = [];
let begin = null, said = document.getElementById('agrik-status').innerText;
document.addEventListener('pointermove', (e) => {
  if ((e.buttons & 1) && begin === null) begin = performance.now();
}, true);
new MutationObserver(() => {
  const now = document.getElementById('agrik-status');
  if (!now || now.innerText === said) return;
  said = now.innerText;
  if (begin !== null) window.agrikTimes.push((performance.now() - begin) / 1000);
  begin = null;
}).observe(document.body, {subtree: true, childList: true, characterData: true});
"""


def drag_times(page: Page, viewer: Any, moves: int) -> np.ndarray:
    """Drag the target to and fro; return the times from a move to the changed status, s."""
    camera, handle = the_camera(viewer), viewer._panel.stage.handle
    pose = viewer.target
    along = pose[:3, 2]
    tip = pose[:3, 3] + 0.95 * handle.scale * along
    page.driver.execute_script(_WATCH)
    page._mouse("mouseMoved", project(camera, tip))
    time.sleep(0.5)
    page._mouse("mousePressed", project(camera, tip), button="left", clickCount=1)
    count = "return window.agrikTimes.length"
    for number in range(1, moves + 1):
        # Never the same place twice: each has its own numbers in the status.
        by = -0.03 * (1 + number % 2) - 0.0004 * number
        page._mouse("mouseMoved", project(camera, tip + by * along), button="left")
        wait_for(
            lambda number=number: page.driver.execute_script(count) >= number, "another status"
        )
    page._mouse("mouseReleased", project(camera, tip), button="left", clickCount=1)
    return np.array(page.driver.execute_script("return window.agrikTimes"))
