"""Links from docstrings: names of the package in single backticks, as docstrings write them."""

from __future__ import annotations

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode


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
    target = node["reftarget"]
    holders = [node.get("py:class"), node.get("py:module")]
    wanted = [f"{holder}.{target}" for holder in holders if holder] + [target]
    for name in wanted:
        found = [full for full in domain.objects if full == name or full.endswith(f".{name}")]
        if len(found) == 1:
            entry = domain.objects[found[0]]
            return make_refnode(
                app.builder, node["refdoc"], entry.docname, entry.node_id, content, found[0]
            )
    return None
