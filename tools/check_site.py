"""Check the built documentation: no dead link, nothing loaded from elsewhere, no table as text.

    tools/check_site.py docs/_build/html

Every internal link must lead to a file of the site, and its fragment to an element there. Scripts,
styles, fonts and pictures must be files of the site too, so that a page makes no request to any
other address; only links that a reader follows by hand may lead elsewhere. A table that its text
runs into is shown as lines that begin with a bar.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Attributes that make a browser fetch something, by element; `a` only leads.
LOADS = {
    "audio": ("src",),
    "embed": ("src",),
    "iframe": ("src",),
    "img": ("src", "srcset"),
    "input": ("src",),
    "link": ("href",),
    "object": ("data",),
    "script": ("src",),
    "source": ("src", "srcset"),
    "track": ("src",),
    "video": ("poster", "src"),
}
# Relations of `link` that name a page, and load nothing.
LEADS = {"alternate", "author", "canonical", "help", "index", "license", "next", "prev", "search"}
# Elements whose text is shown, or not shown, as it stands.
VERBATIM = {"code", "pre", "script", "style", "textarea"}
STYLE_URL = re.compile(r"""url\(\s*["']?([^"')]+)["']?\s*\)|@import\s+["']([^"']+)["']""")


class Page(HTMLParser):
    """The places that a page can be led to, and those that it leads to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.leads: list[str] = []
        self.loads: list[str] = []
        self.tables_as_text: list[str] = []
        self._in_style = False
        self._verbatim = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Note the ids, links and loaded files of one element."""
        given = {name: value for name, value in attributes if value is not None}
        self.places |= {given[name] for name in ("id", "name") if name in given}
        self._in_style = tag == "style"
        self._verbatim += tag in VERBATIM
        if tag == "a" and "href" in given:
            self.leads.append(given["href"])
        self.loads += style_urls(given.get("style", ""))
        relations = set(given.get("rel", "").lower().split())
        for name in LOADS.get(tag, ()):
            if name not in given:
                continue
            if tag == "link" and relations & LEADS:
                self.leads.append(given[name])
            elif name == "srcset":
                self.loads += [part.split()[0] for part in given[name].split(",") if part.strip()]
            else:
                self.loads.append(given[name])

    def handle_endtag(self, tag: str) -> None:
        """Note the end of a style, and of a text that stands as it is."""
        self._verbatim -= tag in VERBATIM
        self._in_style = self._in_style and tag != "style"

    def handle_data(self, data: str) -> None:
        """Note what styles within the page load, and rows of tables among the text."""
        if self._in_style:
            self.loads += style_urls(data)
        if not self._verbatim and "\n|" in data:
            self.tables_as_text.append(" ".join(data.split())[:40])


def style_urls(text: str) -> list[str]:
    """Return the addresses that a style sheet loads."""
    return [first or second for first, second in STYLE_URL.findall(text)]


def faults(site: Path) -> Iterator[str]:
    """Yield what is wrong with a site, one line a fault."""
    # Themes leave templates among their own files.
    files = [path for path in sorted(site.rglob("*.html")) if "_static" not in path.parts]
    pages = {path: Page(path.read_text("utf-8")) for path in files}
    if not pages:
        yield f"{site}: holds no pages"
    for path, page in pages.items():
        for address in page.leads:
            yield from _fault_of_link(site, path, address, pages)
        for address in page.loads:
            yield from _fault_of_load(site, path, address)
        for text in page.tables_as_text:
            yield f"{path.relative_to(site)}: a table is shown as text: {text!r}"
    for path in sorted(site.rglob("*.css")):
        for address in style_urls(path.read_text("utf-8")):
            yield from _fault_of_load(site, path, address)


def _target(site: Path, path: Path, address: str) -> Path:
    place = unquote(urlsplit(address).path)
    if not place:
        return path
    found = (site / place.lstrip("/") if place.startswith("/") else path.parent / place).resolve()
    return found / "index.html" if found.is_dir() else found


def _fault_of_link(site: Path, path: Path, address: str, pages: dict[Path, Page]) -> Iterator[str]:
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        return
    target = _target(site, path, address)
    fragment = unquote(parts.fragment)
    if not target.is_file():
        yield f"{path.relative_to(site)}: dead link to {address!r}"
    elif fragment and target in pages and fragment not in pages[target].places:
        yield f"{path.relative_to(site)}: no place {fragment!r} behind {address!r}"


def _fault_of_load(site: Path, path: Path, address: str) -> Iterator[str]:
    parts = urlsplit(address)
    if parts.scheme == "data" or address.startswith("#"):
        return
    if parts.scheme or parts.netloc:
        yield f"{path.relative_to(site)}: loads {address!r} from elsewhere"
    elif not _target(site, path, address).is_file():
        yield f"{path.relative_to(site)}: loads {address!r}, which is not there"


def main() -> int:
    """Print the faults; 1 if there are any."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    site = Path(sys.argv[1]).resolve()
    found = list(faults(site))
    for fault in found:
        print(fault)
    print(f"{site.name}: {len(found)} faults")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
