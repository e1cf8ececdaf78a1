"""What was found, drawn into its picture and written as a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .._checks import items, real_number, text, whole_number
from .._checks import path as checked_path
from ._camera import Camera
from ._cv import opencv
from ._detection import Detection, DetectionStatus
from ._errors import VisionFileError
from ._images import Image, checked_image, of_kind
from ._scenes import rim_of

__all__ = ["DETECTION_COLUMNS", "annotated", "detection_row", "write_image"]

_COLOURS = {
    DetectionStatus.OK: (255, 255, 255),
    DetectionStatus.WEAK: (0, 220, 255),
    DetectionStatus.EDGE: (255, 200, 60),
}

DETECTION_COLUMNS = (
    "image",
    "number",
    "status",
    "kind",
    "u_px",
    "v_px",
    "radius_px",
    "alpha_rad",
    "cover",
    "fill",
    "score",
    "x_m",
    "y_m",
    "z_m",
)
"""Columns of a table of detections; the last three are in the camera's frame."""


def detection_row(
    image: str, number: int, found: Detection | None, radius: float | None
) -> list[str]:
    """Return a row of the table; no detection is a row of its own, ``not_found``.

    Parameters
    ----------
    image : str
        The picture's name.
    number : int
        Of the detection in it, from 0.
    found : Detection or None
        What was found.
    radius : float, m, or None
        The fruits' radius; places are left empty without one.

    Examples
    --------
    >>> from agrik_fast.vision import detection_row
    >>> "not_found" in detection_row("empty.png", 0, None, 0.03)
    True
    """
    image, number = text("image", image), whole_number("number", number, 0)
    if radius is not None:
        radius = real_number("radius", radius, 0, open_low=True, unit="m")
    if found is None:
        return [image, "", "not_found", *[""] * (len(DETECTION_COLUMNS) - 3)]
    of_kind("found", found, Detection)
    place = [""] * 3 if radius is None else [f"{value:.6f}" for value in found.centre(radius)]
    return [
        image,
        str(number),
        found.status.name.lower(),
        found.kind,
        *(f"{value:.3f}" for value in (*found.uv, found.radius_px)),
        f"{found.alpha:.6f}",
        *(f"{value:.3f}" for value in (found.cover, found.fill, found.score)),
        *place,
    ]


def annotated(image: Image, camera: Camera, found: Sequence[Detection]) -> Image:
    """Return a copy of a picture with every detection's outline, centre and status in it.

    Outlines are those of cones: exact for the camera's perspective and distortion. White is ok,
    yellow weak, blue cut by the border.

    Parameters
    ----------
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.
    camera : Camera
        Who took it.
    found : sequence of Detection
        What to draw.

    Examples
    --------
    >>> from agrik_fast.vision import Detector, annotated, paper_camera, random_scene, render
    >>> camera, picture = paper_camera(), render(random_scene("clean", seed=1))
    >>> found = Detector(camera).detect(picture.image)
    >>> annotated(picture.image, camera, found).shape
    (240, 320, 3)
    """
    cv2 = opencv()
    picture: Image = checked_image("image", image).copy()
    of_kind("camera", camera, Camera)
    for number, each in enumerate(items("found", found, "detections")):
        of_kind(f"found[{number}]", each, Detection)
        colour = _COLOURS[each.status]
        line = np.rint(16 * camera.project(rim_of(each.axis, each.alpha, 120))).astype(np.int32)[
            :, None
        ]
        cv2.polylines(picture, [line], True, colour, 1, cv2.LINE_AA, 4)
        u, v = (round(float(value)) for value in each.uv)
        cv2.drawMarker(picture, (u, v), colour, cv2.MARKER_CROSS, 9, 1)
        label = f"{number} {each.status.name.lower()}"
        place = (max(u - 20, 1), max(round(v - each.radius_px) - 4, 9))
        cv2.putText(picture, label, place, cv2.FONT_HERSHEY_SIMPLEX, 0.35, colour, 1, cv2.LINE_AA)
    return picture


def write_image(file: str | Path, image: Image) -> Path:
    """Write a picture in the form that its suffix names.

    Raises
    ------
    VisionFileError
        It cannot be written.

    Examples
    --------
    >>> from agrik_fast.vision import write_image
    >>> write_image("white.png", np.full((16, 16, 3), 255, dtype=np.uint8)).name
    'white.png'
    """
    cv2 = opencv()
    path = checked_path("file", file)
    try:
        good, data = cv2.imencode(path.suffix or ".png", checked_image("image", image))
    except cv2.error:
        good, data = False, None
    if not good or data is None:
        raise VisionFileError(str(path), f"no form of pictures is called {path.suffix}")
    try:
        path.write_bytes(data.tobytes())
    except OSError as error:
        raise VisionFileError(str(path), error.strerror or str(error)) from None
    return path
