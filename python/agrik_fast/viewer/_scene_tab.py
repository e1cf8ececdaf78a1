"""The tab of what stands round the arm, and of what the arm is shown as."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from ..collision import Scene, SceneObject, Sphere
from ..robot import LOOKS
from ._panel import Panel, send_file


class SceneTab:
    """Obstacles: shown, kept clear of, added, read and written."""

    def __init__(self, panel: Panel, tab: Any) -> None:
        self._panel = panel
        session, gui = panel.session, panel.server.gui
        with tab:
            self._look = gui.add_dropdown("arm shown as", LOOKS, initial_value=panel.show)
            self._shown = gui.add_checkbox("obstacles", True)
            self._avoid = gui.add_checkbox(
                "keep clear of collisions", session.avoid, hint="look for postures that hit nothing"
            )
            self._clear = gui.add_number("distance to keep [mm]", 0.0, min=0.0, step=1.0)
            self._radius = gui.add_number("radius [mm]", 50.0, min=1.0, step=5.0)
            self._add = gui.add_button("add sphere at the target")
            self._empty = gui.add_button("remove all obstacles")
            self._load = gui.add_upload_button("load scene file", mime_type=".json,.toml")
            self._save = gui.add_button("save scene file")
            self._words = gui.add_markdown("")
        when = panel._when
        self._look.on_update(when("look", lambda: panel.show_as(self._look.value)))
        self._shown.on_update(when("obstacles", self.redraw))
        self._avoid.on_update(when("avoid", self._changed))
        self._clear.on_update(when("avoid", self._changed))
        self._add.on_click(lambda _: panel.worker.submit("scene", self._add_sphere))
        self._empty.on_click(lambda _: panel.worker.submit("scene", lambda: self._take(None)))
        self._load.on_upload(lambda _: panel.worker.submit("scene", self._read))
        self._save.on_click(self._write)
        panel.loaded.append(self._told)
        self._told()
        self.redraw()

    def _told(self) -> None:
        """Say what is known of the arm's collisions."""
        robot = self._panel.session.robot
        bodies = bool(robot.bodies)
        self._avoid.disabled = self._clear.disabled = not bodies
        self._words.content = (
            f"{len(robot.bodies)} bodies, {len(robot.self_pairs.asked)} pairs of them are watched"
            if bodies
            else f"{robot.name} has no bodies: collisions are not known"
        )

    def redraw(self) -> None:
        """Draw the obstacles, or take them away."""
        self._panel.stage.obstacles(self._panel.session.scene, self._shown.value)

    def _changed(self) -> None:
        session = self._panel.session
        session.avoid = self._avoid.value
        session.clear = max(self._clear.value, 0.0) / 1000
        session.outcome = session.solve()
        self._panel.refresh()

    def _take(self, scene: Scene | None) -> None:
        session = self._panel.session
        if scene is not None and session.robot.bodies:
            scene.collider(session.robot)  # says what does not fit this arm
        session.scene = scene
        session.outcome = session.solve()
        self.redraw()
        self._panel.refresh()

    def _add_sphere(self) -> None:
        session = self._panel.session
        scene = session.scene or Scene()
        number = 1
        while f"sphere {number}" in scene.names:
            number += 1
        place = session.target[:3, 3].tolist()
        ball = Sphere(place, max(self._radius.value, 1.0) / 1000)
        self._take(scene.with_objects(SceneObject.of(f"sphere {number}", ball, kind="added")))

    def _read(self) -> None:
        given = self._load.value
        name = Path(given.name)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / f"{name.stem}{name.suffix.lower()}"
            file.write_bytes(given.content)
            self._take(Scene.load(file))

    def _write(self, event: Any) -> None:
        from ..collision import document_of

        scene = self._panel.session.scene or Scene()
        content = json.dumps(document_of(scene), indent=1).encode()
        send_file(event, "scene.json", content)
