"""Hours of simulated work with faults: ``make rigs-full`` runs one of each rig, the tests minutes.

Every fault that is put in must be named, with the motors off, and nothing may drift: the board's
counts are compared with the encoders', home with the first home, memory with the beginning.
"""

import argparse
import resource
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from agrik_fast.drivers import (
    LinkError,
    RigError,
    RigFaultError,
    RigStatus,
    Simulator,
    StrawberryRig,
    TomatoRig,
)
from agrik_fast.drivers._messages import Type

FAULTS = ("none", "jam", "switch", "estop", "cable", "hang", "stop")
NAMED = {"jam": "stall", "switch": "limit_switch", "estop": "estop", "hang": "watchdog"}


@dataclass
class Record:
    """What a soak has seen."""

    rig: str
    minutes: float = 0.0
    seconds: float = 0.0
    motions: int = 0
    requests: int = 0
    retries: int = 0
    faults: dict[str, int] = field(default_factory=dict)
    wrong: list[str] = field(default_factory=list)
    encoder_error_mm: float = 0.0
    home_drift_mm: float = 0.0
    count_error: int = 0
    lost_ticks: int = 0
    skips: int = 0
    memory_kib: int = 0

    def lines(self) -> list[str]:
        """Return the record as text."""
        faults = ", ".join(f"{count} {name}" for name, count in sorted(self.faults.items()))
        return [
            f"{self.rig}: {self.minutes:.1f} simulated minutes in {self.seconds:.0f} s, "
            f"{self.motions} motions, {self.requests} requests, {self.retries} retries",
            f"  faults put in: {faults}; missed or wrong: {len(self.wrong)}",
            f"  encoder against command {self.encoder_error_mm:.3f} mm, home within "
            f"{self.home_drift_mm:.3f} mm, counts off by {self.count_error}, "
            f"{self.lost_ticks} lost ticks, {self.skips} encoder skips, "
            f"memory {self.memory_kib:+d} KiB",
            *(f"  WRONG: {text}" for text in self.wrong),
        ]


def _memory(simulator: Simulator) -> int:
    """Return what simulator and this process hold, KiB."""
    held = 0
    for number in (simulator._process.pid, "self"):
        text = Path(f"/proc/{number}/status").read_text()
        held += int(text.split("VmRSS:")[1].split()[0])
    return held


class Soak:
    """One rig, until a simulated time has passed."""

    def __init__(self, rig: StrawberryRig | TomatoRig, simulator: Simulator, seed: int) -> None:
        self.rig, self.simulator = rig, simulator
        self.random = np.random.default_rng(seed)
        self.record = Record(rig.name)
        self.put_in = "none"
        self.at = 0.0

    def run(self, minutes: float) -> Record:
        begin, simulator, record = time.monotonic(), self.simulator, self.record
        with self.rig:
            self.rig.home()
            self.homed()
            early: int | None = None
            while simulator.now() < 60 * minutes:
                self.once()
                record.motions += 1
                if early is None and simulator.now() > 6 * minutes:
                    early = _memory(simulator)
            record.memory_kib = _memory(simulator) - (early or 0)
            stats = self.rig.link.statistics
            record.requests, record.retries = stats.requests, stats.retries
        record.minutes, record.seconds = simulator.now() / 60, time.monotonic() - begin
        return record

    def once(self) -> None:
        """Do one motion, perhaps with a fault in it, and see what comes of it."""
        kinds = [kind for kind in FAULTS if self.possible(kind)]
        kind = str(self.random.choice(kinds)) if self.random.random() < 0.25 else "none"
        self.put_in, self.at = kind, self.simulator.now() + float(self.random.uniform(0.3, 1.5))
        self.rig.progress = self.watch
        error: RigError | None = None
        try:
            self.motion()
        except RigError as caught:
            error = caught
        self.rig.progress = None
        came = self.put_in == "done " + kind
        if kind != "none" and came:
            self.record.faults[kind] = self.record.faults.get(kind, 0) + 1
        self.judge(kind if came else "none", error)

    def watch(self, status: RigStatus) -> None:
        """Put the fault in when it is due and something moves."""
        if self.put_in.startswith("done") or self.put_in == "none":
            return
        if self.simulator.now() < self.at or not status.moving:
            return
        kind, self.put_in = self.put_in, "done " + self.put_in
        self.put(kind, status)

    def judge(self, kind: str, error: RigError | None) -> None:
        """See that a fault was named, motors are off, and all is well when it is cleared."""
        if kind == "none":
            if error is not None:
                self.wrong(f"{error} without a fault")
                self.recover()
            return
        if error is None:
            self.wrong(f"{kind} was not noticed")
        self.simulator.run(0.7)
        for name in ("cable", "estop"):
            self.simulator.set(name, float(name == "cable"))
        state, status = self.simulator.state(), self.rig.status()
        if any(state[f"driven{i}"] or state[f"speed{i}"] for i in range(3)):
            self.wrong(f"{kind}: a motor runs on")
        expected = self.expected(kind)
        if status.fault != expected:
            self.wrong(f"{kind}: the board names it {status.fault}, expected {expected}")
        named = error.fault if isinstance(error, RigFaultError) else None
        if kind in NAMED and kind != "hang" and named not in (expected, "watchdog"):
            self.wrong(f"{kind}: the driver says {error}")
        if kind in ("cable", "hang") and not isinstance(error, LinkError | RigFaultError):
            self.wrong(f"{kind}: the driver says {error}")
        self.recover()

    def wrong(self, text: str) -> None:
        self.record.wrong.append(f"at {self.simulator.now():.1f} s: {text}")

    def recover(self) -> None:
        """Take the fault out, clear it and home again."""
        for i in range(3):
            self.simulator.set(f"slide{i}.jammed", 0)
            self.simulator.set(f"slide{i}.stuck", 0)
        self.rig.clear()
        self.rig._prepare()
        self.rig.home()
        self.homed()

    # ---- what the rigs do differently ------------------------------------------------------

    def possible(self, kind: str) -> bool:
        return True

    def put(self, kind: str, status: RigStatus) -> None:
        self.put_at = self.simulator.now()
        if kind == "cable":
            self.simulator.set("cable", 0)
        elif kind == "estop":
            self.simulator.set("estop", 1)
        elif kind == "hang":
            try:
                self.rig.link.request(Type.HANG, tries=1)
            except LinkError:
                return
        elif kind == "stop":
            self.rig.stop()

    def expected(self, kind: str) -> str:
        return NAMED.get(kind, "link_timeout" if kind == "cable" else "none")

    def motion(self) -> None:
        raise NotImplementedError

    def homed(self) -> None:
        """Note where home is."""


class StrawberrySoak(Soak):
    rig: StrawberryRig
    homes: list[np.ndarray]

    def motion(self) -> None:
        low, high = self.rig.lower, self.rig.upper
        q = self.random.uniform(low, high)
        steps = []
        choice = self.random.integers(0, 4)
        if choice == 0:
            steps = self.rig.move(q)
        elif choice == 1:
            steps = list(self.rig.pick(q[:5], psi=float(q[5])).steps)
        elif choice == 2:
            steps = list(self.rig.reset().steps)
        else:
            self.rig.home()
            self.homed()
        for step in steps:
            error = 1000 * abs(step.encoder_error)
            self.record.encoder_error_mm = max(self.record.encoder_error_mm, error)
        self.compare()

    def compare(self) -> None:
        """See that the board counts what the encoders show."""
        report, state = self.rig.link.report(), self.simulator.state()
        for i in range(3):
            off = int(state[f"count{i}"]) - report.position[i] - self.zero[i]
            self.record.count_error = max(self.record.count_error, abs(off))
        self.record.lost_ticks = max(self.record.lost_ticks, report.lost_ticks)
        self.record.skips = max(self.record.skips, report.skips)

    def homed(self) -> None:
        report, state = self.rig.link.report(), self.simulator.state()
        self.zero = [int(state[f"count{i}"]) - report.position[i] for i in range(3)]
        place = np.array([state[f"carriage{i}"] for i in range(3)])
        if not hasattr(self, "homes"):
            self.homes = [place]
        drift = float(np.abs(place - self.homes[0]).max())
        self.record.home_drift_mm = max(self.record.home_drift_mm, drift)

    def put(self, kind: str, status: RigStatus) -> None:
        report = self.rig.link.report()
        busy = [i for i in range(3) if report.busy >> i & 1] or [0]
        axis = busy[int(self.random.integers(0, len(busy)))]
        if kind == "jam":
            self.simulator.set(f"slide{axis}.jammed", 1)
        elif kind == "switch":
            self.simulator.set(f"slide{axis}.stuck", 1)
        else:
            super().put(kind, status)

    def expected(self, kind: str) -> str:
        if kind != "cable":
            return super().expected(kind)
        # A slide that arrives within the half second of grace has no fault.
        state = self.simulator.state()
        drove = max(state[f"last_drive{i}"] for i in range(3)) / 16e6 - self.put_at
        if drove > 0.51:
            self.wrong(f"cable: motors had current for {drove:.2f} s")
        # The silence began with the last frame before the cut, up to a poll earlier.
        if 0.465 < drove < 0.5:
            return self.rig.status().fault
        return "none" if drove <= 0.465 else "link_timeout"

    def watch(self, status: RigStatus) -> None:
        # Homing names its faults otherwise; the tests of single faults look at that.
        if status.state == "moving" and not (self.put_in == "jam" and not self.quick(status)):
            super().watch(status)

    def quick(self, status: RigStatus) -> bool:
        """Whether something moves so fast that a jam is a jam and not an arrival."""
        return any(abs(self.simulator.state()[f"speed{i}"]) > 50 for i in range(3))


class TomatoSoak(Soak):
    rig: TomatoRig

    def possible(self, kind: str) -> bool:
        return kind in ("none", "cable", "hang", "stop")

    def motion(self) -> None:
        low, high = self.rig.lower, self.rig.upper
        if self.random.random() < 0.3:
            start = self.random.uniform(low, high)
            end = self.random.uniform(low, high)
            self.rig.move(start)
            share = np.linspace(0, 1, 45)[:, None]
            self.rig.follow(start + share * (end - start), near=bool(self.random.integers(0, 2)))
        else:
            q = self.random.uniform(low, high)
            status = self.rig.move(q, near=bool(self.random.integers(0, 2)))
            off = np.degrees(np.abs(status.q - q)).max()
            if off > 0.1:
                self.wrong(f"arrived {off:.2f} degrees off")
        self.record.lost_ticks = max(self.record.lost_ticks, self.rig.status().lost_ticks)

    def expected(self, kind: str) -> str:
        # Half a second of silence is a fault on the way; at its target the arm holds as it is.
        pulses, commanded = self.rig.link.report().servo, self.rig._commanded
        if kind == "cable" and commanded is not None:
            servos = zip(self.rig.calibration.servo, commanded, strict=True)
            if list(pulses[:3]) == [servo.ticks(angle) for servo, angle in servos]:
                return "none"
        return super().expected(kind)


def soak(rig: str, minutes: float, seed: int = 0) -> Record:
    """Run one rig for so many simulated minutes."""
    if rig == "strawberry":
        random = np.random.default_rng(seed + 1)
        numbers = {
            f"slide{i}.{name}": float(value)
            for i in range(3)
            for name, value in (
                ("play", random.uniform(0.5, 1.5)),
                ("carriage", random.uniform(1, 6)),
                ("weight", 0.03 * (i == 2)),
            )
        }
        simulator = Simulator("strawberry", test_build=True, numbers=numbers)
        return StrawberrySoak(StrawberryRig(simulator, surroundings=None), simulator, seed).run(
            minutes
        )
    simulator = Simulator("tomato", test_build=True)
    return TomatoSoak(TomatoRig(simulator), simulator, seed).run(minutes)


def main() -> int:
    """Run both rigs; 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    wrong = 0
    for rig in ("strawberry", "tomato"):
        record = soak(rig, given.minutes, given.seed)
        print("\n".join(record.lines()), flush=True)
        wrong += len(record.wrong)
    used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    print(f"simulators: {used:.0f} s of processor")
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
