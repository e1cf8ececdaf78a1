"""Every function, class and method of the reference has an example, and all examples run.

An example is what a reader can type after ``import numpy as np`` and
``import agrik_fast as ik``; whatever else it uses, it imports.
"""

import ast
import doctest
import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
import layout
import reference

ENTRIES = list(reference.entries())


def run(name: str, docstring: str, names: dict[str, Any]) -> int:
    """Run the examples of a docstring, and return how many lines there were."""
    test = doctest.DocTestParser().get_doctest(docstring, names, name, None, 0)
    said: list[str] = []
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    outcome = runner.run(test, out=said.append, clear_globs=False)
    assert not outcome.failed, "".join(said)
    return outcome.attempted


def marks(docstring: str) -> list[pytest.MarkDecorator]:
    """The boards' programs need a compiler that not everybody has."""
    return [pytest.mark.rigs] if "Simulator(" in docstring else []


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_it_has_an_example(entry: reference.Entry) -> None:
    section = entry.docstring.partition("Examples\n--------\n")[2]
    assert ">>> " in section, f"{entry.name} (docs/api/{entry.page}.md): wants an example"


# A name that two pages or two classes share is run once.
ONCE = {
    entry.docstring: entry
    for entry in reversed(ENTRIES)
    if entry.is_here and ">>> " in entry.docstring
}


@pytest.mark.parametrize(
    "entry",
    [pytest.param(one, marks=marks(one.docstring), id=one.name) for one in ONCE.values()],
)
def test_the_example_runs(
    entry: reference.Entry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(entry.name, entry.docstring, {"np": np, "ik": ik})


def others() -> Iterator[tuple[str, str, str]]:
    """Yield examples of what the reference does not show: module, name, docstring."""
    shown = {entry.docstring for entry in ENTRIES}
    for module, path in layout.modules().items():
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                text = ast.get_docstring(node) or ""
                if ">>> " in text and text not in shown:
                    yield module, getattr(node, "name", module), text


@pytest.mark.parametrize(
    ("module", "name", "docstring"),
    [pytest.param(*one, marks=marks(one[2]), id=f"{one[0]}.{one[1]}") for one in others()],
)
def test_examples_elsewhere_run_in_their_modules(
    module: str, name: str, docstring: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(name, docstring, vars(importlib.import_module(module)) | {"np": np, "ik": ik})


def test_the_walk_finds_what_there_is() -> None:
    names = {entry.name for entry in ENTRIES}
    for one in ("Robot", "Robot.ik", "Robot.fk", "Robot.bodies", "IkResult.to_arrow"):
        found = f"agrik_fast.{one}" in names
        assert found == (one != "Robot.bodies"), one  # a property, no method
    assert "agrik_fast.collision.Scene.load" in names
    assert len(ENTRIES) > 350
