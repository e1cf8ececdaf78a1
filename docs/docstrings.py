"""What AutoAPI and napoleon make of docstrings and types, put right before they are written."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from sphinx.application import Sphinx

_SEVERAL = re.compile(r"(\w+(?:, \w+)+)( :.*)?")
_MODULES = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z])")
# Types of this package, and those of others that are called like one of its own.
_AMBIGUOUS = re.compile(r"\b(?=(?:agrik_fast|pathlib)\.)(?:[a-z_]\w*\.)+(?=[A-Z])")


_CHECKED = re.compile(r"Annotated\[(.+?), [A-Z]\w*\(.*\)\]")
_PRIVATE = re.compile(r"\b_[A-Z]")
# Stands for a dot that stays.
_DOT = "\0"


def short(text: str) -> str:
    """Return types by their last names, which say enough: no private modules before them."""
    return _MODULES.sub("", text)


def linked(text: str) -> str:
    """Return types that are shown by their last names, and still tell `links` where they are."""
    kept = _AMBIGUOUS.sub(lambda found: "~" + found[0].replace(".", _DOT), text)
    return short(kept).replace(_DOT, ".")


def of_attribute(text: str) -> str | None:
    """Return the type of an attribute as a reader knows it; None for a private name."""
    found = _CHECKED.sub(r"\1", linked(text))
    return None if _PRIVATE.search(short(found)) else found


def name_types_shortly(objects: Iterable[Any]) -> None:
    """Have properties and attributes show the last names of their types."""
    for each in objects:
        if each.type in ("property", "attribute", "data") and each.annotation:
            each.annotation = of_attribute(each.annotation)


def attributes_apart(lines: list[str]) -> list[str]:
    """Return a docstring whose attributes have an entry each.

    Of ``begin, end : float`` napoleon makes one attribute, ``end``, with ``begin,`` for its type;
    parameters it takes apart itself.
    """
    out: list[str] = []
    inside = False
    at = 0
    while at < len(lines):
        line = lines[at]
        rule = lines[at + 1] if at + 1 < len(lines) else ""
        if rule and set(rule) == {"-"} and len(rule) == len(line):
            inside = line == "Attributes"
        found = _SEVERAL.fullmatch(line) if inside else None
        if found is None:
            out.append(line)
            at += 1
            continue
        end = at + 1
        while end < len(lines) and (lines[end].startswith(" ") or not lines[end]):
            end += 1
        while not lines[end - 1]:
            end -= 1
        about = lines[at + 1 : end]
        for name in found[1].split(", "):
            out += [name + (found[2] or ""), *about]
        at = end
    return out


def put_right(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Do so before napoleon reads them.

    Of a line on an attribute it would take what stands before a colon for the type. It skips
    empty lines first, so a comment of reStructuredText, which is not shown, stands before.
    """
    lines[:] = attributes_apart(lines)
    if what in ("attribute", "data", "property"):
        lines[:0] = ["..", ""]
