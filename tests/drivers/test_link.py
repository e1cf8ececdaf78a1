"""The link: nothing wrong is taken for an answer, nothing is carried out twice."""

import socket
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.drivers import (
    Link,
    LinkError,
    RigError,
    Simulator,
    StrawberryRig,
    WrongDeviceError,
    _frames,
)
from agrik_fast.drivers._frames import Frame, FrameReader, encode
from agrik_fast.drivers._messages import Board, Identity, Move, Report, Servo, State, Type
from agrik_fast.errors import ArgumentError
from rigs import NoisyLine, losing, needs_simulator, strawberry


class Answering:
    """A line whose other end is a function of frames; time passes by itself."""

    name = "toy"

    def __init__(self, answer: Callable[[Frame], bytes]) -> None:
        self.answer = answer
        self.arrived = b""
        self.time = 0.0
        self.reader = FrameReader()

    def write(self, data: bytes) -> None:
        for frame in self.reader.feed(data):
            self.arrived += self.answer(frame)

    def read(self, timeout: float) -> bytes:
        data, self.arrived = self.arrived, b""
        self.time += 0.001 if data else timeout
        return data

    def now(self) -> float:
        return self.time

    def sleep(self, seconds: float) -> None:
        self.time += seconds

    def close(self) -> None:
        pass


def identity(version: int = 1, board: int = 1) -> Callable[[Frame], bytes]:
    """Return the other end of a board that only says who it is."""

    def answer(frame: Frame) -> bytes:
        payload = Identity(version, board, b"test    ", 0).pack()
        return encode(Frame(Type.IDENTITY, frame.sequence, payload))

    return answer


# ---- wrong devices ---------------------------------------------------------------------------


def test_nobody_is_there() -> None:
    with pytest.raises(LinkError, match=r"nobody answers HELLO in 4 s: is the board on"):
        StrawberryRig(Answering(lambda frame: b"")).connect()


def test_no_such_port() -> None:
    with pytest.raises(LinkError, match=r"/dev/ttyNOTHING: cannot be opened: no such file"):
        StrawberryRig("/dev/ttyNOTHING").connect()
    with pytest.raises(LinkError, match="cannot be opened"):
        StrawberryRig("nonsense://somewhere").connect()


def test_another_device_answers() -> None:
    chatter = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n\0"
    with pytest.raises(WrongDeviceError, match="does not speak this protocol: another device"):
        StrawberryRig(Answering(lambda frame: chatter)).connect()


def test_an_echo_is_no_board() -> None:
    with Link("loop://", timeout=0.01) as link:
        expected = "loop://: what is there sends back what it gets"
        with pytest.raises(WrongDeviceError, match=expected):
            link.hello(patience=0.05)


def test_other_version_of_the_protocol() -> None:
    expected = "the board speaks version 2 of the protocol, this program version 1"
    with pytest.raises(WrongDeviceError, match=expected):
        StrawberryRig(Answering(identity(version=2))).connect()


def test_board_of_the_other_kind() -> None:
    expected = r"the board is mega8 \(the tomato rig\), expected mega2560 \(the strawberry rig\)"
    with pytest.raises(WrongDeviceError, match=expected):
        StrawberryRig(Answering(identity(board=2))).connect()
    with pytest.raises(WrongDeviceError, match="the board is number 9, expected mega2560"):
        StrawberryRig(Answering(identity(board=9))).connect()


@needs_simulator
def test_board_of_the_other_kind_itself() -> None:
    simulator = Simulator("tomato")
    with pytest.raises(WrongDeviceError, match="mega8"):
        StrawberryRig(simulator).connect()
    assert simulator._process.poll() is not None


def test_answers_of_another_length_are_another_protocol() -> None:
    def answer(frame: Frame) -> bytes:
        return encode(Frame(Type.REPORT, frame.sequence, b"short"))

    with pytest.raises(WrongDeviceError, match="the answer to STATUS has 5 bytes"):
        Link(Answering(answer)).report()


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(LinkError, match=r"serial ports need pyserial; .* agrik_fast\[drivers\]"):
        Link("/dev/ttyACM0")
    monkeypatch.setitem(sys.modules, "cobs", None)
    _frames._cobs.cache_clear()
    with pytest.raises(RigError, match=r"drivers need cobs and pyserial: the extra agrik_fast"):
        Link(Answering(identity())).hello()


# ---- arguments -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "name"),
    [({"timeout": 0.0}, "timeout"), ({"tries": 0}, "tries"), ({"timeout": "x"}, "timeout")],
)
def test_bad_arguments(options: dict[str, object], name: str) -> None:
    with pytest.raises(ArgumentError, match=f"`{name}`"):
        Link(Answering(lambda frame: b""), **options)  # type: ignore[arg-type]


def test_log_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="`log`: expected a file that can be written"):
        Link(Answering(lambda frame: b""), log=tmp_path / "none" / "frames.log")


# ---- retries ---------------------------------------------------------------------------------


def test_a_retry_has_the_number_of_what_it_repeats() -> None:
    seen: list[Frame] = []

    def answer(frame: Frame) -> bytes:
        seen.append(frame)
        return encode(Frame(Type.ACK, frame.sequence, b"\0")) if len(seen) == 3 else b""

    with Link(Answering(answer)) as link:
        link.command(Type.STOP)
        assert [frame.sequence for frame in seen] == [1, 1, 1]
        assert (link.statistics.retries, link.statistics.answered) == (2, 1)


def test_late_and_foreign_answers_are_no_answers() -> None:
    late: list[bytes] = []

    def answer(frame: Frame) -> bytes:
        # The answer to the request before, an answer of another type, and noise.
        wrong = encode(Frame(Type.PONG, frame.sequence - 1 & 255, b"late"))
        wrong += encode(Frame(Type.ACK, frame.sequence, b"\0")) + b"\x07noise\0"
        late.append(wrong)
        return wrong

    with Link(Answering(answer), tries=2) as link:
        with pytest.raises(LinkError, match=r"no answer to PING after 2 tries \(4 frames came"):
            link.ping(b"now")
        assert link.statistics.stray == 4
        assert link.statistics.timeouts == 1
        assert link.statistics.frame_errors + link.statistics.crc_errors == 2


def test_another_echo_is_told() -> None:
    link = Link(Answering(lambda f: encode(Frame(Type.PONG, f.sequence, b"x"))))
    with pytest.raises(LinkError, match="the echo of PING is another one"):
        link.ping(b"y")


@needs_simulator
def test_a_command_whose_answer_is_lost_is_carried_out_once() -> None:
    swallow = [0]

    def harm(data: bytes) -> bytes:
        # What comes back, of the next frames.
        if data[:2] == b"\x02\x90" or b"\x90" in data[:2]:
            swallow[0] -= 1
            return b"" if swallow[0] >= 0 else data
        return data

    rig = strawberry()
    rig._given = NoisyLine(rig._given, harm)  # type: ignore[arg-type]
    with rig:
        rig.home()
        for lost in range(1, 4):
            swallow[0] = lost
            before = rig.link.statistics.retries
            # Carried out twice, it would be refused: the axis is on its way already.
            rig.link.command(Type.MOVE, Move(0, 100 * lost, 20000).pack())
            assert rig.link.statistics.retries == before + lost
            rig._wait(7, 3.0, "a move")


def noisy_requests(count: int, harm: Callable[[bytes], bytes], seed: int) -> Link:
    """Ask so many things over a noisy line and check every answer."""
    rig = strawberry()
    rig.connect()
    rig.home()
    link = rig.link
    link.transport = NoisyLine(rig._given, harm)  # type: ignore[arg-type]
    random = np.random.default_rng(seed)
    pulses, target, unanswered = list(link.report().servo), 0, 0
    for _ in range(count):
        kind = random.integers(0, 4)
        try:
            if kind == 0:
                link.ping(random.integers(0, 256, random.integers(0, 45), dtype=np.uint8).tobytes())
            elif kind == 1:
                report = link.report()
                assert list(report.servo) == pulses
                assert report.state in (State.IDLE, State.MOVING)
            elif kind == 2:
                index = int(random.integers(0, 4))
                ticks = int(random.integers(1200, 4801))
                before, pulses[index] = pulses[index], ticks
                link.command(Type.SERVO, Servo(index, ticks).pack())
            elif link.report().state == State.IDLE:
                # A second execution would be refused, as the axis is busy then.
                target = 3000 if target == 0 else 0
                link.command(Type.MOVE, Move(0, target, 20000).pack())
        except LinkError:
            # Given up: whether it was carried out is for a report to say.
            unanswered += 1
            while True:
                try:
                    report = link.report()
                    break
                except LinkError:
                    unanswered += 1
            assert all(a in (b, before) for a, b in zip(report.servo, pulses, strict=True))
            pulses = list(report.servo)
            if report.state == State.FAULT:
                link.command(Type.CLEAR)
    # A report and its request are 56 bytes: 0.43 of them are harmed, and 0.43^5 given up.
    assert unanswered <= count * 0.04
    rig.close()
    return link


@needs_simulator
def test_one_percent_of_all_bytes_lost(requests_count: int) -> None:
    link = noisy_requests(requests_count, losing(0.01, 1), 2)
    assert link.statistics.retries > requests_count / 10
    assert link.statistics.answered > requests_count * 0.98


@needs_simulator
def test_one_percent_of_all_bytes_changed() -> None:
    random = np.random.default_rng(3)

    def harm(data: bytes) -> bytes:
        flips = (random.random(len(data)) < 0.01) * (1 << random.integers(0, 8, len(data)))
        return bytes(byte ^ int(flip) for byte, flip in zip(data, flips, strict=True))

    link = noisy_requests(300, harm, 4)
    assert link.statistics.crc_errors + link.statistics.frame_errors > 5


@needs_simulator
def test_bursts_of_noise(requests_count: int) -> None:
    random = np.random.default_rng(5)
    rig = strawberry()
    with rig:
        rig.home()
        before = rig.link.report()
        simulator = rig.link.transport
        for burst in range(2 * requests_count):
            noise = random.integers(0, 256, random.integers(1, 60), dtype=np.uint8).tobytes()
            simulator.write(noise + b"\0")
            if burst % 10 == 0:
                rig.link.ping(noise[:44])
        after = rig.link.report()
        assert after.crc_errors + after.frame_errors > 1.8 * requests_count
        assert (after.position, after.servo, after.state) == (
            before.position,
            before.servo,
            before.state,
        )


@needs_simulator
def test_every_flipped_bit_of_a_move_is_refused_by_the_board() -> None:
    with strawberry() as rig:
        rig.home()
        simulator, before = rig.link.transport, rig.link.report()
        wire = encode(Frame(Type.MOVE, 77, Move(1, 50000, 21474).pack()))
        for bit in range(8 * len(wire)):
            harmed = bytearray(wire)
            harmed[bit // 8] ^= 1 << bit % 8
            simulator.write(bytes(harmed) + b"\0")
            simulator.sleep(0.003)
        for drop in range(len(wire) - 1):
            simulator.write(wire[:drop] + wire[drop + 1 :] + b"\0")
            simulator.sleep(0.003)
        after = rig.link.report()
        assert (after.position, after.busy) == (before.position, 0)
        assert after.crc_errors + after.frame_errors >= 9 * len(wire) - 2


# ---- the rest --------------------------------------------------------------------------------


@needs_simulator
def test_every_frame_is_in_the_log(tmp_path: Path) -> None:
    file = tmp_path / "frames.log"
    with Link(Simulator("strawberry"), log=file) as link:
        link.hello(Board.MEGA2560)
        link.ping(b"\x01\x02")
        requests = link.statistics.requests
    lines = [line.split() for line in file.read_text().splitlines()]
    assert [(way, name) for _, way, name, *_ in lines] == [
        (">", "HELLO"),
        ("<", "IDENTITY"),
        (">", "PING"),
        ("<", "PONG"),
    ]
    assert lines[2][4] == lines[3][4] == "0102" and requests == 2


def test_the_log_is_begun_anew_when_it_is_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agrik_fast.drivers._link._LOG_BYTES", 2000)
    file = tmp_path / "frames.log"
    with Link(Answering(identity()), log=file) as link:
        for _ in range(200):
            link.hello()
    sizes = [path.stat().st_size for path in sorted(tmp_path.iterdir())]
    assert len(sizes) == 3 and max(sizes) <= 2000


def test_threads_may_share_a_link() -> None:
    def answer(frame: Frame) -> bytes:
        return encode(Frame(Type.PONG, frame.sequence, frame.payload))

    failures: list[BaseException] = []
    with Link(Answering(answer)) as link:

        def work(number: int) -> None:
            try:
                for i in range(200):
                    link.ping(bytes((number, i)))
            except BaseException as error:
                failures.append(error)

        threads = [threading.Thread(target=work, args=(n,)) for n in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert failures == [] and link.statistics.answered == 1600


@pytest.fixture
def server() -> Iterator[str]:
    """Serve a board that echoes pings at a socket, and close it after five frames."""
    listener = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        connection, _ = listener.accept()
        reader, count = FrameReader(), 0
        with connection:
            while count < 5 and (data := connection.recv(100)):
                for frame in reader.feed(data):
                    count += 1
                    connection.sendall(encode(Frame(Type.PONG, frame.sequence, frame.payload)))

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    yield f"socket://127.0.0.1:{listener.getsockname()[1]}"
    thread.join(5)
    listener.close()


def test_a_socket_is_a_line_too(server: str) -> None:
    with Link(server, timeout=2.0) as link:
        for i in range(5):
            link.ping(bytes([i]) * i)
        # The other end has closed: unplugged.
        with pytest.raises(LinkError, match="the line broke"):
            link.ping(b"again")


def test_report_is_what_the_specification_says() -> None:
    report = Report(
        1, 2, 3, 4, 5, 6, 7, (8, -9, 10), (11, -12, 13), (14, 15, 16, 17), 1, 2, 3, 4, 5
    )
    assert Report.unpack(report.pack()) == report
