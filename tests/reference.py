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
from types import ModuleType
from typing import Any

import layout

PAGES = layout.ROOT / "docs" / "api"
STUB = layout.SOURCES / "_native.pyi"
_DIRECTIVE = re.compile(
    r"^\.\. autoapi(class|exception|function):: (\S+)\n((?:   :[^\n]*\n)*)", re.MULTILINE
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
    module : ModuleType
        Public module that holds it.
    docstring : str
        Its documentation, empty if there is none.
    """

    page: str
    name: str
    module: ModuleType
    docstring: str


def entries() -> Iterator[Entry]:
    """Yield all that the reference shows, page by page."""
    for page in sorted(PAGES.glob("*.md")):
        for kind, name, lines in _DIRECTIVE.findall(page.read_text("utf-8") + "\n"):
            module, thing = _found(name)
            yield Entry(page.stem, name, module, _docstring(thing))
            if kind != "function":
                for method in _methods(thing, lines):
                    doc = _docstring(inspect.getattr_static(thing, method), thing, method)
                    yield Entry(page.stem, f"{name}.{method}", module, doc)


def _found(name: str) -> tuple[ModuleType, Any]:
    module, _, last = name.rpartition(".")
    holder = importlib.import_module(module)
    return holder, getattr(holder, last)


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
        return _stub_docstrings().get(name, "")
    return inspect.getdoc(getattr(owner, method) if owner else thing) or ""


@functools.cache
def _stub_docstrings() -> dict[str, str]:
    """Return the docstrings of the compiled module, which are those of its stub."""
    found = {}

    def visit(body: list[ast.stmt], prefix: str) -> None:
        for node in body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                found.setdefault(prefix + node.name, ast.get_docstring(node) or "")
            if isinstance(node, ast.ClassDef):
                visit(node.body, f"{prefix}{node.name}.")

    visit(ast.parse(STUB.read_text("utf-8")).body, "")
    return found
