"""A rig in a box: the board's own program in a simulator, wired to a simulated plant.

Time stands still but while somebody waits for the board, so that a run is the same, bit for
bit, however busy the machine is.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import threading
import weakref
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Literal, Self

from .._background import Started
from .._checks import real_number, shown, text, truth_value, word
from ..errors import ArgumentError
from ._errors import LinkError, SimulatorError

FREQUENCY = 16_000_000
"""Cycles of the boards, 1/s."""

BOARDS = {"strawberry": "mega2560", "tomato": "mega8"}
_TOOLS = ("make", "cc", "avr-gcc", "pkg-config")


def firmware_folder() -> Path:
    """Return the folder of the firmware: ``AGRIK_FIRMWARE``, or that of the checkout.

    Raises
    ------
    SimulatorError
        There is none: an installed package has no firmware.
    """
    given = os.environ.get("AGRIK_FIRMWARE")
    folder = Path(given) if given else Path(__file__).resolve().parents[3] / "firmware"
    if not (folder / "messages.toml").is_file():
        raise SimulatorError(
            f"the simulated rig needs a checkout, but {folder} holds no firmware; "
            "set AGRIK_FIRMWARE to its folder firmware"
        )
    return folder


def built(name: str) -> Path:
    """Return a built file of the firmware, which is made if it is not there.

    Raises
    ------
    SimulatorError
        It cannot be made; the message says what is missing.
    """
    folder = firmware_folder()
    path = folder / "build" / name
    if path.exists():
        return path
    missing = [tool for tool in _TOOLS if shutil.which(tool) is None]
    if missing:
        raise SimulatorError(
            f"the simulated rig is not built and cannot be: {', '.join(missing)} missing; "
            "`make firmware` says what to install (as root on Debian it does)"
        )
    made = subprocess.run(
        ["make", "-C", str(folder), f"build/{name}"], capture_output=True, text=True, check=False
    )
    if made.returncode or not path.exists():
        lines = (made.stderr or made.stdout).strip().splitlines() or ["no reason given"]
        raise SimulatorError(f"the simulated rig cannot be built (`make firmware`): {lines[-1]}")
    return path


class Simulator:
    """The board's program in simavr, with its plant.

    A transport of `Link`: reading lets time pass.

    Parameters
    ----------
    rig : {"strawberry", "tomato"}
        Which.
    test_build : bool, default False
        The program that can be told to hang.
    numbers : mapping, optional
        Numbers of the plant by name, see `set`; those of the servos are set beforehand.

    Raises
    ------
    SimulatorError
        It is not built and cannot be.

    Examples
    --------
    It goes where a port's name would.

    >>> from agrik_fast.drivers import Simulator, StrawberryRig
    >>> with StrawberryRig(Simulator("strawberry")) as rig:
    ...     print(rig.status().state)
    not_homed
    """

    def __init__(
        self,
        rig: Literal["strawberry", "tomato"] = "strawberry",
        *,
        test_build: bool = False,
        numbers: Mapping[str, float] | None = None,
    ) -> None:
        word("rig", rig, tuple(BOARDS))
        test_build = truth_value("test_build", test_build)
        if numbers is not None and not isinstance(numbers, Mapping):
            raise ArgumentError("numbers", shown(numbers), "numbers by name, or None")
        plant = {
            text("numbers", name): real_number(f"numbers[{name!r}]", value)
            for name, value in (numbers or {}).items()
        }
        self.name = "simulated"
        self.rig = rig
        board = BOARDS[rig]
        program = built(f"{board}{'-test' if test_build else ''}.elf")
        self._lock = threading.RLock()
        self._pipe = threading.Lock()
        self._lines = bytearray()
        self._arrived = bytearray()
        self._sent = 0
        self._given = 0
        self._cycle = 0
        self._process = subprocess.Popen(
            [built("simulator"), f"at{board}", program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
            start_new_session=True,  # Ctrl-C is for whoever drives it
        )
        # Whoever forgets to close it leaves no process behind.
        self._end = weakref.finalize(self, _end, self._process)
        try:
            for name, value in {**plant_numbers(rig), **plant}.items():
                self.set(name, value)
        except BaseException:
            self.close()
            raise
        # Until the board has started, it hears nothing.
        self.run(0.005)

    def _ask(self, command: str) -> str:
        """Put a question to the simulator, in a thread of its own.

        Signals raise in the main thread alone, at any place: here they could only part an answer
        from its question, or bytes that came from their count.
        """
        return Started(lambda: self._exchange(command), "simulator").result()

    def _exchange(self, command: str) -> str:
        with self._pipe:
            if self._process.poll() is not None:
                raise SimulatorError("the simulator ended")
            assert self._process.stdin and self._process.stdout
            try:
                self._process.stdin.write(f"{command}\n".encode())
                while b"\n" not in self._lines:
                    more = os.read(self._process.stdout.fileno(), 1 << 16)
                    if not more:
                        raise SimulatorError("the simulator ended")
                    self._lines += more
            except (OSError, ValueError) as error:
                raise SimulatorError(f"the simulator ended: {error}") from None
            line, _, self._lines = self._lines.partition(b"\n")
            answer = line.decode()
            if answer.startswith("error "):
                verb = command.split()[0]
                raise SimulatorError(f"{answer.removeprefix('error ')} ({verb})")
            if command.startswith("run "):
                self._count(answer, command)
        return answer

    def _count(self, answer: str, command: str) -> None:
        """Take what came, and see that both sides have the same totals.

        A lost byte would be a fault of the pipe, not of the line.
        """
        cycle, arrived, taken, given = answer.split()
        self._cycle = int(cycle)
        self._sent += len(bytes.fromhex("".join(command.split()[3:])))
        if arrived != "-":
            self._arrived += bytes.fromhex(arrived)
            self._given += len(arrived) // 2
        if int(given) != self._given or int(taken) > self._sent:
            raise SimulatorError(f"totals differ: {given} and {self._given} bytes from the board")

    def set(self, name: str, value: float) -> None:
        """Set a number of the plant: ``slide0.jammed``, ``servo2.noise``, ``cable``, ``estop``.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> with Simulator("strawberry") as simulator:
        ...     simulator.set("slide0.jammed", 1)
        """
        name = text("name", name)
        if not name or any(letter.isspace() or letter == "\0" for letter in name):
            raise ArgumentError("name", shown(name), "the name of a number of the plant")
        self._ask(f"set {name} {real_number('value', float(value))!r}")

    def state(self) -> dict[str, float]:
        """Return where everything is: ``carriage0`` (mm), ``count0``, ``angle0`` (degrees), ...

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> with Simulator("strawberry") as simulator:
        ...     print("carriage0" in simulator.state())
        True
        """
        pairs = (word.split("=") for word in self._ask("state").split())
        return {name: float(value) for name, value in pairs}

    def trace(self, file: Path | None, every: float = 0.01) -> None:
        """Write a row of counts, carriages and servos to a CSV file every so many seconds.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> from pathlib import Path
        >>> with Simulator("strawberry") as simulator:
        ...     simulator.trace(Path("trace.csv"), every=0.05)
        ...     simulator.run(0.2)
        ...     simulator.trace(None)
        >>> Path("trace.csv").exists()
        True
        """
        every = real_number("every", every, 1e-5, 3600, unit="s")
        self._ask(f"trace {'-' if file is None else file.resolve()} {1e6 * every!r}")

    def _run(self, seconds: float, stop: bool, data: bytes = b"") -> None:
        cycles = max(int(seconds * FREQUENCY), 1)
        self._ask(f"run {cycles} {int(stop)} {data.hex()}".rstrip())

    def run(self, seconds: float) -> None:
        """Let time pass.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> with Simulator("tomato") as simulator:
        ...     before = simulator.now()
        ...     simulator.run(0.5)
        ...     print(round(simulator.now() - before, 3))
        0.5
        """
        with self._lock:
            end = self._cycle + int(seconds * FREQUENCY)
            while self._cycle < end:
                self._run((end - self._cycle) / FREQUENCY, stop=False)

    # ---- transport ---------------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """Put bytes on the line.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> with Simulator("tomato") as simulator:
        ...     simulator.write(bytes(1))
        """
        with self._lock:
            try:
                self._run(0, stop=False, data=data)
            except SimulatorError as error:
                raise LinkError(self.name, f"the line broke: {error}") from None

    def read(self, timeout: float) -> bytes:
        """Return what has come, letting up to `timeout` seconds pass.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> with Simulator("tomato") as simulator:
        ...     print(type(simulator.read(timeout=0.01)).__name__)
        bytes
        """
        with self._lock:
            if not self._arrived:
                try:
                    self._run(timeout, stop=True)
                except SimulatorError as error:
                    raise LinkError(self.name, f"the line broke: {error}") from None
            with self._pipe:
                data, self._arrived = bytes(self._arrived), bytearray()
        return data

    def now(self) -> float:
        """Return the simulated time, s.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> with Simulator("tomato") as simulator:
        ...     simulator.run(0.25)
        ...     print(simulator.now() > 0.25)
        True
        """
        return self._cycle / FREQUENCY

    def sleep(self, seconds: float) -> None:
        """Let time pass.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> with Simulator("tomato") as simulator:
        ...     before = simulator.now()
        ...     simulator.sleep(0.5)
        ...     print(round(simulator.now() - before, 3))
        0.5
        """
        self.run(seconds)

    def close(self) -> None:
        """End the simulator.

        Examples
        --------
        >>> from agrik_fast.drivers import Simulator
        >>> simulator = Simulator("tomato")
        >>> simulator.close()
        """
        self._end()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _end(process: subprocess.Popen[bytes]) -> None:
    for stream in (process.stdin, process.stdout):
        if stream:
            with contextlib.suppress(OSError):
                stream.close()
    try:
        process.wait(2)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def plant_numbers(rig: str) -> dict[str, float]:
    """Return the servos' numbers of a plant, from ``firmware/servos.toml``."""
    import tomllib

    servos = tomllib.loads((firmware_folder() / "servos.toml").read_text(encoding="utf-8"))
    if rig == "strawberry":
        places = [("HS-422", 0.0, -95.0, 95.0)] * 4
    else:
        # The horn's middle, and the stops, degrees.
        places = [
            ("HD-6001HB", 90.0, 5.0, 175.0),
            ("HD-6001HB", -90.0, -175.0, -5.0),
            ("HS-311", 0.0, -62.0, 62.0),
        ]
    numbers: dict[str, float] = {}
    for index, (kind, middle, low, high) in enumerate(places):
        servo = servos[kind]
        numbers |= {
            f"servo{index}.us_per_degree": servo["us_per_deg"],
            f"servo{index}.zero_us": 1500.0 - middle * servo["us_per_deg"],
            f"servo{index}.rate": servo["deg_per_s"],
            f"servo{index}.dead_band": servo["dead_band_us"],
            f"servo{index}.low": low,
            f"servo{index}.high": high,
            f"servo{index}.angle": middle,
        }
    return numbers
