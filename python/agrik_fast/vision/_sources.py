"""Cameras: iterators of (time, picture) from files, folders, devices and the renderer."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from .._checks import finite_array, items, real_number, shown, whole_number
from .._checks import path as checked_path
from ..errors import ArgumentError
from ._camera import Camera
from ._cv import opencv
from ._errors import CameraError, VisionFileError
from ._images import Image, checked_image, of_kind
from ._render import render
from ._scenes import Scene

__all__ = ["Device", "Frame", "files", "folder", "folder_images", "read_image", "rendered"]

Frame: TypeAlias = tuple[float, Image]
"""Time in seconds, and a picture."""

SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".ppm")


def read_image(file: str | Path) -> Image:
    """Return the picture of a file.

    Raises
    ------
    VisionFileError
        It is not there, or no picture.

    Examples
    --------
    >>> from agrik_fast.vision import read_image, write_image
    >>> _ = write_image("red.png", np.full((16, 16, 3), 255, dtype=np.uint8))
    >>> read_image("red.png").shape
    (16, 16, 3)
    """
    name = checked_path("file", file)
    try:
        data = name.read_bytes()
    except OSError as error:
        raise VisionFileError(str(file), error.strerror or str(error)) from None
    cv2 = opencv()
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
    if image is None:
        raise VisionFileError(str(file), "no picture that OpenCV can read")
    try:
        return checked_image("image", image)
    except ArgumentError as error:
        raise VisionFileError(str(file), f"{error.received}, not {error.expected}") from None


def files(paths: Iterable[str | Path], rate: float = 30.0) -> Iterator[Frame]:
    """Return the pictures of files, one after another.

    Parameters
    ----------
    paths : iterable of str or path
        Their names.
    rate : float, default 30.0, 1/s
        Pictures a second, by which they get their times.

    Raises
    ------
    CameraError
        There are none.
    VisionFileError
        A file is no picture.

    Examples
    --------
    >>> from agrik_fast.vision import files, random_scene, render, write_image
    >>> _ = write_image("one.png", render(random_scene("clean", seed=1)).image)
    >>> [picture.shape for time, picture in files(["one.png"])]
    [(240, 320, 3)]
    """
    given = items("paths", paths, "names of files")
    rate = real_number("rate", rate, 0, open_low=True, unit="1/s")
    names = [checked_path("paths", each) for each in given]
    if not names:
        raise CameraError("files", "no pictures were given")
    return ((number / rate, read_image(name)) for number, name in enumerate(names))


def folder_images(path: str | Path) -> list[Path]:
    """Return the names of a folder's pictures, in order.

    Parameters
    ----------
    path : str or path
        Its name; files of other suffixes than those of pictures are passed over.

    Raises
    ------
    CameraError
        It is no folder, or holds no picture.

    Examples
    --------
    >>> from agrik_fast.vision import folder_images, random_scene, render, write_image
    >>> from pathlib import Path
    >>> Path("pictures").mkdir()
    >>> _ = write_image("pictures/one.png", render(random_scene("clean", seed=1)).image)
    >>> [path.name for path in folder_images("pictures")]
    ['one.png']
    """
    place = checked_path("path", path)
    if not place.is_dir():
        raise CameraError(str(path), "no such folder")
    names = sorted(each for each in place.iterdir() if each.suffix.lower() in SUFFIXES)
    if not names:
        raise CameraError(str(path), f"a folder without pictures ({', '.join(SUFFIXES)})")
    return names


def folder(path: str | Path, rate: float = 30.0) -> Iterator[Frame]:
    """Return the pictures of a folder in the order of their names.

    Parameters
    ----------
    path, rate
        As for `folder_images` and `files`.

    Raises
    ------
    CameraError
        It is no folder, or holds no picture.

    Examples
    --------
    >>> from agrik_fast.vision import folder, random_scene, render, write_image
    >>> from pathlib import Path
    >>> Path("pictures").mkdir()
    >>> _ = write_image("pictures/one.png", render(random_scene("clean", seed=1)).image)
    >>> len(list(folder("pictures")))
    1
    """
    return files(folder_images(path), rate)


def rendered(
    scene: Scene | Callable[[float], Scene],
    camera: Camera,
    *,
    pose: ArrayLike | None = None,
    rate: float = 30.0,
    frames: int | None = None,
) -> Iterator[Frame]:
    """Return pictures that the renderer makes.

    Parameters
    ----------
    scene : Scene or callable
        What there is, or a function that says it for a time (s).
    camera, pose
        As for `render`.
    rate : float, default 30.0, 1/s
        Pictures a second.
    frames : int, optional
        How many; without end by default.

    Examples
    --------
    >>> from agrik_fast.vision import paper_camera, random_scene, rendered
    >>> frames = rendered(random_scene("clean", seed=1), paper_camera(), frames=2)
    >>> len(list(frames))
    2
    """
    of_kind("camera", camera, Camera)
    if not callable(scene):
        of_kind("scene", scene, Scene)
    place = None if pose is None else finite_array("pose", pose, (4, 4))
    rate = real_number("rate", rate, 0, open_low=True, unit="1/s")
    if frames is not None:
        frames = whole_number("frames", frames, 0)

    def picture(number: int) -> Frame:
        when = number / rate
        there = scene(when) if callable(scene) else scene
        return when, render(there, camera, pose=place, frame=number).image

    return map(picture, count() if frames is None else range(frames))


class Device:
    """A camera or a video by `cv2.VideoCapture`: the newest picture only.

    A thread takes every picture from the driver, so that none waits there and grows old. As a
    context manager it gives the camera up when the block ends.

    Parameters
    ----------
    source : int or str
        Number of a device, or what OpenCV takes: a file, an address.
    width, height : int, optional
        Size to ask the driver for; another one that comes is an error.
    patience : float, default 2.0, s
        How long it may deliver nothing.

    Raises
    ------
    CameraError
        It cannot be opened; while reading: it stalls, or delivers another size.

    Examples
    --------
    >>> from agrik_fast.vision import CameraError, Device
    >>> try:
    ...     Device("no_such_video.avi")
    ... except CameraError as error:
    ...     print(type(error).__name__)
    CameraError
    """

    def __init__(
        self,
        source: int | str,
        *,
        width: int | None = None,
        height: int | None = None,
        patience: float = 2.0,
    ) -> None:
        given: object = source
        if isinstance(given, bool) or not isinstance(given, int | str):
            raise ArgumentError("source", shown(source), "the number of a device, or a name")
        cv2 = opencv()
        self.name = str(source)
        self.patience = real_number("patience", patience, 0, open_low=True, unit="s")
        self._size = (width, height)
        for name, value in (("width", width), ("height", height)):
            if value is not None:
                whole_number(name, value, 1, 20000)
        self._capture: Any = cv2.VideoCapture(source)
        if not self._capture.isOpened():
            raise CameraError(self.name, "cannot be opened")
        self._capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        if width is not None and height is not None:
            self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, width)
            self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, height)
        # A video is read picture by picture: it has no newest one.
        rate = float(self._capture.get(cv2.CAP_PROP_FPS))
        self._is_file = isinstance(source, str) and Path(source).is_file()
        self._rate = rate if np.isfinite(rate) and 1 <= rate <= 1000 else 30.0
        self._fresh = threading.Condition()
        self._frame: Frame | None = None
        self._ended = False
        self._count = 0
        self._thread: threading.Thread | None = None
        if not self._is_file:
            self._thread = threading.Thread(target=self._grab, daemon=True, name="camera")
            self._thread.start()

    def _grab(self) -> None:
        while not self._ended:
            good, image = self._capture.read()
            with self._fresh:
                if good:
                    self._frame = time.monotonic(), image
                else:
                    self._ended = True
                self._fresh.notify_all()

    def __iter__(self) -> Iterator[Frame]:
        return self

    def __next__(self) -> Frame:
        if self._is_file:
            good, image = self._capture.read()
            if not good:
                if self._count == 0:
                    raise CameraError(self.name, "delivers no picture")
                raise StopIteration
            self._count += 1
            return self._checked((self._count - 1) / self._rate, image)
        with self._fresh:
            self._fresh.wait_for(lambda: self._frame is not None or self._ended, self.patience)
            if self._frame is None:
                why = "delivers no picture" if self._count == 0 else "delivers no more pictures"
                raise CameraError(self.name, f"{why} (waited {self.patience:g} s)")
            when, image = self._frame
            self._frame = None
        self._count += 1
        return self._checked(when, image)

    def _checked(self, when: float, image: Any) -> Frame:
        picture = checked_image("image", image)
        wanted = self._size
        if None not in wanted and (picture.shape[1], picture.shape[0]) != wanted:
            came = f"{picture.shape[1]} x {picture.shape[0]}"
            raise CameraError(self.name, f"delivers {came} pixels, not {wanted[0]} x {wanted[1]}")
        return when, picture

    def close(self) -> None:
        """Give the camera up.

        Examples
        --------
        >>> from agrik_fast.vision import CameraError, Device
        >>> try:
        ...     Device("no_such_video.avi").close()
        ... except CameraError:
        ...     print("no camera")
        no camera
        """
        self._ended = True
        if self._thread is not None:
            self._thread.join(timeout=self.patience)
        if self._thread is None or not self._thread.is_alive():
            # A thread inside the driver cannot be ended, and must not lose it under its feet.
            self._capture.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
