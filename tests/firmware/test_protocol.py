"""One protocol: its two halves are made from one file and agree on every byte."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import make_messages
from agrik_fast.drivers import _messages
from agrik_fast.drivers._frames import Frame, FrameReader, encode
from rigs import FIRMWARE

needs_compiler = pytest.mark.skipif(
    shutil.which("cc") is None or shutil.which("make") is None,
    reason="NOT CHECKED: the firmware's pure parts need a C compiler and make",
)


@pytest.fixture(scope="module")
def host() -> Path:
    """Build the firmware's pure parts for this machine, with the sanitizers."""
    made = subprocess.run(
        ["make", "-C", str(FIRMWARE), "host"], capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr
    return FIRMWARE / "build" / "host"


def test_both_halves_are_made_from_one_file() -> None:
    for path, text in make_messages.texts().items():
        assert path.read_text(encoding="utf-8") == text, f"{path}: run tools/make_messages.py"


def test_payloads_fit_and_every_request_has_an_answer() -> None:
    for name in ("Identity", "Report", "Configure", "Move", "Servo", "Servos", "Home", "Ack"):
        form = getattr(_messages, name).FORM
        assert form.size <= _messages.PAYLOAD_MAX
    requests = {kind for kind in _messages.Type if kind < 0x80}
    assert set(_messages.REPLIES) == requests
    assert _messages.Report.FORM.size == 44
    # Types of the specification.
    assert _messages.Type.HELLO == 0 and _messages.Type.SERVOS == 0x21
    assert _messages.REPLIES[_messages.Type.HELLO] == 0x80
    assert len(encode(Frame(0x21, 5, _messages.Servos(1, 3000, 2469, 4000).pack()))) == 13
    assert len(encode(Frame(0x90, 5, b"\0"))) == 7


def test_no_number_of_a_rig_is_in_the_mega_s_program() -> None:
    # Counts, gains and limits come with CONFIGURE, from a calibration file.
    text = "".join(p.read_text() for p in sorted((FIRMWARE / "mega2560").glob("*.c")))
    assert not re.search(r"107\.|21474|62918", text)


@needs_compiler
def test_pure_parts_on_the_host(host: Path) -> None:
    done = subprocess.run([host, "test"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    held = re.fullmatch(r"(\d+) checks held\n", done.stdout)
    assert held is not None and int(held[1]) > 1_000_000


def both(host: Path, data: bytes) -> tuple[list[str], list[str]]:
    """Return what the two readers make of the bytes of a line."""
    done = subprocess.run([host, "frames"], input=data, capture_output=True, check=True)
    reader = FrameReader()
    ours = [(bytes((f.type, f.sequence)) + f.payload).hex() for f in reader.feed(data)]
    theirs = done.stdout.decode().split()
    bad = theirs.count("crc"), theirs.count("malformed")
    assert (reader.crc_errors, reader.frame_errors) == bad
    return ours, [line for line in theirs if line not in ("crc", "malformed")]


@needs_compiler
def test_both_readers_see_the_same_frames(host: Path) -> None:
    random = np.random.default_rng(4)
    sent, line = [], b""
    for _ in range(2000):
        payload = random.integers(0, 256, random.integers(0, 45)) * (random.random(1) < 0.7)
        frame = Frame(*random.integers(0, 256, 2).tolist(), bytes(payload.astype(np.uint8)))
        sent.append((bytes((frame.type, frame.sequence)) + frame.payload).hex())
        line += encode(frame)
    assert both(host, line) == (sent, sent)
    # Garbled: each byte of a hundred is changed, lost or doubled.
    harmed = bytearray()
    for byte in line:
        kind = random.integers(0, 300)
        if kind == 0:
            continue
        harmed.append(byte ^ (1 << random.integers(0, 8)) if kind == 1 else byte)
        if kind == 2:
            harmed.append(byte)
    ours, theirs = both(host, bytes(harmed))
    assert ours == theirs
    assert 500 < len(ours) < 2000 and set(ours) <= set(sent)
    ours, theirs = both(host, random.integers(0, 256, 300_000, dtype=np.uint8).tobytes())
    assert ours == theirs


@needs_compiler
def test_both_writers_write_the_same_bytes(host: Path) -> None:
    random = np.random.default_rng(5)
    for length in range(45):
        kind, sequence = random.integers(0, 256, 2).tolist()
        payload = random.integers(0, 3, length, dtype=np.uint8).tobytes()
        done = subprocess.run(
            [host, "encode", str(kind), str(sequence), payload.hex()],
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.strip() == encode(Frame(kind, sequence, payload)).hex()


def test_every_flipped_bit_and_dropped_byte_is_seen() -> None:
    wire = encode(Frame(0x10, 7, _messages.Move(1, -70000, 21474).pack()))
    for bit in range(8 * len(wire)):
        harmed = bytearray(wire)
        harmed[bit // 8] ^= 1 << bit % 8
        assert list(FrameReader().feed(bytes(harmed))) == []
    for drop in range(len(wire)):
        assert list(FrameReader().feed(wire[:drop] + wire[drop + 1 :])) == []
    with pytest.raises(ValueError, match="a payload of 45 bytes, at most 44 fit"):
        encode(Frame(1, 1, bytes(45)))


def test_noise_without_an_end_does_not_pile_up() -> None:
    reader = FrameReader()
    for _ in range(100):
        assert list(reader.feed(bytes([7]) * 1000)) == []
    assert len(reader._rest) < 1000
    assert list(reader.feed(b"\0" + encode(Frame(1, 2)))) == [Frame(1, 2)]
