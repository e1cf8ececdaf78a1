"""``agrik-fast drive``: a rig, real or simulated, from target to target."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from .._checks import FloatArray
from ..drivers import LinkError, RigError, RigStatus, StrawberryRig, TomatoRig
from ..errors import AgrikError, ArgumentError, UnknownNameError
from ..io import read_targets
from ._exits import write_line

if TYPE_CHECKING:
    from rich.table import Table

RIGS = ("strawberry", "tomato")
BARE = ("x", "y", "z")
# No rig is that small or that far, in metres.
_CERTAINLY_MM = 10.0


@dataclass(frozen=True)
class DriveRequest:
    """What the command was asked for."""

    rig: str
    port: str
    targets: Path
    calibration: Path | None = None
    method: str = "exact"
    psi_deg: float = 0.0
    h_extra_mm: float | None = None
    near: bool = False
    log: Path | None = None


@dataclass
class Row:
    """A target and what became of it."""

    number: int
    point: FloatArray
    outcome: str = ""
    seconds: float | None = None
    note: str = ""


def one_of(targets: Path | None, camera: str | None) -> None:
    """Refuse both targets and a camera, and neither.

    Raises
    ------
    ArgumentError
        It is so.
    """
    if (targets is None) == (camera is None):
        found = "neither" if targets is None else "both"
        raise ArgumentError("--targets, --camera", found, "one of them")


class DriveError(RigError):
    """A target that could not be driven to, and what of the list was left."""


def read_points(path: Path) -> FloatArray:
    """Return the points of a target file, shape (n, 3), m.

    Columns x, y and z without a unit, as the strawberry paper's table 3 has them, are mm.

    Raises
    ------
    TargetFileError
        The file cannot be read.
    ArgumentError
        The unit is not clear, or there are no targets.
    """
    points = _bare_points(path)
    if points is None:
        given = read_targets(path).read_all().targets
        points = given[:, :3, 3] if given.ndim == 3 else given
    if not len(points):
        raise ArgumentError("--targets", f"{path} without a target", "one or more")
    return points


def _bare_points(path: Path) -> FloatArray | None:
    if path.suffix.lower() != ".csv" or not path.is_file():
        return None
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            lines = (line for line in stream if not line.startswith("#"))
            rows = csv.DictReader(lines)
            if not set(BARE) <= set(rows.fieldnames or ()):
                return None
            points = np.array([[float(row[name]) for name in BARE] for row in rows]).reshape(-1, 3)
    except (OSError, UnicodeDecodeError, ValueError, TypeError, csv.Error):
        # The reader of target files says what is wrong.
        return None
    if len(points) and not (np.abs(points).max(axis=1) > _CERTAINLY_MM).all():
        found = f"{path}, whose columns x, y, z name no unit and hold small numbers"
        raise ArgumentError("--targets", found, "columns x_m,y_m,z_m or x_mm,y_mm,z_mm")
    return points / 1000


@dataclass
class Show:
    """A live table on a terminal, plain lines elsewhere."""

    rig: str
    stream: TextIO
    rows: list[Row] = field(default_factory=list)
    status: RigStatus | None = None
    _live: Any = None

    @contextmanager
    def open(self) -> Iterator[None]:
        """Show the table until the block ends."""
        if not self.stream.isatty():
            yield
            return
        from rich.console import Console
        from rich.live import Live

        console = Console(file=self.stream)
        with Live(self._table(), console=console, refresh_per_second=10) as self._live:
            yield

    def moved(self, status: RigStatus) -> None:
        """Take where the rig is."""
        self.status = status
        self._update()

    def changed(self, row: Row) -> None:
        """Take what became of a target."""
        self._update()
        if self._live is None and row.outcome != "on its way":
            took = "" if row.seconds is None else f", {row.seconds:.2f} s"
            note = f", {row.note}" if row.note else ""
            write_line(self.stream, f"{self.rig}: {_named(row)}: {row.outcome}{took}{note}")

    def _update(self) -> None:
        if self._live is not None:
            self._live.update(self._table())

    def _table(self) -> Table:
        from rich.table import Table

        state = ""
        if self.status is not None:
            shown = ", ".join(_joint(value, i, self.rig) for i, value in enumerate(self.status.q))
            link = self.status.link
            state = (
                f"{self.status.state}   {shown}   {link.requests} requests, {link.retries} retries"
            )
        table = Table(title=f"{self.rig} rig", caption=state)
        # No brackets: they are the table's own language.
        for name in ("target", "x, mm", "y, mm", "z, mm", "outcome", "time, s", "note"):
            table.add_column(name, justify="right" if "," in name else "left")
        active = next((i for i, row in enumerate(self.rows) if row.outcome == "on its way"), 0)
        # As many as a terminal shows, with the one on its way among them.
        for row in self.rows[max(active - 10, 0) : active + 15]:
            seconds = "" if row.seconds is None else f"{row.seconds:.2f}"
            place = [f"{1000 * value:.1f}" for value in row.point]
            table.add_row(str(row.number), *place, row.outcome, seconds, row.note)
        return table


def _joint(value: float, index: int, rig: str) -> str:
    if np.isnan(value):
        return "?"
    if rig == "strawberry" and index < 3:
        return f"{1000 * value:.1f}"
    return f"{np.degrees(value):.1f}°"


def _named(row: Row) -> str:
    x, y, z = 1000 * row.point
    return f"target {row.number} ({x:.1f}, {y:.1f}, {z:.1f}) mm"


def drive(request: DriveRequest, rows: list[Row], stream: TextIO | None = None) -> None:
    """Drive a rig to every target of a file, which fill `rows`.

    Raises
    ------
    UnknownNameError
        No such rig.
    AgrikError
        A file, the link, the board or a target is at fault; motors are off. The message says
        what of the list was not driven to.
    """
    if request.rig not in RIGS:
        raise UnknownNameError("rig", request.rig, RIGS)
    points = read_points(request.targets)
    show = Show(request.rig, stream or sys.stderr)
    rows += [Row(number, point) for number, point in enumerate(points, 1)]
    show.rows = rows
    options: dict[str, Any] = {
        "calibration": request.calibration,
        "log": request.log,
        "progress": show.moved,
    }
    with show.open():
        if request.rig == "strawberry":
            with StrawberryRig(request.port, **options) as berry:
                _each(show, berry.home, lambda row: _pick(berry, request, row))
        else:
            with TomatoRig(request.port, **options) as tomato:
                _each(show, tomato.home, lambda row: _point(tomato, request, row))


def count(rows: list[Row]) -> str:
    """Say how many of the targets were driven to."""
    reached = sum(row.outcome == "reached" for row in rows)
    return f"{reached} of {len(rows)} targets were driven to"


def _each(show: Show, home: Callable[[], None], one: Callable[[Row], None]) -> None:
    try:
        home()
    except AgrikError as error:
        raise DriveError(f"homing: {error}; {_left(show.rows)}") from None
    for row in show.rows:
        row.outcome = "on its way"
        show.changed(row)
        try:
            one(row)
        except AgrikError as error:
            row.outcome = "failed"
            show.changed(row)
            rest = _left(show.rows[row.number :])
            motors = "motors are off"
            if isinstance(error, LinkError):
                motors = "the board stops its motors by itself within half a second"
            raise DriveError(f"{_named(row)}: {error}; {motors}; {rest}") from None
        row.outcome = "reached"
        show.changed(row)


def _left(rows: list[Row]) -> str:
    if not rows:
        return "it was the last of the list"
    if len(rows) == 1:
        return f"not driven to: target {rows[0].number}"
    return f"not driven to: targets {rows[0].number} to {rows[-1].number}"


def _pick(rig: StrawberryRig, request: DriveRequest, row: Row) -> None:
    height = None if request.h_extra_mm is None else request.h_extra_mm / 1000
    run = rig.pick(
        target=row.point,
        method=request.method,  # type: ignore[arg-type]
        psi=float(np.radians(request.psi_deg)),
        h_extra=height,
    )
    off = 1000 * max(abs(step.encoder_error) for step in run.steps)
    row.seconds = run.seconds
    row.note = f"h_extra {1000 * run.h_extra:.0f} mm, encoders within {off:.2f} mm"
    rig.reset(h_extra=height)


def _point(rig: TomatoRig, request: DriveRequest, row: Row) -> None:
    clock = rig.link.transport
    begin = clock.now()
    status = rig.move(target=row.point, near=request.near)
    row.seconds = clock.now() - begin
    row.note = ", ".join(f"{angle:.1f}°" for angle in np.degrees(status.q))


# What arguments of the drivers are called on the command line.
_OPTIONS = {"psi": "--psi", "h_extra": "--h-extra", "method": "--method", "log": "--log"}


def drive_words(request: DriveRequest, rows: list[Row]) -> None:
    """Drive; an error names the option that its cause was given by."""
    try:
        drive(request, rows)
    except UnknownNameError:
        raise
    except ArgumentError as error:
        option = _OPTIONS.get(error.argument, error.argument)
        raise ArgumentError(option, error.received, error.expected) from None
