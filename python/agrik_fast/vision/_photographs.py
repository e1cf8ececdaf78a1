"""Photographs of one's own with boxes round their fruits: how a detector does on them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, items
from .._checks import path as checked_path
from ._adapters import checked_boxes
from ._camera import Camera
from ._detection import Detection, DetectionStatus
from ._errors import VisionFileError
from ._images import Image, of_kind
from ._scenes import rim_of
from ._sources import folder_images, read_image
from ._tables import read_numbers

__all__ = ["Agreement", "Photograph", "agreement", "photographs", "read_boxes"]

BOX_COLUMNS = ("left", "top", "right", "bottom")
# Two boxes are of one fruit where they share half of what they cover together.
_SAME = 0.5


class Photograph(NamedTuple):
    """A picture and what a person marked in it.

    Attributes
    ----------
    name : str
        Of the file.
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.
    boxes : ndarray, shape (n, 4), pixels
        left, top, right, bottom of every fruit.

    Examples
    --------
    >>> from agrik_fast.vision import Photograph
    >>> Photograph("a.jpg", np.zeros((16, 16, 3), dtype=np.uint8), np.zeros((0, 4))).name
    'a.jpg'
    """

    name: str
    image: Image
    boxes: FloatArray


@dataclass(frozen=True)
class Agreement:
    """How detections agree with boxes.

    Attributes
    ----------
    boxes : int
        Fruits that were marked.
    ok : int
        Of them found ``OK``.
    unsure : int
        Of them found ``WEAK`` or ``EDGE``.
    wrong : int
        Detections that are ``OK`` where there is no box.
    centre_px : ndarray, shape (ok,), pixels
        How far centres that are ok are from their boxes' middles.
    radius_percent : ndarray, shape (ok,)
        By how much their boxes are larger or smaller than those marked.

    Examples
    --------
    >>> from agrik_fast.vision import Agreement
    >>> one = Agreement(3, 2, 0, 1, np.array([0.4, 0.8]), np.array([1.0, -2.0]))
    >>> (one + one).missed
    2
    """

    boxes: int
    ok: int
    unsure: int
    wrong: int
    centre_px: FloatArray
    radius_percent: FloatArray

    @property
    def missed(self) -> int:
        """Fruits that were marked and not found."""
        return self.boxes - self.ok - self.unsure

    def __add__(self, other: Agreement) -> Agreement:
        """Return that of both."""
        return Agreement(
            self.boxes + other.boxes,
            self.ok + other.ok,
            self.unsure + other.unsure,
            self.wrong + other.wrong,
            np.concatenate([self.centre_px, other.centre_px]),
            np.concatenate([self.radius_percent, other.radius_percent]),
        )

    def __str__(self) -> str:
        """Return it in one line."""
        said = (
            f"{self.ok} of {self.boxes} boxes ok, {self.unsure} weak or edge, "
            f"{self.missed} missed, {self.wrong} ok where there is no box"
        )
        if not self.ok:
            return said
        centre = np.percentile(self.centre_px, [50, 95])
        radius = np.percentile(np.abs(self.radius_percent), [50, 95])
        return (
            f"{said}; centre {centre[0]:.1f} px, 95 % {centre[1]:.1f}; "
            f"radius {radius[0]:.1f} %, 95 % {radius[1]:.1f}"
        )


def read_boxes(file: str | Path) -> dict[str, FloatArray]:
    r"""Return the boxes of a CSV file by the names of their pictures, shape (n, 4), pixels.

    Parameters
    ----------
    file : str or path
        With the columns image, left, top, right, bottom.

    Raises
    ------
    VisionFileError
        It cannot be read, or a box is none; names row and column.

    Examples
    --------
    >>> from pathlib import Path
    >>> from agrik_fast.vision import read_boxes
    >>> _ = Path("boxes.csv").write_text("image,left,top,right,bottom\na.jpg,10,20,50,61\n")
    >>> read_boxes("boxes.csv")["a.jpg"].tolist()
    [[10.0, 20.0, 50.0, 61.0]]
    """
    name = checked_path("file", file)
    rows, labels = read_numbers(name, BOX_COLUMNS, "image", labelled=True)
    for number, (left, top, right, bottom) in enumerate(rows.tolist(), 1):
        if not (left < right and top < bottom):
            reason = f"row {number}: {[left, top, right, bottom]}, not left < right, top < bottom"
            raise VisionFileError(str(file), reason)
    images = np.array(labels)
    return {label: rows[images == label] for label in dict.fromkeys(labels)}


def photographs(folder: str | Path, boxes: str | Path) -> Iterator[Photograph]:
    r"""Return a folder's pictures, in the order of their names, with their boxes.

    Parameters
    ----------
    folder : str or path
        Of pictures; one without a row in `boxes` shows no ripe fruit.
    boxes : str or path
        A file as for `read_boxes`.

    Raises
    ------
    CameraError
        It is no folder, or holds no picture.
    VisionFileError
        A file cannot be read, or `boxes` names a picture that is not there.

    Examples
    --------
    >>> from pathlib import Path
    >>> from agrik_fast.vision import photographs, random_scene, render, write_image
    >>> Path("own").mkdir()
    >>> _ = write_image("own/a.png", render(random_scene("clean", seed=1)).image)
    >>> _ = Path("boxes.csv").write_text("image,left,top,right,bottom\na.png,10,20,50,61\n")
    >>> [(each.name, len(each.boxes)) for each in photographs("own", "boxes.csv")]
    [('a.png', 1)]
    """
    files, marked = folder_images(folder), read_boxes(boxes)
    unknown = sorted(set(marked) - {file.name for file in files})
    if unknown:
        raise VisionFileError(str(boxes), f"{unknown[0]} is no picture in {folder}")
    none = np.zeros((0, 4))
    return (Photograph(each.name, read_image(each), marked.get(each.name, none)) for each in files)


def agreement(found: Iterable[Detection], boxes: ArrayLike, camera: Camera) -> Agreement:
    """Return how a picture's detections agree with boxes.

    A detection and a box are of one fruit where they share half of what they cover together;
    those that share most come first.

    Parameters
    ----------
    found : iterable of Detection
        Of `Detector.detect`.
    boxes : array_like, shape (n, 4), pixels
        left, top, right, bottom of the whole fruits, also where leaves hide a part.
    camera : Camera
        Who took the picture.

    Raises
    ------
    ArgumentError
        Another shape, or a box that is none.

    Examples
    --------
    >>> from agrik_fast.vision import Detector, agreement, paper_camera, random_scene, render
    >>> camera, picture = paper_camera(), render(random_scene("clean", seed=1))
    >>> truth = picture.fruits[0]
    >>> around = [*(truth.uv - 28), *(truth.uv + 28)]
    >>> agreement(Detector(camera).detect(picture.image), [around], camera).missed
    0
    """
    of_kind("camera", camera, Camera)
    rows = checked_boxes(boxes)
    seen = list(items("found", found, "detections"))
    for number, each in enumerate(seen):
        of_kind(f"found[{number}]", each, Detection)
    around = np.array([_box(each, camera) for each in seen]).reshape(-1, 4)
    pairs = sorted(
        (
            (_shared(one, other), i, k)
            for i, one in enumerate(around)
            for k, other in enumerate(rows)
        ),
        reverse=True,
    )
    of_box: dict[int, int] = {}
    for share, i, k in pairs:
        if share >= _SAME and i not in of_box.values() and k not in of_box:
            of_box[k] = i
    sure = {k: i for k, i in of_box.items() if seen[i].status == DetectionStatus.OK}
    ok = sum(each.status == DetectionStatus.OK for each in seen)
    middles = {k: (rows[k, :2] + rows[k, 2:]) / 2 for k in sure}
    off = [float(np.hypot(*(seen[i].uv - middles[k]))) for k, i in sure.items()]
    sizes = [100 * float(np.sqrt(_area(around[i]) / _area(rows[k])) - 1) for k, i in sure.items()]
    return Agreement(
        len(rows),
        len(sure),
        len(of_box) - len(sure),
        ok - len(sure),
        np.array(off, dtype=float),
        np.array(sizes, dtype=float),
    )


def _box(found: Detection, camera: Camera) -> FloatArray:
    uv = camera.project(rim_of(found.axis, found.alpha, 48))
    return np.concatenate([uv.min(axis=0), uv.max(axis=0)])


def _area(box: FloatArray) -> float:
    return float(np.prod(np.maximum(box[2:] - box[:2], 0)))


def _shared(one: FloatArray, other: FloatArray) -> float:
    both = _area(np.concatenate([np.maximum(one[:2], other[:2]), np.minimum(one[2:], other[2:])]))
    return both / (_area(one) + _area(other) - both)
