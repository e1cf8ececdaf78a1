"""The same program on a pseudoterminal, where time passes as on the wall."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from agrik_fast.drivers import Link, LinkError, RigFaultError, StrawberryRig
from agrik_fast.drivers._messages import Board
from rigs import FIRMWARE, SIMULATOR

pytestmark = [*SIMULATOR, pytest.mark.timeout(300)]


class Box:
    """A simulator on a pseudoterminal."""

    def __init__(self, board: str) -> None:
        self.process = subprocess.Popen(
            [FIRMWARE / "build/simulator", f"at{board}", FIRMWARE / f"build/{board}.elf", "--pty"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        assert self.process.stdout is not None
        self.port = self.process.stdout.readline().strip()
        assert self.port.startswith("/dev/")

    def ask(self, command: str) -> str:
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(f"{command}\n")
        return self.process.stdout.readline().strip()

    def state(self) -> dict[str, float]:
        return {k: float(v) for k, v in (w.split("=") for w in self.ask("state").split())}


@contextlib.contextmanager
def box(board: str) -> Iterator[Box]:
    """Run one until the block ends."""
    made = Box(board)
    try:
        for i in range(3):
            assert made.ask(f"set slide{i}.carriage 4") == "ok"
        yield made
    finally:
        made.process.kill()
        made.process.wait()
        for stream in (made.process.stdin, made.process.stdout):
            if stream:
                stream.close()


# A busy machine may let the host be late; the board is not, since its time is its own.
PATIENT = {"timeout": 0.5, "tries": 10}


def test_both_boards_answer_on_a_pseudoterminal() -> None:
    for board, kind in (("mega2560", Board.MEGA2560), ("mega8", Board.MEGA8)):
        with box(board) as made, Link(made.port, **PATIENT) as link:
            assert link.hello(kind).version == 1
            for i in range(50):
                link.ping(bytes([i]) * (i % 45))
            assert link.report().clock > 0


HOST = """
import sys
from agrik_fast.drivers import StrawberryRig
with StrawberryRig(sys.argv[1], surroundings=None, timeout=0.5, tries=10) as rig:
    rig.home()
    print("homed", flush=True)
    while True:
        rig.move([0.6, 0.9, 0.2, 0, 0])
        rig.move([0.1, 0.1, 0.07, 0, 0])
"""


def test_host_is_killed_on_the_way() -> None:
    with box("mega2560") as made:
        host = subprocess.Popen(
            [sys.executable, "-c", HOST, made.port], stdout=subprocess.PIPE, text=True
        )
        try:
            assert host.stdout is not None and host.stdout.readline() == "homed\n"
            end = time.monotonic() + 60
            while made.state()["speed1"] < 100 and time.monotonic() < end:
                time.sleep(0.02)
            os.kill(host.pid, signal.SIGKILL)
            host.wait()
            killed = made.state()
            assert killed["speed1"] > 50
        finally:
            host.kill()
            host.wait()
            if host.stdout:
                host.stdout.close()
        while (state := made.state())["cycle"] < killed["cycle"] + 1.2 * 16e6:
            time.sleep(0.05)
        assert all(state[f"driven{i}"] == 0 and state[f"speed{i}"] == 0 for i in range(3))
        last = max(state[f"last_drive{i}"] for i in range(3))
        # From the last frame before the kill; some more may have been on their way.
        assert 0 < (last - killed["cycle"]) / 16e6 < 0.53
        # Who comes next finds the fault named, and nothing moves until it is cleared.
        with StrawberryRig(made.port, surroundings=None, **PATIENT) as rig:
            status = rig.status()
            assert (status.state, status.fault) == ("fault", "link_timeout")
            with pytest.raises(RigFaultError, match="link timeout"):
                rig.move([0.1, 0.1, 0.07, 0, 0])
            rig.clear()
            rig.home()
            assert rig.status().state == "idle"


def test_the_box_goes_away_while_a_link_is_open() -> None:
    with box("mega8") as made:
        link = Link(made.port, timeout=0.2, tries=2)
        link.hello()
        made.process.kill()
        made.process.wait()
        with pytest.raises(LinkError, match=r"the line broke|no answer to PING"):
            link.ping()
        link.close()
