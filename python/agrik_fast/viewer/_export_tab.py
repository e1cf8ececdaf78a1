"""The tab of what is taken away: page, picture, tables, script."""

from __future__ import annotations

import csv
import html
import io
from typing import Any

import numpy as np

from ._export import page
from ._panel import Panel, send_file
from ._path_tab import PathTab

_PICTURE = (900, 1200)
"""Height and width of a picture, px."""


class ExportTab:
    """Files of what is shown, sent to the browser that asked."""

    def __init__(self, panel: Panel, path: PathTab, tab: Any) -> None:
        self._panel = panel
        self._path = path
        gui = panel.server.gui
        with tab:
            script = gui.add_button("copy as Python")
            picture = gui.add_button("picture (PNG)")
            whole = gui.add_button("page without a server (HTML)")
            table = gui.add_button("target and joint values (CSV)")
            self._script = gui.add_html("", visible=False)
        script.on_click(lambda _: panel.worker.submit("script", self._show_script))
        picture.on_click(self._picture)
        whole.on_click(self._page)
        table.on_click(self._table)

    def _show_script(self) -> None:
        self._script.content = script_box(self._panel.session.python())
        self._script.visible = True

    def _picture(self, event: Any) -> None:
        if event.client is None:
            return
        camera = event.client.camera
        # A picture may not be larger than the window that draws it.
        height, width = min(camera.image_height, _PICTURE[0]), min(camera.image_width, _PICTURE[1])
        pixels = event.client.get_render(height, width, transport_format="png", timeout=30.0)
        send_file(event, "arm.png", png(pixels))

    def _page(self, event: Any) -> None:
        way = self._path.way
        rows = None if way is None else way.q
        text = page(self._panel.server, self._panel.stage, self._panel.session, rows)
        send_file(event, "arm.html", text.encode())

    def _table(self, event: Any) -> None:
        session, way = self._panel.session, self._path.way
        rows = session.q[None] if way is None else way.q
        send_file(event, "arm.csv", table(session.robot, rows))


# A page that came from another machine has no clipboard: there the selection is copied.
_COPY = (
    "const box = this.nextElementSibling; box.focus(); box.select();"
    " const said = () => { this.textContent = 'copied'; };"
    " if (navigator.clipboard) navigator.clipboard.writeText(box.value).then(said);"
    " else if (document.execCommand('copy')) said();"
)


def script_box(script: str) -> str:
    """Return a script as HTML: text that can be selected, and a button that copies it."""
    style = "width:100%;height:9em;font:0.8em monospace;white-space:pre;box-sizing:border-box"
    return (
        '<div style="padding:0 0.8em">'
        f'<button onclick="{html.escape(_COPY)}" style="margin-bottom:0.4em;padding:0.2em 0.8em;'
        "border:1px solid #00507d;border-radius:0.2em;background:#fff;color:#00507d;"
        'cursor:pointer">copy to the clipboard</button>'
        f'<textarea readonly aria-label="Python" style="{style}">{html.escape(script)}</textarea>'
        "</div>"
    )


def png(pixels: Any) -> bytes:
    """Return an image, shape (h, w, 3 or 4), as a PNG on white."""
    from PIL import Image

    stream = io.BytesIO()
    image = Image.fromarray(np.asarray(pixels, dtype=np.uint8))
    if image.mode == "RGBA":
        white = Image.new("RGBA", image.size, "white")
        image = Image.alpha_composite(white, image).convert("RGB")
    image.save(stream, "PNG")
    return stream.getvalue()


def table(robot: Any, rows: Any) -> bytes:
    """Return postures as CSV: the tool's place and turn, then the joint values, m and rad."""
    from ..rotations import rpy_of

    poses = robot.fk(rows)
    units = ["m" if kind == "prismatic" else "rad" for kind in robot.joint_types]
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    joints = [f"{name}_{unit}" for name, unit in zip(robot.joint_names, units, strict=True)]
    writer.writerow(["x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad", *joints])
    numbers = np.column_stack([poses[:, :3, 3], rpy_of(poses).angles, rows])
    writer.writerows([[repr(float(x)) for x in row] for row in numbers])
    return stream.getvalue().encode()
