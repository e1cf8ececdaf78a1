"""The tab of ways: made, read or recorded, and played."""

from __future__ import annotations

import functools
import tempfile
import threading
from pathlib import Path
from typing import Any

import numpy as np

from .._checks import FloatArray
from ..errors import ArgumentError
from ._panel import Panel
from ._ways import PICKING, Way, circle, follow, line, picking, read_way

_RATE = 25.0
"""Postures per second at speed 1."""
_DRAWN = 60.0
"""Pictures per second at most: faster ways leave postures out."""
_MARKS = 12
_LINE = (0.0, 0.2, 0.0)


class PathTab:
    """A way and how it is played: on, back, step by step, at any speed."""

    def __init__(self, panel: Panel, tab: Any) -> None:
        self._panel = panel
        self._tab = tab
        self.way: Way | None = None
        self._targets: FloatArray | None = None
        self._recorded: list[FloatArray] = []
        self._ended = threading.Event()
        self._playing = threading.Event()
        self._folder: Any = None
        self._time: Any = None
        gui = panel.server.gui
        with tab:
            self._kind = gui.add_dropdown("way", ("line", "circle", "recorded"))
            self._by = gui.add_vector3("line by [m]", _LINE, step=0.01)
            self._radius = gui.add_number("circle radius [m]", 0.1, min=0.001, step=0.01)
            self._psi = gui.add_number("psi [deg]", 0.0, min=-90.0, max=90.0, visible=False)
            self._make = gui.add_button("make the way")
            self._record = gui.add_button("record this target")
            self._load = gui.add_upload_button("load file", mime_type=".csv,.npy,.npz,.parquet")
            self._number = gui.add_slider("target of the file", 1, 2, 1, 1, visible=False)
            self._words = gui.add_markdown("no way yet")
            self._slot = gui.add_folder("play")
            with self._slot:
                self._play = gui.add_button("play")
                self._pause = gui.add_button("pause")
                self._step = gui.add_button_group("step", ("back", "on"))
                self._speed = gui.add_slider("speed", 0.1, 4.0, 0.1, 1.0)
        submit = panel.worker.submit
        self._make.on_click(lambda _: submit("way", self._made))
        self._record.on_click(lambda _: submit("record", self._recorded_one))
        self._load.on_upload(lambda _: submit("way", self._read))
        self._number.on_update(panel._when("number", self._choose_target))
        self._play.on_click(lambda _: self.play())
        self._pause.on_click(lambda _: self._playing.clear())
        steps = {"back": -1, "on": 1}
        self._step.on_click(lambda event: self._stepped(steps[event.target.value]))
        panel.loaded.append(self._loaded)
        self._loaded()
        self._thread = threading.Thread(target=self._run, name="agrik-player", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread that plays."""
        self._playing.clear()
        self._ended.set()
        self._thread.join(timeout=5.0)

    def _loaded(self) -> None:
        session = self._panel.session
        picks = session.robot.name in PICKING
        self._kind.options = ("line", "circle", "recorded", *(("picking",) if picks else ()))
        self._psi.visible = session.robot.name == "strawberry6"
        self._recorded = []
        self.take(None)

    # -- ways --------------------------------------------------------------------------------

    def _made(self) -> None:
        session = self._panel.session
        kind = self._kind.value
        if kind == "line":
            self.take(follow(session, line(session.target, self._by.value), "line"))
        elif kind == "circle":
            self.take(follow(session, circle(session.target, self._radius.value), "circle"))
        elif kind == "picking":
            self.take(picking(session, float(np.radians(self._psi.value))))
        elif not self._recorded:
            raise ArgumentError("way", "no recorded target", "some ('record this target')")
        else:
            self.take(follow(session, np.array(self._recorded), "recorded"))

    def _recorded_one(self) -> None:
        self._recorded.append(self._panel.session.target.copy())
        places = np.array(self._recorded)[:, :3, 3]
        self._panel.stage.way(None, None, places)
        self._words.content = f"{len(self._recorded)} recorded"
        self._kind.value = "recorded"

    def _read(self) -> None:
        given = self._load.value
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / Path(given.name).name
            file.write_bytes(given.content)
            self.read(file)

    def read(self, file: Path) -> None:
        """Take the way of a file: postures as they are, targets followed in order."""
        session = self._panel.session
        found = read_way(session.robot, file)
        if isinstance(found, Way):
            self.take(found)
            return
        self.targets(found)
        self.take(follow(session, found, file.name, free=True), found)

    def targets(self, targets: FloatArray) -> None:
        """Take targets to step through, shape (n, 3) or (n, 4, 4), m."""
        self._targets = targets
        self._number.visible = True
        self._number.max = max(len(targets), 2)
        self._panel.stage.way(None, None, _places(targets))
        self._words.content = f"{len(targets)} targets"

    def _choose_target(self) -> None:
        assert self._targets is not None
        row = min(int(self._number.value), len(self._targets)) - 1
        self.aim_at(row)

    def aim_at(self, row: int) -> None:
        """Aim at one of the targets, by its row."""
        session = self._panel.session
        assert self._targets is not None
        given = self._targets[row]
        pose = session.target.copy()
        if given.shape == (3,):
            pose[:3, 3] = given
        else:
            pose = given
        session.aim(pose)
        self._panel.refresh()

    def take(self, way: Way | None, targets: FloatArray | None = None) -> None:
        """Take a way in place of the one before; None for none."""
        self._playing.clear()
        self.way = way
        gui, stage = self._panel.server.gui, self._panel.stage
        if self._time is not None:
            self._time.remove()
            self._time = None
        self._slot.visible = way is not None
        if way is None:
            stage.way(None)
            self._words.content = "no way yet"
            return
        tips = self._panel.session.robot.fk(way.q)[:, :3, 3]
        stage.way(tips, way.bad, None if targets is None else _places(targets))
        rows = np.flatnonzero(way.bad) + 1
        marked = rows[:: max(1, -(-len(rows) // _MARKS))]
        with self._slot:
            # A cross in the bar of time for every pose that failed.
            self._time = gui.add_slider(
                "pose",
                1,
                max(len(way.q), 2),
                1,
                1,
                marks=tuple((int(row), "×") for row in marked),
                order=0.0,
            )
        self._time.on_update(self._panel._when("scrub", lambda: self._show(self._time.value)))
        self._words.content = way.words
        self._show(1)

    # -- playing -----------------------------------------------------------------------------

    def play(self) -> None:
        """Play from where it stands; from the beginning where that is the end."""
        if self.way is not None and self._time is not None:
            if self._time.value >= len(self.way.q):
                self._time.value = 1
            self._playing.set()

    def _stepped(self, by: int) -> None:
        self._playing.clear()
        if self.way is not None and self._time is not None:
            self._time.value = int(np.clip(self._time.value + by, 1, len(self.way.q)))
            number = self._time.value
            self._panel.worker.submit("scrub", lambda: self._show(number))

    def _run(self) -> None:
        while not self._ended.is_set():
            if not self._playing.wait(0.2):
                continue
            way, bar = self.way, self._time
            if way is None or bar is None or bar.value >= len(way.q):
                self._playing.clear()
                continue
            rate = _RATE * self._speed.value
            step = int(np.ceil(rate / _DRAWN))
            number = min(bar.value + step, len(way.q))
            bar.value = number
            self._panel.worker.submit("scrub", functools.partial(self._show, number))
            self._ended.wait(step / rate)

    def _show(self, number: int) -> None:
        way = self.way
        if way is None:
            return
        row = int(np.clip(number, 1, len(way.q))) - 1
        session, panel = self._panel.session, self._panel
        session.q = way.q[row].copy()
        session.opening = float(way.opening[row])
        session.target = session.robot.fk(session.q)
        session.outcome = session.solve()
        where = f"pose {row + 1} of {len(way.q)}"
        panel.note = (
            f"{where}: a target was missed here, or a joint jumped" if way.bad[row] else where
        )
        panel.refresh()
        panel.note = ""


def _places(targets: FloatArray) -> FloatArray:
    return targets if targets.ndim == 2 else targets[:, :3, 3]
