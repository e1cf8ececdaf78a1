"""Pages that show an arm without a server: one file each, to be turned and played."""

from __future__ import annotations

from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .._atomic import write_bytes
from .._checks import FloatArray, float_array, real_number, shown, truth_value, word
from ..collision import Scene
from ..errors import AgrikError, ArgumentError
from ..robot import LOOKS, Look, Robot

if TYPE_CHECKING:
    from ._session import Session
    from ._stage import Stage

_RATE = 25.0
"""Postures per second."""


def export_html(
    robot: Robot | str | PathLike[str],
    path: str | PathLike[str],
    *,
    q: ArrayLike | None = None,
    targets: ArrayLike | None = None,
    scene: Scene | str | PathLike[str] | None = None,
    cloud: ArrayLike | None = None,
    show: Look = "auto",
    rate: float = _RATE,
    force: bool = False,
) -> Path:
    """Write a page that shows an arm in space; it needs no server and asks for nothing else.

    Parameters
    ----------
    robot : Robot, str or path
        The arm, or what `Robot.load` takes.
    path : str or path
        The ``.html`` file.
    q : array_like, shape (dof,) or (n, dof), rad or m, optional
        Posture, or postures that are played, with pause, scrub bar and speed. Default: the
        targets' answers, or a posture with room to all limits.
    targets : array_like, shape (n, 3) or (n, 4, 4), m, optional
        Marked in the page; without `q` the arm follows them.
    scene : Scene, str or path, optional
        What stands round it.
    cloud : array_like, shape (k, 3), m, optional
        Points, such as places that the tool reaches; at most 200 000.
    show : {"auto", "chain", "bodies", "visuals"}, default "auto"
        What the arm is shown as, see `Robot.surfaces`.
    rate : float, default 25, 1/s
        Postures per second.
    force : bool, default False
        Replace an existing file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    MissingExtraError
        viser is not installed.
    ArgumentError
        A wrong shape or value, another suffix.
    AgrikError
        The file exists, or cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from agrik_fast.viewer import export_html
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "arm.html"
    >>> export_html("tomato", file).stat().st_size > 500_000
    True
    """
    from ._server import open_server, stop_server
    from ._session import Session
    from ._sources import load, load_scene
    from ._stage import Stage
    from ._ways import follow

    try:
        file = Path(fspath(path))
    except TypeError:
        raise ArgumentError("path", shown(path), "a .html file") from None
    if file.suffix.lower() not in (".html", ".htm"):
        raise ArgumentError("path", shown(path), "a .html file")
    truth_value("force", force)
    real_number("rate", rate, 1e-3, 1e3, unit="1/s")
    word("show", show, LOOKS)
    arm, source = load(robot)
    session = Session(arm, source, load_scene(scene))
    rows = None if q is None else _postures(arm, q)
    goals = None if targets is None else _targets(targets)
    points = None if cloud is None else _points(cloud)
    if file.exists() and not force:
        raise AgrikError(f"{file}: exists already (force replaces it)")
    bad = None
    if rows is None and goals is not None:
        way = follow(session, goals, "targets", free=True)
        rows, bad = way.q, way.bad
    if rows is not None:
        session.q = rows[0]
    server = open_server("127.0.0.1", 0)
    try:
        stage = Stage(server)
        stage.load(arm, show, 1.0)
        # Nobody answers in such a page: there is nothing to drag.
        stage.handle.visible = False
        stage.obstacles(session.scene)
        if rows is not None and len(rows) > 1:
            tips = arm.fk(rows)[:, :3, 3]
            stage.way(tips, np.zeros(len(rows), bool) if bad is None else bad, _at(goals))
        elif goals is not None:
            stage.way(None, None, _at(goals))
        if points is not None:
            stage.cloud(points, (86, 180, 233), 0.008 * arm.reach_radius)
        text = page(server, stage, session, rows, rate)
    finally:
        stop_server(server)
    write_bytes(file, text.encode(), lambda reason: AgrikError(f"{file}: {reason}"), force=force)
    return file


def playable(
    robot: Robot, path: str | PathLike[str] | None
) -> tuple[FloatArray | None, FloatArray | None]:
    """Return what a file holds for `export_html`: postures, or targets to follow.

    Parameters
    ----------
    robot : Robot
    path : str, path or None
        Results of ``agrik-fast solve`` for this arm, or a target file.

    Returns
    -------
    q : ndarray, shape (n, dof), rad or m, or None
    targets : ndarray, shape (n, 3) or (n, 4, 4), m, or None

    Raises
    ------
    AgrikError
        It is neither, or that of another arm.

    Examples
    --------
    >>> from agrik_fast.viewer import playable
    >>> np.save("points.npy", [[0.4, 0.2, 0.3]])
    >>> q, targets = playable(ik.Robot.load("ur5"), "points.npy")
    >>> q is None, targets.shape
    (True, (1, 3))
    """
    from ._ways import Way, read_way

    if path is None:
        return None, None
    found = read_way(robot, Path(path))
    return (found.q, None) if isinstance(found, Way) else (None, found)


def page(
    server: Any, stage: Stage, session: Session, rows: FloatArray | None, rate: float = _RATE
) -> str:
    """Return a page of what a server shows, and of the postures that it plays."""
    stage.pose(session.q, session.opening)
    _aim_camera(server, session)
    recorder = server.get_scene_serializer()
    for row in () if rows is None or len(rows) < 2 else rows:
        stage.pose(row, session.opening)
        recorder.insert_sleep(1.0 / rate)
    text: str = recorder.as_html()
    stage.pose(session.q, session.opening)
    title = f"<title>{session.robot.name}</title>"
    head, tag, rest = text.partition("<title>")
    return text if not tag else head + title + rest.partition("</title>")[2]


def _aim_camera(server: Any, session: Session) -> None:
    frames = session.robot.frames_of(session.q)[:, :3, 3]
    centre = (frames.min(axis=0) + frames.max(axis=0)) / 2
    away = 1.5 * max(float(np.ptp(frames, axis=0).max()), 0.5 * session.robot.reach_radius)
    position = centre + away * np.array([0.85, -0.85, 0.55])
    server.initial_camera.position = tuple(position.tolist())
    server.initial_camera.look_at = tuple(centre.tolist())


def _postures(robot: Robot, q: ArrayLike) -> FloatArray:
    given = float_array("q", q)
    rows = given[None] if given.ndim == 1 else given
    if rows.ndim != 2 or rows.shape[1] != robot.dof or not len(rows):
        expected = f"shape ({robot.dof},) or (n, {robot.dof})"
        raise ArgumentError("q", f"shape {given.shape}", expected)
    if not np.isfinite(rows).all():
        raise ArgumentError("q", shown(q), "finite numbers")
    return rows


def _targets(targets: ArrayLike) -> FloatArray:
    given = float_array("targets", targets)
    right = given.shape[1:] in ((3,), (4, 4)) and len(given)
    if not right or not np.isfinite(given).all():
        expected = "shape (n, 3) or (n, 4, 4), finite"
        raise ArgumentError("targets", f"shape {given.shape}", expected)
    return given


_MOST_POINTS = 200_000


def _points(cloud: ArrayLike) -> FloatArray:
    given = float_array("cloud", cloud)
    if given.ndim != 2 or given.shape[1] != 3 or len(given) > _MOST_POINTS:
        expected = f"shape (k, 3), k up to {_MOST_POINTS}"
        raise ArgumentError("cloud", f"shape {given.shape}", expected)
    if not np.isfinite(given).all():
        raise ArgumentError("cloud", "numbers that are not finite", "finite numbers")
    return given


def _at(goals: FloatArray | None) -> FloatArray | None:
    if goals is None:
        return None
    return goals if goals.ndim == 2 else goals[:, :3, 3]
