"""The tab of where the tool can be."""

from __future__ import annotations

from typing import Any

from ._panel import Panel
from ._reach import PLANES, QUANTITIES, Reach, reach

_COUNTS = {"10 000": 10_000, "100 000": 100_000}


class ReachTab:
    """Points that the tool reaches: all of them, or a slice."""

    def __init__(self, panel: Panel, tab: Any) -> None:
        self._panel = panel
        self._made: Reach | None = None
        gui = panel.server.gui
        with tab:
            self._on = gui.add_checkbox("reach map", False)
            self._count = gui.add_dropdown("points", tuple(_COUNTS), initial_value="100 000")
            self._quantity = gui.add_dropdown("colour", QUANTITIES)
            self._sliced = gui.add_checkbox("slice", True, hint="only points near a plane")
            self._plane = gui.add_dropdown("across", PLANES, initial_value="y")
            self._at = gui.add_slider("at [m]", -1.0, 1.0, 0.01, 0.0)
            self._words = gui.add_markdown("")
        when = panel._when
        for widget in (self._on, self._count, self._quantity):
            widget.on_update(when("reach", self._make))
        self._sliced.on_update(when("slice", self._draw))
        self._at.on_update(when("slice", self._draw))
        self._plane.on_update(when("plane", self._turn))
        panel.loaded.append(self._loaded)
        self._loaded()

    def _loaded(self) -> None:
        self._on.value = False
        self._made = None
        self._turn()

    def _turn(self) -> None:
        """Fit the slider to the plane, and put it through the tool."""
        robot, place = self._panel.session.robot, self._panel.session.target[:3, 3]
        axis = PLANES.index(self._plane.value)
        low, high = robot.reach_box[:, axis]
        self._at.min, self._at.max = round(float(low), 2), round(float(high), 2)
        middle = min(max(float(place[axis]), self._at.min), self._at.max)
        self._at.value = round(middle, 2)
        self._draw()

    def _make(self) -> None:
        self._made = None
        session = self._panel.session
        if self._on.value:
            self._words.content = "computing ..."
            count = _COUNTS[self._count.value]
            self._made = reach(session.robot, count, self._quantity.value, session.collides_with)
        self._draw()

    def _draw(self) -> None:
        made = self._made
        if made is None:
            self._panel.stage.cloud(None)
            self._words.content = ""
            return
        if self._sliced.value:
            made = made.slice(self._plane.value, self._at.value)
        size = 0.008 * self._panel.session.robot.reach_radius
        self._panel.stage.cloud(made.places, made.colours, size)
        self._words.content = f"{len(made.places):,} points shown. {made.words}"
