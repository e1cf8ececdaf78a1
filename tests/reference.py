"""What the pages of docs/api show: every function, class and method, with its docstring.

The list is read from the pages, so that whatever is added to the reference is found.
"""

from __future__ import annotations

import ast
import functools
import importlib
import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import layout
from agrik_fast.errors import MissingExtraError

PAGES = layout.ROOT / "docs" / "api"
_DIRECTIVE = re.compile(
    r"^\.\. autoapi(class|exception|function|module):: (\S+)\n((?:   :[^\n]*\n)*)", re.MULTILINE
)


@dataclass(frozen=True)
class Entry:
    """One function, class or method of the reference.

    Attributes
    ----------
    page : str
        Name of the page that shows it.
    name : str
        Full public name.
    module : str
        Public module that holds it.
    is_here : bool
        False if that needs a library that is not installed: those of gradients, whose examples
        ``tests/gradients`` runs.
    docstring : str
        Its documentation, empty if there is none.
    """

    page: str
    name: str
    module: str
    is_here: bool
    docstring: str


def entries() -> Iterator[Entry]:
    """Yield all that the reference shows, page by page."""
    for page in sorted(PAGES.glob("*.md")):
        for kind, name, lines in _DIRECTIVE.findall(page.read_text("utf-8") + "\n"):
            if kind == "module":
                yield from _of_module(page.stem, name)
                continue
            module, _, last = name.rpartition(".")
            try:
                thing = getattr(importlib.import_module(module), last)
            except MissingExtraError:
                yield Entry(page.stem, name, module, False, _in_source(module)[last])
                continue
            yield Entry(page.stem, name, module, True, _docstring(thing))
            if kind != "function":
                for method in _methods(thing, lines):
                    doc = _docstring(inspect.getattr_static(thing, method), thing, method)
                    yield Entry(page.stem, f"{name}.{method}", module, True, doc)


def _of_module(page: str, name: str) -> Iterator[Entry]:
    """Yield the functions and classes of a module that is shown whole."""
    module = importlib.import_module(name)
    for public in module.__all__:
        thing = getattr(module, public)
        if inspect.isroutine(thing) or isinstance(thing, type):
            yield Entry(page, f"{name}.{public}", name, True, _docstring(thing))


def _methods(kind: type, lines: str) -> list[str]:
    """Return the names of the methods that the options of a directive let through."""
    options = dict(re.findall(r":([\w-]+):[ ]*(.*)", lines))
    if "members" not in options:
        return []
    left_out = {part.strip() for part in options.get("exclude-members", "").split(",")}
    wanted = {part.strip() for part in options["members"].split(",")} - {""}
    bases = inspect.getmro(kind) if "inherited-members" in options else (kind,)
    own = {name for base in bases if base.__module__.startswith("agrik") for name in vars(base)}
    return [
        name
        for name in sorted(wanted or own)
        if not name.startswith("_") and name not in left_out and _is_method(kind, name)
    ]


def _is_method(kind: type, name: str) -> bool:
    raw = inspect.getattr_static(kind, name)
    if isinstance(raw, classmethod | staticmethod):
        return True
    return inspect.isroutine(raw) and not inspect.isdatadescriptor(raw)


def _docstring(thing: Any, owner: type | None = None, method: str = "") -> str:
    holder = owner or thing
    if holder.__module__ == "agrik_fast._native":
        name = f"{holder.__name__}.{method}" if method else holder.__name__
        return _in_source("agrik_fast._native").get(name, "")
    return inspect.getdoc(getattr(owner, method) if owner else thing) or ""


@functools.cache
def _in_source(module: str) -> dict[str, str]:
    """Return the docstrings of a module by reading it; the compiled one has a stub for that."""
    found: dict[str, str] = {}

    def visit(body: list[ast.stmt], prefix: str) -> None:
        for node in body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                found.setdefault(prefix + node.name, ast.get_docstring(node) or "")
            if isinstance(node, ast.ClassDef):
                visit(node.body, f"{prefix}{node.name}.")

    visit(ast.parse(layout.modules()[module].read_text("utf-8")).body, "")
    return found
