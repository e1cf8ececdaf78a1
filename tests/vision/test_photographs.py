"""Photographs with boxes that somebody marked: loaded, and compared with what is found."""

import csv
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.errors import ArgumentError
from agrik_fast.vision import (
    CameraError,
    Detection,
    DetectionStatus,
    Detector,
    VisionFileError,
    agreement,
    from_boxes,
    paper_camera,
    photographs,
    random_scene,
    read_boxes,
    render,
    write_image,
)
from cli_runner import one_line, run_command

CAMERA = paper_camera()


def box(camera_uv: np.ndarray, radius_px: float) -> list[float]:
    return [*(camera_uv - radius_px), *(camera_uv + radius_px)]


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """Return a folder with a cluster of marked fruits, and a picture without any."""
    folder = tmp_path / "own"
    folder.mkdir()
    rows = []
    for name, kind in (("a.png", "cluster"), ("b.png", "green")):
        picture = render(random_scene(kind, 4), CAMERA)
        write_image(folder / name, picture.image)
        for each in picture.fruits:
            if each.red:
                size = CAMERA.focal * float(np.tan(each.angular_radius))
                rows.append([name, *box(each.uv, size)])
    with (tmp_path / "boxes.csv").open("w", newline="") as stream:
        columns = ["image", "left", "top", "right", "bottom"]
        csv.writer(stream).writerows([columns, *rows])
    return folder


def test_marked_fruits_are_found(own: Path) -> None:
    pictures = list(photographs(own, own.parent / "boxes.csv"))
    assert [each.name for each in pictures] == ["a.png", "b.png"]
    assert len(pictures[0].boxes) >= 2
    assert pictures[1].boxes.shape == (0, 4)
    detector = Detector(CAMERA)
    one, other = (agreement(detector.detect(p.image), p.boxes, CAMERA) for p in pictures)
    assert (one.boxes, one.ok, one.missed, one.wrong) == (len(pictures[0].boxes),) * 2 + (0, 0)
    assert one.centre_px.max() < 2.5
    assert np.abs(one.radius_percent).max() < 8
    both = one + other
    assert both.boxes == one.boxes
    assert f"{one.ok} of {one.boxes} boxes ok" in str(both)
    assert str(other) == "0 of 0 boxes ok, 0 weak or edge, 0 missed, 0 ok where there is no box"


def test_how_boxes_and_detections_are_matched() -> None:
    def found(*boxes: list[float], trusted: bool = True) -> list[Detection]:
        return from_boxes(boxes, CAMERA, trusted=trusted)

    a, b = [100.0, 80.0, 140.0, 120.0], [200.0, 80.0, 240.0, 120.0]
    same = agreement(found(a), [a, b], CAMERA)
    assert (same.ok, same.unsure, same.missed, same.wrong) == (1, 0, 1, 0)
    assert same.centre_px[0] < 0.6
    unsure = agreement(found(a, trusted=False), [a], CAMERA)
    assert (unsure.ok, unsure.unsure, unsure.missed, unsure.wrong) == (0, 1, 0, 0)
    # Half a fruit beside it is another one.
    beside = [120.0, 80.0, 160.0, 120.0]
    assert agreement(found(beside), [a], CAMERA).wrong == 1
    # Two on one box: the better one counts, the other is wrong.
    near = [104.0, 80.0, 144.0, 120.0]
    two = agreement(found(near, a), [a], CAMERA)
    assert (two.ok, two.wrong) == (1, 1)
    assert two.centre_px[0] < 0.6
    larger = agreement(found([96.0, 76.0, 144.0, 124.0]), [a], CAMERA)
    assert larger.radius_percent[0] == pytest.approx(20, abs=1.5)
    with pytest.raises(ArgumentError, match=r"`boxes\[0\]`"):
        agreement(found(a), [[3, 3, 2, 9]], CAMERA)
    with pytest.raises(ArgumentError, match=r"`found\[0\]`"):
        agreement([DetectionStatus.OK], [a], CAMERA)  # type: ignore[list-item]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("left,top,right,bottom\n1,2,3,4\n", "no column image"),
        ("image,left,top\n", "no column right, bottom"),
        ("image,left,top,right,bottom\na.png,1,2,x,4\n", "row 1, column right: 'x' is no number"),
        ("image,left,top,right,bottom\na.png,1,2,3\n", "row 1, column bottom: None is no number"),
        ("image,left,top,right,bottom\n,1,2,3,4\n", "row 1, column image: empty"),
        ("image,left,top,right,bottom\na.png,5,2,3,4\n", "not left < right"),
        ("image,left,top,right,bottom\nz.png,1,2,3,4\n", "z.png is no"),
        ("", "no column left"),
    ],
)
def test_faulty_boxes(own: Path, text: str, words: str) -> None:
    file = own.parent / "faulty.csv"
    file.write_text(text)
    with pytest.raises(VisionFileError, match=words) as caught:
        photographs(own, file)
    assert str(file) in str(caught.value)
    line = one_line(run_command("detect", own, "-o", own.parent / "out", "--boxes", file))
    assert words.split(":")[0] in line


def test_no_boxes_and_no_pictures(own: Path) -> None:
    with pytest.raises(VisionFileError, match=r"none\.csv"):
        read_boxes(own.parent / "none.csv")
    with pytest.raises(CameraError, match="no such folder"):
        photographs(own / "none", own.parent / "boxes.csv")
    binary = own.parent / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(VisionFileError, match="UTF-8"):
        read_boxes(binary)


def test_the_command_says_how_many_were_found(own: Path) -> None:
    calibration = own.parent / "camera.json"
    CAMERA.save(calibration)
    boxes = own.parent / "boxes.csv"
    words = ("--calibration", calibration, "--boxes", boxes)
    result = run_command("detect", own, "-o", own.parent / "out", *words)
    assert result.exit_code == 0, result.output
    count = len(read_boxes(boxes)["a.png"])
    assert f"{count} of {count} boxes ok, 0 weak or edge, 0 missed, 0 ok where" in result.stderr
