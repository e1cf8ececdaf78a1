"""Sphinx settings. `make docs` builds with -W: every warning is an error."""

import importlib.metadata
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tools")]

import docstrings  # noqa: E402 - found only after the line above
import generate  # noqa: E402 - found only after the line above
import links  # noqa: E402

from agrik_fast import _lazy  # noqa: E402
from agrik_fast.drivers import Simulator, SimulatorError  # noqa: E402

project = "agrik_fast"
author = "the agrik_fast contributors"
copyright = author  # noqa: A001 - Sphinx's name for it
release = version = importlib.metadata.version("agrik_fast")

extensions = [
    "autoapi.extension",
    "mathml",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "_generated", "gallery", "hardware"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
# A name in single backticks is a link where the reference has it.
default_role = "py:obj"
# A word such as `iterations` may be an attribute of several classes: it stays without a link.
suppress_warnings = ["ref.python"]

html_theme = "pydata_sphinx_theme"
html_title = "agrik_fast"
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["agrik.css"]
# Pages of the viewer, which are made with the pictures; Sphinx asks for the folder before.
html_extra_path = ["_generated/interactive"]
(HERE / html_extra_path[0]).mkdir(parents=True, exist_ok=True)
html_math_renderer = "mathml"
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": []}
# What a copy button takes: commands without the prompts and without what they print.
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True


def simulated_rigs() -> bool:
    """Return whether the boards' programs are there, or can be compiled."""
    try:
        Simulator().close()
    except SimulatorError as error:
        print(f"NOT CHECKED: the tutorial of the simulated rig ({error})")
        return False
    return True


# Scripts whose names begin with tutorial_ run at every build. Without an AVR compiler that of
# the simulated rig is shown and not run.
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "tutorials",
    "filename_pattern": r"/tutorial_" if simulated_rigs() else r"/tutorial_(?!.*_rig)",
    "within_subsection_order": "FileNameSortKey",
    "backreferences_dir": None,
    "abort_on_example_error": False,
    "only_warn_on_example_error": False,
    "plot_gallery": True,
    "capture_repr": (),
    # Every script begins with Matplotlib's own settings; pictures have the style of all others.
    "reset_modules": ("matplotlib", "seaborn", "gallery_style.use"),
    "download_all_examples": False,
    "copyfile_regex": r".*\.(urdf|toml)",
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 5,
    # That page would load scripts from elsewhere.
    "write_computation_times": False,
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


def add_names_of_the_package(app):
    """Let the reference show `agrik_fast.Robot` by that name.

    The package loads its names when they are used, which AutoAPI does not follow.
    """
    found = app.env.autoapi_all_objects
    for name, module in _lazy.MODULE_OF.items():
        if f"agrik_fast.{module}.{name}" in found:
            found[f"agrik_fast.{name}"] = found[f"agrik_fast.{module}.{name}"]
    docstrings.name_types_shortly(found.values())


def shorten(app, what, name, obj, options, signature, returned):
    """Write types by their last names; an arm is made by `Robot.load` and its like alone."""
    if name == "agrik_fast.Robot":
        return "", None
    return tuple(docstrings.linked(text or "") for text in (signature, returned))


def without_text(app, what, name, member, skip, options):
    """Leave out attributes that only repeat what the class docstring says of them."""
    return True if getattr(member, "docstring", None) == "" else None


def setup(app):
    app.connect("builder-inited", lambda app: generate.main(HERE / "_generated"))
    # After AutoAPI has read the sources.
    app.connect("builder-inited", add_names_of_the_package, priority=900)
    app.connect("autodoc-process-docstring", docstrings.put_right, priority=100)
    app.connect("autodoc-process-signature", shorten)
    app.connect("autodoc-skip-member", without_text)
    app.connect("doctree-read", links.exactly)
    app.connect("missing-reference", links.resolve)
