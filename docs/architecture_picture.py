"""Draws who takes from whom: crates, modules of the crates, rooms of the Python package."""

from collections.abc import Callable, Sequence
from pathlib import Path

from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

import layout
from agrik_fast.plots import BAD, GOOD

INSIDE, OUTSIDE, BOX = GOOD, BAD, "#d6e7f3"
ROW = 1.0
WIDTH = 1.5
Places = dict[str, tuple[float, float]]


def places(floors: Sequence[Sequence[str]]) -> Places:
    """Return a place for each name: its floor's height, and beside its neighbours."""
    at: Places = {}
    for height, names in enumerate(floors):
        # Every other floor is shifted, so that arrows pass between the boxes.
        shift = 0.25 * WIDTH if height % 2 else -0.25 * WIDTH
        for k, name in enumerate(names):
            at[name] = (WIDTH * (k - (len(names) - 1) / 2) + shift, ROW * height)
    return at


def draw(
    axes: Axes,
    title: str,
    floors: Sequence[Sequence[str]],
    arrows: layout.Arrows,
    wrong: Callable[[str, str], bool],
    wide: float,
) -> None:
    """Draw the names as boxes on their floors, and the arrows between them; wide in boxes."""
    at = places(floors)
    across = [x for x, _ in at.values()]
    middle = (min(across) + max(across)) / 2
    axes.set_xlim(middle - WIDTH * wide / 2, middle + WIDTH * wide / 2)
    axes.set_ylim(-0.8 * ROW, ROW * (len(floors) - 0.3))
    style = {"boxstyle": "round,pad=0.35", "facecolor": BOX, "edgecolor": INSIDE}
    boxes = {
        name: axes.text(x, y, name, ha="center", va="center", bbox=style, zorder=2)
        for name, (x, y) in at.items()
    }
    # A box has its size once it is drawn, and arrows end at its edge.
    axes.figure.canvas.draw()
    shown = {*layout.direct(arrows)}
    shown |= {(a, b) for a, targets in arrows.items() for b in targets if wrong(a, b)}
    for source, target in sorted(shown):
        bad = wrong(source, target)
        floors_down = (at[source][1] - at[target][1]) / ROW
        bend = 0.4 if floors_down == 0 else 0.0 if floors_down == 1 else 0.12
        arrow = FancyArrowPatch(
            at[source],
            at[target],
            patchA=boxes[source].get_bbox_patch(),
            patchB=boxes[target].get_bbox_patch(),
            connectionstyle=f"arc3,rad={bend}",
            arrowstyle="->",
            mutation_scale=9,
            color=OUTSIDE if bad else INSIDE,
            alpha=0.9 if bad else 0.55,
            zorder=1,
        )
        axes.add_patch(arrow)
    axes.set_title(title)
    axes.set_axis_off()


def draw_rust(file: Path) -> None:
    """Draw the crates, and beside them the modules of each."""
    crates = layout.crates()
    table = layout.rules("rust")
    panels = [("crates", crates)]
    panels += [(crate, layout.rust_modules(crate)) for crate in crates]
    floors = {title: layout.floors(arrows) for title, arrows in panels}
    columns = _columns({title: len(each) + 1 for title, each in floors.items()})
    widths = [
        1.5 + max(len(floor) for title in each for floor in floors[title]) for each in columns
    ]
    tall = max(sum(len(floors[title]) + 1 for title in each) for each in columns)
    figure = plt.figure(figsize=(0.85 * sum(widths), 0.55 * tall), layout="constrained")
    sides = figure.add_gridspec(1, len(columns), width_ratios=widths)
    axes, wide = {}, {}
    for side, titles, width in zip(sides, columns, widths, strict=True):
        ratios = [len(floors[title]) + 1 for title in titles]
        rows = side.subgridspec(len(titles), 1, height_ratios=ratios)
        for row, title in zip(rows, titles, strict=True):
            axes[title], wide[title] = figure.add_subplot(row), width
    for title, arrows in panels:
        # The table has the modules of the core; elsewhere a circle alone is wrong.
        around = {name for group in layout.circles(arrows) for name in group}
        allowed = table.allowed if title == "agrik" else None

        def wrong(source: str, target: str, allowed=allowed, around=around) -> bool:
            if allowed is not None:
                return target not in allowed(source)
            return source in around and target in around

        draw(axes[title], title, floors[title], arrows, wrong, wide[title])
    _save(figure, file)


def _columns(heights: dict[str, int]) -> list[list[str]]:
    """Return titles in two columns of about one height: the tallest first, to the shorter one."""
    columns: list[list[str]] = [[], []]
    for title in sorted(heights, key=lambda each: -heights[each]):
        min(columns, key=lambda each: sum(heights[name] for name in each)).append(title)
    return columns


def draw_python(file: Path) -> None:
    """Draw the rooms of the package in the layers of the table."""
    table = layout.rules("python")
    arrows = layout.rooms(layout.imports(layout.modules()))
    for name in (layout.PACKAGE, "_lazy"):
        arrows.pop(name, None)
    floors = [[name for name in layer if name not in table.planned] for layer in table.layers]
    floors = [layer for layer in floors if layer]
    wide = 1.5 + max(map(len, floors))
    figure, axis = plt.subplots(figsize=(9, 0.85 * len(floors)), layout="constrained")
    draw(axis, "agrik_fast", floors, arrows, lambda a, b: b not in table.allowed(a), wide)
    _save(figure, file)


def _save(figure: plt.Figure, file: Path) -> None:
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def main(folder: Path) -> None:
    """Draw both pictures into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    draw_rust(folder / "rust.svg")
    draw_python(folder / "python.svg")
