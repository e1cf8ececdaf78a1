"""The style of every figure here: colours, sizes, labels; and what is drawn in space.

Figures need the extra ``plots`` (Matplotlib). They belong to no window: save one with its
``savefig``, or show it in a notebook.
"""

from ._outcomes import outcomes
from ._space import (
    add_frame,
    add_triangles,
    bounds,
    checked_view,
    frame_space,
    is_blank,
    space,
    space_or,
)
from ._style import (
    BAD,
    FIELD,
    GOOD,
    GREY,
    PAGE_WIDTH,
    PALE,
    PALETTE,
    PNG_DPI,
    STATUS_COLOURS,
    figure,
    label,
    style,
    styled,
)

__all__ = [
    "BAD",
    "FIELD",
    "GOOD",
    "GREY",
    "PAGE_WIDTH",
    "PALE",
    "PALETTE",
    "PNG_DPI",
    "STATUS_COLOURS",
    "add_frame",
    "add_triangles",
    "bounds",
    "checked_view",
    "figure",
    "frame_space",
    "is_blank",
    "label",
    "outcomes",
    "space",
    "space_or",
    "style",
    "styled",
]
