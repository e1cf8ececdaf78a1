"""``agrik-fast detect``: ripe fruits in pictures, drawn and written as a table."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import AgrikError, ArgumentError
from ..vision import (
    DETECTION_COLUMNS,
    Agreement,
    Camera,
    Detector,
    VisionFileError,
    agreement,
    annotated,
    detection_row,
    folder_images,
    read_boxes,
    read_image,
    write_image,
)

TABLE = "detections.csv"


@dataclass(frozen=True)
class DetectRequest:
    """What the command was asked for."""

    images: Sequence[Path]
    output: Path
    camera: Path | None = None
    view_deg: float = 60.0
    radius_mm: float | None = None
    boxes: Path | None = None
    force: bool = False


def detect(request: DetectRequest, report: Callable[[str], None]) -> list[Path]:
    """Look at pictures, and return the files written.

    Raises
    ------
    AgrikError
        A file is no picture, of another size than the calibration, or cannot be written.
    """
    names = _pictures(request.images)
    out = request.output
    if out.exists() and not out.is_dir():
        raise ArgumentError("output", f"the file {out}", "a folder")
    if out.is_dir() and any(out.iterdir()) and not request.force:
        raise ArgumentError(
            "output", f"{out}, which holds files", "an empty or new folder (or --force)"
        )
    radius = None
    if request.radius_mm is not None:
        if not 0 < request.radius_mm < 1000:
            raise ArgumentError("--radius-mm", f"{request.radius_mm:g}", "> 0 and < 1000 mm")
        radius = request.radius_mm / 1000
    calibrated = None if request.camera is None else Camera.load(request.camera)
    boxes = None if request.boxes is None else read_boxes(request.boxes)
    unknown = sorted(set(boxes or ()) - {name.name for name in names})
    if unknown:
        raise VisionFileError(str(request.boxes), f"{unknown[0]} is none of the pictures")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArgumentError("output", str(out), f"a folder ({error.strerror})") from None
    rows, written, seen = [], [], Counter[str]()
    agreed: list[Agreement] = []
    for name in names:
        image = read_image(name)
        height, width = image.shape[:2]
        camera = calibrated or Camera.of_view(width, height, request.view_deg)
        try:
            found = Detector(camera).detect(image)
        except ArgumentError as error:
            raise AgrikError(f"{name}: {error}") from None
        rows += [detection_row(name.name, i, each, radius) for i, each in enumerate(found)] or [
            detection_row(name.name, 0, None, radius)
        ]
        seen[name.stem] += 1
        again = f"-{seen[name.stem]}" if seen[name.stem] > 1 else ""
        file = out / f"{name.stem}{again}-detected.png"
        written.append(write_image(file, annotated(image, camera, found)))
        counts = Counter(each.status.name.lower() for each in found)
        said = ", ".join(f"{count} {status}" for status, count in counts.items())
        report(f"{name}: {said or 'not_found'}")
        if boxes is not None:
            agreed.append(agreement(found, boxes.get(name.name, ()), camera))
    table = out / TABLE
    try:
        with table.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows([DETECTION_COLUMNS, *rows])
    except OSError as error:
        raise AgrikError(f"{table}: {error.strerror}") from None
    if agreed:
        report(f"{request.boxes}: {sum(agreed[1:], agreed[0])}")
    return [table, *written]


def _pictures(given: Sequence[Path]) -> list[Path]:
    """Return the names of pictures; folders stand for theirs."""
    names: list[Path] = []
    for each in given:
        names += folder_images(each) if each.is_dir() else [each]
    return names
