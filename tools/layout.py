"""Reads from the code who takes from whom, and from the record of decisions who may.

The layout test refuses arrows that the table in ``docs/adr/0001-layout.md`` does not have; the
documentation's pictures are drawn from the same reading.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "agrik_fast"
SOURCES = ROOT / "python" / PACKAGE
RECORD = ROOT / "docs" / "adr" / "0001-layout.md"
BELOW = "layers below"
"""What the table says of rooms that may take from every layer below their own."""

Arrows = dict[str, set[str]]
"""For each name the names that it takes from."""


# ---- Python -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Import:
    """One import of a module of the package by another.

    Attributes
    ----------
    source, target : str
        Full names of the modules; the package's own for its ``__init__``.
    line : int
        Where in the source.
    """

    source: str
    target: str
    line: int


def modules(sources: Path = SOURCES) -> dict[str, Path]:
    """Return the files of the package, stubs included, by the names of their modules."""
    found = {}
    for path in sorted((*sources.rglob("*.py"), *sources.rglob("*.pyi"))):
        parts = path.relative_to(sources.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(files: Mapping[str, Path]) -> Iterator[Import]:
    """Yield every import between the modules, those inside functions and for types too."""
    for name, path in files.items():
        is_package = path.stem == "__init__"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    if alias.name.split(".")[0] == PACKAGE:
                        yield Import(name, _known(alias.name, files), node.lineno)
            elif isinstance(node, ast.ImportFrom):
                base = _base(node, name, is_package)
                if base.split(".")[0] == PACKAGE:
                    for alias in node.names:
                        # A name of a package may be one of its modules.
                        target = _known(f"{base}.{alias.name}", files)
                        yield Import(name, target, node.lineno)


def _base(node: ast.ImportFrom, name: str, is_package: bool) -> str:
    """Return the full name of what stands between ``from`` and ``import``."""
    module = node.module or ""
    if not node.level:
        return module
    parts = name.split(".")
    kept = parts[: len(parts) - node.level + is_package]
    return ".".join([*kept, module]) if module else ".".join(kept)


def _known(name: str, files: Mapping[str, Path]) -> str:
    """Return the module that a dotted name is, or is a name of."""
    while name not in files:
        name = name.rpartition(".")[0]
    return name


def room(module: str) -> str:
    """Return the room of a module: its first name below the package."""
    return module.split(".")[1] if "." in module else PACKAGE


def is_part_of(module: str, package: str) -> bool:
    """Return whether a module is a part of a package, at any depth."""
    return module.startswith(f"{package}.")


def rooms(found: Iterable[Import]) -> Arrows:
    """Return which room takes from which others."""
    arrows: Arrows = {}
    for each in found:
        if room(each.source) != room(each.target):
            arrows.setdefault(room(each.source), set()).add(room(each.target))
    return arrows


# ---- Rust -------------------------------------------------------------------------------------


def crates(root: Path = ROOT) -> Arrows:
    """Return the crates of the workspace, each with those that it depends on."""
    found: Arrows = {}
    for manifest in sorted((root / "rust").glob("*/Cargo.toml")):
        content = tomllib.loads(manifest.read_text(encoding="utf-8"))
        found[content["package"]["name"]] = set(content.get("dependencies", {}))
    return {name: needs & set(found) for name, needs in found.items()}


def rust_modules(crate: str, root: Path = ROOT) -> Arrows:
    """Return the top modules of a crate, each with those that it takes from; tests do not count."""
    folder = root / "rust" / crate / "src"
    texts: dict[str, list[str]] = {}
    for path in sorted(folder.rglob("*.rs")):
        top = path.relative_to(folder).parts[0].removesuffix(".rs")
        if top != "lib" and "tests" not in path.relative_to(folder).with_suffix("").parts:
            texts.setdefault(top, []).append(_without_tests(path.read_text(encoding="utf-8")))
    return {
        top: {name for text in parts for name in _crate_names(text)} & set(texts) - {top}
        for top, parts in texts.items()
    }


def _without_tests(text: str) -> str:
    return re.split(r"^#\[cfg\(test\)\]\nmod \w+ \{", text, maxsplit=1, flags=re.MULTILINE)[0]


def _crate_names(text: str) -> Iterator[str]:
    """Yield the first names of all paths that begin with ``crate``."""
    text = re.sub(r"//[^\n]*", "", text)
    for match in re.finditer(r"\bcrate::(\w+|\{)", text):
        if match[1] != "{":
            yield match[1]
            continue
        depth, name = 0, ""
        for char in text[match.end() :]:
            if char in "{}":
                depth += 1 if char == "{" else -1
            if depth < 0 or (char == "," and depth == 0):
                yield name.strip().split("::")[0]
                name = ""
            elif depth == 0:
                name += char
            if depth < 0:
                break


# ---- the rules --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rules:
    """The table of layers, lowest first.

    Attributes
    ----------
    layers : tuple of tuple of str
        Names in each layer.
    only : dict of str to set of str
        What those names may take from that do not take from all layers below.
    planned : frozenset of str
        Names in the table that are yet to come; they stand there in parentheses.
    """

    layers: tuple[tuple[str, ...], ...]
    only: dict[str, frozenset[str]]
    planned: frozenset[str]

    @property
    def names(self) -> frozenset[str]:
        """All names of the table."""
        return frozenset(name for layer in self.layers for name in layer)

    def allowed(self, name: str) -> frozenset[str]:
        """Return what a name may take from."""
        if name in self.only:
            return self.only[name]
        below: set[str] = set()
        for layer in self.layers:
            if name in layer:
                return frozenset(below)
            below.update(layer)
        return frozenset()


def rules(language: str, record: Path = RECORD) -> Rules:
    """Read the table of layers of "python" or "rust" in the record of decisions."""
    text = record.read_text(encoding="utf-8")
    _, marker, rest = text.partition(f"<!-- layers: {language} -->\n")
    if not marker:
        raise ValueError(f"{record.name} has no table of layers for {language}")
    layers: list[tuple[str, ...]] = []
    only: dict[str, frozenset[str]] = {}
    planned: set[str] = set()
    lines = rest.lstrip("\n").split("\n\n")[0].splitlines()
    for line in lines[2:]:
        names, takes = (cell.strip() for cell in line.strip("|").split("|")[1:3])
        layer = tuple(re.findall(r"`(\w+)`", names))
        planned.update(re.findall(r"\(`(\w+)`\)", names))
        layers.append(layer)
        if takes != BELOW:
            only.update(dict.fromkeys(layer, frozenset(re.findall(r"`(\w+)`", takes))))
    return Rules(tuple(layers), only, frozenset(planned))


def forbidden(arrows: Arrows, table: Rules) -> list[tuple[str, str]]:
    """Return the arrows that the table does not have, as (from, to)."""
    return sorted(
        (source, target)
        for source, targets in arrows.items()
        for target in targets - table.allowed(source)
    )


def circles(arrows: Arrows) -> list[list[str]]:
    """Return the groups of names that lead to one another, each sorted."""
    reached = {name: _reachable(name, arrows) for name in arrows}
    groups = {
        tuple(sorted(other for other in mine if name in reached.get(other, ()))): None
        for name, mine in reached.items()
        if name in mine
    }
    return [list(group) for group in groups]


def _reachable(start: str, arrows: Arrows) -> set[str]:
    found: set[str] = set()
    waiting = [*arrows.get(start, ())]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += arrows.get(name, ())
    return found


def floors(arrows: Arrows) -> list[list[str]]:
    """Return names in layers, each above all that it takes from; a circle stays on one floor."""
    together = {name: group[0] for group in circles(arrows) for name in group}
    names = {*arrows, *(target for targets in arrows.values() for target in targets)}
    members: dict[str, list[str]] = {}
    for name in sorted(names):
        members.setdefault(together.get(name, name), []).append(name)
    below = {
        head: {together.get(target, target) for name in group for target in arrows.get(name, ())}
        - {head}
        for head, group in members.items()
    }
    height: dict[str, int] = {}

    def height_of(head: str) -> int:
        if head not in height:
            height[head] = 1 + max((height_of(other) for other in below[head]), default=-1)
        return height[head]

    levels: list[list[str]] = [[] for _ in range(1 + max(map(height_of, members), default=-1))]
    for head, group in members.items():
        levels[height_of(head)] += group
    return levels


def direct(arrows: Arrows) -> list[tuple[str, str]]:
    """Return the arrows that no detour over others replaces, as (from, to)."""
    return sorted(
        (source, target)
        for source, targets in arrows.items()
        for target in targets
        if not any(
            target in _reachable(other, arrows) and source not in _reachable(other, arrows)
            for other in targets - {target}
        )
    )
