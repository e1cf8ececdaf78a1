"""Links from docstrings: names of the package in single backticks, as docstrings write them."""

from __future__ import annotations

from docutils import nodes
from sphinx.addnodes import desc_signature, pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode

# Private modules whose classes the reference has under a public one.
_SHOWN_ELSEWHERE = ("_bodies", "_gradients", "_native", "_rotations")


def resolve(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.reference | None:
    """Link a short name to the only entry of the reference that ends with it.

    ``Robot.ik`` and ``ik`` of a docstring of `Robot` are `agrik_fast.Robot.ik`. A name that is
    none of the reference, such as an argument, stays text in the typewriter's face.
    """
    if node.get("refdomain") != "py":
        return None
    domain = env.domains.python_domain
    full = _entry(node, list(domain.objects))
    if full is None:
        return None
    entry = domain.objects[full]
    return make_refnode(app.builder, node["refdoc"], entry.docname, entry.node_id, content, full)


def exactly(app: Sphinx, doctree: nodes.document) -> None:
    """Keep Sphinx from looking through all modules for types of signatures, and for words."""
    for node in doctree.findall(pending_xref):
        if _in_signature(node) or _is_word(node):
            node.attributes.pop("refspecific", None)


def _entry(node: pending_xref, entries: list[str]) -> str | None:
    """Return the entry of the reference that a name means."""
    target = node["reftarget"]
    if _in_signature(node):
        return of_type(target, entries)
    if _is_word(node):
        return None
    holders = [node.get("py:class"), node.get("py:module")]
    for name in [f"{holder}.{target}" for holder in holders if holder] + [target]:
        found = [full for full in entries if full == name or full.endswith(f".{name}")]
        if len(found) == 1:
            return found[0]
    return None


def of_type(target: str, entries: list[str]) -> str | None:
    """Return the entry of a type of a signature, which says from which module it is.

    A type is found in the reference of its own module, or among the names of the package;
    those of some private modules where they are shown. `pathlib.Path` is not `agrik_fast.Path`.
    """
    package, _, rest = target.partition(".")
    if package != "agrik_fast":
        return None
    room, _, _ = rest.partition(".")
    name = target.rpartition(".")[2]
    called = [full for full in entries if full.endswith(f".{name}")]
    for found in (
        [full for full in called if full.startswith(f"agrik_fast.{room}.")],
        [full for full in called if full == f"agrik_fast.{name}"],
        called if room in _SHOWN_ELSEWHERE else [],
    ):
        if len(found) == 1:
            return found[0]
    return None


def _is_word(node: pending_xref) -> bool:
    """Whether it is a word of the type of an argument: `names` there is no attribute."""
    target = node["reftarget"]
    return node["reftype"] == "class" and target.islower() and "." not in target and target != "dof"


def _in_signature(node: nodes.Node) -> bool:
    while node is not None and not isinstance(node, desc_signature):
        node = node.parent
    return node is not None
