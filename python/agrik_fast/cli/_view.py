"""``agrik-fast view``: an arm in the browser, or in a page without a server."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from .._checks import FloatArray, word
from ..errors import ArgumentError, UnknownNameError
from ..io import read_targets
from ..jobs import RobotChoice
from ..robot import LOOKS, Look, Robot
from ..viewer import Viewer, export_html, view
from ._options import numbers


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
    q0: str | None = None
    solver: str | None = None

    def open(self, *, browser: bool) -> Viewer:
        """Start the viewer.

        Raises
        ------
        AgrikError
            A file is faulty, the port is taken, viser is not installed.
        """
        arm = self.robot.load()
        with _in_options():
            return view(
                arm,
                targets=self.read_targets(),
                path=self.path,
                q=self.posture(arm),
                solver=self.solver or "lm",
                host=self.host,
                port=self.port,
                open_browser=browser,
                **self._common(),
            )

    def posture(self, arm: Robot) -> FloatArray | None:
        """Return the posture at first, rad or m; None where none is given."""
        return None if self.q0 is None else np.array(numbers("--q0", self.q0, (arm.dof,)))

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

    if request.solver is not None:
        expected = "nothing with --export: such a page solves nothing"
        raise ArgumentError("--solver", request.solver, expected)
    if request.q0 is not None and not (request.path is None and request.targets is None):
        expected = "nothing with --export and --path or --targets, which are played"
        raise ArgumentError("--q0", request.q0, expected)
    arm = request.robot.load()
    q, targets = playable(arm, request.path)
    if targets is None:
        targets = request.read_targets()
    if request.q0 is not None:
        q = request.posture(arm)
    with _in_options():
        return export_html(arm, file, q=q, targets=targets, force=force, **request._common())


@contextlib.contextmanager
def _in_options() -> Iterator[None]:
    """Let errors about the posture name its option."""
    try:
        yield
    except UnknownNameError:
        raise
    except ArgumentError as error:
        if error.argument != "q":
            raise
        raise ArgumentError("--q0", error.received, error.expected) from None
