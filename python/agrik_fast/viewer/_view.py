"""The viewer: a session, its window and the server that shows it."""

from __future__ import annotations

import threading
import webbrowser
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from .._checks import float_array, shown, text, whole_number, word
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import LOOKS, Look, Robot
from ..solvers import Solver
from ._panel import Panel
from ._server import open_server, stop_server
from ._session import Session
from ._sources import load, load_scene, load_solver
from ._tabs import Tabs

_LARGEST_PORT = 65535


class Viewer:
    """A viewer that runs; `view` makes one. As a context manager it ends with the block.

    Attributes
    ----------
    url : str
        Where a browser finds it.

    Examples
    --------
    >>> from agrik_fast.viewer import view
    >>> with view("ur5", port=0, open_browser=False) as viewer:
    ...     print(viewer.robot)
    Robot('ur5', dof=6)
    """

    def __init__(self, panel: Panel, tabs: Tabs, host: str) -> None:
        self._panel = panel
        self._tabs = tabs
        self._ended = threading.Event()
        port = panel.server.get_port()
        place = "localhost" if host in ("0.0.0.0", "::") else host
        self.url = f"http://{f'[{place}]' if ':' in place else place}:{port}"

    @property
    def robot(self) -> Robot:
        """The arm that is shown."""
        return self._panel.session.robot

    @property
    def q(self) -> np.ndarray:
        """The posture that is shown, shape (n,), rad or m."""
        return self._panel.session.q.copy()

    @property
    def target(self) -> np.ndarray:
        """The target, shape (4, 4), m."""
        return self._panel.session.target.copy()

    @property
    def status(self) -> str:
        """One line on what became of the target."""
        return self._panel.session.outcome.headline

    def aim(self, target: ArrayLike) -> str:
        """Move the target, as dragging it does.

        Parameters
        ----------
        target : array_like, shape (4, 4) or (3,), m
            A pose, or a position: the orientation stays.

        Returns
        -------
        str
            What became of it.

        Raises
        ------
        ArgumentError
            A wrong shape, or numbers that are not finite.

        Examples
        --------
        >>> from agrik_fast.viewer import view
        >>> with view("ur5", port=0, open_browser=False) as viewer:
        ...     print(viewer.aim([0.4, 0.2, 0.3]).split()[0])
        CONVERGED
        """
        given = float_array("target", target)
        if given.shape not in ((4, 4), (3,)) or not np.isfinite(given).all():
            raise ArgumentError("target", shown(target), "shape (4, 4) or (3,), finite")
        pose = self.target
        if given.shape == (3,):
            pose[:3, 3] = given
        else:
            pose = given.copy()

        def job() -> None:
            self._panel.session.aim(pose)
            self._panel.refresh()

        self._panel.worker.submit("aim", job)
        self._panel.worker.settle(60.0)
        return self.status

    def wait(self) -> None:
        """Return when the viewer was stopped; Ctrl-C ends it.

        Examples
        --------
        >>> from agrik_fast.viewer import view
        >>> import threading
        >>> with view("ur5", port=0, open_browser=False) as viewer:
        ...     threading.Timer(0.1, viewer.stop).start()
        ...     viewer.wait()
        """
        # In short pieces: a signal is seen between them on every system.
        while not self._ended.wait(0.2):
            pass

    def stop(self) -> None:
        """End the server; pages that show it stay as they are.

        Examples
        --------
        >>> from agrik_fast.viewer import view
        >>> viewer = view("ur5", port=0, open_browser=False)
        >>> viewer.stop()
        """
        if not self._ended.is_set():
            self._ended.set()
            self._tabs.stop()
            self._panel.worker.stop()
            stop_server(self._panel.server)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"Viewer({self.robot.name!r}, {self.url!r})"


def view(
    robot: Robot | str | PathLike[str],
    *,
    scene: Scene | str | PathLike[str] | None = None,
    targets: ArrayLike | None = None,
    path: str | PathLike[str] | None = None,
    q: ArrayLike | None = None,
    solver: Solver | str | PathLike[str] = "lm",
    show: Look = "auto",
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = True,
) -> Viewer:
    """Show an arm in the browser.

    Parameters
    ----------
    robot : Robot, str or path
        The arm, or what `Robot.load` takes.
    scene : Scene, str or path, optional
        What stands round it, or a scene file.
    targets : array_like, shape (n, 3) or (n, 4, 4), m, optional
        Targets to step through; the first is aimed at.
    path : str or path, optional
        A file of targets to follow, or of postures from ``agrik-fast solve``, to play.
    q : array_like, shape (dof,), rad or m, optional
        Posture at first; by default one with room to all limits.
    solver : solver, str or path, default "lm"
        Solver at first, by its name; a gain file (.toml or .json), with the solver's usual start
        and restarts; or as it is. The latter two stand in the panel's list before the names.
    show : {"auto", "chain", "bodies", "visuals"}, default "auto"
        What the arm is shown as, see `Robot.surfaces`.
    host : str, default "127.0.0.1"
        What the server listens to: with this one only programs of this machine see it.
    port : int, default 8080
        Port of the server; 0 takes a free one.
    open_browser : bool, default True
        Open the page.

    Returns
    -------
    Viewer
        With `url` and `stop`. All browsers that open it see and move one arm.

    Raises
    ------
    MissingExtraError
        viser is not installed.
    ArgumentError
        The port is taken, a wrong shape or value.
    AgrikError
        A file is faulty.

    Examples
    --------
    >>> from agrik_fast.viewer import view
    >>> viewer = view("redundant7", port=0, open_browser=False)
    >>> viewer.status.split()[0]
    'CONVERGED'
    >>> viewer.stop()
    """
    arm, source = load(robot)
    word("show", show, LOOKS)
    if "\0" in text("host", host):
        raise ArgumentError("host", shown(host), "an address of this machine")
    whole_number("port", port, 0, _LARGEST_PORT)
    surroundings = load_scene(scene)
    chosen = load_solver(solver)
    given = None if isinstance(chosen, str) else chosen
    session = Session(arm, source, surroundings, given)
    session.solver = chosen if isinstance(chosen, str) else chosen.label
    if q is not None:
        session.move_joints(posture(arm, q))
    elif session.solver != "lm":
        session.aim(session.target, remember=False)
    way = None if path is None else Path(path)
    server = open_server(host, port)
    try:
        panel = Panel(server, session, show)
        tabs = Tabs(panel)
        if targets is not None:
            tabs.take_targets(float_array("targets", targets))
        if way is not None:
            tabs.take_path(way)
    except BaseException:
        stop_server(server)
        raise
    viewer = Viewer(panel, tabs, host)
    if open_browser:
        webbrowser.open(viewer.url)
    return viewer


def posture(robot: Robot, q: ArrayLike) -> np.ndarray:
    """Return joint values within the limits.

    Raises
    ------
    ArgumentError
        A wrong shape, or values beyond the limits or not finite.
    """
    given = float_array("q", q)
    inside = given.shape == (robot.dof,) and (given >= robot.lower) & (given <= robot.upper)
    if not np.all(inside):
        expected = f"{robot.dof} values within the limits of {robot.name!r}"
        raise ArgumentError("q", shown(q), expected)
    return given
