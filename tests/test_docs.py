"""The examples in the documentation and in docstrings run as they stand."""

import doctest
import importlib
import re
from pathlib import Path

import pytest

import layout

DOCS = Path(__file__).resolve().parents[1] / "docs"
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if BLOCK.search(page.read_text("utf-8"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_python_examples_run(page: Path) -> None:
    # The blocks of a page build on one another, as they do for its reader.
    names: dict[str, object] = {}
    for block in BLOCK.findall(page.read_text("utf-8")):
        exec(compile(block, page.name, "exec"), names)


def test_there_are_examples() -> None:
    assert "getting-started" in [page.stem for page in PAGES]


EXAMPLES = [
    name
    for name, path in layout.modules().items()
    if path.suffix == ".py" and ">>>" in path.read_text("utf-8")
]


@pytest.mark.parametrize("module", EXAMPLES)
def test_examples_in_docstrings_hold(module: str) -> None:
    outcome = doctest.testmod(importlib.import_module(module))
    assert outcome.attempted
    assert not outcome.failed
