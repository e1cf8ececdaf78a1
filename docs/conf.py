"""Sphinx settings. `make docs` builds with -W: every warning is an error."""

import importlib.metadata
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tools")]

import generate  # noqa: E402 - found only after the line above

project = "agrik_fast"
author = "the agrik_fast contributors"
copyright = author  # noqa: A001 - Sphinx's name for it
release = version = importlib.metadata.version("agrik_fast")

extensions = [
    "autoapi.extension",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["_build", "_generated", "hardware"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "pydata_sphinx_theme"
html_title = "agrik_fast"
html_show_copyright = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars = {
    "index": [],
    "getting-started": [],
    "conventions": [],
    "robots": [],
    "solvers": [],
    "population": [],
    "paths": [],
    "closed-forms": [],
    "hardware": [],
}

# The API pages are read from the sources and, for the compiled module, from its stub,
# which is where its documentation lives; nothing has to be imported for them.
autoapi_dirs = [str(HERE.parent / "python" / "agrik_fast")]
autoapi_file_patterns = ["*.pyi", "*.py"]
autoapi_generate_api_docs = False
autoapi_add_toctree_entry = False
autoapi_member_order = "bysource"
autodoc_typehints = "signature"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False


def without_text(app, what, name, member, skip, options):
    """Leave out attributes that only repeat what the class docstring says of them."""
    return True if getattr(member, "docstring", None) == "" else None


def setup(app):
    app.connect("builder-inited", lambda app: generate.main(HERE / "_generated"))
    app.connect("autodoc-skip-member", without_text)
