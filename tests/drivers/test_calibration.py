"""Calibration files: every number has a source, servos are lines, faults are named."""

import re
from importlib import resources
from pathlib import Path

import pytest

from agrik_fast.drivers import Calibration, CalibrationError, StrawberryRig, TomatoRig
from agrik_fast.errors import ArgumentError

TEXT = {
    name: (resources.files("agrik_fast.drivers") / "bundled" / f"{name}.toml").read_text("utf-8")
    for name in ("strawberry", "tomato")
}


def refused(text: str, name: str = "rig.toml") -> str:
    """Return the message for a file's content."""
    with pytest.raises(CalibrationError) as caught:
        Calibration.parse(text.encode(), name)
    message = str(caught.value)
    assert message.startswith(f"{name}: ")
    return message


@pytest.mark.parametrize("name", ["strawberry", "tomato"])
def test_bundled_files_are_sound(name: str) -> None:
    found = Calibration.load(name, name)
    assert found.rig.name == name
    for servo in found.servo:
        assert abs(
            servo.angle(servo.ticks(0.3 if servo.limits[0] < 0.3 < servo.limits[1] else 0.0))
        )
        low, high = servo.limits
        assert servo.angle(servo.ticks(low)) == pytest.approx(low, abs=1e-3)
        assert high - low > 1.9
    # The XL belt: 22 teeth of 5.08 mm, 400 counts a turn of the motor, geared 30 to 1.
    for axis in found.axis:
        assert axis.counts_per_mm == pytest.approx(400 * 30 / (22 * 5.08), abs=0.01)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "s21"', 'name = "s12"', "a strawberry rig has board mega2560, axes s10, s21, s32"),
        ('board = "mega2560"', 'board = "uno"', "[rig], board: input should be 'mega2560'"),
        ("format = 1", "format = 2", "[rig], format: input should be 1, got 2"),
        ("counts_per_mm = 107.37", "counts_per_mm = -1.0", "[[axis]] row 1, counts_per_mm: input"),
        ("counts_per_mm = 107.37", "counts_per_mm = nan", "[[axis]] row 1, counts_per_mm: input"),
        ("counts_per_mm = 107.37", "counts_per_mm = 500.0", "speed_mm_s 200 is more than 65535"),
        ("counts_per_mm = 107.37\n", "", "[[axis]] row 1, counts_per_mm: missing"),
        ("backlash_mm = 1.0", "back_lash_mm = 1.0", "[[axis]] row 1, back_lash_mm: unknown key"),
        ("home_mm = 75\n", "home_mm = 70\n", "home 70 mm is not within 75 to 660 mm"),
        ('kv = "', 'kw = "', "[[axis]] row 1: no source is given for kv"),
        ('kp = "tuned', 'kp = ""\nkx = "tuned', "no source is given for kp"),
        ("[-60, -30, 0, 30, 60]", "[-60, -30, 0, 30]", "5 pulses, but 4 angles"),
        ("[-60, -30, 0, 30, 60]", "[-60, -30, 4, 30, 60]", "the angle at 1500 us is 3.20 degrees"),
        ("[-60, -30, 0, 30, 60]", "[10, 10, 10, 10, 10]", "needs measurements at different"),
        ("lower_us = 600", "lower_us = 2400", "lower_us 2400 is not below upper_us 2400"),
        ("lower_us = 600", "lower_us = 100", "[[servo]] row 1, lower_us: input should be greater"),
        ("index = 1", "index = 0", "two servos have the same index: [0, 0, 2, 3]"),
        ("[gripper]", "[griper]", "unknown key"),
        (
            "kp = 300",
            'kp = "high"',
            "[[axis]] row 1, kp: input should be a valid number, got 'high",
        ),
        ("kp = 300", "kp = 30000", "kp is too large for the board: 71528 of 65535"),
        ("format = 1", "format 1", "not a TOML file"),
    ],
)
def test_faults_are_named(old: str, new: str, message: str) -> None:
    assert old in TEXT["strawberry"]
    told = refused(TEXT["strawberry"].replace(old, new, 1))
    assert re.search(re.escape(message), told), told


def test_all_faults_of_a_file_are_told_at_once() -> None:
    text = TEXT["strawberry"].replace("kp = 300", "kp = -1").replace("index = 3", "index = 7")
    assert "4 faults" in refused(text)


def test_calibration_of_another_rig(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(TEXT["tomato"])
    expected = r"mine.toml: 1 fault\n  \[rig\], name: a calibration of the tomato rig, expected one"
    with pytest.raises(CalibrationError, match=expected):
        StrawberryRig(calibration=file)
    with pytest.raises(CalibrationError, match="a calibration of the strawberry rig"):
        TomatoRig(calibration="strawberry")
    with pytest.raises(ArgumentError, match="`calibration`: expected one of the tomato rig"):
        TomatoRig(calibration=Calibration.load("strawberry"))


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(CalibrationError, match=r"none.toml: 1 fault\n  cannot be read: no such"):
        Calibration.load(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(CalibrationError, match="line 1: is not UTF-8"):
        Calibration.load(tmp_path / "bad.toml")


def test_play_is_taken_up_on_the_way_up() -> None:
    axis = Calibration.load("strawberry").axis[0]
    play = axis.counts(axis.backlash_mm)
    up = axis.target(175.0, 0)
    assert up == axis.counts(100.0) + play
    assert axis.target(175.0, 50_000) == axis.counts(100.0)
    # Within the play the carriage stands where it should already.
    assert axis.target(175.0, up) == axis.counts(100.0)
    assert axis.value_mm(up, upward=True) == pytest.approx(175.0, abs=0.01)
    assert axis.value_mm(axis.counts(100.0), upward=False) == pytest.approx(175.0, abs=0.01)
