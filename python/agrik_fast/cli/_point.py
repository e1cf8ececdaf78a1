"""``agrik-fast drive tomato --camera``: the arm points at what a camera sees."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from .._checks import FloatArray, finite_array
from ..drivers import LockstepCamera, PointingLoop, PointingStep, Simulator, TomatoRig
from ..errors import ArgumentError
from ..vision import (
    Camera,
    Detector,
    Device,
    Frame,
    Fruit,
    Look,
    Scene,
    Wall,
    folder,
    looking_at,
    paper_camera,
)
from ._exits import write_line

if TYPE_CHECKING:
    from rich.table import Table

# Where the simulated camera stands, and the fruit before it.
_POSE = looking_at([-0.10, 0.0, 0.14], [0.25, 0.0, 0.06])
_CENTRE = (0.26, 0.03, 0.06)
_LINES_A_SECOND = 1.0


@dataclass(frozen=True)
class PointRequest:
    """What the command was asked for; lengths in metres."""

    rig: str
    port: str
    camera: str
    calibration: Path | None = None
    camera_calibration: Path | None = None
    camera_pose: Path | None = None
    radius: float = 0.03
    radius_sigma: float = 0.0
    seconds: float | None = None
    log: Path | None = None


@dataclass
class Summary:
    """What was seen so far."""

    frames: int = 0
    commands: int = 0
    pointing: int = 0
    seconds: list[float] = field(default_factory=list)
    last: PointingStep | None = None

    def take(self, step: PointingStep) -> None:
        """Count a step."""
        self.frames += 1
        self.commands += step.sent
        self.pointing += step.state == "pointing"
        self.seconds.append(step.seconds)
        self.last = step


def said(summary: Summary) -> str:
    """Return the summary in words."""
    if not summary.frames:
        return "no picture was looked at"
    last = summary.last.state.replace("_", " ") if summary.last else ""
    return (
        f"{summary.frames} pictures, {summary.commands} commands, pointing in {summary.pointing}, "
        f"{1e3 * float(np.median(summary.seconds)):.1f} ms a picture; at the end: {last}"
    )


def point(request: PointRequest, summary: Summary, stream: TextIO | None = None) -> None:
    """Point at what a camera sees until its pictures or the time end.

    Raises
    ------
    AgrikError
        An option, a file, the camera, the link or the board is at fault.
    """
    if request.rig != "tomato":
        raise ArgumentError("--camera", f"the {request.rig} rig", "the tomato rig")
    if request.seconds is not None and not 0 < request.seconds < 1e6:
        raise ArgumentError("--seconds", f"{request.seconds:g}", "> 0 s")
    for option, value in (
        ("--radius-mm", 1000 * request.radius),
        ("--radius-sigma-mm", 1000 * request.radius_sigma),
    ):
        if not (0 < value < 500 or (value == 0 and option == "--radius-sigma-mm")):
            raise ArgumentError(option, f"{value:g}", "> 0 and < 500 mm")
    simulated = request.camera == "simulated"
    if simulated and request.port != "simulated":
        raise ArgumentError("--camera", f"simulated, on port {request.port}", "--port simulated")
    pose = _POSE if request.camera_pose is None else read_pose(request.camera_pose)
    if request.camera_pose is None and not simulated:
        raise ArgumentError("--camera-pose", "none", "where the camera stands, for a real one")
    calibrated = (
        paper_camera()
        if request.camera_calibration is None
        else Camera.load(request.camera_calibration)
    )
    if request.camera_calibration is None and not simulated:
        raise ArgumentError("--camera-calibration", "none", "the camera's file, for a real one")
    show = _Show(stream or sys.stderr)

    def progress(step: PointingStep) -> None:
        summary.take(step)
        show.took(step)

    with TomatoRig(request.port, calibration=request.calibration, log=request.log) as rig:
        rig.home()
        clock = rig.link.transport
        begin = clock.now()
        loop = PointingLoop(
            rig, Detector(calibrated), pose, request.radius, radius_sigma=request.radius_sigma
        )
        with show.open(), _pictures(request, rig, calibrated, pose) as pictures:
            loop.run(_until(pictures, clock.now, begin, request.seconds), progress=progress)


def read_pose(file: Path) -> FloatArray:
    """Return the matrix of a JSON file, shape (4, 4).

    Raises
    ------
    ArgumentError
        There is none in it.
    """
    try:
        return finite_array("--camera-pose", json.loads(file.read_text("utf-8")), (4, 4))
    except OSError as error:
        raise ArgumentError("--camera-pose", f"{file}: {error.strerror}", "a JSON file") from None
    except ValueError as error:
        if isinstance(error, ArgumentError):
            raise
        raise ArgumentError("--camera-pose", f"{file}: {error}", "a JSON file") from None


@contextmanager
def _pictures(
    request: PointRequest, rig: TomatoRig, calibrated: Camera, pose: FloatArray
) -> Iterator[Iterable[Frame]]:
    """Yield the pictures of what ``--camera`` names."""
    name = request.camera
    clock = rig.link.transport
    if name == "simulated":
        assert isinstance(clock, Simulator)
        fruit = Fruit(_CENTRE, request.radius)
        wall = Wall(point=(0.55, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))
        scene = Scene((fruit,), (), wall, Look(light=(-0.6, 0.2, 0.75)))
        yield LockstepCamera(clock, lambda time: scene, calibrated, pose)
    elif Path(name).is_dir():
        yield _by_the_clock(folder(name), rig)
    else:
        source = int(name) if name.isdecimal() else name
        with Device(source, width=calibrated.width, height=calibrated.height) as device:
            yield _by_the_clock(device, rig)


def _by_the_clock(pictures: Iterable[Frame], rig: TomatoRig) -> Iterator[Frame]:
    """Give pictures the times of the rig's line, at which they are handed on."""
    clock, before = rig.link.transport, -1.0
    first: tuple[float, float] | None = None
    for when, image in pictures:
        if first is None:
            first = when, clock.now()
        # A file's pictures come as they were taken.
        left = (when - first[0]) - (clock.now() - first[1])
        if 0 < left < 1:
            clock.sleep(left)
        before = max(clock.now(), before + 1e-6)
        yield before, image


def _until(
    pictures: Iterable[Frame], now: Callable[[], float], begin: float, seconds: float | None
) -> Iterator[Frame]:
    for frame in pictures:
        if seconds is not None and now() - begin > seconds:
            return
        yield frame


@dataclass
class _Show:
    """A live table of numbers on a terminal, a line a second elsewhere."""

    stream: TextIO
    _live: Any = None
    _told: float = -np.inf

    @contextmanager
    def open(self) -> Iterator[None]:
        """Show the table until the block ends."""
        if not self.stream.isatty():
            yield
            return
        from rich.console import Console
        from rich.live import Live

        console = Console(file=self.stream)
        with Live(console=console, refresh_per_second=10) as self._live:
            yield

    def took(self, step: PointingStep) -> None:
        """Take a step."""
        if self._live is not None:
            self._live.update(_table(step))
        elif step.time - self._told >= _LINES_A_SECOND:
            self._told = step.time
            words = ", ".join(f"{name} {value}" for name, value in _numbers(step))
            write_line(self.stream, f"tomato: {words}")


def _numbers(step: PointingStep) -> list[tuple[str, str]]:
    def place(point: FloatArray) -> str:
        return "-" if np.isnan(point).any() else " ".join(f"{1000 * v:.1f}" for v in point)

    joints = " ".join("?" if np.isnan(v) else f"{np.degrees(v):.1f}" for v in step.q)
    gap = "-" if np.isnan(step.gap) else f"{1000 * step.gap:.1f}"
    return [
        ("time s", f"{step.time:.2f}"),
        ("state", step.state.replace("_", " ")),
        ("fruits", str(step.detections)),
        ("centre mm", place(step.centre)),
        ("command mm", place(step.command)),
        ("gap mm", gap),
        ("joints deg", joints),
        ("vision ms", f"{1e3 * step.vision:.1f}"),
        ("all ms", f"{1e3 * step.seconds:.1f}"),
        *([("note", step.note)] if step.note else []),
    ]


def _table(step: PointingStep) -> Table:
    from rich.table import Table

    table = Table(title="tomato rig and camera", show_header=False)
    table.add_column("what")
    table.add_column("value", min_width=24)
    for name, value in _numbers(step):
        table.add_row(name, value)
    return table
