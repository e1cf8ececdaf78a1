"""One page on all that was computed: every table and picture, paper by paper."""

from __future__ import annotations

import csv
import html
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from .._native import __version__
from ._output import write_text

REPORT = "report.md"
"""What every paper's folder has besides tables and pictures: what matches and what does not."""
_ROWS = 40
"""Rows of a table that the page shows; the file has all."""
_STYLE = """
:root { color-scheme: light dark; --line: #cccccc; --soft: #f4f4f4; --link: #00507d; }
@media (prefers-color-scheme: dark) { :root { --line: #555; --soft: #262626; --link: #7cc4f0; } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 68rem; margin: 0 auto; padding: 0 1rem; }
a { color: var(--link); }
nav a { margin-right: 1rem; }
figure { margin: 1rem 0; }
img { max-width: 100%; background: white; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.85rem; margin: 0.5rem 0; }
th, td { border: 1px solid var(--line); padding: 0.15rem 0.5rem; text-align: left; }
th { background: var(--soft); }
.published { background: #fde9d9; }
@media (prefers-color-scheme: dark) { .published { background: #5a3416; } }
"""
# Columns of ours that hold what a paper prints.
_PUBLISHED = ("published", "paper", "printed", "reference")


def write_index(directory: Path, papers: Sequence[str]) -> Path:
    """Write ``index.html``: reports, tables and pictures of papers that are in its folder.

    Parameters
    ----------
    directory : path
        With a folder for each paper.
    papers : sequence of str
        Their names, in order.

    Returns
    -------
    Path
        The page; it asks for nothing outside of the folder.
    """
    lines = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>agrik_fast {__version__}: the papers, computed anew</title>",
        f"<style>{_STYLE}</style></head><body>",
        "<h1>The papers, computed anew</h1>",
        f"<p>agrik_fast {html.escape(__version__)}. Columns on a tinted ground are what the paper "
        "prints; beside them is what this library computes.</p>",
        "<nav>" + " ".join(f'<a href="#{name}">{name}</a>' for name in papers) + "</nav>",
    ]
    for name in papers:
        lines += _paper(directory / name, name)
    lines.append("</body></html>")
    return write_text(directory / "index.html", lines)


def _paper(folder: Path, name: str) -> Iterator[str]:
    yield f'<h2 id="{name}">{name}</h2>'
    report = folder / REPORT
    if report.exists():
        yield _markdown(report.read_text(encoding="utf-8"))
    for file in sorted(folder.glob("*.csv")):
        yield f"<h3>{file.stem}</h3>"
        yield from _table(file, f"{name}/{file.name}")
    for file in sorted(folder.glob("*.png")):
        place, title = html.escape(f"{name}/{file.name}"), html.escape(f"{name}: {file.stem}")
        vector = file.with_suffix(".svg")
        more = f' (<a href="{name}/{vector.name}">SVG</a>)' if vector.exists() else ""
        yield (
            f'<figure><img src="{place}" alt="{title}" loading="lazy">'
            f"<figcaption>{title}{more}</figcaption></figure>"
        )


def _table(file: Path, place: str) -> Iterator[str]:
    with file.open(newline="", encoding="utf-8") as lines:
        head, *rows = list(csv.reader(lines))
    marks = [
        ' class="published"' if any(word in name.lower() for word in _PUBLISHED) else ""
        for name in head
    ]
    yield '<div class="wide"><table><thead><tr>'
    yield "".join(
        f"<th{mark}>{html.escape(name)}</th>" for name, mark in zip(head, marks, strict=True)
    )
    yield "</tr></thead><tbody>"
    for row in rows[:_ROWS]:
        cells = zip(row, marks, strict=False)
        yield "<tr>" + "".join(f"<td{mark}>{_cell(text)}</td>" for text, mark in cells) + "</tr>"
    yield "</tbody></table></div>"
    left = len(rows) - _ROWS
    more = f"{left} more rows in " if left > 0 else ""
    yield f'<p>{more}<a href="{place}">{place}</a></p>'


def _cell(text: str) -> str:
    """Return a number with as many digits as a reader wants; the file has all."""
    try:
        value = float(text)
    except ValueError:
        return html.escape(text)
    if math.isnan(value):
        return ""
    return f"{value:.5g}" if len(text) > 8 else html.escape(text)


def _markdown(text: str) -> str:
    from markdown_it import MarkdownIt

    made: str = MarkdownIt("commonmark", {"html": False}).enable("table").render(text)
    # A paper's name is the page's second heading: those of its report are below it.
    for level in (3, 2, 1):
        for mark in ("<h", "</h"):
            made = made.replace(f"{mark}{level}>", f"{mark}{level + 2}>")
    return made.replace("<table>", '<div class="wide"><table>').replace(
        "</table>", "</table></div>"
    )
