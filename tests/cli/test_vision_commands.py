"""``agrik-fast detect`` and ``drive tomato --camera``: files, tables, and what they refuse."""

import csv
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.cli import _point
from agrik_fast.vision import (
    DETECTION_COLUMNS,
    Camera,
    looking_at,
    paper_camera,
    read_image,
    write_image,
)
from cli_runner import one_line, run_command
from rigs import needs_simulator

IMAGES = Path(__file__).resolve().parents[1] / "data" / "vision" / "images"


def test_detect_draws_and_writes_a_table(tmp_path: Path) -> None:
    camera = tmp_path / "camera.json"
    paper_camera().save(camera)
    out = tmp_path / "out"
    images = [IMAGES / "cluster.jpg", IMAGES / "green.jpg", IMAGES / "edge.jpg"]
    words = ("--calibration", camera, "--radius-mm", 33)
    result = run_command("detect", *images, "-o", out, *words)
    assert result.exit_code == 0, result.output
    names = {file.name for file in out.iterdir()}
    assert names == {
        "detections.csv",
        *(f"{name}-detected.png" for name in ("cluster", "green", "edge")),
    }
    assert {Path(line).name for line in result.stdout.split()} == names
    with (out / "detections.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(rows[0]) == DETECTION_COLUMNS
    statuses = [(row["image"], row["status"]) for row in rows]
    assert statuses == [
        *[("cluster.jpg", "ok")] * 4,
        ("green.jpg", "not_found"),
        ("edge.jpg", "edge"),
    ]
    near = min(abs(float(row["z_m"]) - 0.38445) for row in rows[:4])
    assert near < 0.02
    drawn = read_image(out / "cluster-detected.png")
    assert (drawn != read_image(images[0])).any()
    assert "4 ok" in result.stderr


def test_detect_takes_folders_and_any_size(tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    write_image(folder / "a.png", read_image(IMAGES / "clean.jpg")[:200, :300].copy())
    out = tmp_path / "out"
    assert run_command("detect", folder, "-o", out, "--view-deg", 55).exit_code == 0
    rows = (out / "detections.csv").read_text().splitlines()
    assert len(rows) == 2
    assert rows[1].endswith(",,,")
    assert "holds files" in one_line(run_command("detect", folder, "-o", out))
    assert run_command("detect", folder, "-o", out, "--force").exit_code == 0


def test_what_detect_refuses(tmp_path: Path) -> None:
    broken = tmp_path / "broken.jpg"
    broken.write_bytes(b"\xff\xd8 no picture")
    small = write_image(tmp_path / "small.png", np.zeros((16, 16, 3), np.uint8))
    large = tmp_path / "large.json"
    Camera.of_view(640, 480, 60).save(large)
    for number, (words, said) in enumerate(
        (
            ((broken,), "no picture"),
            ((tmp_path / "none.jpg",), "none.jpg"),
            ((IMAGES / "clean.jpg", "--calibration", large), "640 x 480"),
            ((IMAGES / "clean.jpg", "--calibration", broken), "broken.jpg"),
            ((small, "--radius-mm", -3), "--radius-mm"),
        )
    ):
        line = one_line(run_command("detect", *words, "-o", tmp_path / f"out{number}"))
        assert said in line


@needs_simulator
def test_drive_by_a_camera(tmp_path: Path) -> None:
    result = run_command("drive", "tomato", "--camera", "simulated", "--seconds", "1.6")
    assert result.exit_code == 0, result.output
    assert re.fullmatch(
        r"4\d pictures, \d commands, pointing in \d+, \d+\.\d ms a picture; "
        r"at the end: pointing\n",
        result.stdout,
    )
    lines = result.stderr.splitlines()
    assert len(lines) >= 2
    assert all(line.startswith("tomato: time s ") for line in lines)
    assert "state pointing" in lines[-1]


@needs_simulator
def test_drive_by_a_folder_of_pictures(tmp_path: Path) -> None:
    camera, pose, folder = tmp_path / "c.json", tmp_path / "p.json", tmp_path / "pictures"
    paper_camera().save(camera)
    pose.write_text(json.dumps(looking_at([-0.1, 0, 0.14], [0.25, 0, 0.06]).tolist()))
    folder.mkdir()
    for number in range(6):
        write_image(folder / f"{number}.png", np.zeros((240, 320, 3), np.uint8))
    words = ("--camera-calibration", camera, "--camera-pose", pose)
    result = run_command("drive", "tomato", "--camera", folder, *words)
    assert result.exit_code == 0, result.output
    assert "6 pictures, 0 commands" in result.stdout
    assert result.stdout.endswith("at the end: searching\n")


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self) -> bool:
        return True


@needs_simulator
def test_a_terminal_has_live_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("TERM", "xterm")
    stream, summary = Terminal(), _point.Summary()
    _point.point(
        _point.PointRequest("tomato", "simulated", "simulated", seconds=0.5), summary, stream
    )
    assert summary.frames > 10
    assert "centre mm" in stream.getvalue()
    assert "gap mm" in stream.getvalue()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("tomato",), "--targets, --camera"),
        (("strawberry", "--camera", "simulated"), "the tomato rig"),
        (("tomato", "--camera", "0"), "--camera-pose"),
        (("tomato", "--camera", "simulated", "--port", "COM7"), "--port simulated"),
        (("tomato", "--camera", "simulated", "--radius-mm", "0"), "--radius-mm"),
        (("tomato", "--camera", "simulated", "--seconds", "-1"), "--seconds"),
    ],
)
def test_what_drive_refuses(words: tuple[str, ...], said: str) -> None:
    assert said in one_line(run_command("drive", *words))


def test_a_pose_that_is_none(tmp_path: Path) -> None:
    pose = tmp_path / "pose.json"
    pose.write_text("[[1, 2], [3]]")
    words = ("--camera", "0", "--camera-pose", pose)
    assert "--camera-pose" in one_line(run_command("drive", "tomato", *words))
