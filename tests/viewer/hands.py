"""What a person does in the viewer's panel, done without a browser."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from agrik_fast.viewer import Viewer


class Client:
    """What the viewer sees of a browser: it draws a picture, and takes files."""

    def __init__(self) -> None:
        self.camera = SimpleNamespace(image_width=640, image_height=480)
        self.files: dict[str, bytes] = {}

    def send_file_download(self, name: str, content: bytes, *, save_immediately: bool) -> None:
        assert save_immediately
        self.files[name] = content

    def get_render(self, height: int, width: int, **_: Any) -> np.ndarray:
        """A picture that is clear on the left, and black on the right."""
        pixels = np.zeros((height, width, 4), np.uint8)
        pixels[:, width // 2 :, 3] = 255
        return pixels


def press(viewer: Viewer, widget: Any, value: Any = None) -> dict[str, bytes]:
    """Do to a widget what a browser does: set its value, tell its call-backs, and wait.

    Returns the files that the browser was sent.
    """
    if value is not None:
        # Not through its setter, which is the program's own way and tells call-backs as well.
        widget._impl.value = value
    client = Client()
    for callback in widget._impl.update_cb:
        callback(SimpleNamespace(client=client, target=widget))
    assert viewer._panel.worker.settle(60)
    return client.files
