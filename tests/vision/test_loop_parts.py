"""Trackers, cameras, stand-off and budget: what the loop is made of."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agrik_fast.errors import ArgumentError
from agrik_fast.vision import (
    CameraError,
    Detector,
    Device,
    Tracker,
    VisionFileError,
    budget,
    files,
    folder,
    paper_camera,
    random_scene,
    range_sigma,
    read_image,
    render,
    rendered,
    stand_off,
    write_image,
)
from agrik_fast.vision._camera import Camera

IMAGES = Path(__file__).resolve().parents[1] / "data" / "vision" / "images"


def followed(speed: float, seed: int, frames: int = 300) -> np.ndarray:
    """Return errors against the true place two frames later, m, of the specification's noise."""
    rng = np.random.default_rng([5, seed])
    tracker = Tracker()
    off = []
    for k in range(frames):
        now = k / 30

        def place(when: float) -> np.ndarray:
            return np.array([0.02 * np.sin(0.3), speed * when, 0.35])

        truth = place(now)
        seen = truth * (1 + 0.003 * rng.normal())
        seen[:2] += rng.normal(size=2) * 0.35 / 277 * 0.35
        points = [] if rng.random() < 0.05 else [seen]
        if rng.random() < 0.02:
            points = [truth + rng.uniform(-0.1, 0.1, 3)]
        tracks = [each for each in tracker.update(now, points) if each.confirmed]
        if tracks and k > 20:
            off.append(np.linalg.norm(tracks[0].at(now + 2 / 30) - place(now + 2 / 30)))
    assert len(off) > 0.9 * (frames - 20)
    return np.array(off)


@pytest.mark.parametrize(
    ("speed", "mean", "most"), [(0.0, 0.0012, 0.0025), (0.03, 0.0022, 0.0045), (0.1, 0.003, 0.006)]
)
def test_tracks_of_moving_fruits(speed: float, mean: float, most: float) -> None:
    off = np.concatenate([followed(speed, seed) for seed in range(6)])
    assert off.mean() < mean
    assert np.percentile(off, 95) < most


def test_the_first_wild_detection_confirms_nothing() -> None:
    tracker = Tracker()
    tracker.update(0.0, [[0.3, 0, 0]])
    tracker.update(0.03, [[0.2, 0.1, 0]])
    assert not any(each.confirmed for each in tracker.update(0.06, [[0.1, 0.2, 0]]))


def test_two_fruits_keep_their_numbers_and_lost_ones_are_forgotten() -> None:
    tracker = Tracker()
    a, b = np.array([0.3, 0, 0]), np.array([0.3, 0.05, 0])
    for k in range(5):
        tracks = tracker.update(k / 30, [a, b] if k % 2 else [b, a])
    names = {each.number: each.position for each in tracks}
    assert len(names) == 2
    for k in range(5, 14):
        tracks = tracker.update(k / 30, [a])
    assert len(tracks) == 2
    assert len(tracker.update(14 / 30, [a])) == 1
    assert tracker.update(15 / 30, [[np.nan, 0, 0]])[0].misses == 1


def test_what_a_tracker_refuses() -> None:
    tracker = Tracker()
    tracker.update(1.0, [])
    with pytest.raises(ArgumentError, match="`time`"):
        tracker.update(1.0, [])
    with pytest.raises(ArgumentError, match="`points`"):
        tracker.update(2.0, [[1, 2]])
    with pytest.raises(ArgumentError, match="`gate`"):
        Tracker(gate=0.0)


# ---- where to stop ------------------------------------------------------------------------------


def test_the_gap_follows_the_budget() -> None:
    near = stand_off([0.3, 0, 0.1], 0.03)
    assert near.gap == 0.010
    way = np.array([0.3, 0, 0.1]) / np.hypot(0.3, 0.1)
    np.testing.assert_allclose(near.first, [0.3, 0, 0.1] - 0.07 * way)
    np.testing.assert_allclose(near.final, [0.3, 0, 0.1] - 0.04 * way)
    (found,) = Detector(paper_camera()).detect(render(random_scene("clean", 1)).image)
    radius = 0.35 * float(np.sin(found.alpha))
    unsure = range_sigma(found, radius, radius_sigma=0.05 * radius)
    assert 3 * unsure == pytest.approx(0.0525, abs=0.002)
    far = stand_off([0.35, 0, 0], 0.03, sigma=unsure)
    assert far.gap == pytest.approx(3 * unsure)
    np.testing.assert_array_equal(far.first, far.final)
    with pytest.raises(ArgumentError, match="`origin`"):
        stand_off([0.01, 0, 0], 0.03)


def test_the_budgets_columns() -> None:
    good, paper = budget(0.3), budget(0.3, calibrated=False)
    assert good.total == pytest.approx(0.0022, abs=0.0003)
    assert paper.total == pytest.approx(0.0046, abs=0.0003)
    assert 1.3 < paper.percent < 1.7
    assert good.total**2 == pytest.approx(sum(value**2 for value in good.terms.values()))
    assert budget(0.35, radius_share=0.05).terms["radius"] == pytest.approx(0.0175)
    for argument, value in (("distance", 0.0), ("focal", -1.0), ("picture_px", float("nan"))):
        with pytest.raises(ArgumentError, match=argument):
            budget(**{argument: value})


# ---- cameras ------------------------------------------------------------------------------------


def test_files_and_folders(tmp_path: Path) -> None:
    names = sorted(IMAGES.glob("c*.jpg"))
    frames = list(files(names, rate=10))
    assert [when for when, _ in frames] == pytest.approx([k / 10 for k in range(len(names))])
    assert all(image.shape == (240, 320, 3) for _, image in frames)
    assert len(list(folder(IMAGES))) == len(list(IMAGES.glob("*.jpg")))
    with pytest.raises(CameraError, match="without pictures"):
        folder(tmp_path)
    with pytest.raises(CameraError, match="no such folder"):
        folder(tmp_path / "none")
    with pytest.raises(CameraError, match="no pictures were given"):
        files([])
    with pytest.raises(ArgumentError, match="`paths`"):
        files("a.png")
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"no picture")
    with pytest.raises(VisionFileError, match=r"broken\.png: no picture"):
        list(folder(tmp_path))
    broken.write_bytes(b"")
    with pytest.raises(VisionFileError, match="no picture"):
        read_image(broken)
    with pytest.raises(VisionFileError, match=r"none\.png"):
        read_image(tmp_path / "none.png")
    with pytest.raises(VisionFileError, match="no form of pictures"):
        write_image(tmp_path / "a.nothing", frames[0][1])
    small = write_image(tmp_path / "small.png", np.zeros((16, 16, 3), np.uint8))
    assert read_image(small).shape == (16, 16, 3)


def test_the_renderer_is_a_camera() -> None:
    scene = random_scene("clean", 2)
    frames = list(rendered(lambda when: scene, paper_camera(), frames=2))
    assert [when for when, _ in frames] == pytest.approx([0.0, 1 / 30])
    assert (frames[0][1] != frames[1][1]).any()


def test_devices(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="cannot be opened"):
        Device(str(tmp_path / "none.avi"))
    with pytest.raises(ArgumentError, match="`source`"):
        Device(None)  # type: ignore[arg-type]
    import cv2

    name = str(tmp_path / "video.avi")
    writer = cv2.VideoWriter(name, cv2.VideoWriter.fourcc(*"MJPG"), 25, (320, 240))
    scene = random_scene("clean", 2)
    for k in range(3):
        writer.write(render(scene, frame=k).image)
    writer.release()
    with Device(name, width=320, height=240) as device:
        frames = list(device)
    assert [when for when, _ in frames] == pytest.approx([0, 0.04, 0.08])
    assert len(Detector(paper_camera()).detect(frames[0][1])) == 1
    with (
        Device(name, width=640, height=480) as device,
        pytest.raises(CameraError, match="320 x 240"),
    ):
        next(device)


class Driver:
    """A driver that gives a few pictures, quickly, and then none."""

    def __init__(self, source: Any) -> None:
        self.left = 5 if source == 0 else 0

    def isOpened(self) -> bool:
        return True

    def set(self, what: int, value: float) -> bool:
        return True

    def get(self, what: int) -> float:
        return 0.0

    def read(self) -> tuple[bool, Any]:
        if self.left == 0:
            time.sleep(10)
            return False, None
        self.left -= 1
        time.sleep(0.02)
        return True, np.full((240, 320, 3), self.left, np.uint8)

    def release(self) -> None:
        pass


@pytest.fixture
def _driver(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    import cv2

    monkeypatch.setattr(cv2, "VideoCapture", Driver)
    return


@pytest.mark.usefixtures("_driver")
def test_a_device_gives_its_newest_picture_and_tells_when_it_stalls() -> None:
    device = Device(0, patience=0.3)
    time.sleep(0.2)
    when, image = next(device)
    # The four before it are gone.
    assert image.max() == 0
    assert when <= time.monotonic()
    with pytest.raises(CameraError, match="delivers no more pictures"):
        next(device)
    device.close()
    with pytest.raises(CameraError, match=r"delivers no picture \(waited 0.3 s\)"):
        next(Device(1, patience=0.3))


def test_camera_files(tmp_path: Path) -> None:
    file = tmp_path / "camera.json"
    for text, words in (
        ("{", "no JSON"),
        ("[]", "no camera"),
        ('{"width": 320}', "missing: height"),
        ('{"width":320,"height":240,"fx":1,"fy":1,"cx":1,"cy":1,"f":1}', "unknown: f"),
        ('{"width":320,"height":240,"fx":-1,"fy":1,"cx":1,"cy":1}', "fx"),
    ):
        file.write_text(text)
        with pytest.raises(VisionFileError, match=words):
            Camera.load(file)
    with pytest.raises(VisionFileError, match="none"):
        Camera.load(tmp_path / "none.json")
