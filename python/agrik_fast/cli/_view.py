"""``agrik-fast view``: an arm in the browser, or in a page without a server."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from .._checks import FloatArray, word
from ..errors import ArgumentError
from ..io import read_targets
from ..jobs import RobotChoice
from ..robot import LOOKS, Look
from ..viewer import Viewer, export_html, view


@dataclass(frozen=True)
class ViewRequest:
    """What the command was asked for."""

    robot: RobotChoice
    scene: Path | None
    targets: Path | None
    path: Path | None
    show: str
    host: str
    port: int

    def open(self, *, browser: bool) -> Viewer:
        """Start the viewer.

        Raises
        ------
        AgrikError
            A file is faulty, the port is taken, viser is not installed.
        """
        return view(
            self.robot.load(),
            targets=self.read_targets(),
            path=self.path,
            host=self.host,
            port=self.port,
            open_browser=browser,
            **self._common(),
        )

    def _common(self) -> dict[str, Any]:
        word("--show", self.show, LOOKS)
        return {"scene": self.scene, "show": cast("Look", self.show)}

    def read_targets(self) -> FloatArray | None:
        """Return the targets of the file, shape (n, 3) or (n, 4, 4), m; None without one."""
        if self.targets is None:
            return None
        found = read_targets(self.targets).read_all().targets
        if not len(found):
            raise ArgumentError("--targets", f"{self.targets} without a target", "one or more")
        return found


def write_page(request: ViewRequest, file: Path, *, force: bool) -> Path:
    """Write a page that needs no server; the arm follows the path, or the targets.

    Raises
    ------
    AgrikError
        A file is faulty or exists, viser is not installed.
    """
    from ..viewer import playable

    arm = request.robot.load()
    q, targets = playable(arm, request.path)
    if targets is None:
        targets = request.read_targets()
    return export_html(arm, file, q=q, targets=targets, force=force, **request._common())
