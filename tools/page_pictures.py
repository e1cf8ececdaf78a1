"""Take a picture of every page of the built documentation, at the width of a desk and of a phone.

    tools/page_pictures.py docs/_build/html pictures/

Needs Chromium and its driver (``.ci/browser``). The pictures are for eyes; what a program can see
is said as well, and makes the exit code 1: pages that scroll sideways, pictures that are not shown,
text smaller than can be read.
"""

from __future__ import annotations

import argparse
import base64
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "viewer"))

from browser import chromium

WIDTHS = {"desk": 1280, "phone": 390}
# A tall page is taken in pieces: of more lines a browser draws the first ones again.
_PIECE = 4000
# What a program can see: how far the page goes to the right, and what is not shown. Pictures that
# are loaded when they are scrolled to are loaded first.
_LOOK = """
const done = arguments[0];
for (const img of document.images) img.loading = 'eager';
Promise.all([...document.images].map(i => i.decode().catch(() => 0))).then(() => done({
  wide: document.documentElement.scrollWidth,
  tall: document.documentElement.scrollHeight,
  lost: [...document.images].filter(i => !i.naturalWidth).map(i => i.src),
  small: [...document.querySelectorAll('main p, main li, main td, main pre')]
    .filter(e => e.innerText.trim() && parseFloat(getComputedStyle(e).fontSize) < 11)
    .map(e => e.innerText.slice(0, 40)),
}))
"""


def pictures(driver: Any, site: Path, out: Path, wanted: list[str]) -> Iterator[str]:
    """Write a picture of each page and width; yield what is wrong, one line a fault."""
    for page in sorted(site.rglob("*.html")):
        name = page.relative_to(site).with_suffix("").as_posix()
        if "_static" in page.parts or (wanted and name not in wanted):
            continue
        for kind, width in WIDTHS.items():
            size = {"width": width, "height": 900, "deviceScaleFactor": 1}
            phone = {"mobile": kind == "phone"}
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {**size, **phone})
            driver.get(page.as_uri())
            seen = driver.execute_async_script(_LOOK)
            if seen["wide"] > width:
                yield f"{name}: {seen['wide']} px wide in a window of {width}"
            for lost in seen["lost"]:
                yield f"{name}: {lost} is not shown"
            for text in seen["small"]:
                yield f"{name}: too small to be read: {text!r}"
            size["height"] = min(seen["tall"], _PIECE)
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {**size, **phone})
            for number, top in enumerate(range(0, seen["tall"], _PIECE)):
                driver.execute_script("scrollTo({top: arguments[0], behavior: 'instant'})", top)
                png = driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
                piece = f".{number + 1}" if number else ""
                file = out / kind / f"{name.replace('/', '.')}{piece}.png"
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(base64.b64decode(png["data"]))


def main() -> int:
    """Take the pictures and print the faults; 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("site", type=Path, help="folder of the pages")
    parser.add_argument("out", type=Path, help="folder for the pictures")
    parser.add_argument("pages", nargs="*", help="only these, such as index or api/robot")
    parser.add_argument("--dark", action="store_true", help="as who prefers dark pages sees them")
    given = parser.parse_args()
    count = 0
    with chromium() as page:
        if given.dark:
            dark = {"name": "prefers-color-scheme", "value": "dark"}
            page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [dark]})
        for fault in pictures(page.driver, given.site.resolve(), given.out, given.pages):
            print(fault, flush=True)
            count += 1
    print(f"{given.site.name}: {count} faults")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
