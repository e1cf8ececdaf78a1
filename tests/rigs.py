"""What tests of firmware and drivers share: whether there is a simulator, and rigs in it."""

import contextlib
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agrik_fast.drivers import Calibration, Simulator, SimulatorError, StrawberryRig, TomatoRig
from agrik_fast.drivers._simulator import built

FIRMWARE = Path(__file__).resolve().parents[1] / "firmware"


def _why_not() -> str:
    if shutil.which("avr-gcc") and shutil.which("pkg-config"):
        # What is tested is what the sources say now; one at a time where two test runs begin.
        make = "flock firmware/Makefile make -C firmware boards build/simulator"
        made = subprocess.run(
            make.split(), cwd=FIRMWARE.parent, capture_output=True, text=True, check=False
        )
        if made.returncode:
            return f"NOT CHECKED: {made.stderr.strip().splitlines()[-1]}"
    try:
        for name in ("simulator", "mega2560.elf", "mega2560-test.elf", "mega8.elf"):
            built(name)
        built("mega8-test.elf")
    except SimulatorError as error:
        return f"NOT CHECKED: {error}"
    return ""


WHY_NOT = _why_not()


def needs_simulator(test: Any) -> Any:
    """Mark a test, a class or, in ``pytestmark``, a module as one for the simulator."""
    for mark in SIMULATOR:
        test = mark(test)
    return test


SIMULATOR = [
    pytest.mark.rigs,
    pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT or "the simulator is there"),
]
"""For ``pytestmark``."""

# Near their homes, so that homing takes little time.
NEAR = {f"slide{i}.carriage": 4.0 for i in range(3)}


def strawberry(numbers: Mapping[str, float] | None = None, **options: object) -> StrawberryRig:
    """Return a rig on a simulator of its own, not connected."""
    test_build = bool(options.pop("test_build", False))
    simulator = Simulator("strawberry", test_build=test_build, numbers={**NEAR, **(numbers or {})})
    return StrawberryRig(simulator, **options)  # type: ignore[arg-type]


def tomato(numbers: Mapping[str, float] | None = None, **options: object) -> TomatoRig:
    """Return a rig on a simulator of its own, not connected."""
    test_build = bool(options.pop("test_build", False))
    simulator = Simulator("tomato", test_build=test_build, numbers=numbers)
    return TomatoRig(simulator, **options)  # type: ignore[arg-type]


def simulator_of(rig: StrawberryRig | TomatoRig) -> Simulator:
    """Return the simulator that a connected rig is on."""
    simulator = rig.link.transport
    assert isinstance(simulator, Simulator)
    return simulator


def changed(calibration: Calibration, **numbers: float) -> Calibration:
    """Return a calibration with other numbers for all axes."""
    axes = [axis.model_copy(update=numbers) for axis in calibration.axis]
    return calibration.model_copy(update={"axis": axes})


class NoisyLine:
    """A line that does what it is told to the bytes on it, either way."""

    def __init__(self, line: Simulator, harm: Callable[[bytes], bytes]) -> None:
        self.line = line
        self.harm = harm
        self.name = "noisy"

    def write(self, data: bytes) -> None:
        self.line.write(self.harm(data))

    def read(self, timeout: float) -> bytes:
        return self.harm(self.line.read(timeout))

    def now(self) -> float:
        return self.line.now()

    def sleep(self, seconds: float) -> None:
        self.line.sleep(seconds)

    def close(self) -> None:
        self.line.close()


def losing(share: float, seed: int) -> Callable[[bytes], bytes]:
    """Return what loses that share of all bytes."""
    random = np.random.default_rng(seed)

    def harm(data: bytes) -> bytes:
        return bytes(byte for byte in data if random.random() >= share)

    return harm


@contextlib.contextmanager
def moving(rig: StrawberryRig, axis: int, mm: float, wait: float = 0.4) -> Iterator[Simulator]:
    """Begin a move, let a while of it pass, and leave the rest to the block."""
    from agrik_fast.drivers._messages import Move, Type

    calibration = rig.calibration.axis[axis]
    count = calibration.counts(mm)
    speed = calibration.counts(calibration.speed_mm_s)
    rig.link.command(Type.MOVE, Move(axis, count, speed).pack())
    simulator = simulator_of(rig)
    simulator.run(wait)
    assert simulator.state()[f"speed{axis}"] > 100
    yield simulator


def motors_off_at(simulator: Simulator) -> float:
    """Return when the last motor had current, s."""
    state = simulator.state()
    assert not any(state[f"driven{i}"] for i in range(3))
    return max(state[f"last_drive{i}"] for i in range(3)) / 16e6
