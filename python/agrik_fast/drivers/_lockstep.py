"""A camera before the simulated rig: pictures of the renderer at the simulator's time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from .._checks import finite_array, real_number, shown, whole_number
from ..errors import ArgumentError
from ..vision import Camera, Frame, Scene, render
from ._transport import Transport

__all__ = ["LockstepCamera"]


class LockstepCamera:
    """An iterator of (time, picture) by which a rig's simulated time goes on.

    Parameters
    ----------
    clock : Transport
        The rig's line, whose time counts.
    scene : callable
        Returns the `Scene` at a time (s).
    camera : Camera
        Who looks.
    pose : array_like, shape (4, 4)
        Of the camera, in the scene's frame.
    rate : float, default 30.0, 1/s
        Pictures a second.
    age : float, default 0.022, s
        How old a picture is when it is handed out: exposure, reading, the driver's queue.
    frames : int, optional
        How many; without end by default.

    Examples
    --------
    >>> from agrik_fast.drivers import LockstepCamera, Simulator
    >>> from agrik_fast.vision import paper_camera, random_scene
    >>> with Simulator("tomato") as simulator:
    ...     scene, pose = random_scene("clean", seed=1), np.eye(4)
    ...     camera = paper_camera()
    ...     frames = LockstepCamera(simulator, lambda _: scene, camera, pose, frames=2)
    ...     print([picture.shape for time, picture in frames])
    [(240, 320, 3), (240, 320, 3)]
    """

    def __init__(
        self,
        clock: Transport,
        scene: Callable[[float], Scene],
        camera: Camera,
        pose: ArrayLike,
        *,
        rate: float = 30.0,
        age: float = 0.022,
        frames: int | None = None,
    ) -> None:
        if not callable(getattr(clock, "now", None)):
            raise ArgumentError("clock", shown(clock), "a Transport")
        if not callable(scene):
            raise ArgumentError("scene", shown(scene), "a function of the time")
        if not isinstance(camera, Camera):
            raise ArgumentError("camera", shown(camera), "a vision.Camera")
        self.clock, self.scene, self.camera = clock, scene, camera
        self.pose = finite_array("pose", pose, (4, 4))
        self.rate = real_number("rate", rate, 0, 1000, open_low=True, unit="1/s")
        self.age = real_number("age", age, 0, 1, unit="s")
        self.frames = None if frames is None else whole_number("frames", frames, 0)
        self._number = 0
        self._begin = clock.now()

    def __iter__(self) -> Iterator[Frame]:
        return self

    def __next__(self) -> Frame:
        if self.frames is not None and self._number >= self.frames:
            raise StopIteration
        due = self._begin + self._number / self.rate + self.age
        left = due - self.clock.now()
        if left > 0:
            self.clock.sleep(left)
        when = max(due - self.age, 0.0)
        scene = self.scene(when)
        picture = render(scene, self.camera, pose=self.pose, frame=self._number)
        self._number += 1
        return when, np.asarray(picture.image)
