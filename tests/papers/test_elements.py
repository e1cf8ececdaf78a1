"""The table of the papers' elements: whole, and nothing in it leads nowhere."""

from __future__ import annotations

import ast
import csv
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "docs/papers/elements.csv"
VERDICTS = {"reproduced", "corrected", "holds", "holds in part", "refuted", "lost"}
KINDS = {"equation", "table", "figure", "algorithm", "experiment", "claim"}
# What the papers have, counted in their texts: equations, tables, figures.
WHOLE = {
    "strawberry": {"equation": 37, "table": 4, "figure": 7},
    "hydrolek": {"equation": 15, "table": 3, "figure": 7},
    "tomato": {"equation": 17, "table": 1, "figure": 10},
    "redundant7": {"equation": 10, "table": 1, "figure": 4},
}
ROMAN = {"i": 1, "ii": 2, "iii": 3}

with FILE.open(newline="", encoding="utf-8") as lines:
    ROWS = list(csv.DictReader(lines))


def named(row: dict[str, str]) -> str:
    return f"{row['paper']} {row['element']}: {row['says']}"


def parts(row: dict[str, str], column: str) -> list[str]:
    return [part for part in row[column].split(";") if part]


def numbers(text: str) -> set[int]:
    """Return the numbers that "(5)-(8)", "(9), (10)" or "figures 4 to 6" stand for."""
    found: set[int] = set()
    for low, high in re.findall(r"\(?(\d+)\)?(?:\s*(?:-|to)\s*\(?(\d+)\)?)?", text):
        found |= set(range(int(low), int(high or low) + 1))
    found |= {ROMAN[word] for word in re.findall(r"\b(i{1,3})\b", text.lower())}
    return found


def test_rows_are_whole() -> None:
    assert len(ROWS) > 140
    assert len({named(row) for row in ROWS}) == len(ROWS)
    for row in ROWS:
        assert row["paper"] in WHOLE and row["kind"] in KINDS, named(row)
        assert row["verdict"] in VERDICTS, named(row)
        assert row["element"] and row["says"] and row["number"], named(row)
        if row["verdict"] == "lost":
            continue
        # Whatever is not lost in print has a place and a test.
        assert parts(row, "where") and parts(row, "tests"), named(row)


@pytest.mark.parametrize("paper", WHOLE)
@pytest.mark.parametrize("kind", ["equation", "table", "figure"])
def test_every_numbered_element_of_a_paper_has_a_row(paper: str, kind: str) -> None:
    own = [row["element"] for row in ROWS if row["paper"] == paper]
    words = [text for text in own if text.startswith(("(",) if kind == "equation" else (kind,))]
    found = set().union(
        *(numbers(text.split(",")[0] if kind == "table" else text) for text in words)
    )
    assert found == set(range(1, WHOLE[paper][kind] + 1))


def test_only_what_a_paper_itself_has_lost_is_open() -> None:
    lost = [row for row in ROWS if row["verdict"] == "lost"]
    assert len(lost) < 12
    for row in lost:
        assert re.search(r"not in the scan|not published|lost picture", row["number"]), named(row)


def test_code_that_is_named_exists() -> None:
    names = {part for row in ROWS for part in parts(row, "where") if part.startswith("agrik_fast.")}
    assert len(names) > 40
    for name in names:
        path = name.split(".")
        for cut in range(len(path), 0, -1):
            try:
                found: object = importlib.import_module(".".join(path[:cut]))
            except ModuleNotFoundError:
                continue
            for attribute in path[cut:]:
                found = getattr(found, attribute)
            break
        else:
            raise AssertionError(name)


def test_files_that_are_named_are_written_by_the_paper() -> None:
    files = {
        part for row in ROWS for part in parts(row, "where") if not part.startswith("agrik_fast.")
    }
    assert len(files) > 30
    for file in files:
        paper, _, name = file.partition("/")
        folder = ROOT / "python/agrik_fast/papers" / paper
        source = "\n".join(path.read_text(encoding="utf-8") for path in folder.glob("*.py"))
        stem, _, suffix = name.partition(".")
        assert suffix in ("csv", "svg"), file
        # By its whole name, by the name that `save` or `write_table` is given, or by a start.
        start = re.sub(r"_(zero|middle)$", "_{start}", stem)
        wanted = [f'"{name}"', f'"{stem}"', f'f"{start}.{suffix}"', f"{{job.name}}.{suffix}"]
        assert any(text in source for text in wanted), file


def test_tests_that_are_named_exist() -> None:
    tests = {part for row in ROWS for part in parts(row, "tests")}
    assert len(tests) > 60
    known: dict[str, set[str]] = {}
    for test in tests:
        file, _, name = test.partition("::")
        if file not in known:
            text = (ROOT / file).read_text(encoding="utf-8")
            if file.endswith(".rs"):
                known[file] = set(re.findall(r"#\[test\]\nfn (\w+)\(", text))
            else:
                nodes = ast.walk(ast.parse(text))
                known[file] = {node.name for node in nodes if isinstance(node, ast.FunctionDef)}
        assert name in known[file], test


def test_references_that_lead_nowhere_are_found() -> None:
    """The checks above would notice: what they look for is not in the sources by chance."""
    with pytest.raises(AttributeError):
        getattr(importlib.import_module("agrik_fast.papers.tomato"), "no_such_thing")  # noqa: B009
    assert numbers("(9), (10)") == {9, 10} and numbers("figures 4 to 6") == {4, 5, 6}
    assert numbers("(33)-(36)") == {33, 34, 35, 36} and numbers("table II") == {2}


def test_the_page_holds_every_row(tmp_path: Path) -> None:
    # Found by its path: the documentation's scripts are no package.
    import sys

    sys.path.insert(0, str(ROOT / "docs"))
    try:
        import elements
    finally:
        sys.path.remove(str(ROOT / "docs"))
    page = elements.table(FILE).splitlines()
    lines = [line for line in page if line.startswith("|") and line[1:4] not in (" el", "---")]
    assert len(lines) == len(ROWS)
    for row, line in zip(ROWS, lines, strict=True):
        element, _, verdict, number, _ = (cell.strip() for cell in line[1:-1].split("|"))
        assert (element, verdict) == (row["element"], row["verdict"])
        assert row["number"].strip() == number
    assert [line for line in page if line.startswith("### ")] == [
        f"### [{elements.TITLES[name]}]({name}.md)"
        for name in dict.fromkeys(r["paper"] for r in ROWS)
    ]
    # The papers' own pages have these titles.
    for name, title in elements.TITLES.items():
        assert (ROOT / f"docs/papers/{name}.md").read_text("utf-8").startswith(f"# {title}\n")
