"""An arm in the browser: drag its target, look at what stands round it, play its ways.

Needs the extra ``viewer`` (viser). ``agrik-fast view NAME`` is the same on the command line.
"""

from ._export import export_html, playable
from ._view import Viewer, view

__all__ = ["Viewer", "export_html", "playable", "view"]
