"""The tomato loop: picture, detection, track, joint values, servos, once a frame."""

from __future__ import annotations

import math
import time as host_time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, real_number, shown, whole_number
from ..errors import ArgumentError
from ..vision import (
    CameraError,
    Detection,
    DetectionStatus,
    Detector,
    Frame,
    Image,
    StandOff,
    Track,
    Tracker,
    range_sigma,
    stand_off,
)
from ._errors import OutOfReachError
from ._tomato import TomatoRig

__all__ = ["PointingLoop", "PointingStep"]

State = Literal["searching", "approaching", "pointing", "holding", "out_of_reach", "released"]

_LEAST_MOVE = 0.002
_LARGEST_JUMP = 0.015
_ARRIVED = 0.004
# How far from the shoulder the tip is drawn back where the direct way is barred.
_DRAWN_BACK = 0.14
_WAY_POINTS = 25


@dataclass(frozen=True)
class PointingStep:
    """What the loop saw and did in one frame.

    Attributes
    ----------
    time : float, s
        When the picture was taken.
    state : str
        searching (no fruit), approaching, pointing, holding (the fruit is hidden or lost),
        out_of_reach, or released (pulses are off).
    detections : int
        Fruits that are ok, in this picture.
    centre : ndarray, shape (3,), m
        Where the fruit's centre is expected, in the arm's frame; NaN without one.
    command : ndarray, shape (3,), m
        Where the tip was sent, with this frame or before; NaN for nowhere.
    sent : bool
        With this frame.
    gap : float, m
        Between surface and stand-off point; NaN without a fruit.
    q : ndarray, shape (3,), rad
        By the board's pulses.
    vision, track, ik, link : float, s
        Processor time of the loop's parts.
    note : str
        Why it does not move.

    Examples
    --------
    >>> from agrik_fast.drivers import PointingStep
    >>> PointingStep.__annotations__["gap"]
    'float'
    """

    time: float
    state: State
    detections: int
    centre: FloatArray
    command: FloatArray
    sent: bool
    gap: float
    q: FloatArray
    vision: float
    track: float
    ik: float
    link: float
    note: str = ""

    @property
    def seconds(self) -> float:
        """Processor time of all parts, s."""
        return self.vision + self.track + self.ik + self.link


class PointingLoop:
    """Points the tomato arm at a fruit that a camera sees, and stays before its surface.

    Only detections that are ``OK`` move the arm, and only from the third frame on. It goes to a
    point 40 mm before the surface first, then, slowly, to the stand-off point, whose gap follows
    from how sure the distance is. A command is sent at most once a frame, and only where the
    target moved by 2 mm.

    Parameters
    ----------
    rig : TomatoRig
        Connected.
    detector : Detector
        Of the camera.
    base_from_camera : array_like, shape (4, 4)
        Pose of the camera in the arm's frame.
    radius : float, m
        Of the fruits.
    radius_sigma : float, default 0.0, m
        Its standard deviation: the gap grows with it.
    tracker : Tracker, optional
        One of your own.
    lead : float, default 0.012, s
        From command to motion: places are predicted for the frame's age and this.
    dead_band_us : float, default 4.0, us
        Of the servos, see `TomatoRig.aim`.
    release_after : float, default 5.0, s
        Pulses are switched off when no fruit was seen for so long, or no picture came.

    Raises
    ------
    ArgumentError
        A number is out of its range.

    Examples
    --------
    >>> from agrik_fast.drivers import PointingLoop, Simulator, TomatoRig
    >>> from agrik_fast.vision import Detector, looking_at, paper_camera
    >>> pose = looking_at([-0.1, 0.0, 0.14], [0.25, 0.0, 0.06])
    >>> with TomatoRig(Simulator("tomato")) as rig:
    ...     rig.home()
    ...     loop = PointingLoop(rig, Detector(paper_camera()), pose, radius=0.03)
    """

    def __init__(
        self,
        rig: TomatoRig,
        detector: Detector,
        base_from_camera: ArrayLike,
        radius: float,
        *,
        radius_sigma: float = 0.0,
        tracker: Tracker | None = None,
        lead: float = 0.012,
        dead_band_us: float = 4.0,
        release_after: float = 5.0,
    ) -> None:
        for name, value, kind in (("rig", rig, TomatoRig), ("detector", detector, Detector)):
            if not isinstance(value, kind):
                raise ArgumentError(name, type(value).__name__, f"a {kind.__name__}")
        self.rig, self.detector = rig, detector
        self.pose = finite_array("base_from_camera", base_from_camera, (4, 4))
        turn = self.pose[:3, :3]
        if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) or np.linalg.det(turn) < 0:
            raise ArgumentError("base_from_camera", "a matrix that is no pose", "a rigid pose")
        self.radius = real_number("radius", radius, 0, open_low=True, unit="m")
        self.radius_sigma = real_number("radius_sigma", radius_sigma, 0, unit="m")
        if tracker is not None and not isinstance(tracker, Tracker):
            raise ArgumentError("tracker", type(tracker).__name__, "a vision.Tracker or None")
        self.tracker = Tracker() if tracker is None else tracker
        self.lead = real_number("lead", lead, 0, 1, unit="s")
        self.dead_band_us = real_number("dead_band_us", dead_band_us, 0, 50, unit="us")
        self.release_after = real_number("release_after", release_after, 0.1, 3600, unit="s")
        self._target: int | None = None
        self._near = False
        self._way: list[FloatArray] = []
        self._command = np.full(3, np.nan)
        self._centre: FloatArray | None = None
        self._sigma = 0.0
        self._seen = -math.inf
        self._released = False

    # ---- a frame -----------------------------------------------------------------------------

    def step(self, time: float, image: Image) -> PointingStep:
        """Look at one picture and send at most one command.

        Parameters
        ----------
        time : float, s
            When it was taken, by the clock of the rig's line.
        image : ndarray
            The picture.

        Raises
        ------
        RigError
            The line or the board failed.

        Examples
        --------
        >>> from agrik_fast.drivers import PointingLoop, Simulator, TomatoRig
        >>> from agrik_fast.vision import Detector, Scene, looking_at, paper_camera, render
        >>> pose = looking_at([-0.1, 0.0, 0.14], [0.25, 0.0, 0.06])
        >>> with TomatoRig(Simulator("tomato")) as rig:
        ...     rig.home()
        ...     loop = PointingLoop(rig, Detector(paper_camera()), pose, radius=0.03)
        ...     print(loop.step(rig.status().clock, render(Scene()).image).state)
        searching
        """
        begin = host_time.thread_time()
        found = [d for d in self.detector.detect(image) if d.status == DetectionStatus.OK]
        seen = host_time.thread_time()
        places = np.array([self._place(each) for each in found]).reshape(-1, 3)
        tracks = self.tracker.update(time, places)
        tracked = host_time.thread_time()
        status = self.rig.watch(dead_band_us=self.dead_band_us)
        looked = host_time.thread_time()
        now = self.rig.link.transport.now()
        track = self._chosen(tracks, status.q)
        if self._seen == -math.inf or (track is not None and track.misses == 0):
            self._seen = now
        idle = PointingStep(
            time,
            "searching",
            len(found),
            np.full(3, np.nan),
            self._command,
            False,
            math.nan,
            status.q,
            seen - begin,
            tracked - seen,
            0.0,
            looked - tracked,
        )
        if track is None or track.misses:
            return self._without(idle, now)
        if self.rig.touching():
            # The sensor at the tip knows better than a picture: nothing goes nearer.
            return replace(idle, state="pointing", note="the sensor at the tip says near")
        self._released = False
        nearest = min(
            zip(places, found, strict=True), key=lambda pair: math.dist(pair[0], track.position)
        )[1]
        self._sigma = range_sigma(nearest, self.radius, radius_sigma=self.radius_sigma)
        age = min(max(now - time, 0.0), 0.5)
        centre = track.at(time + age + self.lead)
        return self._pointed(idle, centre, looked, bool(status.moving))

    def run(
        self,
        camera: Iterable[Frame],
        *,
        frames: int | None = None,
        progress: Callable[[PointingStep], None] | None = None,
    ) -> list[PointingStep]:
        """Work through a camera's pictures.

        Parameters
        ----------
        camera : iterable of (time, image)
            Its pictures.
        frames : int, optional
            How many; all by default.
        progress : callable, optional
            Told of every step.

        Returns
        -------
        list of PointingStep

        Raises
        ------
        CameraError
            The camera delivers nothing or stalls: the arm held, and its pulses are off.
        RigError
            The line or the board failed.

        Examples
        --------
        >>> from agrik_fast.drivers import LockstepCamera, PointingLoop, Simulator, TomatoRig
        >>> from agrik_fast.vision import Detector, Scene, looking_at, paper_camera
        >>> simulator, pose = Simulator("tomato"), looking_at([-0.1, 0.0, 0.14], [0.25, 0.0, 0.06])
        >>> with TomatoRig(simulator) as rig:
        ...     rig.home()
        ...     loop = PointingLoop(rig, Detector(paper_camera()), pose, radius=0.03)
        ...     camera = paper_camera()
        ...     eye = LockstepCamera(simulator, lambda _: Scene(), camera, pose, frames=3)
        ...     print([step.state for step in loop.run(eye)])
        ['searching', 'searching', 'searching']
        """
        if frames is not None:
            frames = whole_number("frames", frames, 0)
        steps: list[PointingStep] = []
        pictures = _frames(camera)
        while frames is None or len(steps) < frames:
            try:
                when, image = next(pictures)
            except StopIteration:
                if not steps:
                    self._let_go()
                    raise CameraError("given", "delivers no picture") from None
                break
            except CameraError:
                self._let_go()
                raise
            steps.append(self.step(when, image))
            if progress:
                progress(steps[-1])
        return steps

    # ---- parts -------------------------------------------------------------------------------

    def _place(self, found: Detection) -> FloatArray:
        return np.asarray(self.pose[:3, :3] @ found.centre(self.radius) + self.pose[:3, 3])

    def _chosen(self, tracks: list[Track], q: FloatArray) -> Track | None:
        """Return the fruit that is pointed at: the one of before, or the nearest to the tip."""
        sure = [each for each in tracks if each.confirmed]
        for each in sure:
            if each.number == self._target:
                return each
        fresh = [each for each in sure if each.misses == 0]
        if not fresh:
            return None
        tip = self.rig.arm.fk(q) if np.isfinite(q).all() else np.zeros(3)
        chosen = min(fresh, key=lambda each: math.dist(each.position, tip))
        self._target, self._near, self._way, self._centre = chosen.number, False, [], None
        return chosen

    def _without(self, idle: PointingStep, now: float) -> PointingStep:
        """Hold where there is nothing to point at, and let go after long."""
        if now - self._seen > self.release_after and not self._released:
            self.rig.release()
            self._released, self._target = True, None
            self._command = np.full(3, np.nan)
        if self._released:
            return replace(idle, state="released", command=self._command)
        return replace(idle, state="searching" if self._target is None else "holding")

    def _let_go(self) -> None:
        """Hold for a while, since the next picture may come late, then end the pulses."""
        clock = self.rig.link.transport
        end = clock.now() + self.release_after
        while clock.now() < end:
            self.rig.watch(dead_band_us=self.dead_band_us)
            clock.sleep(0.1)
        self.rig.release()
        self._released = True

    def _pointed(
        self, idle: PointingStep, centre: FloatArray, begin: float, moving: bool
    ) -> PointingStep:
        """Return the step of a frame in which there is a fruit to point at."""
        origin = np.zeros(3)
        if float(np.linalg.norm(centre)) <= self.radius:
            return replace(idle, state="out_of_reach", centre=centre, note="around the shoulder")
        if (
            self._centre is not None
            and self._near
            and math.dist(centre, self._centre) > _LARGEST_JUMP
        ):
            return replace(idle, state="holding", centre=centre, note="it cannot have moved so far")
        points = stand_off(centre, self.radius, origin=origin, sigma=self._sigma)
        idle = replace(idle, centre=centre, gap=points.gap)
        try:
            sent, near = self._next(points, centre, idle.q, moving)
        except OutOfReachError as error:
            return replace(idle, state="out_of_reach", note=str(error))
        solved = host_time.thread_time()
        if sent is not None:
            self.rig.aim(sent, near=near, dead_band_us=self.dead_band_us)
        ended = host_time.thread_time()
        return replace(
            idle,
            state="pointing" if self._near else "approaching",
            command=self._command,
            sent=sent is not None,
            ik=solved - begin,
            link=idle.link + ended - solved,
        )

    def _next(
        self, points: StandOff, centre: FloatArray, q: FloatArray, moving: bool
    ) -> tuple[FloatArray | None, bool]:
        """Return the joint values to send, or None, and whether slowly."""
        solve = self.rig.solve
        final = solve(points.final)
        if self._way and moving:
            return None, False
        if self._way:
            return self._way.pop(0), False
        if not self._near:
            first = solve(points.first)
            moved = self._centre is None or math.dist(centre, self._centre) > _LEAST_MOVE
            if self._centre is not None and not moving:
                tip = self.rig.arm.fk(q)
                if math.dist(tip, points.first) < _ARRIVED + _LEAST_MOVE:
                    self._near, self._centre = True, centre
                    self._command = points.final
                    return final, True
            if not moved:
                return None, False
            self._centre, self._command = centre, points.first
            self._way = self._around(q, first, centre, points.gap)
            return self._way.pop(0), False
        if self._centre is not None and math.dist(centre, self._centre) <= _LEAST_MOVE:
            return None, True
        self._centre, self._command = centre, points.final
        return final, True

    def _around(
        self, q: FloatArray, first: FloatArray, centre: FloatArray, gap: float
    ) -> list[FloatArray]:
        """Return joint values on a way to `first` that keeps clear of the fruit."""
        if not np.isfinite(q).all():
            return [first]
        ways: list[list[FloatArray]] = [[first]]
        tip = self.rig.arm.fk(q)
        here, there = (
            _DRAWN_BACK * point / max(float(np.linalg.norm(point)), 1e-9) for point in (tip, centre)
        )
        back: list[FloatArray] = []
        for point in (here, there):
            try:
                back.append(self.rig.solve(point))
            except OutOfReachError:
                return [first]
        ways += [[back[1], first], [*back, first]]
        for way in ways:
            if self._clear([q, *way], centre, self.radius + gap):
                return way
        return ways[-1]

    def _clear(self, way: list[FloatArray], centre: FloatArray, least: float) -> bool:
        """Whether tip and links stay away from a ball while joints turn at the board's rate."""
        arm = self.rig.arm
        for start, end in pairwise(way):
            longest = max(float(np.abs(end - start).max()), 1e-9)
            turned = np.linspace(0, longest, _WAY_POINTS)[:, None]
            joints = start + np.sign(end - start) * np.minimum(np.abs(end - start), turned)
            reach, height = arm.l1 * np.cos(joints[:, 0]), arm.l1 * np.sin(joints[:, 0])
            pan = joints[:, 2]
            elbows = np.stack([reach * np.cos(pan), reach * np.sin(pan), height], axis=1)
            tips = arm.fk(joints)
            for share in (0.0, 0.5, 1.0):
                points = elbows + share * (tips - elbows)
                if float(np.linalg.norm(points - centre, axis=1).min()) < least:
                    return False
        return True


def _frames(camera: object) -> Iterator[Frame]:
    """Return the pictures of a camera, which are pairs of a time and an image."""
    expected = "an iterable of (time, image)"
    if isinstance(camera, str | bytes) or not isinstance(camera, Iterable):
        raise ArgumentError("camera", shown(camera), expected)
    try:
        each = iter(camera)
    except TypeError:
        raise ArgumentError("camera", shown(camera), expected) from None
    for frame in each:
        if not isinstance(frame, tuple) or len(frame) != 2:
            raise ArgumentError("camera", f"{shown(frame)} out of it", expected)
        yield frame
